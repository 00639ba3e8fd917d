//! Where everybody goes in each member, in the plan view: a thin line for each, and a dot where
//! they touch.

use super::drawing::{PlanWindow, Use};
use std::fmt::Write as _;
use trolley::plan::{PlanMember, PlanPoint, PlanScene};

/// A line shorter than this (m) is not drawn.
const SHORT_M: f64 = 0.5;

/// The lines of all members. For the screen, those of each party and of each candidate are groups
/// that the page's script shows and hides.
pub(super) fn spread(
    scene: &PlanScene,
    window: &PlanWindow,
    shown: usize,
    made_for: Use,
) -> String {
    let mut out = String::new();
    if scene.members.is_empty() {
        return out;
    }
    let reacts = |party: usize| {
        scene
            .courses
            .get(shown)
            .is_some_and(|course| course.reactions.iter().any(|(number, _)| *number == party))
    };
    for party in (0..scene.parties.len()).filter(|party| *party != scene.ego) {
        let hidden = reacts(party);
        if hidden && made_for == Use::Paper {
            continue;
        }
        open("spread", party, hidden, made_for, &mut out);
        for track in scene.members.iter().filter_map(|member| member.parties.get(party)) {
            thread(window, track, "", &mut out);
        }
        out.push_str("</g>");
    }
    let is_drawn = |k: &usize| made_for == Use::Screen || *k == shown;
    for k in (0..scene.courses.len()).filter(is_drawn) {
        open("course", k, k != shown, made_for, &mut out);
        for course in scene.members.iter().filter_map(|member| member.courses.get(k)) {
            for (_, track) in &course.reactions {
                thread(window, track, "", &mut out);
            }
            thread(window, &course.ego, " own", &mut out);
        }
        touches(window, &scene.members, k, &mut out);
        out.push_str("</g>");
    }
    out
}

/// Opens a group that the script finds by its number.
fn open(kind: &str, number: usize, is_hidden: bool, made_for: Use, out: &mut String) {
    let hidden = if is_hidden { " style=\"display:none\"" } else { "" };
    let _w = match made_for {
        Use::Screen => write!(out, "<g data-{kind}=\"{number}\"{hidden}>"),
        Use::Paper => write!(out, "<g>"),
    };
}

fn thread(window: &PlanWindow, track: &[PlanPoint], class: &str, out: &mut String) {
    let steps = track.windows(2);
    let length_m: f64 = steps
        .map(|pair| f64::hypot(pair[1].0[1] - pair[0].0[1], pair[1].0[2] - pair[0].0[2]))
        .sum();
    if length_m < SHORT_M {
        return;
    }
    let point = |point: &PlanPoint| {
        let [x, y] = window.at([point.0[1], point.0[2]]);
        format!("{x:.1},{y:.1}")
    };
    let points: Vec<String> = track.iter().map(point).collect();
    let _w = write!(out, "<polyline class=\"thread{class}\" points=\"{}\"/>", points.join(" "));
}

/// A dot for each contact of a candidate in each member.
fn touches(window: &PlanWindow, members: &[PlanMember], k: usize, out: &mut String) {
    let courses = members.iter().filter_map(|member| member.courses.get(k));
    for contact in courses.flat_map(|course| &course.contacts) {
        let [x, y] = window.at(contact.at_m);
        let _w = write!(out, "<circle class=\"touch\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
    }
}
