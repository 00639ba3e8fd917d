//! The four tables, [`TABLES_SCHEMA`]: which columns there are, and the rows of an answer.
//!
//! | table | a row for each | key |
//! |---|---|---|
//! | `answers` | scene, policy and set of curves | `row` |
//! | `candidates` | candidate of an answer | `row`, `place` |
//! | `persons` | person of a candidate who is harmed or may be | `row`, `place`, `party`, `seat` |
//! | `inputs` | recording or scenario | `input` |
//!
//! Harm is the policy's leading measure. Where there is no value, it is missing, never 0.

use crate::inputs::Input;
use crate::knob::SweepKnob;
use crate::plan::{Plan, SceneKey};
use crate::spec::RowSelection;
use columns::{Form, Table, Value};
use trolley::{Answer, CourseRow, Failure};

/// Name and version of the columns of all tables.
pub const TABLES_SCHEMA: &str = "trolley.study-tables/1";

const TEXT: Form = Form::Text;
const WHOLE: Form = Form::Whole;
const REAL: Form = Form::Real;
const FLAG: Form = Form::Flag;

/// Columns of `answers`.
pub(crate) const ANSWERS: [(&str, Form); 38] = [
    ("row", WHOLE),
    ("scene", WHOLE),
    ("input", WHOLE),
    ("policy", TEXT),
    ("curves", TEXT),
    ("parameters", TEXT),
    ("speed", REAL),
    ("offset_m", REAL),
    ("reaction_s", REAL),
    ("error_sigma", REAL),
    ("errors", REAL),
    // Why there is no answer; then all that follows is missing.
    ("refusal", TEXT),
    ("answer_hash", TEXT),
    ("state", TEXT),
    // Missing where the policy lets nobody be chosen.
    ("winner", TEXT),
    ("second", TEXT),
    ("candidates", WHOLE),
    // How many the model cannot tell from the first, itself included.
    ("tied", WHOLE),
    // Whether the model is sure that the first comes before the second.
    ("is_certain", FLAG),
    ("touches_nobody", FLAG),
    // Of the first candidate: the measure over open work, and over what the model does not know.
    ("work_lo", REAL),
    ("work_hi", REAL),
    ("range_low", REAL),
    ("range_high", REAL),
    ("second_work_lo", REAL),
    ("second_work_hi", REAL),
    ("first_party", TEXT),
    ("first_contact_s", REAL),
    // What members and worlds say of the first; missing with members = 1.
    ("members", WHOLE),
    ("contact_share", REAL),
    ("best_share", REAL),
    ("regret", REAL),
    ("lead", REAL),
    ("lead_error", REAL),
    ("worlds", WHOLE),
    ("worlds_won", REAL),
    // What, drawn alone, has another win most often, and in which share of such worlds.
    ("flip", TEXT),
    ("flip_lost", REAL),
];

/// Columns of `candidates`.
pub(crate) const CANDIDATES: [(&str, Form); 18] = [
    ("row", WHOLE),
    ("place", WHOLE),
    ("candidate", TEXT),
    ("is_winner", FLAG),
    ("is_certain", FLAG),
    ("is_tied", FLAG),
    ("work_lo", REAL),
    ("work_hi", REAL),
    ("range_low", REAL),
    ("range_high", REAL),
    ("contacts", WHOLE),
    ("first_party", TEXT),
    ("first_contact_s", REAL),
    ("closing_m_s", REAL),
    ("energy_j", REAL),
    ("contact_share", REAL),
    ("best_share", REAL),
    ("worlds_won", REAL),
];

/// Columns of `persons`.
pub(crate) const PERSONS: [(&str, Form); 9] = [
    ("row", WHOLE),
    ("place", WHOLE),
    ("candidate", TEXT),
    ("party", TEXT),
    ("seat", TEXT),
    ("work_lo", REAL),
    ("work_hi", REAL),
    ("range_low", REAL),
    ("range_high", REAL),
];

/// Columns of `inputs`.
pub(crate) const INPUTS: [(&str, Form); 8] = [
    ("input", WHOLE),
    ("name", TEXT),
    ("kind", TEXT),
    ("at_s", REAL),
    ("source_hash", TEXT),
    ("parties", WHOLE),
    ("candidates", WHOLE),
    ("refusal", TEXT),
];

/// What became of one scene under one policy and one set of curves.
pub(crate) struct Row {
    pub(crate) row: u64,
    pub(crate) key: SceneKey,
    pub(crate) policy: usize,
    pub(crate) curves: usize,
    pub(crate) outcome: Result<Answered, String>,
}

