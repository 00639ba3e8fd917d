//! Every way to write a square gives that square; transforms are products; the rest is refused.

use super::super::{Format, Frame};
use super::*;
use proptest::prelude::*;

/// A scene: what its node holds, and what its mesh holds beside the four corners.
fn file(node: &str, primitive: &str) -> String {
    format!(
        r##"<?xml version="1.0"?><COLLADA version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>
<library_materials><material id="m" name="paint"/></library_materials>
<library_geometries><geometry id="g" name="plate"><mesh>
<source id="s"><float_array id="f" count="12">0 0 0 1 0 0 1 1 0 <!-- cut -->0 1 0</float_array>
<technique_common><accessor source="#f" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
{primitive}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node name="car">{node}</node></visual_scene>
</library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##
    )
}

const INSTANCE: &str = r##"<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="red" target="#m"/></technique_common></bind_material>
</instance_geometry>"##;
const TRIANGLES: &str = r##"<triangles count="2" material="red">
<input semantic="VERTEX" source="#v" offset="1"/><input semantic="NORMAL" source="#n" offset="0"/>
<p>9 0 9 1 9 2 9 0 9 2 9 3</p></triangles>"##;

fn collect(text: &str) -> Result<Collector<'static>, ImportError> {
    let parsed = parse("a.dae", text.as_bytes())?;
    let frame =
        Frame::new(Format::Collada, LengthUnit::METRE, Some(Axis::Z), None).expect("orthogonal");
    let mut into = Collector::new("a.dae", frame);
    read(&parsed, &mut into)?;
    Ok(into)
}

fn fault(text: &str) -> String {
    collect(text).err().expect("refused").to_string()
}

/// Area of all triangles, and the box.
fn measured(into: &Collector<'_>) -> (f64, [[f32; 3]; 2]) {
    let area = into.corners.iter().map(|[a, b, c]| {
        let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        let n = [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            f64::from(u[j] * v[k] - u[k] * v[j])
        });
        0.5 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
    });
    let area = area.sum();
    let points = || into.corners.iter().flatten();
    let end = |pick: fn(f32, f32) -> f32, from: f32| {
        [0, 1, 2].map(|axis| points().fold(from, |end, p| pick(end, p[axis])))
    };
    (area, [end(f32::min, f32::MAX), end(f32::max, f32::MIN)])
}

#[test]
fn every_way_to_write_a_square_gives_it() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    for primitive in [
        TRIANGLES.to_owned(),
        format!("<polylist count=\"1\">{input}<vcount>4</vcount><p>0 1 2 3</p></polylist>"),
        format!("<polygons count=\"1\">{input}<p>0 1 2 3</p></polygons>"),
        format!("<tristrips count=\"1\">{input}<p>0 1 3 2</p></tristrips>"),
        format!("<trifans count=\"1\">{input}<p>0 1 2 3</p></trifans>"),
        format!("<lines count=\"1\">{input}<p>0 1</p></lines>{TRIANGLES}"),
    ] {
        let read = collect(&file(INSTANCE, &primitive)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.corners.len(), 2, "{primitive}");
        assert_eq!(measured(&read), (1.0, [[0.0; 3], [1.0, 1.0, 0.0]]), "{primitive}");
    }
    let read = collect(&file(INSTANCE, TRIANGLES)).expect("valid");
    assert_eq!(read.parts[0].name, "car:paint");
    assert!(["car", "plate", "red", "paint"].iter().all(|name| read.parts[0].is_named(name)));
}

#[test]
fn unit_and_axis_are_those_that_the_file_states() {
    let text = file(INSTANCE, TRIANGLES);
    let asset = parse("a.dae", text.as_bytes()).and_then(|c| c.asset("a.dae")).expect("an asset");
    assert_eq!((asset.unit.metres(), asset.up), (0.0254, Axis::Z));
    let bare = "<COLLADA/>";
    let asset = parse("a.dae", bare.as_bytes()).and_then(|c| c.asset("a.dae")).expect("defaults");
    assert_eq!((asset.unit, asset.up), (LengthUnit::METRE, Axis::Y));
    for (old, new) in [("0.0254", "0"), ("0.0254", "wide"), ("Z_UP", "UP")] {
        let text = text.replace(old, new);
        let parsed = parse("a.dae", text.as_bytes()).expect("XML");
        assert!(parsed.asset("a.dae").is_err(), "{new}");
    }
}

