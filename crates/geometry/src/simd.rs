//! Which vector instructions the kernels use: the user's choice, limited to what this processor
//! has.
//!
//! The choice affects speed and never the answer: a kernel does the same operations on each lane at
//! every width, none fused, so all levels give the same bits. Kernels are generic over
//! `fearless_simd::Simd`; a [`Level`] is the proof that the processor has the instructions, and
//! [`fearless_simd::dispatch!`] turns it into that generic argument.
//!
//! `avx512` means the AVX-512 of Intel's Ice Lake (2019) and AMD's Zen 4, or later. The processors
//! before them (Skylake-X, Cascade Lake) lack some of its instructions and lower their clock for
//! the rest: they are treated as `avx2`.

use core::fmt;
use core::str::FromStr;
use diagnostic::{Diagnostic, FailureKind};

pub use fearless_simd::Level;

/// The user's choice of vector instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Simd {
    /// The widest available on this processor.
    #[default]
    Auto,
    /// AVX-512 as of Ice Lake: 8 lanes of f64.
    Avx512,
    /// AVX2 and its companions (x86-64-v3): 4 lanes of f64.
    Avx2,
    /// SSE4.2 (x86-64-v2): 2 lanes of f64.
    Sse4,
    /// SSE2, which every x86-64 has: 2 lanes of f64.
    Sse2,
    /// NEON, which every aarch64 has: 2 lanes of f64.
    Neon,
}

/// The requested instructions are not available on this processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unavailable {
    asked: Simd,
    widest: &'static str,
}

/// The text is not the name of a [`Simd`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown(String);

impl Simd {
    /// All choices: [`Simd::Auto`] first, then from the widest down.
    pub const ALL: [Self; 6] =
        [Self::Auto, Self::Avx512, Self::Avx2, Self::Sse4, Self::Sse2, Self::Neon];

    /// The level of the kernels under this choice.
    ///
    /// # Errors
    ///
    /// This processor does not have the instructions.
    pub fn level(self) -> Result<Level, Unavailable> {
        let widest = Level::new();
        narrowed(widest, self).ok_or(Unavailable { asked: self, widest: name(widest) })
    }

    /// The name, as used on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Sse4 => "sse4",
            Self::Sse2 => "sse2",
            Self::Neon => "neon",
        }
    }
}

/// All levels of this processor, widest first, without repetition; never empty.
pub fn levels() -> impl Iterator<Item = Level> {
    let named = Simd::ALL.into_iter().skip(1).filter_map(|simd| simd.level().ok());
    let scalar = Some(Level::new()).filter(|widest| widest.is_fallback());
    named.chain(scalar)
}

/// The name of a level: that of the matching [`Simd`], or `scalar` if there is none.
#[must_use]
pub fn name(level: Level) -> &'static str {
    let named = |simd: &Simd| narrowed(level, *simd).is_some();
    Simd::ALL[1..].iter().find(|simd| named(simd)).map_or("scalar", |simd| simd.name())
}

/// `level`, or a narrower one that it includes.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn narrowed(level: Level, to: Simd) -> Option<Level> {
    match to {
        Simd::Auto => Some(level),
        Simd::Avx512 => level.as_avx512().map(Level::Avx512),
        Simd::Avx2 => level.as_avx2().map(Level::Avx2),
        Simd::Sse4 => level.as_sse4_2().map(Level::Sse4_2),
        Simd::Sse2 => level.as_sse2().map(Level::Sse2),
        Simd::Neon => None,
    }
}

/// `level`, or a narrower one that it includes.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn narrowed(level: Level, to: Simd) -> Option<Level> {
    match to {
        Simd::Auto => Some(level),
        #[cfg(target_arch = "aarch64")]
        Simd::Neon => level.as_neon().map(Level::Neon),
        _ => None,
    }
}

/// Prefetches this element where the processor supports it. There is no other effect, even if the
/// element does not exist.
#[inline(always)]
pub fn prefetch<S: fearless_simd::Simd, T>(simd: S, of: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        fearless_simd::kernel!(
            #[inline(always)]
            fn line(_simd: Sse2, at: *const i8) {
                _mm_prefetch::<_MM_HINT_T0>(at);
            }
        );
        if let Some(sse2) = simd.level().as_sse2() {
            let start: *const i8 = of.as_ptr().wrapping_add(index).cast();
            for offset in (0..size_of::<T>()).step_by(LINE) {
                line(sse2, start.wrapping_add(offset));
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (simd, of, index);
}

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Simd {
    type Err = Unknown;

    fn from_str(text: &str) -> Result<Self, Unknown> {
        let named = Self::ALL.into_iter().find(|simd| simd.name() == text);
        named.ok_or_else(|| Unknown(text.to_owned()))
    }
}

impl fmt::Display for Unavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { asked, widest } = self;
        write!(
            f,
            "this processor does not support {asked} (widest available: {widest}): use --simd auto"
        )
    }
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\" is none of {}", self.0, Simd::ALL.map(Simd::name).join(", "))
    }
}

impl core::error::Error for Unavailable {}
impl core::error::Error for Unknown {}

impl Diagnostic for Unavailable {
    fn kind(&self) -> FailureKind {
        FailureKind::Configuration
    }
}

#[cfg(test)]
mod tests;
