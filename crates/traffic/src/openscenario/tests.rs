//! World positions are read, everything else is refused with a reason.

use crate::{NamedText, ReadOptions, read};

const CATALOG: &str = r#"<OpenSCENARIO><Catalog name="V">
<Vehicle name="car_white" vehicleCategory="car">
<BoundingBox><Center x="1.4" y="0" z="0.75"/><Dimensions width="2" length="5" height="1.5"/>
</BoundingBox>
</Vehicle></Catalog></OpenSCENARIO>"#;

const SMALL: &str = r#"<OpenSCENARIO><FileHeader description="Small"/>
<ParameterDeclarations><ParameterDeclaration name="Speed" parameterType="double" value="12"/>
</ParameterDeclarations>
<Entities><ScenarioObject name="Ego"><CatalogReference catalogName="V" entryName="car_white"/>
</ScenarioObject>
<ScenarioObject name="walker"><Pedestrian pedestrianCategory="pedestrian">
<BoundingBox><Center x="0" y="0" z="0.9"/><Dimensions width="0.5" length="0.6" height="1.8"/>
</BoundingBox>
</Pedestrian></ScenarioObject></Entities>
<Storyboard><Init><Actions>
<Private entityRef="Ego"><PrivateAction><TeleportAction><Position>
<WorldPosition x="0" y="0" h="0"/></Position></TeleportAction></PrivateAction>
<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionTarget>
<AbsoluteTargetSpeed value="$Speed"/></SpeedActionTarget></SpeedAction></LongitudinalAction>
</PrivateAction></Private>
<Private entityRef="walker"><PrivateAction><TeleportAction><Position>
<WorldPosition x="20" y="0.2"/></Position></TeleportAction></PrivateAction></Private>
</Actions></Init></Storyboard></OpenSCENARIO>"#;

fn small(old: &str, new: &str) -> Result<crate::Recording, crate::TrafficError> {
    assert!(SMALL.contains(old), "{old}");
    let catalogs = [NamedText { file: "v.xosc", text: CATALOG }];
    let options = ReadOptions { catalogs: &catalogs, ..ReadOptions::default() };
    read("s.xosc", &SMALL.replacen(old, new, 1), &options)
}

#[test]
fn entities_with_world_positions_are_read() {
    let recording = small("Small", "Small").expect("valid");
    let outline = recording.ego.outline.as_ref().expect("of the catalogue");
    assert_eq!((outline.size(), outline.middle()), ([5.0, 2.0], [1.4, 0.0]));
    assert_eq!(recording.ego.start.speed_m_s, 12.0);
    assert_eq!(recording.others[0].kind, "pedestrian");
    assert!(recording.others[0].is_static());
}

#[test]
fn the_rest_is_refused_with_a_reason() {
    for (old, new, says) in [
        ("<WorldPosition x=\"20\" y=\"0.2\"/>", "<LanePosition roadId=\"0\"/>", "LanePosition"),
        ("value=\"$Speed\"", "value=\"${$Speed / 3.6}\"", "is an expression"),
        ("<AbsoluteTargetSpeed value=\"$Speed\"/>", "<RelativeTargetSpeed/>", "relative"),
        ("entryName=\"car_white\"", "entryName=\"car_red\"", "has \"car_red\""),
        ("name=\"Ego\"", "name=\"Host\"", "there is no entity \"Ego\""),
        ("length=\"0.6\"", "length=\"6000\"", "a length of 6000 m"),
        ("<WorldPosition x=\"20\"", "<WorldPosition x=\"far\"", "x is not a finite number"),
    ] {
        let error = small(old, new).expect_err(new);
        assert!(error.what.contains(says) && !error.remedy.is_empty(), "{new}: {error}");
    }
    let error = read("c.xosc", CATALOG, &ReadOptions::default()).expect_err("a catalogue");
    assert!(error.remedy.contains("--catalog"), "{error}");
}
