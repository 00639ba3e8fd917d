//! The bodies and contacts of a ranking as plain values: a shot of each contact.

use crate::shot::{Shot, ShotBody, ShotPatch};
use trolley::bodies::Bodies;
use trolley::{Answer, ContactRow, Failure, PlanScene};

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

/// Every contact of every candidate, in the order of the ranking.
#[must_use]
pub fn shots(scene: &PlanScene, answer: &Answer) -> Vec<Shot> {
    let mut shots = Vec::new();
    for row in &answer.ranking {
        let Some(course) = scene.courses.iter().find(|course| course.name == row.name) else {
            continue;
        };
        for (contact, at) in row.contacts.iter().zip(&course.scenes) {
            let hits: usize = at.hits.iter().map(Vec::len).sum();
            let patch = patch(contact);
            let name = format!("{}: {}, {:.2} s", row.name, contact.party, contact.time_s);
            let size =
                patch.map_or(String::new(), |ShotPatch { size_m: [width, height], .. }| {
                    format!("; the patch is {width:.2} m wide and {height:.2} m high")
                });
            let caption = format!(
                "{name}: {}. {hits} triangles intersect from first contact on{size}. Bodies as \
                 they lie when it is complete.",
                contact.sides
            );
            shots.push(Shot {
                name,
                candidate: row.name.clone(),
                bodies: at.models,
                rotation: at.pose.rotation,
                translation: at.pose.translation,
                hits: at.hits.clone(),
                patch,
                caption,
            });
        }
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
