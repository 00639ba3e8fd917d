//! A scenario that is read but for the files that its paths name.

use super::csv::CsvStates;
use super::path;
use super::{
    Candidate, GivenMotion, Motion, Party, Prediction, Reaction, Scenario, TEXT_BYTES_MAX, begin,
    check,
};
use crate::document::TextPosition;
use crate::engine::EngineSettings;
use crate::error::ScenarioError;
use crate::members::Members;
use crate::rules;
use crate::scenario::{FileRef, Name, PartyIndex};
use body::BodyKind;
use std::path::Path;
use std::time::Duration;

/// A scenario whose own text is checked, and whose CSV files are not read yet.
///
/// ```
/// use trolley_scenario::{ScenarioDraft, ScenarioError};
///
/// let text = r#"
/// schema = "trolley.scenario/2"
/// name = "A post ahead"
/// [parties]
/// ego = { generate = { shape = "sedan", triangles = 2000 } }
/// post = { generate = { shape = "pole", triangles = 500 }, place = { position_m = [30, 0, 0] } }
/// [[candidates]]
/// name = "brake"
/// path = { csv = "brake.csv" }
/// "#;
/// let draft = ScenarioDraft::parse("post.toml", text)?;
/// let names: Vec<&str> = draft.files().map(|file| file.path.as_str()).collect();
/// assert_eq!(names, ["brake.csv"]);
///
/// let brake = "t_s,x_m,y_m,yaw_deg\n0,0,0,0\n1,8,0,0\n2,12,0,0\n";
/// let scenario = draft.finish(|_| Ok::<_, ScenarioError>(brake.to_owned()))?;
/// let ego = &scenario.candidates[0].ego;
/// assert_eq!(ego.ends_s, Some(2.0));
/// assert_eq!(ego.path.pose_at(5.0).translation, [24.0, 0.0, 0.0]);
/// # Ok::<(), ScenarioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ScenarioDraft {
    pub(super) file: String,
    pub(super) name: String,
    pub(super) policy: Option<FileRef>,
    pub(super) curves: Option<FileRef>,
    pub(super) parameters: Option<FileRef>,
    pub(super) deadline: Option<Duration>,
    pub(super) engine: EngineSettings,
    pub(super) ego: PartyIndex,
    pub(super) horizon_s: f64,
    pub(super) resolution_m: f64,
    pub(super) members: Option<Members>,
    pub(super) parties: Vec<DraftParty>,
    pub(super) candidates: Vec<DraftCandidate>,
}

/// A party whose own predictions are still empty, and what they will be made of.
#[derive(Clone, Debug)]
pub(super) struct DraftParty {
    pub(super) party: Party,
    /// Each with its probability.
    pub(super) predictions: Vec<(f64, DraftMotion)>,
}

#[derive(Clone, Debug)]
pub(super) struct DraftCandidate {
    pub(super) name: Name,
    pub(super) place: TextPosition,
    pub(super) ego: DraftMotion,
    pub(super) reactions: Vec<(PartyIndex, DraftMotion)>,
}

#[derive(Clone, Debug)]
pub(super) enum DraftMotion {
    /// It stands in the scenario.
    Known(Motion),
    /// It stands in a file.
    Csv {
        /// The position of the path that names the file.
        place: TextPosition,
        file: FileRef,
    },
}

impl DraftMotion {
    fn file(&self) -> Option<&FileRef> {
        match self {
            Self::Known(_) => None,
            Self::Csv { file, .. } => Some(file),
        }
    }
}

impl ScenarioDraft {
    /// Reads a scenario but for the CSV files that it names. `file` is its name in errors; nothing
    /// is opened.
    ///
    /// # Errors
    ///
    /// The first fault found, with its place and what to do about it.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        if text.len() > TEXT_BYTES_MAX {
            let fault = format!("{} bytes are too many for a scenario", text.len());
            let help = format!(
                "a scenario has at most {TEXT_BYTES_MAX} bytes; write long paths into CSV \
                 files"
            );
            return Err(ScenarioError::new(file, TextPosition::START, fault, help));
        }
        check::draft(file, text)
    }

    /// The CSV files that paths name, in the order in which [`ScenarioDraft::finish`] asks for
    /// them; one that is named repeatedly stands here repeatedly.
    pub fn files(&self) -> impl Iterator<Item = &FileRef> {
        let predictions = self.parties.iter().flat_map(|draft| &draft.predictions);
        let candidates = self.candidates.iter().flat_map(|candidate| {
            let reactions = candidate.reactions.iter().map(|(_, motion)| motion);
            [&candidate.ego].into_iter().chain(reactions)
        });
        predictions.map(|(_, motion)| motion).chain(candidates).filter_map(DraftMotion::file)
    }

    /// The scenario, with the states in its CSV files. `read` gives the text of one.
    ///
    /// # Errors
    ///
    /// What `read` returned, as it is; or the first fault in a file: the file as the scenario names
    /// it, from the scenario's own folder, with line and column.
    pub fn finish<E: From<ScenarioError>>(
        self,
        mut read: impl FnMut(&FileRef) -> Result<String, E>,
    ) -> Result<Scenario, E> {
        let Self { file, parties, candidates, horizon_s, ego, .. } = self;
        let mut whole = |motion: DraftMotion, kind: Option<BodyKind>| match motion {
            DraftMotion::Known(motion) => Ok(motion),
            DraftMotion::Csv { place, file: csv } => {
                let text = read(&csv)?;
                let motion = from_csv(&beside(&file, &csv.path), &text, place, horizon_s)?;
                if let Some(kind) = kind {
                    rules::motion_fits(kind, &motion).map_err(|misfit| {
                        ScenarioError::new(&file, csv.place, misfit.what, misfit.remedy)
                    })?;
                }
                Ok::<_, E>(motion)
            }
        };
        let mut finished = Vec::with_capacity(parties.len());
        for DraftParty { mut party, predictions } in parties {
            let kind = party.source.kind();
            for (probability, motion) in predictions {
                let motion = whole(motion, kind)?;
                party.predictions.push(Prediction { probability, motion });
            }
            finished.push(party);
        }
        let mut ways = Vec::with_capacity(candidates.len());
        for DraftCandidate { name, place, ego, reactions } in candidates {
            let ego = whole(ego, None)?;
            // What is fixed to the ground has been refused here: it does not react.
            let reactions = reactions
                .into_iter()
                .map(|(party, motion)| Ok(Reaction { party, motion: whole(motion, None)? }));
            let reactions = reactions.collect::<Result<_, E>>()?;
            ways.push(Candidate { name, place, ego, reactions });
        }
        let scenario = Scenario {
            name: self.name,
            policy: self.policy,
            curves: self.curves,
            parameters: self.parameters,
            deadline: self.deadline,
            engine: self.engine,
            ego,
            horizon_s,
            resolution_m: self.resolution_m,
            members: self.members,
            parties: finished,
            candidates: ways,
        };
        begin::check(&file, &scenario)?;
        Ok(scenario)
    }
}

/// The motion that a CSV file describes.
fn from_csv(
    file: &str,
    text: &str,
    place: TextPosition,
    horizon_s: f64,
) -> Result<Motion, ScenarioError> {
    let states = CsvStates::parse(file, text)?;
    let given = GivenMotion::States(states.rows.clone());
    path::motion(given, horizon_s, place).map_err(|fault| states.error(fault))
}

/// A path as written in a file, from where that file's own name counts.
fn beside(file: &str, path: &str) -> String {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    folder.join(path).display().to_string()
}