/// An answer, and its hash.
pub(crate) struct Answered {
    pub(crate) answer: Answer,
    pub(crate) hash: String,
}

impl Answered {
    /// The hash is that of the answer as JSON on one line, as a record has it.
    pub(crate) fn new(answer: Answer) -> Result<Self, Failure> {
        let json = serde_json::to_string(&answer);
        let json = json.map_err(|error| Failure::internal(error.to_string()))?;
        let hash = blake3::hash(json.as_bytes()).to_hex().to_string();
        Ok(Self { answer, hash })
    }
}

/// The tables of one shard.
pub(crate) struct Tables<'r> {
    pub(crate) answers: Table<'r, 38>,
    pub(crate) candidates: Table<'r, 18>,
    pub(crate) persons: Table<'r, 9>,
}

impl<'r> Tables<'r> {
    pub(crate) fn of(plan: &'r Plan, rows: &'r [Row]) -> Self {
        let mut tables = Self {
            answers: Table::new(ANSWERS),
            candidates: Table::new(CANDIDATES),
            persons: Table::new(PERSONS),
        };
        let file = plan.file();
        for row in rows {
            tables.answers.push(answer(plan, row));
            let Ok(Answered { answer, .. }) = &row.outcome else { continue };
            for (place, candidate) in (1_i64..).zip(&answer.ranking) {
                if is_kept(file.candidates, place) {
                    tables.candidates.push(self::candidate(row.row, place, candidate, answer));
                }
                if !is_kept(file.persons, place) {
                    continue;
                }
                for person in &candidate.persons {
                    tables.persons.push([
                        whole(row.row),
                        Value::Whole(place),
                        Value::Text(&candidate.name),
                        Value::Text(&person.party),
                        Value::text(person.seat),
                        Value::real(Some(person.work.lo())),
                        Value::real(Some(person.work.hi())),
                        Value::real(Some(person.range.low())),
                        Value::real(Some(person.range.high())),
                    ]);
                }
            }
        }
        tables
    }
}

fn is_kept(kept: RowSelection, place: i64) -> bool {
    match kept {
        RowSelection::All => true,
        RowSelection::First => place == 1,
        RowSelection::None => false,
    }
}

/// A number of rows or scenes; none is beyond what an i64 holds.
fn whole<'r>(number: u64) -> Value<'r> {
    Value::Whole(i64::try_from(number).unwrap_or(i64::MAX))
}

fn count<'r>(number: usize) -> Value<'r> {
    whole(number as u64)
}

fn answer<'r>(plan: &'r Plan, row: &'r Row) -> [Value<'r>; 38] {
    let file = plan.file();
    let swept = |knob: SweepKnob| {
        let found = row.key.values.iter().find(|(known, _)| *known == knob);
        Value::real(found.map(|(_, value)| *value))
    };
    let mut values = [Value::Empty; 38];
    let head = [
        whole(row.row),
        whole(row.key.scene),
        count(row.key.input),
        Value::Text(&file.policies[row.policy].name),
        Value::Text(&file.curves[row.curves].name),
        Value::Text(&file.parameters[row.key.parameters].name),
        swept(SweepKnob::Speed),
        swept(SweepKnob::Offset),
        swept(SweepKnob::Reaction),
        swept(SweepKnob::ErrorSigma),
        swept(SweepKnob::Errors),
    ];
    values[..head.len()].copy_from_slice(&head);
    let tail = &mut values[head.len()..];
    match &row.outcome {
        Err(refusal) => tail[0] = Value::Text(refusal),
        Ok(answered) => tail[1..].copy_from_slice(&answered_values(answered)),
    }
    values
}

