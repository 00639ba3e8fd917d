//! Reading a set of curves from TOML, and the checks that refuse an unsound one.

use super::{Curves, DEFAULT_CURVES, Quantity, RangeEnd, Rung, Speeds, Victim};
use crate::curve::{Curve, CurveUnit, FrontTerm, Level};
use crate::fault::{DataFileError, Source};
use core::ops::Range;
use serde::Deserialize;
use toml::Spanned;

/// The ladder is checked up to this speed (m/s) ...
const LADDER_END_M_S: f64 = 40.0;
/// ... at so many steps per m/s.
const LADDER_STEPS: u32 = 10;
/// Heights of fronts at which it is checked (m).
const FRONTS_M: [f64; 3] = [0.0, 0.9, 1.24];
/// Rounding is no breach.
const LADDER_SLACK: f64 = 1e-12;

const KEYS: &str = "a curve file has schema, name, mixed_origins, [[curve]] (id, outcome, unit, \
                    a, b, front, valid, source, year, sample, origin, note) and [[person]] \
                    (victim, level, x, nominal, at_most, low, high); age, sex and condition have \
                    no place in it";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: Spanned<u32>,
    name: String,
    #[serde(default)]
    mixed_origins: String,
    curve: Vec<Spanned<CurveText>>,
    person: Vec<Spanned<PersonText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveText {
    id: Spanned<String>,
    outcome: Level,
    unit: CurveUnit,
    a: Spanned<f64>,
    b: Spanned<f64>,
    front: Option<Spanned<FrontTerm>>,
    valid: Spanned<[f64; 2]>,
    source: Spanned<String>,
    year: Spanned<u16>,
    sample: Spanned<String>,
    origin: Spanned<String>,
    #[serde(default)]
    note: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PersonText {
    victim: VictimText,
    level: Level,
    x: Quantity,
    nominal: Spanned<String>,
    at_most: Option<Spanned<String>>,
    low: Spanned<EndText>,
    high: Spanned<EndText>,
}

/// Of whom a table speaks: `occupant-side` of both sides.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum VictimText {
    OccupantFront,
    OccupantSide,
    OccupantNear,
    OccupantFar,
    OccupantRear,
    Pedestrian,
    Cyclist,
    Motorcyclist,
}

