//! Every cell and winner is in the picture, and no name becomes markup.

use super::*;
use trolley::policy::map::MapKnob;

fn sample() -> PolicyMap {
    let cells =
        vec![vec![MapCell::Winner(0), MapCell::Winner(1)], vec![MapCell::Nobody, MapCell::Unknown]];
    let row = MapRow {
        policy: "a <policy> & more".to_owned(),
        curves: "default".to_owned(),
        winner: Some("<b>go on</b>".to_owned()),
        last: None,
        tied: Vec::new(),
        notes: vec!["a \"note\"".to_owned()],
        fault: None,
        given: Some([1.0, 1.0]),
        cells,
    };
    let none = MapRow { cells: Vec::new(), given: None, ..row.clone() };
    PolicyMap {
        scenario: "Two & two".to_owned(),
        candidates: vec!["<b>go on</b>".to_owned(), "brake".to_owned(), "never".to_owned()],
        axes: Some([MapKnob::Speed, MapKnob::OddsOutside].map(MapAxis::usual)),
        rows: vec![row, none],
    }
}

#[test]
fn a_picture_has_every_cell_every_winner_and_the_units() {
    let map = sample();
    let picture = svg(&map);
    for fill in ["#56b4e9", "#e69f00", "url(#nobody)", "url(#unknown)"] {
        // Once in the panel, once in the legend.
        assert_eq!(picture.matches(&format!("fill=\"{fill}\"")).count(), 2, "{fill}");
    }
    for said in [">brake<", ">not known<", "speed of the ego", "odds of injury outside", ">0.1<"] {
        assert!(picture.contains(said), "{said}");
    }
    assert!(!picture.contains(">never<") && !picture.contains("#009e73"), "it wins nowhere");
    assert_eq!(picture.matches("class=\"cross\"").count(), 1);
}

#[test]
fn names_are_no_markup() {
    for made in [svg(&sample()), page(&sample())] {
        assert!(!made.contains("<b>") && !made.contains("<policy>") && made.contains("&lt;b&gt;"));
        assert_eq!(made.matches("://").count(), 1, "the name space alone");
    }
}

#[test]
fn axes_name_round_values_within_their_range() {
    let named = |text: &str| {
        let axis = MapAxis::parse(text).expect("an axis");
        ticks(axis).into_iter().map(|value| shown(axis, value)).collect::<Vec<_>>()
    };
    assert_eq!(named("odds"), ["0.1", "1", "10"]);
    assert_eq!(named("odds=0.5..2"), ["0.5", "1", "2"]);
    assert_eq!(named("speed"), ["0.7", "0.8", "0.9", "1", "1.1", "1.2", "1.3"]);
    assert_eq!(named("accepted"), ["0", "5", "10", "15", "20", "25", "30"]);
    assert_eq!(named("tolerance=0..0.004"), ["0", "0.1", "0.2", "0.3", "0.4"]);
}
