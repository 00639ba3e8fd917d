//! Orderings: a figure of one scene is at least that of another, whatever the figures are.
//!
//! Scenes lack the two lines that begin every scenario, schema and name.

use crate::progress::Progress;
use body::Seat;
use damage::Level;
use damage::injury::DEFAULT_CURVES;
use damage::plane::Ride;
use damage::policy::DEFAULT_POLICY;
use keys::Twice;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use trolley::{Answer, CourseRow, Engine, Failure, Limits, Scenario, SourceText, Texts};

/// The curves at several levels.
const LEVELS: &str = include_str!("../../config/curves/levels.toml");

/// Equal figures may differ by rounding.
const ROUNDING: f64 = 1e-9;

const KEYS: &str = "a file of orderings has schema, [scenes.NAME] (text, and level and curves \
                    where others than MAIS3+ count) and [[ordering]] (name, reason, source, two \
                    of more, less and value, factor); more and less have scene, candidate, of \
                    (risk, injured, delta-v, under, over), party and seat";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: String,
    scenes: BTreeMap<String, Scene>,
    ordering: Vec<Spanned<Written>>,
}

/// A scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scene {
    text: String,
    level: Option<Level>,
    curves: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    reason: String,
    source: String,
    more: Option<Measured>,
    less: Option<Measured>,
    value: Option<f64>,
    #[serde(default = "one")]
    factor: f64,
}

fn one() -> f64 {
    1.0
}

/// A figure of a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Measured {
    scene: String,
    candidate: String,
    of: What,
    party: Option<String>,
    seat: Option<Seat>,
}

/// Which figure.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum What {
    /// The risk of a person, the greatest of those that party and seat name.
    Risk,
    /// The expected number of injured: the sum of all risks.
    Injured,
    /// The change of velocity of the ego, or of the other (m/s), in its hardest contact.
    DeltaV,
    /// 1 if the party goes under the other, else 0.
    Under,
    /// 1 if the party goes over the other, else 0.
    Over,
}

/// An ordering that was read.
#[derive(Clone, Debug)]
pub(super) struct Ordering {
    file: String,
    pub(super) name: String,
    written: Written,
    scenes: Arc<BTreeMap<String, Scene>>,
}

/// An ordering, tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ordered {
    /// Its name.
    pub name: String,
    /// Why any sane model satisfies it.
    pub reason: String,
    /// Who says so.
    pub source: String,
    /// What must be more.
    pub more: f64,
    /// What must be no more than that: the other figure, times the factor.
    pub less: f64,
    /// Whether it holds.
    pub holds: bool,
}

/// Reads a file of orderings.
pub(super) fn read(name: &str, text: &str) -> Result<Vec<Ordering>, Failure> {
    let line = |at: usize| text.get(..at).unwrap_or("").matches('\n').count() + 1;
    let refused = |at: usize, what: &str| {
        Failure::input(what).at(format!("{name}:{}", line(at))).with_remedy(KEYS)
    };
    let file: File = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        match Twice::in_toml(text, &error) {
            Some(twice) => refused(at, &twice.what()).with_remedy(Twice::REMEDY),
            None => refused(at, error.message()),
        }
    })?;
    if file.schema != "trolley.orderings/1" {
        return Err(refused(0, "unknown schema: write schema = \"trolley.orderings/1\""));
    }
    let scenes = Arc::new(file.scenes);
    let mut all = Vec::new();
    for written in file.ordering {
        let at = written.span().start;
        let written = written.into_inner();
        for measured in [&written.more, &written.less].into_iter().flatten() {
            if !scenes.contains_key(&measured.scene) {
                return Err(refused(at, &format!("there is no scene \"{}\"", measured.scene)));
            }
        }
        let given = [written.more.is_some(), written.less.is_some(), written.value.is_some()];
        if given.iter().filter(|is_given| **is_given).count() != 2 {
            return Err(refused(at, "an ordering has two of more, less and value"));
        }
        if written.reason.trim().is_empty() || written.source.trim().is_empty() {
            return Err(refused(at, "an ordering has a reason and a source"));
        }
        let (file, name, scenes) = (name.to_owned(), written.name.clone(), scenes.clone());
        all.push(Ordering { file, name, written, scenes });
    }
    Ok(all)
}

