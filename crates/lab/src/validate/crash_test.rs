//! Crash tests: each becomes a scene, whose first contact gives the computed change of velocity.

use super::object::{BARRIER_M, Object, car};
use crate::progress::Progress;
use body::{Shape, Shells};
use coordinator::{
    Backend, BodySet, CourseRequest, InProcessExecutor, RequestLimits, rank_courses,
};
use damage::parameters::Setting;
use damage::{Criteria, Parameters};
use keys::Twice;
use scenario::{Members, Scenario};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trolley::Failure;

/// Bias and rms that a group must keep (%).
const WITHIN: [f64; 2] = [10.0, 30.0];

/// The parameter that was fitted is tried at so many values.
const TRIED: usize = 12;

/// A test as its file says it. Keys that are not listed say how it was measured.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct CrashTest {
    id: String,
    group: String,
    size_m: [f64; 2],
    mass_kg: f64,
    object: Option<String>,
    overlap: Option<f64>,
    angle_deg: Option<f64>,
    speed_m_s: f64,
    dv_m_s: f64,
    #[serde(default)]
    source: String,
}

/// A test, measured and computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validated {
    /// Its id.
    pub id: String,
    /// Its group.
    pub group: String,
    /// Measured change of velocity (m/s).
    pub measured_m_s: f64,
    /// Computed change of velocity (m/s).
    pub computed_m_s: f64,
    /// The same with the fitted parameter that is best for the others of its group.
    pub left_out_m_s: Option<f64>,
    /// Who measured.
    pub source: String,
}

/// A group of tests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Number of tests.
    pub tests: usize,
    /// Mean of computed / measured − 1 (%).
    pub bias_percent: f64,
    /// Root mean square of the same (%).
    pub rms_percent: f64,
    /// With each test left out of the fit.
    pub left_out: Option<LeftOut>,
}

/// Bias and rms of tests that did not take part in the fit of their parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// The parameter.
    pub parameter: &'static str,
    /// Bias (%).
    pub bias_percent: f64,
    /// Root mean square (%).
    pub rms_percent: f64,
}

impl Group {
    /// Whether bias and rms are within ±10 % and 30 %.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.bias_percent.abs() <= WITHIN[0] && self.rms_percent <= WITHIN[1]
    }
}

/// Reads a file: a list of tests, or an object that has it as `tests`.
pub(super) fn read(name: &str, text: &str) -> Result<Vec<CrashTest>, Failure> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum File {
        List(Vec<CrashTest>),
        Object { tests: Vec<CrashTest> },
    }
    const FORM: &str = "a list of tests, each with id, group, size_m [length, width], mass_kg, \
                        speed_m_s, dv_m_s, and either object and overlap or angle_deg";
    if let Some(twice) = Twice::in_json(text) {
        let line = text[..twice.second.start].matches('\n').count() + 1;
        let fault = Failure::input(twice.what()).at(format!("{name}:{line}"));
        return Err(fault.with_remedy(Twice::REMEDY));
    }
    // The list first: its errors name a line, those of a choice do not.
    let tests = match serde_json::from_str::<Vec<CrashTest>>(text) {
        Ok(tests) => tests,
        Err(error) => match serde_json::from_str::<File>(text) {
            Ok(File::List(tests) | File::Object { tests }) => tests,
            Err(_) => {
                let place = format!("{name}:{}:{}", error.line(), error.column());
                return Err(Failure::input(error.to_string()).at(place).with_remedy(FORM));
            }
        },
    };
    for test in &tests {
        test.check().map_err(|what| {
            Failure::input(format!("test \"{}\": {what}", test.id)).at(name).with_remedy(FORM)
        })?;
    }
    Ok(tests)
}

