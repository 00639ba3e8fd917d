//! From the form of a scenario over a horizon to values, but for what stands in other files.

use super::draft::{DraftCandidate, DraftMotion, DraftParty, ScenarioDraft};
use super::path::{self, RowFault};
use super::raw;
use super::{GivenMotion, GivenState, Occupancy, OccupantGroup, Party, SCHEMA};
use crate::document::{Document, Path};
use crate::error::{Misfit, ScenarioError};
use crate::fault::{self, At, Fault};
use crate::fields::{self, Head, PartyBody, WrittenBody};
use crate::limit::{self, Show};
use crate::members::Errors;
use crate::names::{self, quoted};
use crate::raw::Table;
use crate::rules;
use crate::scenario::PartyIndex;
use body::{BodyKind, Seat};
use std::collections::BTreeMap;

mod doubt;

/// Reads and checks a scenario.
pub(super) fn draft(file: &str, text: &str) -> Result<ScenarioDraft, ScenarioError> {
    fault::read(file, text, SCHEMA, |raw: raw::Scenario, document| {
        let root = Path::default();
        let written = fields::number(raw.horizon_s, "horizon_s", limit::HORIZON_S, &root)?;
        let horizon_s = written.unwrap_or(DEFAULT_HORIZON_S);
        Checker { file, document, horizon_s }.draft(raw)
    })
}

/// What holds where nothing is written: a car stops from 130 km/h in about 5 s.
pub(super) const DEFAULT_HORIZON_S: f64 = 5.0;
/// What holds where nothing is written: less than any body is known to.
pub(crate) const DEFAULT_RESOLUTION_M: f64 = 0.001;

struct Checker<'d> {
    file: &'d str,
    document: &'d Document<'d>,
    horizon_s: f64,
}

/// The motions that a party or a candidate may be written with: exactly one.
struct WrittenMotion {
    place: Option<Table<raw::Place>>,
    state: Option<Table<raw::State>>,
    paths: Vec<Table<raw::Prediction>>,
}

