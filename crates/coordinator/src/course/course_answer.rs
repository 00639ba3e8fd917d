//! The answer over a horizon: order-free values only, as in [`crate::answer`].

use super::flags::{self, Alternative, AtHorizon, NearestRow, Outlines, Predicted};
use super::persons::People;
use super::remarks::remarks;
use super::stages::{ExpectedRow, MembersRow};
use super::way::{Begin, Scenery};
use super::worlds::WorldsRow;
use super::{AssessedContact, Course, Stuck};
use crate::answer::{self, PersonRow, PoseRow};
use bvh::support::Extremes;
use damage::course::Severity;
use damage::{
    AnswerState, ContactPatch, CourseHarm, DeltaV, Interval, Note, Place, Policy, Range,
    RankedCandidates, Unevaluable,
};
use executor::encounter::Encounters;
use schemars::JsonSchema;
use serde::Serialize;

/// The answer to a request.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Answer {
    /// How complete it is.
    pub state: AnswerState,
    /// The policy's name.
    pub policy: String,
    /// Candidates, least harm first.
    pub ranking: Vec<CourseRow>,
    /// Names of the candidates that the model cannot tell from the first, itself included.
    pub tie_class: Vec<String>,
    /// Further remarks on the ranking.
    pub notes: Vec<Note>,
    /// What was assumed for lack of data, in sentences.
    pub assumptions: Vec<String>,
    /// Number of leading places that no open work can change.
    pub settled_places: usize,
    /// What is missing: one sentence per candidate that is not fully known.
    pub missing: Vec<String>,
    /// What the scenario states that is allowed and hardly true; whoever knows the loaded bodies
    /// and the whole scenario fills it in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub implausible: Vec<scenario::Implausible>,
    /// The members that harm is the mean of; `None`: it is that of the scene as stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub members: Option<MembersRow>,
    /// Worlds that the model allows, where all work is done; `None` without members.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worlds: Option<WorldsRow>,
}

impl Answer {
    /// The candidate of least harm; `None` if there are no candidates, no bound can be given, or
    /// the policy lets none be chosen.
    #[must_use]
    pub fn best(&self) -> Option<&CourseRow> {
        let has_winner = self.state != AnswerState::Refused && self.refusal().is_none();
        self.ranking.first().filter(|_| has_winner)
    }

    /// The remark that the policy lets no candidate be chosen, if it does not.
    #[must_use]
    pub fn refusal(&self) -> Option<&Note> {
        self.notes.iter().find(|note| note.is_refusal())
    }
}

/// One candidate in its place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CourseRow {
    /// Its name.
    pub name: String,
    /// The policy's leading measure, over the work interval: [lo, hi].
    pub work: Interval,
    /// The policy's leading measure, over the model range: [low, high].
    pub range: Range,
    /// Whether the model is sure that it comes before the next.
    pub certain: bool,
    /// Why it comes before the next, in one sentence.
    pub why: Option<String>,
    /// Whom the ego meets until the end of its way, in the order of time. Empty: it touches nobody,
    /// which is proven where [`CourseRow::open_from_s`] is `None`.
    pub contacts: Vec<ContactRow>,
    /// Parties that the ego is in contact with at the start, and parts from: no crash.
    pub parts_from: Vec<String>,
    /// Parties of which it was not decided whether they or the ego lie inside each other at the
    /// start.
    pub maybe_inside: Vec<String>,
    /// From this time on (s) it is not known whom the ego meets; `None`: all is known.
    pub open_from_s: Option<f64>,
    /// Everybody who is harmed or may be, over all contacts together.
    pub persons: Vec<CoursePersonRow>,
    /// Kinetic energy lost in all contacts (J).
    pub energy_j: Interval,
    /// Where the ego goes after each heavy contact, until the next one.
    pub run_outs: Vec<RunOutRow>,
    /// The party that comes nearest on the way, of those that are not touched, if all is known.
    pub nearest: Option<NearestRow>,
    /// What is ahead at the end of the way, if that is known.
    pub at_horizon: Option<AtHorizon>,
    /// Predicted motions that were not followed, on which the ego would meet somebody.
    pub alternatives: Vec<Alternative>,
    /// What else has to be known, in sentences.
    pub remarks: Vec<String>,
    /// What members say, if there are any. `work`, `range`, `persons` and `energy_j` are then means
    /// over members; all else is of the scene as stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedRow>,
    /// Whether members were asked for, and there was time for none: all is of the scene as stated,
    /// and what happens in members is not known. The answer says so in [`Answer::missing`].
    #[serde(skip)]
    pub is_stated_alone: bool,
}

