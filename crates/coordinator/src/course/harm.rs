//! The harm of a course: of all its contacts together, and of whatever is open.

use super::Course;
use super::assessed_contact::AssessedContact;
use super::persons::People;
use super::way::{Begin, NextContact};
use damage::course::HEAVY_M_S;
use damage::{CandidateHarm, CourseHarm};
use std::borrow::Cow;

/// The energy that a collision of the ego may still take (J): that of 1000 t at 100 m/s. It only
/// keeps an open candidate from winning by less damage.
const ENERGY_MAX_J: f64 = 5e9;

/// Whether a contact changes the ego's motion much, whatever its survey finds.
pub(super) fn is_heavy_for_sure(harm: &CandidateHarm) -> bool {
    harm.delta_v[0].work.lo() >= HEAVY_M_S
}

/// Whether a contact is in the harm of its course.
pub(super) fn counts(course: &Course<'_>, contact: &AssessedContact) -> bool {
    !course.is_open() || course.is_final(contact)
}

/// The harm of a course: all contacts together, and whatever is open. `next` is a contact that is
/// found and not surveyed, and what is known of it.
pub(super) fn harm_of(
    people: &People,
    course: &Course<'_>,
    next: Option<(&NextContact, &CandidateHarm)>,
) -> CourseHarm {
    harm_by(people, course, next, Cow::Borrowed)
}

/// [`harm_of`] a course whose contacts are as `changed` makes them.
pub(super) fn harm_by<'c>(
    people: &People,
    course: &'c Course<'_>,
    next: Option<(&NextContact, &CandidateHarm)>,
    changed: impl Fn(&'c CandidateHarm) -> Cow<'c, CandidateHarm>,
) -> CourseHarm {
    // A second look at a crash may still find it light: then it is as if it had not been.
    let is_final = |(meeting, harm): &(&NextContact, &CandidateHarm)| {
        meeting.begin != Begin::Again && is_heavy_for_sure(harm)
    };
    let next = next.filter(is_final).map(|(_, next)| Cow::Borrowed(next));
    let contacts = course.contacts.iter().filter(|contact| counts(course, contact));
    let contacts = contacts.map(|contact| changed(&contact.harm)).chain(next);
    let is_unevaluable = course.stuck.is_some_and(|stuck| stuck.unevaluable.is_some());
    total_harm(people, contacts, (is_unevaluable, course.is_open()))
}

/// The harm of these contacts together; and of whatever comes after them, where that is open.
pub(super) fn total_harm<'c>(
    people: &People,
    contacts: impl Iterator<Item = Cow<'c, CandidateHarm>>,
    (is_unevaluable, is_open): (bool, bool),
) -> CourseHarm {
    let mut harm = CourseHarm::none();
    contacts.for_each(|contact| harm.include(&contact));
    harm.is_unevaluable |= is_unevaluable;
    if is_open {
        harm.leave_open(people.all(), ENERGY_MAX_J);
    }
    // Last, as those who may be aboard run the greatest risk there, open ones included.
    people.suppose(&mut harm);
    harm
}
