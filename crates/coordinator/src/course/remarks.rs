//! What else has to be known of a candidate, in sentences.

use super::Course;
use super::way::{Begin, Scenery};
use damage::ContactPatch;
use damage::course::{RUN_OUT_LONG_M, SAME_CRASH_S, Severity};
use damage::plane::{PlaneOrigin, Ride};
use scenario::Motion;

/// What somebody does whose path ends before the horizon.
fn after_path(name: &str, motion: &Motion) -> Option<String> {
    let ends_s = motion.ends_s?;
    let then = if motion.stands_at_end() { "stays there" } else { "goes straight on from there" };
    Some(format!("the path of \"{name}\" ends after {ends_s:.2} s: it {then}"))
}

/// What else has to be known of a course, in sentences.
pub(super) fn remarks(scenery: &Scenery<'_>, k: usize, course: &Course<'_>) -> Vec<String> {
    let scenario = scenery.scenario;
    let candidate = &scenario.candidates[k];
    let name = |party: usize| &scenario.parties[party].name;
    let mut all = Vec::new();
    all.extend(after_path("ego", &candidate.ego));
    for reaction in &candidate.reactions {
        all.extend(after_path(name(reaction.party.0), &reaction.motion));
    }
    for party in &course.way.passed_at_start {
        all.push(format!(
            "it is in contact with \"{}\" at the start, and they part: no crash",
            name(*party)
        ));
    }
    for party in &course.way.undecided_at_start {
        all.push(format!(
            "whether \"{}\" and the ego lie inside each other at the start was not decided: the \
             outer body is open",
            name(*party)
        ));
    }
    for contact in &course.contacts {
        let (party, time_s) = (name(contact.meeting.party), contact.meeting.touching.time_s);
        if contact.meeting.begin == Begin::AtStart {
            all.push(format!(
                "it is in contact with \"{party}\" at the start, and they close: a crash with the \
                 velocities stated"
            ));
        }
        if !contact.meeting.touching.is_certain {
            all.push(format!(
                "contact with \"{party}\" after {time_s:.3} s is possible within {} mm, and counts",
                scenario.resolution_m * 1e3
            ));
        }
        all.extend(contact.harm.contact.iter().flat_map(|patch| heights(patch, party)));
        if contact.may_be_other {
            let other = match contact.severity {
                Severity::Light => "heavy, and end its path",
                Severity::Heavy => "light, and let it drive on",
            };
            all.push(format!(
                "within the model's range the contact with \"{party}\" may be {other}"
            ));
        }
    }
    let times = course
        .contacts
        .windows(2)
        .map(|pair| pair[1].meeting.touching.time_s - pair[0].meeting.touching.time_s);
    if times.into_iter().any(|apart_s| apart_s <= SAME_CRASH_S) {
        all.push(format!(
            "contacts within {SAME_CRASH_S} s of each other are taken as independent"
        ));
    }
    for party in &course.way.touching_at_end {
        all.push(format!("it still touches \"{}\" at the end of its way", name(*party)));
    }
    if !course.way.run_outs.is_empty() {
        all.push(
            "what follows a heavy contact is a model: straight, braked with half of gravity, not \
             validated by tests"
                .to_owned(),
        );
    }
    let lengths = course.way.run_outs.iter().map(|leg| leg.run_out.length_m());
    let long = lengths.filter(|length_m| *length_m > RUN_OUT_LONG_M);
    all.extend(long.map(|length_m| format!("its run-out of {length_m:.0} m is long")));
    all
}

/// What is said of a contact where only a weak part is hit, or one goes under or over the other.
fn heights(patch: &ContactPatch, party: &str) -> Vec<String> {
    let other = format!("\"{party}\"");
    let goes = |who: &str, whom: &str, ride: Ride| match ride {
        Ride::Level => None,
        Ride::Under => Some(format!(
            "{who} goes under {whom}: nothing below its bonnet meets it, and curves do not hold"
        )),
        Ride::Over => Some(format!("{who} goes over {whom}: it meets it below half its bonnet")),
    };
    let [ego, met] = patch.rides;
    let weak = (patch.origin == PlaneOrigin::WeakPart)
        .then(|| format!("only a weak part, as a mirror, meets {other}: no change of velocity"));
    let rides = [goes("the ego", &other, ego), goes(&other, "the ego", met)];
    weak.into_iter().chain(rides.into_iter().flatten()).collect()
}