impl CrashTest {
    fn check(&self) -> Result<(), String> {
        let within = |what: &str, x: f64, from: f64, to: f64| {
            if (from..=to).contains(&x) {
                Ok(())
            } else {
                Err(format!("{what} {x} is not from {from} to {to}"))
            }
        };
        within("length", self.size_m[0], 1.0, 20.0)?;
        within("width", self.size_m[1], 0.5, 4.0)?;
        within("mass_kg", self.mass_kg, 100.0, 60_000.0)?;
        within("speed_m_s", self.speed_m_s, 1.0, 60.0)?;
        within("dv_m_s", self.dv_m_s, 0.01, 100.0)?;
        match (self.angle_deg, &self.object, self.overlap) {
            (Some(angle), _, _) => within("angle_deg", angle, 1.0, 89.0),
            (None, Some(object), Some(overlap)) => {
                within("overlap", overlap, 0.01, 1.0)?;
                Object::of_words(object)
                    .map(drop)
                    .ok_or_else(|| format!("object \"{object}\" is no wall, pole or barrier"))
            }
            _ => Err("it has neither an angle nor an object with an overlap".to_owned()),
        }
    }

    fn object(&self) -> Object {
        let of_words = || self.object.as_deref().and_then(Object::of_words);
        if self.angle_deg.is_some() {
            Object::Barrier
        } else {
            of_words().unwrap_or(Object::Barrier)
        }
    }

    /// The scene: the car drives along x; objects and their sizes as the test has them.
    fn scenario(&self) -> Result<Scenario, Failure> {
        let [length, width] = self.size_m;
        let object = self.object();
        let (x, y, yaw) = match self.angle_deg {
            // The middle of the barrier lies ahead; the car meets it some metres before.
            Some(angle) => (0.5 * length + 8.0, 0.0, angle),
            None => {
                let edge = width * (0.5 - self.overlap.unwrap_or(1.0));
                (0.5 * length + 3.0 + object.half_depth_m(), edge + object.half_width_m(), 0.0)
            }
        };
        let horizon = ((x + BARRIER_M) / self.speed_m_s).clamp(0.5, 10.0);
        let text = format!(
            "schema = \"trolley.scenario/2\"\nname = \"crash test\"\nhorizon_s = {horizon:?}\n\
             [parties.ego]\nmass_kg = {:?}\ngenerate = {{ shape = \"sedan\", triangles = 600 }}\n\
             [parties.object]\ngenerate = {{ shape = \"{}\", triangles = 600 }}\n\
             place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?} }}\n\
             [[candidates]]\nname = \"test\"\n\
             state = {{ position_m = [0, 0, 0], speed_m_s = {:?} }}\n",
            self.mass_kg,
            object.shape().name(),
            self.speed_m_s,
        );
        Scenario::parse("crash-test.toml", &text)
            .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))
    }
}

/// The bodies and the scene of a test, to be ranked again and again.
struct Staged {
    bodies: [body::Body; 2],
    scenario: Scenario,
}

impl Staged {
    fn new(test: &CrashTest) -> Result<Self, Failure> {
        // Pick-ups are tall.
        let shape = if test.mass_kg > 2000.0 { Shape::Suv } else { Shape::Sedan };
        let bodies = [car(shape, test.size_m)?, test.object().body()?];
        Ok(Self { bodies, scenario: test.scenario()? })
    }

    /// The ego's change of velocity at its first contact (m/s).
    fn delta_v_m_s(&self, criteria: &Criteria) -> Result<f64, Failure> {
        let views = self.bodies.each_ref().map(|body| (body.meta.clone(), body.view()));
        let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        let stage = BodySet { bodies: &views, extremes: None, depth: 4 };
        let request = CourseRequest {
            scenario: &self.scenario,
            models: &[0, 1],
            shells: &shells,
            criteria: criteria.clone(),
            members: Members::NOMINAL,
            worlds: scenario::Worlds::USUAL,
            history: false,
            explanation: false,
            scene: false,
        };
        let executor = Box::new(InProcessExecutor::with_room_for(&views));
        let mut backend = Backend::InProcess(executor);
        let ranked = rank_courses(&stage, &request, RequestLimits::default(), &mut backend)?;
        let contacts = ranked.answer.ranking.iter().flat_map(|row| &row.contacts);
        let first = contacts.map(|contact| contact.delta_v_m_s[0].work.hi()).next();
        first.ok_or_else(|| Failure::internal("a car in a crash test touches nothing"))
    }
}