impl Checker<'_> {
    fn draft(&self, raw: raw::Scenario) -> Result<ScenarioDraft, Fault> {
        let root = Path::default();
        let Head { policy, curves, parameters, deadline, engine } = Head::new(
            self.document,
            &raw.name,
            [raw.policy, raw.curves, raw.parameters],
            raw.deadline_ms,
            &raw.engine.0,
        )?;
        let resolution_m =
            fields::number(raw.resolution_m, "resolution_m", limit::RESOLUTION_M, &root)?;
        let members = doubt::members(raw.members, raw.members_max)?;
        let (parties, ego) = self.parties(raw.parties, raw.ego)?;
        let candidates = self.candidates(raw.candidates.unwrap_or_default(), &parties, ego)?;
        Ok(ScenarioDraft {
            file: self.file.to_owned(),
            name: raw.name,
            policy,
            curves,
            parameters,
            deadline,
            engine,
            ego,
            horizon_s: self.horizon_s,
            resolution_m: resolution_m.unwrap_or(DEFAULT_RESOLUTION_M),
            members,
            parties,
            candidates,
        })
    }

    fn parties(
        &self,
        raw: BTreeMap<String, Table<raw::Party>>,
        ego: Option<String>,
    ) -> Result<(Vec<DraftParty>, PartyIndex), Fault> {
        fields::count_parties(raw.len(), limit::PARTIES)?;
        let parent = Path::default().key("parties");
        let mut parties = Vec::with_capacity(raw.len());
        let mut written = Vec::with_capacity(raw.len());
        let mut persons = 0;
        for (key, Table(raw)) in raw {
            let path = parent.key(&key);
            let (party, motion, errors) = self.party(key, raw, &path)?;
            persons += party.occupancy.count().unwrap_or(0);
            if persons > limit::SCENARIO_OCCUPANTS_MAX {
                let fault = format!("up to here there are {persons} persons");
                let help =
                    format!("a scenario has at most {} persons", limit::SCENARIO_OCCUPANTS_MAX);
                return Err(Misfit::new("persons", fault, help)).at(&path.key("persons"));
            }
            parties.push(DraftParty { party, predictions: Vec::new() });
            written.push((motion, errors));
        }
        let known = parties
            .iter()
            .map(|DraftParty { party, .. }| (party.name.as_str(), &party.source, party.is_unknown));
        let ego = fields::ego(ego.as_deref(), known)?;
        for (index, (draft, (motion, errors))) in parties.iter_mut().zip(written).enumerate() {
            let path = parent.key(&draft.party.name);
            let kind = draft.party.source.kind();
            let is_ego = PartyIndex(index) == ego;
            draft.party.errors = doubt::errors(errors, is_ego, &path.key("errors"))?;
            if is_ego {
                motion.has_none(&draft.party.name, &path)?;
            } else {
                draft.predictions = self.predictions(motion, &draft.party.name, kind, &path)?;
            }
        }
        Ok((parties, ego))
    }

    /// A party without its motions and errors, and these as written.
    fn party(
        &self,
        key: String,
        raw: raw::Party,
        path: &Path,
    ) -> Result<(Party, WrittenMotion, Option<Table<raw::Errors>>), Fault> {
        let raw::Party {
            file,
            generate,
            kind,
            size_m,
            mass_kg,
            persons,
            empty,
            responsibility,
            crush,
            errors,
            place,
            state,
            paths,
        } = raw;
        let body = WrittenBody { file, generate, kind, size_m, mass_kg, responsibility, crush };
        let body = PartyBody::new(self.document, &key, body, path)?;
        let occupancy = occupancy(persons, empty, body.source.kind(), path)?;
        body.check_unknown(occupancy != Occupancy::Default, path)?;
        if let Some(paths) = &paths
            && !limit::PREDICTIONS.holds(paths.len())
        {
            let fault = format!("{} paths are given", paths.len());
            let help = format!("write {} paths", limit::PREDICTIONS.range());
            return Err(Misfit::new("paths", fault, help)).at(&path.key("paths"));
        }
        let party = Party {
            name: key.into(),
            place: body.place,
            source: body.source,
            size: body.size,
            mass_kg: body.mass_kg,
            occupancy,
            responsibility: body.responsibility,
            is_unknown: body.is_unknown,
            crush: body.crush,
            errors: Errors::usual(false),
            predictions: Vec::new(),
        };
        Ok((party, WrittenMotion { place, state, paths: paths.unwrap_or_default() }, errors))
    }

    /// The motions of a party other than the ego, with their probabilities.
    fn predictions(
        &self,
        written: WrittenMotion,
        name: &str,
        kind: Option<BodyKind>,
        path: &Path,
    ) -> Result<Vec<(f64, DraftMotion)>, Fault> {
        const HELP: &str = "write place = { position_m = … } for what stands still, state = { … } \
                            for what goes on as it moves, or paths = [{ … }]";
        match (written.place, written.state, written.paths) {
            (Some(Table(raw)), None, paths) if paths.is_empty() => {
                Ok(vec![(1.0, self.place(&raw, &path.key("place"))?)])
            }
            (None, Some(Table(raw)), paths) if paths.is_empty() => {
                Ok(vec![(1.0, self.state(&raw, kind, &path.key("state"))?)])
            }
            (None, None, paths) if !paths.is_empty() => {
                self.predicted_paths(paths, kind, &path.key("paths"))
            }
            (None, None, _) => {
                let fault = format!("nothing is said about where party {} goes", quoted(name));
                Err(Misfit::new("paths", fault, HELP)).at(path)
            }
            _ => {
                let fault = format!("party {} moves in several ways", quoted(name));
                Err(Misfit::new("paths", fault, HELP)).at(path)
            }
        }
    }

    fn predicted_paths(
        &self,
        raw: Vec<Table<raw::Prediction>>,
        kind: Option<BodyKind>,
        parent: &Path,
    ) -> Result<Vec<(f64, DraftMotion)>, Fault> {
        let is_only = raw.len() == 1;
        let mut predictions = Vec::with_capacity(raw.len());
        let mut sum = 0.0;
        for (index, Table(raw)) in raw.into_iter().enumerate() {
            let path = parent.index(index);
            let (probability, raw) = raw.split();
            let probability = fields::number(probability, "probability", limit::SHARE, &path)?;
            let probability = match probability {
                Some(probability) => probability,
                None if is_only => 1.0,
                None => {
                    let help = "write probability = … in each of several paths";
                    return Err(Misfit::new("probability", "probability is missing", help))
                        .at(&path);
                }
            };
            sum += probability;
            predictions.push((probability, self.path(raw, kind, &path)?));
        }
        if (sum - 1.0).abs() > limit::PROBABILITY_SUM_OFF {
            let fault = format!("the probabilities sum to {}", sum.show());
            let help = "what a party may do sums to 1: add what is missing, or scale them";
            let last = parent.index(predictions.len() - 1);
            return Err(Misfit::new("probability", fault, help)).at(&last.key("probability"));
        }
        Ok(predictions)
    }

    fn candidates(
        &self,
        raw: Vec<Table<raw::Candidate>>,
        parties: &[DraftParty],
        ego: PartyIndex,
    ) -> Result<Vec<DraftCandidate>, Fault> {
        fields::count_candidates(raw.len())?;
        let parent = Path::default().key("candidates");
        let mut checked: Vec<DraftCandidate> = Vec::with_capacity(raw.len());
        for (index, Table(raw)) in raw.into_iter().enumerate() {
            let path = parent.index(index);
            let before = checked.iter().map(|twin| (twin.name.as_str(), twin.place));
            fields::is_new(&raw.name, before, &path)?;
            fields::name("name", &raw.name).at(&path.key("name"))?;
            let kind = parties[ego.0].party.source.kind();
            let ego_motion = self.motion(None, raw.state, raw.path, kind, &path)?;
            let reactions = raw.reactions.into_iter().map(|(key, Table(raw))| {
                self.reaction(&key, raw, parties, ego, &path.key("reactions").key(&key))
            });
            checked.push(DraftCandidate {
                place: self.document.place(&path),
                name: raw.name.into(),
                ego: ego_motion,
                reactions: reactions.collect::<Result<_, _>>()?,
            });
        }
        Ok(checked)
    }

    fn reaction(
        &self,
        key: &str,
        raw: raw::Reaction,
        parties: &[DraftParty],
        ego: PartyIndex,
        path: &Path,
    ) -> Result<(PartyIndex, DraftMotion), Fault> {
        let Some(index) = parties.iter().position(|draft| draft.party.name == key) else {
            let known: Vec<&str> = parties.iter().map(|draft| draft.party.name.as_str()).collect();
            return Err(fields::undefined("reactions", key, &known, "")).at(path);
        };
        if index == ego.0 {
            let fault = format!("party {} is the ego: it does not react to itself", quoted(key));
            let help = "write its motion into the candidate: path = { … }, or state = { … }";
            return Err(Misfit::new("reactions", fault, help)).at(path);
        }
        let kind = parties[index].party.source.kind();
        kind.map_or(Ok(()), rules::can_react).at(path)?;
        let motion = self.motion(raw.place, raw.state, raw.path, kind, path)?;
        Ok((PartyIndex(index), motion))
    }

    /// Exactly one motion.
    fn motion(
        &self,
        place: Option<Table<raw::Place>>,
        state: Option<Table<raw::State>>,
        written: Option<Table<raw::Path>>,
        kind: Option<BodyKind>,
        parent: &Path,
    ) -> Result<DraftMotion, Fault> {
        match (place, state, written) {
            (Some(Table(raw)), None, None) => self.place(&raw, &parent.key("place")),
            (None, Some(Table(raw)), None) => self.state(&raw, kind, &parent.key("state")),
            (None, None, Some(Table(raw))) => self.path(raw, kind, &parent.key("path")),
            (place, state, written) => {
                let is_none = place.is_none() && state.is_none() && written.is_none();
                let fault =
                    if is_none { "no motion is given" } else { "several motions are given" };
                let help = "write path = { states = [{ … }] }, path = { csv = \"….csv\" }, or \
                            state = { … } for what goes on as it moves";
                Err(Misfit::new("path", fault, help)).at(parent)
            }
        }
    }

    fn place(&self, raw: &raw::Place, path: &Path) -> Result<DraftMotion, Fault> {
        let position_m = fields::numbers(&raw.position_m, "position_m", limit::POSITION_M, path)?;
        let angles_deg = fields::angles([raw.yaw_deg, raw.pitch_deg, raw.roll_deg], path)?;
        self.known(GivenMotion::Place { position_m, angles_deg }, None, path)
    }

    fn state(
        &self,
        raw: &raw::State,
        kind: Option<BodyKind>,
        path: &Path,
    ) -> Result<DraftMotion, Fault> {
        let position_m = fields::numbers(&raw.position_m, "position_m", limit::POSITION_M, path)?;
        let angles_deg = fields::angles([raw.yaw_deg, raw.pitch_deg, raw.roll_deg], path)?;
        let velocity_m_s = fields::velocity(
            raw.speed_m_s,
            raw.velocity_m_s.as_deref(),
            angles_deg[0],
            limit::PATH_SPEED_M_S,
            path,
        )?;
        let rate =
            fields::number(raw.yaw_rate_deg_s, "yaw_rate_deg_s", limit::TURN_RATE_DEG_S, path)?;
        let yaw_rate_deg_s = rate.unwrap_or(0.0);
        let given = GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s };
        self.known(given, kind, path)
    }

    /// States here or in a file.
    fn path(
        &self,
        raw: raw::Path,
        kind: Option<BodyKind>,
        path: &Path,
    ) -> Result<DraftMotion, Fault> {
        match (raw.states, raw.csv) {
            (Some(states), None) => {
                let rows = rows(&states, &path.key("states"))?;
                self.known(GivenMotion::States(rows), kind, path)
            }
            (None, Some(csv)) => Ok(DraftMotion::Csv {
                place: self.document.place(path),
                file: fields::file_ref(self.document, "csv", csv, path)?,
            }),
            (both, _) => {
                let count = if both.is_some() { "both states and" } else { "neither states nor" };
                let fault = format!("the path has {count} csv");
                let help = "write states = [{ t_s = 0, position_m = [x, y, z] }, …], or csv = \
                            \"….csv\"";
                Err(Misfit::new("states", fault, help)).at(path)
            }
        }
    }

    /// A motion of a body of this kind, which must not move if it is fixed to the ground.
    fn known(
        &self,
        given: GivenMotion,
        kind: Option<BodyKind>,
        path: &Path,
    ) -> Result<DraftMotion, Fault> {
        let place = self.document.place(path);
        let has_states = matches!(given, GivenMotion::States(_));
        let motion = path::motion(given, self.horizon_s, place);
        let motion = motion.map_err(|RowFault { row, misfit }| {
            let list = path.key("states");
            let path = match row {
                Some(row) => list.index(row).key(misfit.setting),
                None if has_states => list,
                None => path.key(misfit.setting),
            };
            Fault { path, misfit }
        })?;
        kind.map_or(Ok(()), |kind| rules::motion_fits(kind, &motion)).at(path)?;
        Ok(DraftMotion::Known(motion))
    }
}

