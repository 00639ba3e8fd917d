//! What was simulated: one point per scheme, depth, cost of a byte and memory, over all seeds; and
//! its text form, from which an interrupted map goes on.

use super::machine::{Machine, SCHEMES};
use scenario::Scheme;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Mean and standard deviation of several runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spread {
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
    pub(crate) count: u32,
}

impl Spread {
    pub(crate) fn over(values: &[f64]) -> Self {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let deviation = (square / (count - 1.0).max(1.0)).sqrt();
        Self { mean, deviation, count: values.len() as u32 }
    }

    /// Standard error of the mean; 0 for what does not depend on a seed.
    pub(crate) fn error(&self) -> f64 {
        self.deviation / f64::from(self.count.max(1)).sqrt()
    }

    /// The reciprocal's spread times `by`: a speed-up from a time.
    pub(crate) fn under(&self, by: f64) -> Self {
        let mean = by / self.mean;
        Self { mean, deviation: mean * self.deviation / self.mean, count: self.count }
    }
}

/// What happens when memory runs out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Beyond {
    /// Virtual memory: nothing is evicted, and a byte beyond M costs time.
    Swap,
    /// The least recently needed sections are evicted, and copied again when needed.
    Evict,
}

impl Beyond {
    pub(crate) const ALL: [Self; 2] = [Self::Swap, Self::Evict];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Swap => "swap",
            Self::Evict => "evict",
        }
    }
}

/// One scheme at one depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Point {
    /// Time of the request (µs).
    pub(crate) time_us: Spread,
    /// Bytes of sections that were sent, over those of both bodies and over the number of requests.
    pub(crate) moved: Spread,
    /// Bytes that moved to and from virtual memory, likewise.
    pub(crate) swapped: f64,
    /// Share of the runs in which a core would have held more than its memory. With a hard stop,
    /// they would have ended there.
    pub(crate) out: f64,
    /// The most that a core held (or would have), over the bytes of both bodies: mean over the
    /// runs.
    pub(crate) peak: f64,
}

/// Which contact between which bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Subject {
    /// Triangles of each body.
    pub(crate) size: u32,
    /// Substantial damage, or a scratch.
    pub(crate) is_deep: bool,
}

impl Subject {
    pub(crate) fn contact(self) -> &'static str {
        contact(self.is_deep)
    }
}

/// The name of a contact: substantial damage, or a scratch.
pub(crate) fn contact(is_deep: bool) -> &'static str {
    if is_deep { "deep" } else { "scratch" }
}

/// What one sheet of the map is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SheetKey {
    pub(crate) machine: Machine,
    pub(crate) subject: Subject,
    /// Whether each contact is a request of its own, with empty memories; else all are one.
    pub(crate) is_single: bool,
    pub(crate) cores: u8,
    pub(crate) buffer: u32,
}

impl SheetKey {
    /// A name for a file.
    pub(crate) fn name(&self) -> String {
        let Self { machine, subject, is_single, cores, buffer } = self;
        let requests = if *is_single { "single" } else { "sixteen" };
        format!(
            "{}-{}-{}-{requests}-{cores}-cores-buffer-{buffer}",
            machine.name(),
            subject.size,
            subject.contact()
        )
    }
}

/// Where a point lies: cost of a byte and memory as numbers of their lists, depth, scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    pub(crate) byte: usize,
    /// `None`: memory suffices. A point that lacks its place here is the one of sufficient memory.
    pub(crate) short: Option<(Beyond, usize)>,
    pub(crate) depth: u32,
    pub(crate) scheme: usize,
}

/// All points of one sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sheet {
    /// The same work in one process without messages (µs).
    pub(crate) alone_us: f64,
    pub(crate) points: BTreeMap<Place, Point>,
}

/// One scheme's line over depth.
pub(crate) type Curve = Vec<(u32, Point)>;

/// The lines of all schemes at one cost of a byte and one memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curves {
    pub(crate) alone_us: f64,
    /// In the order of [`SCHEMES`]; empty for a scheme that was left out.
    pub(crate) lines: [Curve; SCHEMES.len()],
}