impl VictimText {
    fn victims(self) -> &'static [Victim] {
        match self {
            Self::OccupantFront => &[Victim::OccupantFront],
            Self::OccupantSide => &[Victim::OccupantNear, Victim::OccupantFar],
            Self::OccupantNear => &[Victim::OccupantNear],
            Self::OccupantFar => &[Victim::OccupantFar],
            Self::OccupantRear => &[Victim::OccupantRear],
            Self::Pedestrian => &[Victim::Pedestrian],
            Self::Cyclist => &[Victim::Cyclist],
            Self::Motorcyclist => &[Victim::Motorcyclist],
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EndText {
    curves: Vec<Spanned<String>>,
    times: Spanned<f64>,
    x: Option<Quantity>,
}

impl Curves {
    /// The set that ships with the program.
    ///
    /// # Errors
    ///
    /// Never for the file as shipped: a test reads it.
    pub fn shipped() -> Result<Self, DataFileError> {
        Self::parse("config/curves/default.toml", DEFAULT_CURVES)
    }

    /// Reads and checks a set. `file` is only named in errors.
    ///
    /// # Errors
    ///
    /// Line, column, fault and remedy, for: text that is not TOML, a missing or unknown key, a
    /// number that is not finite, a slope that is not positive, an empty source, an unknown or
    /// twice used name, a curve of another outcome, several origins without a reason, a model range
    /// that does not contain its nominal curve, and a broken severity ladder.
    pub fn parse(file: &str, text: &str) -> Result<Self, DataFileError> {
        let source = Source { file, text };
        let read: File = toml::from_str(text).map_err(|e| source.malformed(&e, KEYS))?;
        if *read.schema.get_ref() != 1 {
            return Err(source.fault(read.schema.span(), "unknown schema", "write schema = 1"));
        }
        let mut curves: Vec<Curve> = Vec::with_capacity(read.curve.len());
        for text in read.curve {
            let span = text.get_ref().id.span();
            let curve = curve(&source, text.into_inner())?;
            if curves.iter().any(|c| c.id == curve.id) {
                return Err(source.fault(span, "two curves have this id", "rename one of them"));
            }
            curves.push(curve);
        }
        let mut set = Self {
            name: read.name,
            mixed_origins: read.mixed_origins,
            curves: curves.into(),
            rungs: Vec::new(),
        };
        for text in read.person {
            let span = text.span();
            let victims = text.get_ref().victim.victims();
            let rung = set.resolve(&source, text.into_inner())?;
            for victim in victims {
                set.add(&source, span.clone(), Rung { victim: *victim, ..rung.clone() })?;
            }
        }
        set.rungs.sort_by_key(|r| (r.victim, r.level));
        Ok(set)
    }

    /// Adds a checked rung.
    fn add(
        &mut self,
        source: &Source<'_>,
        span: Range<usize>,
        rung: Rung,
    ) -> Result<(), DataFileError> {
        if self.rung(rung.victim, rung.level).is_ok() {
            let fault = "this person has a curve at this level already";
            return Err(source.fault(span, fault, "leave one [[person]] per victim and level"));
        }
        self.check_range(&rung).map_err(|fault| {
            let remedy = "choose range curves and factors that enclose the nominal curve";
            source.fault(span.clone(), fault, remedy)
        })?;
        self.check_origin(&rung).map_err(|fault| {
            let remedy = "take one origin, or say in mixed_origins why several must do";
            source.fault(span.clone(), fault, remedy)
        })?;
        self.rungs.push(rung);
        self.check_ladder().map_err(|fault| {
            let remedy = "take the levels of one person from one study, or state at_most";
            source.fault(span, fault, remedy)
        })
    }

    fn resolve(&self, source: &Source<'_>, text: PersonText) -> Result<Rung, DataFileError> {
        let (x, level) = (text.x, text.level);
        let any = |id: &Spanned<String>, milder: bool| {
            let position = self.curves.iter().position(|c| *c.id == **id.get_ref());
            let number = position.ok_or_else(|| {
                let fault = format!("curve \"{}\" is not defined", id.get_ref());
                let known: Vec<_> = self.curves.iter().map(|c| &*c.id).collect();
                source.fault(id.span(), fault, format!("curves here: {}", known.join(", ")))
            })?;
            let is_wanted = |of: Level| if milder { of < level } else { of == level };
            if !is_wanted(self.curves[number].outcome) {
                let fault = format!("curve \"{}\" is of another outcome", id.get_ref());
                let milder = if milder { "a milder outcome than" } else { "outcome =" };
                let remedy = format!("name a curve with {milder} \"{}\"", level.name());
                return Err(source.fault(id.span(), fault, remedy));
            }
            Ok(number)
        };
        let find = |id: &Spanned<String>| any(id, false);
        let end = |text: Spanned<EndText>| {
            let span = text.span();
            let text = text.into_inner();
            let curves = text.curves.iter().map(find).collect::<Result<Vec<_>, _>>()?;
            if curves.is_empty() {
                return Err(source.fault(span, "no curve", "name at least one curve"));
            }
            let times = *text.times.get_ref();
            if !(times > 0.0 && times.is_finite()) {
                let remedy = "write a finite factor above 0";
                return Err(source.fault(text.times.span(), "not a factor", remedy));
            }
            Ok(RangeEnd { curves, x: text.x.unwrap_or(x), times })
        };
        Ok(Rung {
            victim: text.victim.victims()[0],
            level,
            x,
            nominal: find(&text.nominal)?,
            at_most: text.at_most.as_ref().map(|id| any(id, true)).transpose()?,
            low: end(text.low)?,
            high: end(text.high)?,
        })
    }

    fn check_range(&self, rung: &Rung) -> Result<(), String> {
        let name = rung.victim.name();
        for all in speeds() {
            let v = all.delta_v;
            let risk = self.risk(rung, &all);
            let low = self.low_end(rung, &all);
            let high = self.extreme(&rung.high, &all, f64::NEG_INFINITY, f64::max);
            if !(low <= risk + LADDER_SLACK && risk <= high + LADDER_SLACK) {
                return Err(format!(
                    "{name}: the nominal risk {risk:.5} at {v:.1} m/s is outside its own range \
                     {low:.5} to {high:.5}"
                ));
            }
        }
        Ok(())
    }

    fn check_origin(&self, rung: &Rung) -> Result<(), String> {
        let ours = self.nominal(rung);
        let other = self.rungs.iter().map(|r| self.nominal(r)).find(|c| c.origin != ours.origin);
        match other {
            Some(other) if self.mixed_origins.trim().is_empty() => Err(format!(
                "nominal curves \"{}\" and \"{}\" have different origins, and mixed_origins gives \
                 no reason",
                other.id, ours.id
            )),
            _ => Ok(()),
        }
    }

    /// Fatal ≤ MAIS3+ ≤ MAIS2+ for every person, wherever both are given.
    fn check_ladder(&self) -> Result<(), String> {
        for mild in &self.rungs {
            for severe in self.family(mild).filter(|r| r.level > mild.level) {
                let (m, s) = (self.nominal(mild), self.nominal(severe));
                let broken =
                    |all: &Speeds| self.risk(severe, all) > self.risk(mild, all) + LADDER_SLACK;
                let mut broken_at = speeds().filter(broken).map(|all| all.delta_v);
                if let Some(first) = broken_at.next() {
                    let last = broken_at.last().unwrap_or(first);
                    return Err(format!(
                        "{}: {} (\"{}\") is likelier than {} (\"{}\") from {first:.1} to {last:.1} \
                         m/s",
                        mild.victim.name(),
                        severe.level.name(),
                        s.id,
                        mild.level.name(),
                        m.id,
                    ));
                }
            }
        }
        Ok(())
    }
}

/// The speeds on which curves are compared, with fronts of several heights: for each of these the
/// whole ladder of speeds.
fn speeds() -> impl Iterator<Item = Speeds> {
    let count = (LADDER_END_M_S * f64::from(LADDER_STEPS)) as u32;
    FRONTS_M.into_iter().flat_map(move |front_m| {
        (0..=count).map(move |k| {
            let v = f64::from(k) / f64::from(LADDER_STEPS);
            Speeds { delta_v: v, normal: v, closing: v, front_m }
        })
    })
}

fn curve(source: &Source<'_>, text: CurveText) -> Result<Curve, DataFileError> {
    let (a, b) = (*text.a.get_ref(), *text.b.get_ref());
    if !a.is_finite() {
        return Err(source.fault(text.a.span(), "not a number", "write a finite intercept"));
    }
    if !(b > 0.0 && b.is_finite()) {
        let fault = "the slope is not above 0: risk would not rise with speed";
        return Err(source.fault(text.b.span(), fault, "write b > 0, per unit of x"));
    }
    if let Some(front) = &text.front {
        let FrontTerm { from_cm, per_cm, per_cm_and_unit, at } = *front.get_ref();
        let is_sound = [from_cm, per_cm_and_unit, at].iter().all(|x| (0.0..1e3).contains(x));
        if !(is_sound && per_cm.abs() < 1e3) {
            let remedy = "write from_cm, per_cm_and_unit and at of at least 0";
            return Err(source.fault(front.span(), "not a term for tall fronts", remedy));
        }
    }
    let valid = *text.valid.get_ref();
    if !(0.0 <= valid[0] && valid[0] < valid[1] && valid[1].is_finite()) {
        let remedy = "write valid = [from, to] in the curve's unit, 0 ≤ from < to";
        return Err(source.fault(text.valid.span(), "not a range of speeds", remedy));
    }
    if !(1900..=2100).contains(text.year.get_ref()) {
        let remedy = "write the year of publication, four digits";
        return Err(source.fault(text.year.span(), "not a year", remedy));
    }
    for field in [&text.id, &text.source, &text.sample, &text.origin] {
        if field.get_ref().trim().is_empty() {
            let remedy = "say who published the curve, fitted to whom, and from which data";
            return Err(source.fault(field.span(), "is empty", remedy));
        }
    }
    Ok(Curve {
        id: text.id.into_inner().into(),
        outcome: text.outcome,
        unit: text.unit,
        a,
        b,
        front: text.front.map(Spanned::into_inner),
        valid,
        source: text.source.into_inner(),
        year: text.year.into_inner(),
        sample: text.sample.into_inner(),
        origin: text.origin.into_inner(),
        note: text.note,
    })
}
