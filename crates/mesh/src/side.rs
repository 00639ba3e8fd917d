//! The TOML file beside a mesh: its mass, centre of mass, inertia, seats and impacts as known to
//! its maker.
//!
//! ```toml
//! name = "sedan"
//! kind = "sedan"
//! mass_kg = 1550.0
//! centre_m = [0.0, 0.0, 0.7]      # body frame: x forward, y left, z up
//! yaw_inertia_kg_m2 = 1053.5      # or gyration_m
//! occupants = [{ seat = "front-left" }]
//! source = "maker's data sheet, 2024"
//!
//! [impact]                        # in place of the parameters in force: body::OwnParameters
//! restitution = { low = 0.05, nominal = 0.12, high = 0.2 }
//! mass_share = 0.02               # the mass is known to 2 %
//! ```
//!
//! Every key is optional, but `[impact]` needs a source; unknown keys are rejected. Errors give
//! file, line and column.

use body::meta::{LENGTH_MAX_M, MASS_MAX_KG, Occupant};
use body::{BodyKind, Meta, OwnParameters};
use diagnostic::Diagnostic;
use geometry::Aabb;
use keys::Twice;
use serde::Deserialize;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;

/// A side file, parsed and checked as far as possible without the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SideFile {
    file: String,
    text: String,
    keys: Keys,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    name: Option<Spanned<String>>,
    kind: Option<BodyKind>,
    mass_kg: Option<Spanned<f64>>,
    centre_m: Option<Spanned<[f64; 3]>>,
    yaw_inertia_kg_m2: Option<Spanned<f64>>,
    gyration_m: Option<Spanned<f64>>,
    occupants: Option<Spanned<Vec<Occupant>>>,
    source: Option<String>,
    impact: Option<Spanned<OwnParameters>>,
}

/// A side file was rejected: `file:line:column: what`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {what}")]
pub struct SideError {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// The problem.
    pub what: String,
    /// The remedy.
    pub remedy: &'static str,
}

impl Diagnostic for SideError {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Input
    }

    fn place(&self) -> Option<String> {
        Some(format!("{}:{}:{}", self.file, self.line, self.column))
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.into())
    }
}

const KEYS: &str = "the keys are name, kind, mass_kg, centre_m, yaw_inertia_kg_m2 or gyration_m, \
                    occupants, source; and under [impact] restitution, friction (low, \
                    nominal, high), face_restitution_more, \
                    face_tangential_share, gyration_share, mass_share";

impl SideFile {
    /// Parses a side file.
    ///
    /// # Errors
    ///
    /// It is not valid TOML, has an unknown key, or a value is not finite or out of range.
    pub fn parse(file: &str, text: &str) -> Result<Self, SideError> {
        let keys: Keys =
            toml::from_str(text).map_err(|fault| match Twice::in_toml(text, &fault) {
                Some(twice) => error(file, text, fault.span(), twice.what(), Twice::REMEDY),
                None => error(file, text, fault.span(), fault.message().trim().to_owned(), KEYS),
            })?;
        let side = Self { file: file.to_owned(), text: text.to_owned(), keys };
        side.check()?;
        Ok(side)
    }

    /// The kind stated in the file.
    #[must_use]
    pub fn kind(&self) -> Option<BodyKind> {
        self.keys.kind
    }