fn answered_values(answered: &Answered) -> [Value<'_>; 26] {
    let Answered { answer, hash } = answered;
    let (first, second) = (answer.ranking.first(), answer.ranking.get(1));
    let contact = first.and_then(|first| first.contacts.first());
    let expected = first.and_then(|first| first.expected.as_ref());
    let spread = expected.and_then(|expected| expected.spread.as_ref());
    let lead = answer.members.as_ref().and_then(|members| members.lead);
    let worlds = answer.worlds.as_ref();
    let flip = worlds.and_then(|worlds| worlds.flips.first());
    let met = expected.and_then(|expected| expected.meets.first());
    let party = contact.map(|contact| contact.party.as_str());
    let from_s = contact.map(|contact| contact.time_s);
    [
        Value::Text(hash),
        Value::Text(answer.state.name()),
        Value::text(answer.best().map(|best| best.name.as_str())),
        Value::text(second.map(|second| second.name.as_str())),
        count(answer.ranking.len()),
        count(answer.tie_class.len()),
        first.map_or(Value::Empty, |first| Value::Flag(first.certain)),
        first.map_or(Value::Empty, |first| Value::Flag(first.touches_nobody())),
        Value::real(first.map(|first| first.work.lo())),
        Value::real(first.map(|first| first.work.hi())),
        Value::real(first.map(|first| first.range.low())),
        Value::real(first.map(|first| first.range.high())),
        Value::real(second.map(|second| second.work.lo())),
        Value::real(second.map(|second| second.work.hi())),
        Value::text(met.map(|met| met.party.as_str()).or(party)),
        Value::real(met.map(|met| met.from_s).or(from_s)),
        Value::whole(answer.members.as_ref().map(|members| members.count)),
        Value::real(expected.map(|expected| expected.contact)),
        Value::real(spread.map(|spread| spread.best)),
        Value::real(spread.map(|spread| spread.regret)),
        Value::real(lead.map(|lead| lead.mean)),
        Value::real(lead.map(|lead| lead.error)),
        Value::whole(worlds.map(|worlds| worlds.count)),
        Value::real(expected.and_then(|expected| expected.worlds)),
        Value::text(flip.map(|flip| flip.doubt.name())),
        Value::real(flip.map(|flip| flip.lost)),
    ]
}

fn candidate<'r>(
    row: u64,
    place: i64,
    candidate: &'r CourseRow,
    answer: &'r Answer,
) -> [Value<'r>; 18] {
    let contact = candidate.contacts.first();
    let expected = candidate.expected.as_ref();
    let is_winner = answer.best().is_some_and(|best| best.name == candidate.name);
    [
        whole(row),
        Value::Whole(place),
        Value::Text(&candidate.name),
        Value::Flag(is_winner),
        Value::Flag(candidate.certain),
        Value::Flag(answer.tie_class.contains(&candidate.name)),
        Value::real(Some(candidate.work.lo())),
        Value::real(Some(candidate.work.hi())),
        Value::real(Some(candidate.range.low())),
        Value::real(Some(candidate.range.high())),
        count(candidate.contacts.len()),
        Value::text(contact.map(|contact| contact.party.as_str())),
        Value::real(contact.map(|contact| contact.time_s)),
        Value::real(contact.map(|contact| contact.closing_m_s)),
        Value::real(Some(candidate.energy_j.hi())),
        Value::real(expected.map(|expected| expected.contact)),
        Value::real(expected.and_then(|expected| expected.spread.as_ref()).map(|it| it.best)),
        Value::real(expected.and_then(|expected| expected.worlds)),
    ]
}

/// The table of inputs.
pub(crate) fn inputs(inputs: &[Input]) -> Table<'_, 8> {
    let mut table = Table::new(INPUTS);
    for input in inputs {
        let is_there = input.refusal.is_none();
        table.push([
            Value::Whole(input.number.into()),
            Value::Text(&input.name),
            Value::Text(&input.kind),
            Value::real(input.at_s),
            Value::Text(&input.source_hash),
            Value::whole(is_there.then_some(input.parties)),
            Value::whole(is_there.then_some(input.candidates)),
            Value::text(input.refusal.as_deref()),
        ]);
    }
    table
}

/// Adds the rows of a table to a hash: every value with its kind, numbers by their bits. It does
/// not depend on how Parquet writes them.
pub(crate) fn hash_rows<const N: usize>(table: &Table<'_, N>, hasher: &mut blake3::Hasher) {
    hasher.update(&(table.rows().len() as u64).to_le_bytes());
    for value in table.rows().iter().flatten() {
        match value {
            Value::Empty => hasher.update(b"-"),
            Value::Text(text) => {
                hasher.update(b"t").update(&(text.len() as u64).to_le_bytes());
                hasher.update(text.as_bytes())
            }
            Value::Whole(number) => hasher.update(b"w").update(&number.to_le_bytes()),
            Value::Real(number, _) => hasher.update(b"r").update(&number.to_bits().to_le_bytes()),
            Value::Flag(is_so) => hasher.update(if *is_so { b"y" } else { b"n" }),
        };
    }
}
