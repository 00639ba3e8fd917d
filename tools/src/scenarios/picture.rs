//! Pictures, in plan: where boxes call something a crash that the bodies are not in, or hardly.
//!
//! Boxes are the stated rectangles; outlines are convex hulls of the very meshes, seen from above.

use super::Ranked;
use super::bodies::Bodies;
use super::cases::{Alternative, Placed};
use super::rivals;
use anyhow::{Context as _, Result};
use std::fmt::Write as _;

/// A picture and its words.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) file: String,
    pub(crate) caption: String,
    pub(crate) svg: String,
}

/// Pixels per metre.
const SCALE: f64 = 90.0;

/// One picture per alternative that boxes call a crash and triangles call none, or a sideswipe; the
/// most telling first, at most three.
pub(crate) fn pictures(ranked: &[Ranked], bodies: &Bodies) -> Result<Vec<Picture>> {
    let mut found = Vec::new();
    for one in ranked {
        for row in one.document["answer"]["ranking"].as_array().into_iter().flatten() {
            let name = row["name"].as_str().unwrap_or_default();
            let all = one.scene.alternatives.iter();
            let Some(alternative) = all.clone().find(|a| a.name == name) else { continue };
            if !rivals::boxes_crash(alternative) {
                continue;
            }
            let misses = row["contact"]["touch"] == "no";
            let chains = one.document["explanation"]["chains"].as_array();
            let chain = chains.into_iter().flatten().find(|chain| chain["name"] == row["name"]);
            let share = chain.map_or(1.0, |chain| {
                let speed = |key: &str| chain[key].as_f64().unwrap_or(0.0);
                speed("normal_m_s") / speed("closing_m_s").max(1e-9)
            });
            if misses || share < 0.5 {
                let key = if misses { -1.0 } else { share };
                found.push((key, one.scene.name.clone(), alternative.clone(), misses));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(3);
    let draw = |(number, (share, scene, alternative, misses)): (usize, _)| {
        let alternative: Alternative = alternative;
        let (scene, share, misses): (String, f64, bool) = (scene, share, misses);
        let what = if misses {
            "the boxes overlap, and no triangle of either body touches the other".to_owned()
        } else {
            format!(
                "boxes call it a crash at {:.1} m/s; the bodies slide along each other, with \
                 {:.0} % of that across the contact",
                closing(&alternative),
                100.0 * share
            )
        };
        let svg = svg(&alternative, bodies)?;
        let caption = format!("{scene}, \"{}\": {what}.", alternative.name);
        Ok(Picture { file: format!("{}.svg", number + 1), caption, svg })
    };
    found.into_iter().enumerate().map(draw).collect()
}

fn closing(one: &Alternative) -> f64 {
    let (a, b) = (one.ego.velocity(), one.other.velocity());
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The outline of a body where it stands.
fn outline(placed: &Placed, bodies: &Bodies) -> Result<Vec<[f64; 2]>> {
    let made = bodies.get(&placed.body).context("a body that was not made")?;
    let (sin, cos) = placed.yaw.sin_cos();
    let at =
        |[x, y]: &[f64; 2]| [placed.at[0] + x * cos - y * sin, placed.at[1] + x * sin + y * cos];
    Ok(made.outline.iter().map(at).collect())
}

fn svg(one: &Alternative, bodies: &Bodies) -> Result<String> {
    let sides = [&one.ego, &one.other];
    let boxes = sides.map(|placed| rivals::corners(placed).to_vec());
    let hulls = [outline(&one.ego, bodies)?, outline(&one.other, bodies)?];
    let all = || boxes.iter().chain(&hulls).flatten();
    let end =
        |axis: usize, pick: fn(f64, f64) -> f64| all().map(|p| p[axis]).reduce(pick).unwrap_or(0.0);
    let (left, right) = (end(0, f64::min) - 0.4, end(0, f64::max) + 0.4);
    let (low, high) = (end(1, f64::min) - 0.4, end(1, f64::max) + 0.4);
    let path = |points: &[[f64; 2]]| {
        let point =
            |[x, y]: &[f64; 2]| format!("{:.1},{:.1}", (x - left) * SCALE, (high - y) * SCALE);
        points.iter().map(point).collect::<Vec<_>>().join(" ")
    };
    let (width, bottom) = ((right - left) * SCALE, (high - low) * SCALE);
    // The key stands below, a line each: how wide its words are is up to the reader's fonts.
    let (brown, key) = (format!("brown: {}", one.party), 34.0);
    let lines = ["blue: ego", brown.as_str(), "dashed: boxes"];
    let height = bottom + key * (lines.len() as f64 + 1.5);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{:.0}\" font-family=\"sans-serif\" font-size=\"26\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        width.min(900.0)
    );
    for ((of_box, hull), colour) in boxes.iter().zip(&hulls).zip(["#1f5fa8", "#b5541c"]) {
        let _w = writeln!(
            svg,
            "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"0.35\" stroke=\"{colour}\" \
             stroke-width=\"3\"/>\n<polygon points=\"{}\" fill=\"none\" stroke=\"{colour}\" \
             stroke-width=\"2\" stroke-dasharray=\"10 8\"/>",
            path(hull),
            path(of_box)
        );
    }
    let (x, mut y) = (0.2 * SCALE, bottom + 0.5 * key);
    let _w = writeln!(
        svg,
        "<line x1=\"{x:.0}\" y1=\"{y:.0}\" x2=\"{:.0}\" y2=\"{y:.0}\" stroke=\"#000\" \
         stroke-width=\"4\"/>\n<text x=\"{:.0}\" y=\"{:.0}\">1 m</text>",
        x + SCALE,
        x + SCALE + 10.0,
        y + 8.0
    );
    for line in lines {
        y += key;
        let _w = writeln!(svg, "<text x=\"{x:.0}\" y=\"{:.0}\">{line}</text>", y + 8.0);
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}