impl Curves {
    pub(crate) fn line(&self, scheme: Scheme) -> &Curve {
        let number = SCHEMES.iter().position(|known| *known == scheme).unwrap_or(0);
        &self.lines[number]
    }

    pub(crate) fn at_depth(&self, scheme: Scheme, depth: u32) -> Option<&Point> {
        self.line(scheme).iter().find(|(known, _)| *known == depth).map(|(_, point)| point)
    }
}

impl Sheet {
    /// The lines at one cost of a byte and one memory (`None`: it suffices).
    pub(crate) fn curves(&self, byte: usize, short: Option<(Beyond, usize)>) -> Curves {
        let mut curves = Curves { alone_us: self.alone_us, ..Curves::default() };
        let ample = self.points.iter().filter(|(at, _)| at.byte == byte && at.short.is_none());
        for (at, point) in ample {
            let found = short.and_then(|_| self.points.get(&Place { short, ..*at }));
            curves.lines[at.scheme].push((at.depth, *found.unwrap_or(point)));
        }
        curves
    }

    /// The text form: a line of what it was made from, and a line per point.
    pub(crate) fn text(&self, made_from: &str) -> String {
        let mut text = format!("# {made_from}\n# alone_us {}\n{HEAD}\n", self.alone_us);
        for (at, point) in &self.points {
            let (beyond, memory) = match at.short {
                None => ("ample", String::new()),
                Some((beyond, memory)) => (beyond.name(), memory.to_string()),
            };
            let Point { time_us, moved, swapped, out, peak } = point;
            // Writing to a String cannot fail.
            let _written = writeln!(
                text,
                "{},{beyond},{memory},{},{},{},{:.1},{:.1},{:.4},{:.4},{swapped:.4},{out:.3},\
                 {peak:.4}",
                at.byte,
                at.depth,
                at.scheme,
                time_us.count,
                time_us.mean,
                time_us.deviation,
                moved.mean,
                moved.deviation,
            );
        }
        text
    }

    /// Reads [`Sheet::text`] back; `None` if it was made from something else, or is not whole.
    pub(crate) fn parse(text: &str, made_from: &str) -> Option<Self> {
        let mut lines = text.lines();
        if lines.next()?.strip_prefix("# ")? != made_from {
            return None;
        }
        let alone_us = lines.next()?.strip_prefix("# alone_us ")?.parse().ok()?;
        if lines.next()? != HEAD || !text.ends_with('\n') {
            return None;
        }
        let mut points = BTreeMap::new();
        for line in lines {
            let fields: Vec<&str> = line.split(',').collect();
            let [byte, beyond, memory, depth, scheme, count, rest @ ..] = &fields[..] else {
                return None;
            };
            let short = match *beyond {
                "ample" => None,
                name => {
                    let beyond = Beyond::ALL.into_iter().find(|known| known.name() == name)?;
                    Some((beyond, memory.parse().ok()?))
                }
            };
            let scheme = scheme.parse().ok().filter(|scheme| *scheme < SCHEMES.len())?;
            let place =
                Place { byte: byte.parse().ok()?, short, depth: depth.parse().ok()?, scheme };
            let numbers: Vec<f64> =
                rest.iter().map(|field| field.parse()).collect::<Result<_, _>>().ok()?;
            let [time, time_sd, moved, moved_sd, swapped, out, peak] = numbers[..] else {
                return None;
            };
            let count = count.parse().ok()?;
            let spread = |mean, deviation| Spread { mean, deviation, count };
            let point = Point {
                time_us: spread(time, time_sd),
                moved: spread(moved, moved_sd),
                swapped,
                out,
                peak,
            };
            points.insert(place, point);
        }
        (!points.is_empty()).then_some(Self { alone_us, points })
    }
}

const HEAD: &str = "byte,beyond,memory,depth,scheme,seeds,time_us,time_sd,moved,moved_sd,swapped,\
                    out,peak";

#[cfg(test)]
mod tests;