impl WrittenMotion {
    /// Whether nothing is written, as it must be for the ego.
    fn has_none(&self, name: &str, path: &Path) -> Result<(), Fault> {
        let key = match (&self.place, &self.state, &self.paths[..]) {
            (None, None, []) => return Ok(()),
            (Some(_), ..) => "place",
            (None, Some(_), _) => "state",
            (None, None, _) => "paths",
        };
        let fault = format!("party {} is the ego: its motion is in the candidates", quoted(name));
        let help = format!("leave {key} out");
        Err(Misfit::new("ego", fault, help)).at(&path.key(key))
    }
}

/// Who is in a body of this kind, if that is known.
fn occupancy(
    persons: Option<Vec<Table<raw::Person>>>,
    empty: Option<bool>,
    kind: Option<BodyKind>,
    path: &Path,
) -> Result<Occupancy, Fault> {
    let occupancy = match (persons, empty) {
        (None, None) => Occupancy::Default,
        (Some(persons), None) => Occupancy::Stated(groups(&persons, kind, &path.key("persons"))?),
        (None, Some(true)) => Occupancy::Empty,
        (None, Some(false)) => {
            let help = "write persons = [{ … }] if somebody is inside, or leave empty out if \
                        nobody knows";
            return Err(Misfit::new("empty", "empty is false", help)).at(&path.key("empty"));
        }
        (Some(_), Some(_)) => {
            let help = "leave empty out, or persons";
            let fault = "a party has both persons and empty";
            return Err(Misfit::new("empty", fault, help)).at(&path.key("empty"));
        }
    };
    kind.map_or(Ok(()), |kind| rules::occupancy_fits(kind, &occupancy)).at(&path.key("empty"))?;
    Ok(occupancy)
}

