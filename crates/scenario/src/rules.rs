//! Rules about what fits the kind of a body.
//!
//! The kind of a generated body is known when the scenario is read, that of a model file only when
//! it is opened. So the same rules are applied twice: when a scenario is read, and by
//! [`crate::Scenario::check_kinds`] or [`crate::Scenario::check_kinds`].

use crate::error::Misfit;
use crate::limit;
use crate::scenario::{Motion, Occupancy, OccupantGroup};
use body::{BodyKind, meta::Occupant};

/// How many persons a body of this kind can hold `[A]`: a number above is an error of its writer.
///
/// - Cars: 9, the driver and the 8 others that a vehicle of category M1 seats at most (Regulation
///   (EU) 2018/858, Article 4); so vans and minibuses too.
/// - Lorries: 3, a cab with a bench.
/// - Buses: 90, seated and standing, and 90 people on foot that are one group.
/// - Motorcycles and bicycles: 2, the rider and one behind.
/// - What is fixed to the ground: nobody.
#[must_use]
pub fn capacity(kind: BodyKind) -> u32 {
    match kind {
        BodyKind::Sedan | BodyKind::Suv => 9,
        BodyKind::Truck => 3,
        BodyKind::Bus | BodyKind::Pedestrian => limit::OCCUPANTS.most as u32,
        BodyKind::Motorcycle | BodyKind::Cyclist => 2,
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => 0,
    }
}

/// Whether a person can be in a body of this kind, among the persons before: on a seat that there
/// is, and not on that of another.
///
/// `kind` is `None` as long as it is not known; then seats must only differ.
pub(crate) fn person_fits(
    kind: Option<BodyKind>,
    person: Occupant,
    before: &[Occupant],
) -> Result<(), Misfit> {
    let misfit = |fault: String, help: String| Err(Misfit::new("persons", fault, help));
    if let Some(kind) = kind {
        let seats: Vec<&str> = kind.seats().iter().map(|seat| seat.name()).collect();
        let seats = format!("seats of a {kind}: {}", seats.join(", "));
        match person.seat {
            _ if kind.is_fixed() => {
                return misfit(format!("a {kind} holds nobody"), "leave persons out".to_owned());
            }
            Some(_) if kind == BodyKind::Pedestrian => {
                let help = "write persons = [{}], or leave persons out";
                return misfit("a pedestrian has no seats".to_owned(), help.to_owned());
            }
            Some(seat) if !kind.seats().contains(&seat) => {
                return misfit(format!("a {kind} has no seat {:?}", seat.name()), seats);
            }
            None if kind != BodyKind::Pedestrian => {
                return misfit(format!("a person in a {kind} needs a seat"), seats);
            }
            _ => {}
        }
    }
    if before.contains(&person) {
        let fault = match person.seat {
            Some(seat) => format!("two persons have the seat {:?}", seat.name()),
            None => "two persons have no seat".to_owned(),
        };
        let help = "one person to a seat; each person on foot is a party of its own";
        return misfit(fault, help.to_owned());
    }
    Ok(())
}

/// Whether such persons can be in a body of this kind, among the groups before, in a scenario over
/// a horizon: there a person without a seat is on foot or has some seat, and a pedestrian may be a
/// group that walks as one body.
pub(crate) fn group_fits(
    kind: Option<BodyKind>,
    group: OccupantGroup,
    before: &[OccupantGroup],
) -> Result<(), Misfit> {
    let person = Occupant { seat: group.seat };
    if let Some(kind) = kind
        && !kind.is_fixed()
    {
        let persons = before.iter().map(|group| group.count).sum::<u32>() + group.count;
        let capacity = capacity(kind);
        if persons > capacity {
            let fault = format!("a {kind} holds {capacity} persons at most, not {persons}");
            let help = "count again, or say of which kind the body really is";
            return Err(Misfit::new("persons", fault, help));
        }
    }
    if group.seat.is_some() {
        let seated: Vec<Occupant> =
            before.iter().map(|group| Occupant { seat: group.seat }).collect();
        return person_fits(kind, person, &seated);
    }
    match kind {
        Some(kind) if kind.is_fixed() => person_fits(Some(kind), person, &[]),
        _ => Ok(()),
    }
}

/// Whether the persons of a party can be in a body of this kind.
pub(crate) fn occupancy_fits(kind: BodyKind, occupancy: &Occupancy) -> Result<(), Misfit> {
    match occupancy {
        Occupancy::Stated(groups) => (groups.iter().enumerate())
            .try_for_each(|(index, group)| group_fits(Some(kind), *group, &groups[..index])),
        Occupancy::Empty if kind == BodyKind::Pedestrian => {
            let help = "leave empty out, or say what it is";
            Err(Misfit::new("empty", "a pedestrian is somebody and cannot be empty", help))
        }
        Occupancy::Empty | Occupancy::Default => Ok(()),
    }
}

/// Whether a body of this kind may move like this: what is fixed to the ground does not.
pub(crate) fn motion_fits(kind: BodyKind, motion: &Motion) -> Result<(), Misfit> {
    if kind.is_fixed() && motion.moves() {
        let fault = format!("a {kind} is fixed to the ground and cannot move");
        return Err(Misfit::new("state", fault, "write place = { position_m = [x, y, z] }"));
    }
    Ok(())
}

/// Whether a body of this kind can react to what the ego does: what is fixed to the ground cannot.
pub(crate) fn can_react(kind: BodyKind) -> Result<(), Misfit> {
    if kind.is_fixed() {
        let fault = format!("a {kind} is fixed to the ground and reacts to nothing");
        return Err(Misfit::new("reactions", fault, "leave the reaction out"));
    }
    Ok(())
}

/// Whether a body of this kind may be given a mass: what is fixed to the ground has none.
pub(crate) fn mass_fits(kind: BodyKind, mass_kg: Option<f64>) -> Result<(), Misfit> {
    if kind.is_fixed() && mass_kg.is_some() {
        let fault = format!("a {kind} is fixed to the ground and has no mass");
        return Err(Misfit::new("mass_kg", fault, "leave mass_kg out"));
    }
    Ok(())
}

/// Whether a body of this kind can be the automated vehicle: it must drive by itself.
pub(crate) fn ego_fits(kind: BodyKind) -> Result<(), Misfit> {
    match kind {
        BodyKind::Sedan
        | BodyKind::Suv
        | BodyKind::Truck
        | BodyKind::Bus
        | BodyKind::Motorcycle => Ok(()),
        BodyKind::Cyclist
        | BodyKind::Pedestrian
        | BodyKind::Wall
        | BodyKind::Pole
        | BodyKind::Building => {
            let fault = format!("a {kind} cannot be the ego");
            let help = "the ego is a vehicle: sedan, suv, truck, bus or motorcycle";
            Err(Misfit::new("ego", fault, help))
        }
    }
}

#[cfg(test)]
mod tests;
