//! What fits whom: rules about a body's kind.
//!
//! The kind of a generated body is known when the scenario is read, that of a model file only when it
//! is opened. So these rules are public: whoever opens the files applies them once more.

use crate::error::Misfit;
use crate::names::{self, SEATS, SHAPES};
use model::{Kind, Seat, meta::Occupant};

/// Whether these persons can be in a body of this kind.
///
/// Fixed objects hold nobody, a pedestrian is one person without a seat, riders sit as riders, and in
/// a car, truck or bus everybody has a seat of his own.
///
/// # Errors
///
/// A [`Misfit`] of `persons` that names the first person who does not fit.
pub fn persons_fit(kind: Kind, persons: &[Occupant]) -> Result<(), Misfit> {
    seats_differ(persons)?;
    let what = name(kind);
    let misfit = |fault: String, help: &str| Err(Misfit::new("persons", fault, help));
    for person in persons {
        match (kind, person.seat) {
            (Kind::Wall | Kind::Pole | Kind::Building, _) => {
                return misfit(format!("a {what} holds nobody"), "leave persons out");
            }
            (Kind::Pedestrian, Some(seat)) => {
                let fault = format!("a pedestrian has no seat {:?}", names::word(SEATS, seat));
                return misfit(fault, "write persons = [{}], or leave persons out");
            }
            (Kind::Pedestrian, None) => {}
            (Kind::Motorcycle | Kind::Cyclist, Some(Seat::Rider)) => {}
            (Kind::Motorcycle | Kind::Cyclist, _) => {
                let fault = format!("who is on a {what} sits as rider");
                return misfit(
                    fault,
                    "write persons = [{ seat = \"rider\" }], or leave persons out",
                );
            }
            (_, None) => {
                let fault = format!("a person in a {what} needs a seat");
                return misfit(fault, "write { seat = \"front-left\" } or another seat");
            }
            (_, Some(Seat::Rider)) => {
                return misfit(
                    format!("nobody sits as rider in a {what}"),
                    "write { seat = \"front-left\" } or another seat",
                );
            }
            (_, Some(_)) => {}
        }
    }
    Ok(())
}

/// Whether a body of this kind can be the automated vehicle: it must drive by itself.
///
/// # Errors
///
/// A [`Misfit`] of `ego`.
pub fn ego_fits(kind: Kind) -> Result<(), Misfit> {
    match kind {
        Kind::Sedan | Kind::Suv | Kind::Truck | Kind::Bus | Kind::Motorcycle => Ok(()),
        Kind::Cyclist | Kind::Pedestrian | Kind::Wall | Kind::Pole | Kind::Building => {
            let fault = format!("a {} cannot be the ego", name(kind));
            let help = "the ego is a vehicle: sedan, suv, truck, bus or motorcycle";
            Err(Misfit::new("ego", fault, help))
        }
    }
}

/// Whether a body of this kind is fixed to the ground unless it is given a mass.
#[must_use]
pub fn is_fixed(kind: Kind) -> bool {
    matches!(kind, Kind::Wall | Kind::Pole | Kind::Building)
}

/// Whether no two persons share a seat; without seats there is room for one.
pub(crate) fn seats_differ(persons: &[Occupant]) -> Result<(), Misfit> {
    for (i, person) in persons.iter().enumerate() {
        if persons[..i].contains(person) {
            let fault = match person.seat {
                Some(seat) => format!("two persons sit {:?}", names::word(SEATS, seat)),
                None => "two persons have no seat".to_owned(),
            };
            let help = "one person to a seat; each person on foot is a party of its own";
            return Err(Misfit::new("persons", fault, help));
        }
    }
    Ok(())
}

/// What people call a kind.
pub(crate) fn name(kind: Kind) -> &'static str {
    if kind == Kind::Building { "building" } else { names::word(SHAPES, kind) }
}

#[cfg(test)]
mod tests;