fn groups(
    raw: &[Table<raw::Person>],
    kind: Option<BodyKind>,
    path: &Path,
) -> Result<Vec<OccupantGroup>, Fault> {
    if raw.is_empty() {
        let help = "write empty = true if nobody is inside, or leave persons out if nobody knows";
        return Err(Misfit::new("persons", "persons names nobody", help)).at(path);
    }
    let mut groups = Vec::new();
    let mut persons = 0;
    for (index, Table(raw)) in raw.iter().enumerate() {
        let item = path.index(index);
        let meaning = |seat: &String| names::meaning::<Seat>("seat", seat);
        let seat = raw.seat.as_ref().map(meaning).transpose().at(&item.key("seat"))?;
        let count = raw.count.unwrap_or(1);
        let count: u32 = limit::OCCUPANTS.whole("count", count).at(&item.key("count"))?;
        if let Some(seat) = seat
            && count > 1
        {
            let fault = format!("{count} persons cannot have the seat {:?}", seat.name());
            let help = "leave count out, or seat if it is not known who sits where";
            return Err(Misfit::new("count", fault, help)).at(&item.key("count"));
        }
        let group = OccupantGroup { seat, count };
        let key = if raw.seat.is_some() { "seat" } else { "count" };
        rules::group_fits(kind, group, &groups).at(&item.key(key))?;
        persons += i64::from(count);
        if !limit::OCCUPANTS.holds(persons) {
            let fault = format!("up to here there are {persons} persons");
            let help = format!("a party has at most {} persons", limit::OCCUPANTS.most);
            return Err(Misfit::new("persons", fault, help)).at(&item);
        }
        groups.push(group);
    }
    Ok(groups)
}