/// A run-out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RunOutRow {
    /// When it begins (s).
    pub from_s: f64,
    /// Velocity of the ego then, in the world (m/s).
    pub velocity_m_s: [f64; 2],
    /// Length until it stands (m), whether or not that is before the horizon.
    pub length_m: f64,
}

/// One contact of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ContactRow {
    /// The party that is met.
    pub party: String,
    /// When the bodies touch (s).
    pub time_s: f64,
    /// When they first touched in this crash (s): before `time_s` if that was a light touch, after
    /// which they did not part.
    pub first_touch_s: f64,
    /// Nothing touches before (s); within the resolution of `time_s`.
    pub excluded_before_s: f64,
    /// Whether triangles touch at that time; else they come as near as the resolution, which counts
    /// as contact.
    pub is_certain: bool,
    /// Whether the bodies are in contact at the start.
    pub is_at_start: bool,
    /// Whether the ego drives on.
    pub severity: Severity,
    /// The model range of the ego's change of velocity holds both severities.
    pub may_be_other: bool,
    /// Source ids of the two triangles that touch first: of the ego, of the party.
    pub triangles: [u32; 2],
    /// Which sides meet, for people: "front ↔ rear", or "left ∥ wall" where they mostly slide.
    pub sides: String,
    /// Whether the party is fixed to the ground.
    pub is_other_fixed: bool,
    /// What the contact is like; `None` if there are no figures.
    pub contact: Option<ContactPatch>,
    /// Number of triangles hit at any depth: of the ego, of the party.
    pub hits: [u64; 2],
    /// Hashes of the sets of hit triangles.
    pub hashes: [String; 2],
    /// Names of the parts hit at any depth: of the ego, of the party.
    pub parts: [Vec<String>; 2],
    /// Closing speed (m/s).
    pub closing_m_s: f64,
    /// Change of velocity of the ego and of the party (m/s).
    pub delta_v_m_s: [DeltaV; 2],
    /// The impulse on the party (N s), in the ego's frame.
    pub impulse_n_s: [f64; 3],
    /// Kinetic energy lost (J).
    pub energy_j: Interval,
    /// Everyone in this contact.
    pub persons: Vec<PersonRow>,
    /// Why there are no figures, if there are none.
    pub unevaluable: Option<Unevaluable>,
    /// Poses from first contact on.
    pub poses: Vec<PoseRow>,
}

/// One person over all contacts of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CoursePersonRow {
    /// The party that the person belongs to.
    pub party: String,
    /// The seat; `None` on foot, or on some seat.
    pub seat: Option<&'static str>,
    /// Probability of injury at the policy's level: [lo, hi].
    pub work: Interval,
    /// Probability of injury over the model range.
    pub range: Range,
}

impl CourseRow {
    /// Whether the ego touches nobody from the start to the end of its way, in any member: proven.
    #[must_use]
    pub fn touches_nobody(&self) -> bool {
        let is_decided = self.expected.as_ref().is_none_or(|of| of.undecided == 0);
        is_decided
            && self.hits_nobody()
            && self.parts_from.is_empty()
            && self.maybe_inside.is_empty()
    }

    /// Whether the ego hits nobody, in any member, though it may be in contact with somebody at the
    /// start.
    #[must_use]
    pub fn hits_nobody(&self) -> bool {
        let of_member =
            |expected: &ExpectedRow| expected.contact == 0.0 && expected.spread.is_some();
        let is_known = self.expected.as_ref().is_none_or(of_member);
        is_known && !self.is_stated_alone && self.contacts.is_empty() && self.open_from_s.is_none()
    }
}

/// What is said of candidates whatever the policy: all but figures of harm and their order.
#[derive(Clone, Debug)]
pub(super) struct Description {
    /// Per candidate, in the scenario's order, without figures of harm.
    pub(super) rows: Vec<CourseRow>,
    assumptions: Vec<String>,
    missing: Vec<String>,
}

