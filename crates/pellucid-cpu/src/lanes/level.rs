//! Which instruction set draws.

use std::fmt;
use std::str::FromStr;

use fearless_simd::{Level, Simd};

/// The instructions a renderer may use. The picture is the same up to rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstructionSet {
    /// The best of this machine, found when the renderer is made.
    #[default]
    Auto,
    /// 16 rays at once (AVX-512 as of Ice Lake and Zen 4).
    Avx512,
    /// 8 rays at once (AVX2 and FMA).
    Avx2,
    /// 4 rays at once, what every processor of the architecture has: SSE2, NEON, WASM SIMD.
    Baseline,
}

impl InstructionSet {
    /// All there are, the best first.
    pub const ALL: [Self; 4] = [Self::Auto, Self::Avx512, Self::Avx2, Self::Baseline];

    /// Whether this machine has it.
    pub fn is_available(self) -> bool {
        self.resolve().is_some()
    }

    /// The one of these vectors.
    pub(crate) fn of(s: impl Simd) -> Self {
        Self::of_level(s.level())
    }

    fn of_level(level: Level) -> Self {
        match level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => Self::Avx512,
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => Self::Avx2,
            _ => Self::Baseline,
        }
    }

    /// The set that is used for this one; `None` if the machine lacks it.
    pub(crate) fn resolve(self) -> Option<Self> {
        let best = Self::of_level(Level::new());
        match self {
            Self::Auto => Some(best),
            Self::Avx512 if best != Self::Avx512 => None,
            Self::Avx2 if best == Self::Baseline => None,
            other => Some(other),
        }
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Baseline => "baseline",
        })
    }
}

impl FromStr for InstructionSet {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|set| set.to_string() == name);
        found.ok_or_else(|| format!("{name:?} is no instruction set: auto, avx512, avx2 or baseline"))
    }
}

/// The token of [`InstructionSet::Baseline`].
macro_rules! baseline {
    () => {{
        let level = fearless_simd::Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let s = level.as_sse2().expect("every x86-64 processor has it");
        #[cfg(target_arch = "aarch64")]
        let s = level.as_neon().expect("every 64-bit Arm processor has it");
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        let s = level.as_wasm_simd128().expect("compiled for it");
        s
    }};
}
pub(crate) use baseline;

/// Runs an expression with the token of an available [`InstructionSet`]. It is compiled once per
/// set: let it be a call of a generic function. (Unlike `fearless_simd::dispatch!` this leaves the
/// token its type, so that it is [`Lanes`](super::Lanes).)
macro_rules! dispatch {
    ($set:expr, $s:ident => $body:expr) => {{
        let level = fearless_simd::Level::new();
        match $set {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::lanes::InstructionSet::Avx512 if level.as_avx512().is_some() => {
                let $s = level.as_avx512().expect("just asked");
                $body
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::lanes::InstructionSet::Avx2 if level.as_avx2().is_some() => {
                let $s = level.as_avx2().expect("just asked");
                $body
            }
            _ => {
                let $s = $crate::lanes::baseline!();
                $body
            }
        }
    }};
}
pub(crate) use dispatch;