/// The states that stand in the scenario itself.
fn rows(raw: &[Table<raw::PathState>], list: &Path) -> Result<Vec<GivenState>, Fault> {
    if raw.len() > limit::PATH_STATES.most {
        let fault = format!("{} states are too many", raw.len());
        let help = format!(
            "a path has at most {} states here, and {} in a file: csv = \"….csv\"",
            limit::PATH_STATES.most,
            limit::CSV_ROWS.most
        );
        return Err(Misfit::new("states", fault, help)).at(list);
    }
    let row = |(index, Table(raw)): (usize, &Table<raw::PathState>)| {
        let path = list.index(index);
        let time_s = limit::PATH_TIME_S.check("t_s", raw.t_s).at(&path.key("t_s"))? + 0.0;
        let position_m = fields::numbers(&raw.position_m, "position_m", limit::POSITION_M, &path)?;
        let angles_deg = fields::angles([raw.yaw_deg, raw.pitch_deg, raw.roll_deg], &path)?;
        let velocity = raw.velocity_m_s.as_ref();
        let velocity_m_s = velocity
            .map(|velocity| fields::plane_velocity(velocity, limit::PATH_SPEED_M_S, &path))
            .transpose()?;
        Ok(GivenState { time_s, position_m, angles_deg, velocity_m_s })
    };
    raw.iter().enumerate().map(row).collect()
}