impl Description {
    /// Of courses in the scene as stated; `is_drawn`: there are members, too. `extremes` as for
    /// [`Outlines::of`].
    pub(super) fn of(
        scenery: &Scenery<'_>,
        people: &People,
        courses: &[Course<'_>],
        (extremes, search, is_drawn): (&[Extremes], &mut Encounters, bool),
    ) -> Self {
        let outlines = Outlines::of(scenery, extremes);
        let predicted = Predicted::of(scenery);
        let all = courses.iter().enumerate();
        let rows = all.map(|(k, course)| {
            let mut row = row(scenery, (&outlines, &predicted), k, course);
            // Members take every predicted path as often as it is probable.
            if !is_drawn && course.open_from_s().is_none() {
                let way = (&course.way, &scenery.scenario.candidates[k]);
                row.alternatives = flags::alternatives(scenery, way, search);
            }
            row
        });
        let rows = rows.collect();
        let open = courses.iter().enumerate().filter_map(|(k, course)| {
            let missing = missing(scenery, course)?;
            Some(format!("{}: {missing}", scenery.scenario.candidates[k].name))
        });
        Self { rows, assumptions: assumptions(scenery, people, is_drawn), missing: open.collect() }
    }

    /// The answer with this harm of every candidate, in this order.
    pub(super) fn answer(
        self,
        (people, policy): (&People, &Policy),
        harms: &[CourseHarm],
        ranking: &RankedCandidates,
    ) -> Answer {
        let Self { rows, assumptions, missing } = self;
        let tied: Vec<String> = tie_class(ranking, &rows).map(|k| rows[k].name.clone()).collect();
        let names: Vec<String> = rows.iter().map(|row| row.name.clone()).collect();
        let mut rows: Vec<Option<CourseRow>> = rows.into_iter().map(Some).collect();
        let placed = ranking.places.iter().enumerate().filter_map(|(at, place)| {
            let k = place.candidate;
            let next = ranking.places.get(at + 1).map(|next| next.candidate);
            let why = place.why.as_ref().zip(next);
            let why = why.map(|(ground, next)| ground.sentence(&names[k], &names[next]));
            Some(rows[k].take()?.with_harm(people, (place, why), &harms[k]))
        });
        Answer {
            state: ranking.state,
            policy: policy.name.clone(),
            ranking: placed.collect(),
            tie_class: tied,
            notes: ranking.notes.clone(),
            assumptions,
            settled_places: ranking.settled,
            missing,
            implausible: Vec::new(),
            members: None,
            worlds: None,
        }
    }
}

/// The candidates that the model cannot tell from the first. One that is proven to touch nobody is
/// never worse than one that touches somebody, though there the range may begin at nobody harmed.
fn tie_class<'r>(
    ranking: &'r RankedCandidates,
    rows: &'r [CourseRow],
) -> impl Iterator<Item = usize> + use<'r> {
    let is_free = |k: usize| rows[k].contacts.is_empty() && rows[k].open_from_s.is_none();
    let first = ranking.places.first().map(|place| place.candidate);
    let is_first_free = first.is_some_and(is_free);
    ranking.tie_class.iter().copied().filter(move |k| !is_first_free || is_free(*k))
}

/// What is not known of a course; `None`: nothing.
fn missing(scenery: &Scenery<'_>, course: &Course<'_>) -> Option<String> {
    let name = |party: usize| &scenery.scenario.parties[party].name;
    let Some(Stuck { party, time_s, unevaluable }) =
        course.stuck.filter(|_| course.way.open_from_s.is_none())
    else {
        return course.open_from_s().map(|from_s| format!("whom it meets after {from_s:.3} s"));
    };
    let party = name(party);
    Some(match unevaluable {
        Some(Unevaluable::AlreadyOverlapping) => format!(
            "it and \"{party}\" overlap at the start and both stand still: that is no crash, and \
             what comes of it is not known"
        ),
        None => format!("the contact with \"{party}\" after {time_s:.3} s, and all that follows"),
    })
}

fn assumptions(scenery: &Scenery<'_>, people: &People, is_drawn: bool) -> Vec<String> {
    let scenario = scenery.scenario;
    let parties = scenario.parties.iter();
    let unknown = parties.clone().filter(|party| party.is_unknown);
    let unknown = unknown.map(|party| answer::unknown_sentence(&party.name));
    // Members take each as often as it is probable.
    let several = parties.enumerate().filter(|(_, party)| !is_drawn && party.predictions.len() > 1);
    let several = several.map(|(number, party)| {
        let (followed, _) = scenery.likeliest(number);
        format!(
            "of the {} predicted paths of \"{}\" number {} was followed, the most probable \
             ({:.2})",
            party.predictions.len(),
            party.name,
            followed + 1,
            party.predictions[followed].probability
        )
    });
    let ends = [(false, "go straight on from there"), (true, "stay there")];
    let ends = ends.into_iter().filter_map(|(stands, then)| {
        let of = scenery.others().filter_map(|number| {
            let motion = scenery.likeliest(number).1;
            let ends_s = motion.ends_s.filter(|_| motion.stands_at_end() == stands)?;
            Some(format!("\"{}\" ({ends_s:.2} s)", scenario.parties[number].name))
        });
        let of: Vec<String> = of.collect();
        let of = (!of.is_empty()).then(|| of.join(", "))?;
        Some(format!("paths end before the horizon, and these {then}: {of}"))
    });
    unknown.chain(people.assumptions(scenario)).chain(several).chain(ends).collect()
}

