//! Labels of a drawing lie inside, and cover neither each other nor what is marked.

use super::*;
use crate::plan::labels::{TakenRoom, overlap};

#[test]
fn labels_lie_inside_and_cover_neither_each_other_nor_what_is_marked() {
    let (_, _, scene) = ranked();
    let window = PlanWindow::of(&scene);
    let mut rng = Rng::new(7);
    for _ in 0..200 {
        let mut room = TakenRoom::default();
        let mut kept: Vec<[f64; 4]> = Vec::new();
        let spread = rng.between(1.0, 40.0);
        for k in 0..12 {
            let at =
                [400.0 + spread * rng.between(-1.0, 1.0), 150.0 + spread * rng.between(-1.0, 1.0)];
            let text = "x".repeat(3 + k);
            if let Some(taken) = room.placed(&window, at, &text) {
                assert!(taken[0] >= 0.0 && taken[2] <= 1000.0 && taken[1] >= 0.0, "{taken:?}");
                assert!(kept.iter().all(|other| !overlap(other, &taken)), "{taken:?}");
                kept.push(taken);
            }
        }
        assert!(kept.len() >= 6, "there is room for half of them");
    }
}

/// The texts of a drawing that a reader sees, and what each takes, as wide as the widest font makes
/// it.
fn texts(drawing: &str) -> Vec<(String, [f64; 4])> {
    let mut texts = Vec::new();
    let mut hidden = 0_usize;
    let mut depth: Vec<bool> = Vec::new();
    for tag in drawing.split('<').skip(1) {
        if tag.starts_with("g ") || tag.starts_with("g>") {
            let is_hidden = tag.contains("display:none");
            depth.push(is_hidden);
            hidden += usize::from(is_hidden);
        } else if tag.starts_with("/g>") {
            hidden -= usize::from(depth.pop().expect("it was opened"));
        } else if tag.starts_with("text") && hidden == 0 {
            let (head, text) = tag.split_once('>').expect("closed");
            let value = |name: &str| {
                let (_, rest) = head.split_once(&format!(" {name}=\""))?;
                Some(rest.split('"').next().expect("closed").to_owned())
            };
            let number = |name: &str| value(name).and_then(|text| text.parse::<f64>().ok());
            let moved = value("transform").map_or([0.0; 2], |text| {
                let inside = text.trim_start_matches("translate(").trim_end_matches(')');
                let (x, y) = inside.split_once(' ').expect("two");
                [x, y].map(|text| text.parse::<f64>().expect("a number"))
            });
            let at = drawing.find(tag).expect("it is there");
            let whole = drawing[at..].split_once("</text>").expect("closed").0;
            let inner: String =
                whole[head.len() + 1..].replace("<tspan>", "").replace("</tspan>", "");
            let wide = 8.0 * inner.chars().count() as f64;
            let [x, y] = [number("x"), number("y")].map(|at| at.expect("a place"));
            let left = x + moved[0]
                - wide
                    * match value("text-anchor").as_deref() {
                        Some("middle") => 0.5,
                        Some("end") => 1.0,
                        _ => 0.0,
                    };
            let base = y + moved[1];
            assert!(!text.is_empty());
            texts.push((inner, [left, base - 13.0, left + wide, base + 4.0]));
        }
    }
    texts
}

#[test]
fn no_label_of_a_drawing_covers_another() {
    let mut seen = 0;
    for name in ["crossing", "four", "wall-or-pole"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(format!("../../config/scenarios/{name}.toml"));
        let (answer, _, scene) = ranked_of(&Scenario::open(&file).expect("sound"));
        let window = PlanWindow::of(&scene);
        for k in 0..answer.ranking.len() {
            for made_for in [drawing::Use::Screen, drawing::Use::Paper] {
                let drawn = drawing::svg(&scene, &window, k, made_for, "a drawing");
                let texts = texts(&drawn);
                seen += texts.len();
                for (at, (text, room)) in texts.iter().enumerate() {
                    for (other, taken) in &texts[..at] {
                        assert!(!overlap(room, taken), "{name} {k}: {text:?} and {other:?}");
                    }
                }
            }
        }
    }
    assert!(seen > 50, "{seen} texts were compared");
}
