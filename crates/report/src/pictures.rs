//! The bodies and contacts of a ranking as plain values: a shot of each contact.

use crate::plan::{apart, in_words};
use crate::shot::{Shot, ShotBody, ShotPatch};
use trolley::bodies::Bodies;
use trolley::plan::{PlanCourse, PlanNearest, PlanScene};
use trolley::{Answer, ContactRow, CourseRow, Failure};

/// The bodies, by number as the contacts of a scene name them.
///
/// # Errors
///
/// If the bodies are damaged.
pub fn bodies(bodies: &Bodies) -> Result<Vec<ShotBody>, Failure> {
    let views = bodies.views()?;
    let bodies = views
        .iter()
        .map(|(meta, view)| ShotBody { name: meta.name.clone(), corners: view.corners.to_vec() });
    Ok(bodies.collect())
}

/// Every contact of every candidate, in the order of the ranking; of one that meets nobody, where
/// it comes nearest to somebody.
#[must_use]
pub fn all_shots(scene: &PlanScene, answer: &Answer) -> Vec<Shot> {
    let mut shots = Vec::new();
    for row in &answer.ranking {
        let Some(course) = scene.courses.iter().find(|course| course.name == row.name) else {
            continue;
        };
        let contacts = shots_of(scene, course, row);
        if contacts.is_empty() {
            shots.extend(course.nearest.as_ref().map(|nearest| nearest_shot(scene, row, nearest)));
        }
        shots.extend(contacts);
    }
    shots
}

/// Every contact of every candidate, in the order of the ranking.
#[must_use]
pub fn shots(scene: &PlanScene, answer: &Answer) -> Vec<Shot> {
    let mut shots = all_shots(scene, answer);
    shots.retain(Shot::is_contact);
    shots
}

fn party(scene: &PlanScene, number: usize) -> String {
    scene.parties.get(number).map_or_else(String::new, |party| party.name.clone())
}

/// The bodies where a candidate comes nearest to somebody.
fn nearest_shot(scene: &PlanScene, row: &CourseRow, nearest: &PlanNearest) -> Shot {
    let other = party(scene, nearest.party);
    let name = format!("{}: nearest to {other}, {:.2} s", row.name, nearest.time_s);
    Shot {
        caption: format!("{name}: {} apart in plan. Nothing touches.", apart(nearest.gap_m)),
        name,
        candidate: row.name.clone(),
        bodies: nearest.scene.models,
        parties: [party(scene, scene.ego), other],
        rotation: nearest.scene.pose.rotation,
        translation: nearest.scene.pose.translation,
        hits: nearest.scene.hits.clone(),
        patch: None,
        is_nearest: true,
    }
}

/// Every contact of a candidate.
fn shots_of(scene: &PlanScene, course: &PlanCourse, row: &CourseRow) -> Vec<Shot> {
    let mut shots = Vec::new();
    for (contact, at) in row.contacts.iter().zip(&course.scenes) {
        let hits: usize = at.hits.iter().map(Vec::len).sum();
        let patch = patch(contact);
        let name = format!("{}: {}, {:.2} s", row.name, contact.party, contact.time_s);
        let size = patch.map_or(String::new(), |ShotPatch { size_m: [width, height], .. }| {
            format!("; the patch is {width:.2} m wide and {height:.2} m high")
        });
        let caption = format!(
            "{name}: {}. {hits} triangles intersect from first contact on{size}. Bodies as \
             they lie when it is complete.",
            in_words(&contact.sides)
        );
        shots.push(Shot {
            name,
            candidate: row.name.clone(),
            bodies: at.models,
            parties: [party(scene, scene.ego), contact.party.clone()],
            rotation: at.pose.rotation,
            translation: at.pose.translation,
            hits: at.hits.clone(),
            patch,
            caption,
            is_nearest: false,
        });
    }
    shots
}

fn patch(contact: &ContactRow) -> Option<ShotPatch> {
    contact.contact.as_ref().map(|patch| ShotPatch {
        centre_m: patch.centre_m,
        normal: patch.normal,
        size_m: [patch.width_m.hi(), patch.height_m.hi()],
    })
}