/// The parameter that was fitted on a group of tests, and how it is set.
struct Fitted {
    name: &'static str,
    range: [f64; 2],
    set: fn(&mut Parameters, f64),
}

fn fitted(object: Object) -> Fitted {
    match object {
        Object::Barrier => Fitted {
            name: "face_restitution_more",
            range: [0.0, 0.4],
            set: |parameters, value| parameters.face_restitution_more = value,
        },
        Object::Wall { .. } | Object::Pole { .. } => Fitted {
            name: "friction",
            range: [0.3, 1.2],
            set: |parameters, value| {
                parameters.friction = Setting { low: value, nominal: value, high: value };
            },
        },
    }
}

/// Runs all tests, each also with the parameter that is best for the others.
pub(super) fn run(
    tests: &[CrashTest],
    criteria: &Criteria,
    bar: &Progress<'_>,
) -> Result<(Vec<Validated>, Vec<Group>), Failure> {
    let mut computed = Vec::new();
    // Per test: the change of velocity at each value of its fitted parameter.
    let mut tried: Vec<Vec<f64>> = Vec::new();
    for test in tests {
        let staged = Staged::new(test)?;
        computed.push(staged.delta_v_m_s(criteria)?);
        let fitted = fitted(test.object());
        let value_at = |k: usize| {
            let share = k as f64 / (TRIED - 1) as f64;
            let mut parameters = (*criteria.parameters).clone();
            let [from, to] = fitted.range;
            (fitted.set)(&mut parameters, from + share * (to - from));
            let criteria = Criteria { parameters: Arc::new(parameters), ..criteria.clone() };
            staged.delta_v_m_s(&criteria)
        };
        tried.push((0..TRIED).map(value_at).collect::<Result<_, _>>()?);
        bar.add(1);
    }
    let error = |k: usize, value: f64| value / tests[k].dv_m_s - 1.0;
    let mut names: Vec<&str> = Vec::new();
    for test in tests {
        if !names.contains(&test.group.as_str()) {
            names.push(&test.group);
        }
    }
    let mut left_out: Vec<Option<f64>> = vec![None; tests.len()];
    let mut groups = Vec::new();
    for name in names {
        let members: Vec<usize> = (0..tests.len()).filter(|k| tests[*k].group == name).collect();
        if members.len() > 1 {
            for &out in &members {
                let others = |value: usize| -> f64 {
                    let squares = members.iter().filter(|k| **k != out).map(|&k| {
                        let off = error(k, tried[k][value]);
                        off * off
                    });
                    squares.sum()
                };
                let best = (0..TRIED).min_by(|a, b| others(*a).total_cmp(&others(*b)));
                left_out[out] = best.map(|value| tried[out][value]);
            }
        }
        let [bias_percent, rms_percent] =
            bias_and_rms(members.iter().map(|&k| error(k, computed[k])));
        let without: Option<Vec<f64>> =
            members.iter().map(|&k| left_out[k].map(|value| error(k, value))).collect();
        groups.push(Group {
            name: name.to_owned(),
            tests: members.len(),
            bias_percent,
            rms_percent,
            left_out: without.map(|errors| {
                let [bias_percent, rms_percent] = bias_and_rms(errors.into_iter());
                let parameter = fitted(tests[members[0]].object()).name;
                LeftOut { parameter, bias_percent, rms_percent }
            }),
        });
    }
    let validated = tests.iter().enumerate().map(|(k, test)| Validated {
        id: test.id.clone(),
        group: test.group.clone(),
        measured_m_s: test.dv_m_s,
        computed_m_s: computed[k],
        left_out_m_s: left_out[k],
        source: test.source.clone(),
    });
    Ok((validated.collect(), groups))
}

/// Mean and root mean square, in per cent.
fn bias_and_rms(errors: impl Iterator<Item = f64>) -> [f64; 2] {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for error in errors {
        count += 1.0;
        sum += error;
        squares += error * error;
    }
    if count == 0.0 {
        return [0.0; 2];
    }
    [100.0 * sum / count, 100.0 * (squares / count).sqrt()]
}
