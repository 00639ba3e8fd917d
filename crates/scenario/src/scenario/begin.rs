//! All motions of a body begin where it is now, and that is one place.

use super::{Motion, Scenario};
use crate::document::TextPosition;
use crate::error::ScenarioError;
use crate::limit;
use crate::names::quoted;
use geometry::DVec3;

/// Whether all motions of a party begin at one pose: those of the ego in all candidates, and those
/// that are predicted of another one or are its reactions. They may be off by
/// [`limit::NOW_OFF_M`] and [`limit::NOW_OFF_DEG`], the rounding of their writers.
///
/// # Errors
///
/// The first that begins elsewhere than the first of its party, at its place.
pub(super) fn check(file: &str, scenario: &Scenario) -> Result<(), ScenarioError> {
    for (index, party) in scenario.parties.iter().enumerate() {
        let is_ego = index == scenario.ego.0;
        let of_ego = scenario.candidates.iter().filter(|_| is_ego).map(|way| &way.ego);
        let reactions = scenario.candidates.iter().flat_map(|way| &way.reactions);
        let reactions = reactions.filter(|reaction| reaction.party.0 == index);
        let mut motions = (party.predictions.iter().map(|prediction| &prediction.motion))
            .chain(of_ego)
            .chain(reactions.map(|reaction| &reaction.motion));
        let Some(first) = motions.next() else { continue };
        for motion in motions {
            if let Some(off) = off(first, motion) {
                let TextPosition { line, .. } = first.place;
                let name = quoted(&party.name);
                let fault = format!("at 0 s party {name} is {off} from where line {line} has it");
                let help = "time 0 is now, and now it is in one place: begin all of its motions \
                            there, within 1 mm and 0.1 degrees";
                return Err(ScenarioError::new(file, motion.place, fault, help));
            }
        }
    }
    Ok(())
}

/// How far apart two motions begin, in words, if that is too far.
fn off(first: &Motion, other: &Motion) -> Option<String> {
    let [a, b] = [first, other].map(|motion| motion.path.state_at(0.0));
    let off_m = (DVec3::from_array(b.position_m) - DVec3::from_array(a.position_m)).length();
    let off_deg = a.orientation.angle_to(&b.orientation).to_degrees();
    let is_off = off_m > limit::NOW_OFF_M || off_deg > limit::NOW_OFF_DEG;
    is_off.then(|| format!("{off_m:.3} m and {off_deg:.1} degrees"))
}
