//! Who signed a policy, who dissented, on what evidence, until when it is valid, and which outcomes
//! must stay as they are.
//!
//! All of it is data of the policy's file: a table `[dossier]` and any number of `[[regression]]`.
//! None of it changes an answer. It is checked by whoever has a clock and can rank: see
//! `trolley policy check`.

use crate::fault::{DataFileError, Source};
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// A day of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Day {
    year: u16,
    month: u8,
    day: u8,
}

impl Day {
    /// The last day that can be written.
    pub const LAST: Self = Self { year: 9999, month: 12, day: 31 };

    /// Reads "YYYY-MM-DD"; `None` if it is no day.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let parts: Vec<&str> = text.split('-').collect();
        let [year, month, day] = parts[..] else { return None };
        if [year, month, day].map(str::len) != [4, 2, 2] {
            return None;
        }
        let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if ![year, month, day].into_iter().all(are_digits) {
            return None;
        }
        Self::new(year.parse().ok()?, month.parse().ok()?, day.parse().ok()?)
    }

    /// This day, if there is one.
    #[must_use]
    pub fn new(year: u16, month: u8, day: u8) -> Option<Self> {
        let divides = |by: u16| year.is_multiple_of(by);
        let is_leap = divides(4) && (!divides(100) || divides(400));
        let days = match month {
            1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
            4 | 6 | 9 | 11 => 30,
            2 if is_leap => 29,
            2 => 28,
            _ => return None,
        };
        ((1..=9999).contains(&year) && (1..=days).contains(&day)).then_some(Self {
            year,
            month,
            day,
        })
    }

    /// The day that lies so many days after 1970-01-01, up to the year 9999.
    ///
    /// H. Hinnant, "chrono-compatible low-level date algorithms": years begin in March, so that
    /// the day that is not always there is the last of them.
    #[must_use]
    pub fn of_unix_days(days: u64) -> Option<Self> {
        let shifted = days.checked_add(719_468)?;
        let (era, of_era) = (shifted / 146_097, shifted % 146_097);
        let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let from_march = (5 * of_year + 2) / 153;
        let day = of_year - (153 * from_march + 2) / 5 + 1;
        let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
        let year = year_of_era + 400 * era + u64::from(month <= 2);
        Self::new(year.try_into().ok()?, month.try_into().ok()?, day.try_into().ok()?)
    }
}

impl core::fmt::Display for Day {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

impl Serialize for Day {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A signature under a policy. It is a statement of the file: nothing proves it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Signature {
    /// Who.
    pub name: String,
    /// As what.
    pub role: String,
    /// When.
    pub date: Day,
}

/// Somebody of the board who does not agree.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Dissent {
    /// Who.
    pub name: String,
    /// Why.
    pub text: String,
}

/// An outcome that must stay as it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Regression {
    /// The scenario: a path relative to the policy's file.
    pub scenario: String,
    /// The candidate that wins there; `None`: the policy lets none be chosen.
    pub winner: Option<String>,
    /// The candidate that comes last there, if that is stated.
    pub worst: Option<String>,
    /// Why that is right.
    pub reason: String,
    /// Line in the policy's file, from 1.
    pub line: usize,
}

/// Who answers for a policy, and for how long.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Dossier {
    /// Who signed.
    pub signed: Vec<Signature>,
    /// Who did not agree.
    pub dissent: Vec<Dissent>,
    /// On what the policy rests: texts and addresses.
    pub evidence: Vec<String>,
    /// The last day on which it is valid, and its line in the file; `None`: no day is stated.
    pub valid_until: Option<(Day, usize)>,
    /// Outcomes that must stay as they are.
    pub regressions: Vec<Regression>,
}

impl Dossier {
    /// The last day on which the policy was valid, and its line in the file, if that day is over.
    #[must_use]
    pub fn expired(&self, today: Day) -> Option<(Day, usize)> {
        self.valid_until.filter(|(last, _)| *last < today)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DossierText {
    signed: Vec<Spanned<SignatureText>>,
    dissent: Vec<Spanned<DissentText>>,
    evidence: Spanned<Vec<String>>,
    valid_until: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SignatureText {
    name: String,
    role: String,
    date: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DissentText {
    name: String,
    text: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegressionText {
    scenario: String,
    winner: Option<String>,
    #[serde(default)]
    refused: bool,
    worst: Option<String>,
    reason: String,
}

/// A day that a file states.
fn day(source: &Source<'_>, text: &Spanned<String>) -> Result<Day, DataFileError> {
    Day::parse(text.get_ref()).ok_or_else(|| {
        let fault = format!("\"{}\" is no day", text.get_ref());
        source.fault(text.span(), fault, "write a day of the calendar as \"YYYY-MM-DD\"")
    })
}

/// Refuses an empty text.
fn filled(
    source: &Source<'_>,
    span: core::ops::Range<usize>,
    keys: &[(&str, &str)],
) -> Result<(), DataFileError> {
    match keys.iter().find(|(_, text)| text.trim().is_empty()) {
        None => Ok(()),
        Some((key, _)) => {
            Err(source.fault(span, format!("{key} is empty"), format!("fill {key} in")))
        }
    }
}

/// The dossier of a policy, from its tables; `None` if there are none.
pub(super) fn dossier(
    source: &Source<'_>,
    text: Option<Spanned<DossierText>>,
    regressions: Vec<Spanned<RegressionText>>,
) -> Result<Option<Dossier>, DataFileError> {
    if text.is_none() && regressions.is_empty() {
        return Ok(None);
    }
    let mut dossier = Dossier::default();
    if let Some(text) = text {
        let DossierText { signed, dissent, evidence, valid_until } = text.into_inner();
        let last = day(source, &valid_until)?;
        dossier.valid_until = Some((last, source.line(valid_until.span())));
        for one in signed {
            let span = one.span();
            let SignatureText { name, role, date } = one.into_inner();
            filled(source, span, &[("name", &name), ("role", &role)])?;
            let signed_on = day(source, &date)?;
            if signed_on > last {
                let fault = format!("{name} signed after {last}, the last valid day");
                let remedy = "correct the date, or valid_until";
                return Err(source.fault(date.span(), fault, remedy));
            }
            dossier.signed.push(Signature { name, role, date: signed_on });
        }
        for one in dissent {
            let span = one.span();
            let DissentText { name, text } = one.into_inner();
            filled(source, span, &[("name", &name), ("text", &text)])?;
            dossier.dissent.push(Dissent { name, text });
        }
        for piece in evidence.get_ref() {
            filled(source, evidence.span(), &[("evidence", piece)])?;
        }
        dossier.evidence = evidence.into_inner();
    }
    for one in regressions {
        let (span, line) = (one.span(), source.line(one.span()));
        let RegressionText { scenario, winner, refused, worst, reason } = one.into_inner();
        filled(source, span.clone(), &[("scenario", &scenario), ("reason", &reason)])?;
        for (key, name) in [("winner", &winner), ("worst", &worst)] {
            filled(source, span.clone(), &[(key, name.as_deref().unwrap_or(key))])?;
        }
        if winner.is_some() == refused {
            let fault = "a regression states one outcome";
            let remedy = "write winner = a candidate, or refused = true if none may be chosen";
            return Err(source.fault(span, fault, remedy));
        }
        if winner.is_some() && worst == winner {
            let remedy = "name another candidate, or remove worst";
            return Err(source.fault(span, "the winner is to be the worst too", remedy));
        }
        dossier.regressions.push(Regression { scenario, winner, worst, reason, line });
    }
    Ok(Some(dossier))
}

#[cfg(test)]
mod tests;