/// Tries all orderings.
pub(super) fn run(
    orderings: &[Ordering],
    parameters: &SourceText,
    bar: &Progress<'_>,
) -> Result<Vec<Ordered>, Failure> {
    let mut engine = Engine::builder().in_process().build()?;
    let mut answers: BTreeMap<(String, String), (Scenario, Answer)> = BTreeMap::new();
    let mut tried = Vec::new();
    for ordering in orderings {
        let mut figure = |measured: &Measured| {
            let key = (ordering.file.clone(), measured.scene.clone());
            if !answers.contains_key(&key) {
                let answer = ordering.answer(&mut engine, parameters, &measured.scene)?;
                answers.insert(key.clone(), answer);
            }
            let (scenario, answer) = &answers[&key];
            measured.of(scenario, answer).map_err(|what| {
                Failure::input(format!("ordering \"{}\": {what}", ordering.name))
                    .at(&ordering.file)
                    .with_remedy(KEYS)
            })
        };
        let Written { reason, source, more, less, value, factor, .. } = &ordering.written;
        let mut given = |side: &Option<Measured>| match side {
            Some(measured) => figure(measured),
            None => Ok(value.unwrap_or(0.0)),
        };
        let more = given(more)?;
        let less = factor * given(less)?;
        tried.push(Ordered {
            name: ordering.name.clone(),
            reason: reason.clone(),
            source: source.clone(),
            more,
            less,
            holds: more >= less - ROUNDING * (1.0 + less.abs()),
        });
        bar.add(1);
    }
    Ok(tried)
}

impl Ordering {
    fn answer(
        &self,
        engine: &mut Engine,
        parameters: &SourceText,
        name: &str,
    ) -> Result<(Scenario, Answer), Failure> {
        let scene = &self.scenes[name];
        let level = scene.level.unwrap_or(Level::Mais3);
        let outcome = |level: Level| format!("outcome = \"{}\"", level.name());
        let policy = DEFAULT_POLICY.replacen(&outcome(Level::Mais3), &outcome(level), 1);
        let curves = match scene.curves.as_deref() {
            None | Some("default") => DEFAULT_CURVES,
            Some("levels") => LEVELS,
            Some(other) => {
                return Err(Failure::input(format!("scene \"{name}\": no curves \"{other}\""))
                    .at(&self.file)
                    .with_remedy("curves are \"default\" or \"levels\""));
            }
        };
        let text = |name: &str, text: String| SourceText { name: name.to_owned(), text };
        let scenario =
            format!("schema = \"trolley.scenario/2\"\nname = \"{name}\"\n{}", scene.text);
        let texts = Texts {
            scenario: text(&format!("{}, scene {name}", self.file), scenario),
            policy: text("policy", policy),
            curves: text("curves", curves.to_owned()),
            parameters: parameters.clone(),
        };
        let scenario = Scenario::of_texts(texts, Vec::new())?;
        let answer = engine.rank(&scenario, &Limits::default().with_members(1, None)?)?.answer;
        Ok((scenario, answer))
    }
}

impl Measured {
    fn of(&self, scenario: &Scenario, answer: &Answer) -> Result<f64, String> {
        // A name that is misspelt would be one whom nothing befalls.
        let parties = &scenario.parsed().parties;
        if let Some(named) = &self.party
            && !parties.iter().any(|party| *party.name == **named)
        {
            return Err(format!("there is no party \"{named}\""));
        }
        let row = answer.ranking.iter().find(|row| row.name == self.candidate);
        let row = row.ok_or_else(|| format!("there is no candidate \"{}\"", self.candidate))?;
        Ok(match self.of {
            What::Risk => self.risk(row),
            What::Injured => row.persons.iter().map(|person| person.work.hi()).sum(),
            What::DeltaV => {
                let side = usize::from(self.party.as_deref().is_some_and(|party| party != "ego"));
                let all = row.contacts.iter().map(|contact| contact.delta_v_m_s[side].work.hi());
                all.fold(0.0, f64::max)
            }
            What::Under => self.rides(row, Ride::Under),
            What::Over => self.rides(row, Ride::Over),
        })
    }

    fn risk(&self, row: &CourseRow) -> f64 {
        let is_meant = |party: &str, seat: Option<&str>| {
            self.party.as_deref().is_none_or(|wanted| wanted == party)
                && self.seat.is_none_or(|wanted| Some(wanted.name()) == seat)
        };
        let persons = row.persons.iter().filter(|one| is_meant(&one.party, one.seat));
        persons.map(|one| one.work.hi()).fold(0.0, f64::max)
    }

    fn rides(&self, row: &CourseRow, ride: Ride) -> f64 {
        let is_so = row.contacts.iter().filter_map(|contact| {
            let rides = contact.contact.as_ref()?.rides;
            let side = usize::from(self.party.as_deref().is_some_and(|party| party != "ego"));
            Some(rides[side] == ride)
        });
        f64::from(u8::from(is_so.into_iter().any(|is_so| is_so)))
    }
}