impl CourseRow {
    /// The row in its place, with its harm.
    fn with_harm(
        self,
        people: &People,
        (place, why): (&Place, Option<String>),
        harm: &CourseHarm,
    ) -> Self {
        let persons = harm.persons.iter().map(|risk| {
            let person = &people.list[risk.id.0];
            CoursePersonRow {
                party: person.party.to_string(),
                seat: person.seat.map(body::Seat::name),
                work: risk.work,
                range: risk.range,
            }
        });
        Self {
            work: place.work,
            range: place.range,
            certain: place.certain,
            why,
            persons: persons.collect(),
            energy_j: harm.energy_j,
            ..self
        }
    }
}

/// A candidate without figures of harm.
fn row(
    scenery: &Scenery<'_>,
    (outlines, predicted): (&Outlines, &Predicted),
    k: usize,
    course: &Course<'_>,
) -> CourseRow {
    let candidate = &scenery.scenario.candidates[k];
    let way = (&course.way, candidate);
    let is_met = |party: usize| {
        course.contacts.iter().any(|contact| contact.meeting.party == party)
            || course.way.passed_at_start.contains(&party)
    };
    let run_outs = course.way.run_outs.iter().map(|leg| RunOutRow {
        from_s: leg.from_s,
        velocity_m_s: leg.run_out.velocity_m_s,
        length_m: leg.run_out.length_m(),
    });
    let names = |parties: &[usize]| -> Vec<String> {
        let name = |party: &usize| scenery.scenario.parties[*party].name.to_string();
        parties.iter().map(name).collect()
    };
    // A late answer is not made later by what is only said.
    let is_known = course.open_from_s().is_none();
    CourseRow {
        name: candidate.name.to_string(),
        work: Interval::ZERO,
        range: Range::new(0.0, 0.0),
        certain: false,
        why: None,
        contacts: course.contacts.iter().map(|contact| contact_row(scenery, contact)).collect(),
        parts_from: names(&course.way.passed_at_start),
        maybe_inside: names(&course.way.undecided_at_start),
        open_from_s: course.open_from_s(),
        persons: Vec::new(),
        energy_j: Interval::ZERO,
        run_outs: run_outs.collect(),
        nearest: is_known
            .then(|| flags::nearest((scenery, outlines, predicted), way, is_met))
            .flatten(),
        at_horizon: is_known.then(|| flags::at_horizon((scenery, outlines), way, is_met)),
        alternatives: Vec::new(),
        remarks: remarks(scenery, k, course),
        expected: None,
        is_stated_alone: false,
    }
}

fn contact_row(scenery: &Scenery<'_>, contact: &AssessedContact) -> ContactRow {
    let AssessedContact { meeting, harm, .. } = contact;
    let touching = &meeting.touching;
    ContactRow {
        party: scenery.scenario.parties[meeting.party].name.to_string(),
        time_s: touching.time_s + 0.0,
        first_touch_s: contact.first_touch_s + 0.0,
        excluded_before_s: touching.excluded_before_s + 0.0,
        is_certain: touching.is_certain,
        is_at_start: meeting.begin == Begin::AtStart,
        severity: contact.severity,
        may_be_other: contact.may_be_other,
        triangles: touching.ids,
        sides: contact.sides.clone(),
        is_other_fixed: contact.is_other_fixed,
        contact: harm.contact.clone(),
        hits: contact.hits,
        hashes: contact.hashes.clone(),
        parts: contact.parts.clone(),
        closing_m_s: harm.closing_m_s,
        delta_v_m_s: harm.delta_v,
        impulse_n_s: harm.impulse_n_s,
        energy_j: harm.energy_j,
        persons: contact.persons.clone(),
        unevaluable: harm.unevaluable,
        poses: contact.poses.clone(),
    }
}
