//! From the form of a file to values: every rule that a scenario must obey, with the place of each.
//!
//! Rules stand in the order of the file's tables; the first that is broken ends the reading.

use crate::document::{Document, Path};
use crate::error::{Misfit, ScenarioError};
use crate::fault::{self, At, Fault};
use crate::fields::{self, Head, PartyBody, WrittenBody};
use crate::limit;
use crate::names;
use crate::raw::{self, Table};
use crate::rules;
use crate::scenario::{Candidate, Occupants, Party, PartyIndex, SCHEMA, Scenario};
use body::{BodyKind, Seat, meta::Occupant};
use std::collections::BTreeMap;

mod collision;

/// Reads and checks a scenario.
pub(crate) fn scenario(file: &str, text: &str) -> Result<Scenario, ScenarioError> {
    fault::read(file, text, SCHEMA, |raw, document| Checker { document }.scenario(raw))
}

struct Checker<'d> {
    document: &'d Document<'d>,
}

impl Checker<'_> {
    fn scenario(&self, raw: raw::Scenario) -> Result<Scenario, Fault> {
        let head = Head::new(
            self.document,
            &raw.name,
            [raw.policy, raw.curves],
            raw.deadline_ms,
            &raw.engine.0,
        )?;
        let Head { policy, curves, deadline, engine } = head;
        let parties = self.parties(raw.parties)?;
        let known = parties.iter().map(|p| (p.name.as_str(), &p.source, p.is_unknown));
        let ego = fields::ego(raw.ego.as_deref(), known)?;
        let candidates = self.candidates(raw.candidates.unwrap_or_default(), &parties, ego)?;
        let name = raw.name;
        Ok(Scenario { name, policy, curves, deadline, engine, ego, parties, candidates })
    }

    fn parties(&self, raw: BTreeMap<String, Table<raw::Party>>) -> Result<Vec<Party>, Fault> {
        fields::count_parties(raw.len(), limit::PARTIES)?;
        let path = Path::default().key("parties");
        raw.into_iter().map(|(key, party)| self.party(key, party, &path)).collect()
    }

    fn party(&self, key: String, raw: Table<raw::Party>, parent: &Path) -> Result<Party, Fault> {
        let path = parent.key(&key);
        let Table(raw) = raw;
        let raw::Party { file, generate, kind, size_m, mass_kg, persons, responsibility, crush } =
            raw;
        let body = WrittenBody { file, generate, kind, size_m, mass_kg, responsibility, crush };
        let body = PartyBody::new(self.document, &key, body, &path)?;
        let kind = body.source.kind();
        let persons = persons.map(|list| list_persons(&list, kind, &path)).transpose()?;
        body.check_unknown(persons.is_some(), &path)?;
        Ok(Party {
            place: body.place,
            name: key.into(),
            source: body.source,
            size: body.size,
            mass_kg: body.mass_kg,
            persons,
            responsibility: body.responsibility,
            is_unknown: body.is_unknown,
            crush: body.crush,
        })
    }

    fn candidates(
        &self,
        raw: Vec<Table<raw::Candidate>>,
        parties: &[Party],
        ego: PartyIndex,
    ) -> Result<Vec<Candidate>, Fault> {
        fields::count_candidates(raw.len())?;
        let path = Path::default().key("candidates");
        let mut checked: Vec<Candidate> = Vec::with_capacity(raw.len());
        for (index, Table(candidate)) in raw.into_iter().enumerate() {
            let path = path.index(index);
            let before = checked.iter().map(|twin| (twin.name.as_str(), twin.place));
            fields::is_new(&candidate.name, before, &path)?;
            let place = self.document.place(&path);
            checked.push(collision::candidate(candidate, &path, place, parties, ego)?);
        }
        Ok(checked)
    }
}

/// Persons by their seats, in a body of this kind if that is known.
fn list_persons(
    raw: &[Table<raw::Person>],
    kind: Option<BodyKind>,
    parent: &Path,
) -> Result<Occupants, Fault> {
    let path = parent.key("persons");
    if raw.len() > limit::PERSONS_MAX {
        let fault = format!("{} persons are too many", raw.len());
        let help = format!("a party holds at most {} persons", limit::PERSONS_MAX);
        return Err(Misfit::new("persons", fault, help)).at(&path);
    }
    let mut persons = Occupants::new();
    for (index, Table(person)) in raw.iter().enumerate() {
        let path = path.index(index).key("seat");
        let meaning = |seat: &String| names::meaning::<Seat>("seat", seat);
        let seat = person.seat.as_ref().map(meaning).transpose().at(&path)?;
        let person = Occupant { seat };
        rules::person_fits(kind, person, &persons).at(&path)?;
        persons.push(person);
    }
    Ok(persons)
}

#[cfg(test)]
mod tests;
