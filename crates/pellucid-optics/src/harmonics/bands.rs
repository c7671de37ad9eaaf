//! How many bands a function on directions has.

use crate::OpticsError;
use crate::error::checked;

/// Most bands there are: degrees 0 to 5.
pub const MOST_BANDS: usize = 6;

/// Their coefficients.
pub const MOST_COEFFICIENTS: usize = MOST_BANDS * MOST_BANDS;

/// A number of bands, 1 to 6: degrees 0 up to one less. Five by default, as in Wyman et al. 2006: they hold 99.8 % of the
/// light that a surface gathers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bands(u8);

impl Default for Bands {
    fn default() -> Self {
        Self(5)
    }
}

impl Bands {
    /// One of each number there may be, from 1 on.
    pub const ALL: [Self; MOST_BANDS] = [Self(1), Self(2), Self(3), Self(4), Self(5), Self(6)];

    /// That many bands.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless they are 1 to 6.
    pub fn new(count: usize) -> Result<Self, OpticsError> {
        checked("number of bands of spherical harmonics", count as f64, 1.0..=MOST_BANDS as f64, "1 to 6")?;
        Ok(Self(count as u8))
    }

    /// How many they are.
    pub const fn count(self) -> usize {
        self.0 as usize
    }

    /// How many coefficients they have: the first ones of those of more bands.
    pub const fn coefficients(self) -> usize {
        self.count() * self.count()
    }
}