    /// The name stated in the file.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.keys.name.as_ref().map(|name| name.as_ref().as_str())
    }

    fn check(&self) -> Result<(), SideError> {
        let keys = &self.keys;
        if let Some(name) = keys.name.as_ref().filter(|name| name.as_ref().trim().is_empty()) {
            return self.fail(name.span(), "the name is empty".into(), "give it a name");
        }
        self.check_positive(keys.mass_kg.as_ref(), "mass_kg", MASS_MAX_KG)?;
        self.check_positive(keys.gyration_m.as_ref(), "gyration_m", LENGTH_MAX_M)?;
        let inertia_max = MASS_MAX_KG * 1.0e4;
        self.check_positive(keys.yaw_inertia_kg_m2.as_ref(), "yaw_inertia_kg_m2", inertia_max)?;
        if let (Some(inertia), Some(_)) = (&keys.yaw_inertia_kg_m2, &keys.gyration_m) {
            let fault = "yaw_inertia_kg_m2 and gyration_m say the same thing twice";
            return self.fail(inertia.span(), fault.into(), "keep one of them");
        }
        let has_source = keys.source.as_ref().is_some_and(|source| !source.trim().is_empty());
        if let Some(impact) = keys.impact.as_ref().filter(|_| !has_source) {
            let fault = "what is known of its impacts has no source".into();
            return self.fail(impact.span(), fault, "add source = \"...\" above [impact]");
        }
        match &keys.centre_m {
            Some(centre) if centre.as_ref().iter().any(|x| !(x.abs() <= LENGTH_MAX_M)) => {
                let fault = format!("centre_m {:?} is not finite", centre.as_ref());
                self.fail(centre.span(), fault, "three numbers in metres: forward, left, up")
            }
            _ => Ok(()),
        }
    }

    fn check_positive(
        &self,
        value: Option<&Spanned<f64>>,
        key: &str,
        max: f64,
    ) -> Result<(), SideError> {
        match value {
            Some(value) if !(*value.as_ref() > 0.0 && *value.as_ref() <= max) => {
                let fault = format!("{key} = {} is not in (0, {max}]", value.as_ref());
                self.fail(value.span(), fault, "the unit stands in the key's name")
            }
            _ => Ok(()),
        }
    }

    /// Replaces defaults with the values of the file. `bounds` is the body's box.
    ///
    /// # Errors
    ///
    /// The file contradicts the kind, or puts the centre of mass far outside the body.
    pub fn apply(&self, meta: &mut Meta, bounds: &Aabb) -> Result<(), SideError> {
        let keys = &self.keys;
        if let Some(name) = self.name() {
            name.clone_into(&mut meta.name);
        }
        let mut said = Vec::new();
        if let Some(mass) = &keys.mass_kg {
            if meta.kind.is_fixed() {
                let fault = format!("a {} is fixed to the ground and has no mass", meta.kind);
                return self.fail(mass.span(), fault, "leave mass_kg out, or state another kind");
            }
            meta.mass_kg = Some(*mass.as_ref());
            said.push("mass");
        }
        if let Some(centre) = &keys.centre_m {
            self.check_centre(centre, bounds)?;
            meta.centre_m = *centre.as_ref();
            said.push("centre");
        }
        if let Some(gyration) = &keys.gyration_m {
            meta.gyration_m = *gyration.as_ref();
            said.push("gyration");
        }
        if let Some(inertia) = &keys.yaw_inertia_kg_m2 {
            let Some(mass) = meta.mass_kg else {
                let fault = format!("a {} is fixed to the ground and does not turn", meta.kind);
                return self.fail(inertia.span(), fault, "leave yaw_inertia_kg_m2 out");
            };
            meta.gyration_m = (inertia.as_ref() / mass).sqrt();
            said.push("yaw inertia");
        }
        if let Some(occupants) = &keys.occupants {
            meta.occupants = Some(occupants.as_ref().clone());
            said.push("occupants");
        }
        let file = self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file);
        if let Some(impact) = &keys.impact {
            let own = *impact.as_ref();
            if let Err(fault) = own.check(meta.kind) {
                return self.fail(impact.span(), fault, "correct it, or leave it out");
            }
            meta.impact = own;
            meta.impact_source = format!("{file} ({})", keys.source.as_deref().unwrap_or_default());
        }
        if !said.is_empty() {
            let source = keys.source.as_deref().map_or(String::new(), |s| format!(" ({s})"));
            let rest = format!("else {}", meta.mass_source);
            let rest = if said.contains(&"mass") { "else default" } else { rest.as_str() };
            meta.mass_source = format!("{} from {file}{source}, {rest}", said.join(", "));
        }
        let place = keys.occupants.as_ref().map_or(0..0, Spanned::span);
        meta.check().or_else(|fault| self.fail(place, fault, "correct the side file or --kind"))
    }

    /// The centre must lie in the body's box, grown by half its size: this catches a frame with
    /// another origin or unit, but accepts a chassis without its wheels.
    fn check_centre(&self, centre: &Spanned<[f64; 3]>, bounds: &Aabb) -> Result<(), SideError> {
        let outside = (0..3).any(|axis| {
            let (min, max) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
            let room = (max - min) / 2.0;
            !(min - room..=max + room).contains(&centre.as_ref()[axis])
        });
        if !outside {
            return Ok(());
        }
        let fault = format!(
            "centre_m {:?} is far outside of the body, which reaches from {:?} to {:?}",
            centre.as_ref(),
            bounds.min,
            bounds.max
        );
        self.fail(centre.span(), fault, "metres in the body frame: x forward, y left, z up")
    }

    fn fail(
        &self,
        span: Range<usize>,
        what: String,
        remedy: &'static str,
    ) -> Result<(), SideError> {
        Err(error(&self.file, &self.text, Some(span), what, remedy))
    }
}

fn error(
    file: &str,
    text: &str,
    span: Option<Range<usize>>,
    what: String,
    remedy: &'static str,
) -> SideError {
    let at = span.map_or(0, |span| span.start);
    let before = text.get(..at).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    SideError {
        file: file.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        what,
        remedy,
    }
}

#[cfg(test)]
mod tests;