#[test]
fn transforms_apply_in_the_order_of_the_file() {
    let node = format!(
        "<translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 3 1</scale>{INSTANCE}"
    );
    let (_, [low, high]) = measured(&collect(&file(&node, TRIANGLES)).expect("valid"));
    // (x, y) → (2x, 3y) → (−3y, 2x) → (10 − 3y, 2x).
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(near(low, [7.0, 0.0, 0.0]) && near(high, [10.0, 2.0, 0.0]), "{low:?} {high:?}");
    let node = format!("<matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix><node>{INSTANCE}</node>");
    let (_, [low, _]) = measured(&collect(&file(&node, TRIANGLES)).expect("valid"));
    assert_eq!(low, [5.0, 6.0, 7.0]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let wrong = |node: &str, primitive: &str| fault(&file(node, primitive));
    for (text, says) in [
        (wrong(INSTANCE, &TRIANGLES.replace("9 3<", "9 4<")), "index 4 is out of range"),
        (wrong(INSTANCE, &TRIANGLES.replace("9 3<", "9<")), "not whole corners"),
        (wrong(INSTANCE, &TRIANGLES.replace("count=\"2\"", "count=\"3\"")), "states 3 and lists 2"),
        (wrong(INSTANCE, &TRIANGLES.replace("9 3<", "9 x<")), "\"x\" is not an index"),
        (wrong(INSTANCE, &TRIANGLES.replace("#v", "#w")), "no <vertices> with id \"w\""),
        (wrong("<instance_geometry url=\"#x\"/>", TRIANGLES), "no <geometry> with id \"x\""),
        (wrong("<instance_geometry url=\"b.dae#g\"/>", TRIANGLES), "reference to another file"),
        (wrong("<instance_controller url=\"#g\"/>", TRIANGLES), "a skin or morph"),
        (wrong(&format!("<scale>1 0 1</scale>{INSTANCE}"), TRIANGLES), "singular"),
        (wrong(&format!("<scale>1 1</scale>{INSTANCE}"), TRIANGLES), "needs 3 finite numbers"),
        (wrong(&format!("<skew>1 1</skew>{INSTANCE}"), TRIANGLES), "<skew>"),
        (wrong("", TRIANGLES), "no triangle"),
        (fault("<!DOCTYPE a [<!ENTITY b \"c\">]><COLLADA/>"), "document type declaration"),
        (fault("<svg/>"), "its first element is <svg>"),
        (fault("<COLLADA>"), "line 1"),
    ] {
        assert!(text.starts_with("a.dae: ") && text.contains(says), "{says}: {text}");
    }
}

/// A node that instances one twice, which instances another twice, ...: 2³⁰ squares.
#[test]
fn instances_that_multiply_are_refused() {
    let mut nodes = format!("<node id=\"n0\">{INSTANCE}</node>");
    for n in 1..=30 {
        let below = format!("<instance_node url=\"#n{}\"/>", n - 1);
        nodes += &format!("<node id=\"n{n}\">{below}{below}</node>");
    }
    let text = file("<instance_node url=\"#n30\"/>", TRIANGLES)
        .replace(
            "<library_visual",
            &format!("<library_nodes>{nodes}</library_nodes><library_visual"),
        )
        .replace("</library_nodes><library_visual_scenes>\n</", "</library_visual_scenes>\n</");
    let said = fault(&text);
    assert!(said.contains("above the limit"), "{said}");
    let cycle = file("<instance_node url=\"#a\"/>", TRIANGLES).replace(
        "<library_geometries>",
        "<library_nodes><node id=\"a\"><instance_node url=\"#a\"/></node></library_nodes>\
         <library_geometries>",
    );
    assert!(fault(&cycle).contains("nested nodes"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn bent_files_never_panic(
        bends in prop::collection::vec((any::<prop::sample::Index>(), 32_u8..127), 1..6),
    ) {
        let mut bytes = file(INSTANCE, TRIANGLES).into_bytes();
        for (at, byte) in bends {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let text = String::from_utf8(bytes).expect("ASCII");
        if let Err(error) = collect(&text) {
            prop_assert!(error.to_string().len() > 10);
        }
    }
}

#[test]
fn attributes_and_nesting_beyond_the_limits_are_refused_and_what_is_below_is_read() {
    let with = |count: usize| {
        let all: String = (0..count).map(|i| format!(" a{i}=''")).collect();
        file(&format!("{INSTANCE}<extra{all}/>"), TRIANGLES)
    };
    assert_eq!(collect(&with(64)).expect("as many as may be").corners.len(), 2);
    assert!(fault(&with(300_000)).contains("more than 64 attributes"));
    let nested = |depth: usize| {
        let (open, close) = ("<extra>".repeat(depth), "</extra>".repeat(depth));
        file(&format!("{INSTANCE}{open}{close}"), TRIANGLES)
    };
    assert_eq!(collect(&nested(500)).expect("deep").corners.len(), 2);
    assert!(fault(&nested(100_000)).contains("more than 512 elements are nested"));
}
