//! Light at places as a volume that can be saved, and back (G-09).
//!
//! Each side of a surface that light is known of is a part of the volume: all places of the lattice, with what is known of
//! them. Parts lie one behind the other along z; the first lies where the lattice lies in the world. A voxel has four 32-bit
//! floats: the red, green and blue of the light that all paths together have found, and how many paths these are, 0 where
//! no surface is near, -1 if nothing is known (a sum tells light to the bit, a mean does not). In spherical harmonics of n
//! bands, 3 n^2 numbers of a place (red, green and blue of each coefficient) and what is known, then 1 instead of paths, follow
//! each other four by four in lattices that lie one behind the other as parts do, filled up with zeros before the last number.
//!
//! The volume's description tells what it is: `light of isosurfaces`, the [mark](super::mark) of what it belongs to in 16
//! hexadecimal digits, a colon, and the sides in their order, each as an isovalue, or `own` for places that are each on their
//! own surface, and `below` or `above`, for the side of lower values or the other:
//! `light of isosurfaces 7e9d40c2a1b35f86: 300 below, 300 above`.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::{DAffine3, Vec3};
use half::f16;
use pellucid_field::memory;
use pellucid_field::{Grid, Volume, Voxels};
use rayon::prelude::*;

use super::bricks::{Bricks, Known};
use super::kept::Kept;
use super::lattice::Lattice;
use super::saved_error::SavedLightError;
use crate::RenderError;

/// What saved light is of.
#[derive(Clone, Debug, PartialEq)]
struct Contents {
    mark: u64,
    /// Isovalues, or `None` where every place has its own, and sides.
    parts: Vec<(Option<f32>, usize)>,
}

const TITLE: &str = "light of isosurfaces ";
const SIDES: [&str; 2] = ["below", "above"];

impl fmt::Display for Contents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{TITLE}{:016x}: ", self.mark)?;
        for (number, (level, side)) in self.parts.iter().enumerate() {
            let comma = if number > 0 { ", " } else { "" };
            let level = level.map_or_else(|| "own".to_owned(), |level| level.to_string());
            write!(f, "{comma}{level} {}", SIDES[*side])?;
        }
        Ok(())
    }
}

impl FromStr for Contents {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (mark, parts) = text.strip_prefix(TITLE).and_then(|rest| rest.split_once(": ")).ok_or(())?;
        let part = |part: &str| {
            let (level, side) = part.split_once(' ')?;
            let level = if level == "own" { None } else { Some(level.parse().ok()?) };
            Some((level, SIDES.iter().position(|known| *known == side)?))
        };
        let parts = parts.split(", ").map(part).collect::<Option<_>>().ok_or(())?;
        Ok(Self { mark: u64::from_str_radix(mark, 16).map_err(|_| ())?, parts })
    }
}

/// Numbers of a voxel of saved light.
const NUMBERS: usize = 4;
/// What is known of a place, as a number: paths, or one of these.
const TRANSFER: f32 = 1.0;
const ABSENT: f32 = 0.0;
const NOTHING: f32 = -1.0;

/// How light at places lies in a volume.
#[derive(Clone, Copy)]
struct SavedLayout {
    lattice: Lattice,
    /// Numbers of a place, the last of which is what is known.
    numbers: usize,
    /// Those of its light.
    light: usize,
    is_transfer: bool,
    /// Paths from a place whose light is known.
    paths: u32,
}

impl SavedLayout {
    fn new(kept: &Kept, lattice: Lattice) -> Self {
        let light = 3 * kept.coefficients.unwrap_or(1);
        let numbers = (light + 1).next_multiple_of(NUMBERS);
        Self { lattice, numbers, light, is_transfer: kept.coefficients.is_some(), paths: kept.paths }
    }

    /// Voxels of so many parts.
    fn dims(&self, parts: usize) -> [usize; 3] {
        let [x, y, z] = self.lattice.dims;
        [x, y, z.saturating_mul(parts * self.numbers / NUMBERS)]
    }

    fn places(&self) -> usize {
        self.lattice.dims.iter().product()
    }

    fn place(&self, number: usize) -> [usize; 3] {
        let [x, y, _] = self.lattice.dims;
        [number % x, number / x % y, number / (x * y)]
    }

    /// What a voxel tells of a place, as the voxels of a part are counted.
    fn write(&self, bricks: &Bricks, voxel: usize, to: &mut [f32]) {
        let (at, first) = (self.place(voxel % self.places()), voxel / self.places() * NUMBERS);
        let (known, transfer) = (bricks.get(at, self.paths), bricks.transfer(at));
        let (state, light) = match known {
            Known::Absent => (ABSENT, None),
            Known::Light(light) if !self.is_transfer => (self.paths as f32, Some(light)),
            _ => (if transfer.is_some() { TRANSFER } else { NOTHING }, None),
        };
        for (number, to) in (first..).zip(to) {
            *to = match light {
                _ if number + 1 == self.numbers => state,
                Some(light) => light[number],
                None => transfer.and_then(|transfer| transfer.get(number)).map_or(0.0, |v| v.to_f32()),
            };
        }
    }

    /// Writes down what a part tells of a place.
    fn read(&self, bricks: &Bricks, place: usize, part: &[f32]) {
        let number = |k: usize| part[(k / NUMBERS * self.places() + place) * NUMBERS + k % NUMBERS];
        let (at, state) = (self.place(place), number(self.numbers - 1));
        if state == ABSENT {
            bricks.set(at, self.paths, Known::Absent);
        } else if state == TRANSFER && self.is_transfer {
            bricks.set_transfer(at, (0..self.light).map(|k| f16::from_f32(number(k))));
        } else if state == self.paths as f32 {
            bricks.set(at, self.paths, Known::Light([0, 1, 2].map(number)));
        }
    }
}

/// What is known of light, with a mark of what it belongs to; `None` if nothing is.
///
/// # Errors
/// [`RenderError::SavedLight`] if there is no memory for it, [`RenderError::Field`] if places are closer to each other than
/// voxels can be.
pub fn save(kept: &Kept, mark: u64) -> Result<Option<Volume>, RenderError> {
    let sides: Vec<_> = kept.touched().collect();
    let Some(lattice) = kept.lattice.filter(|_| !sides.is_empty()) else { return Ok(None) };
    let layout = SavedLayout::new(kept, lattice);
    let spacing = DAffine3::from_scale(Vec3::from(lattice.spacing).as_dvec3());
    let grid = Grid::with_affine(layout.dims(sides.len()), kept.volume.grid().world_from_index() * spacing)?;
    let mut values = Vec::new();
    memory::reserve(&mut values, grid.len() * NUMBERS).map_err(SavedLightError::from)?;
    values.resize(grid.len() * NUMBERS, 0.0);
    let voxels = layout.places() * layout.numbers / NUMBERS;
    values.par_chunks_exact_mut(NUMBERS).enumerate().for_each(|(voxel, to)| {
        let (surface, side) = sides[voxel / voxels];
        layout.write(&surface.sides[side], voxel % voxels, to);
    });
    let parts = sides.iter().map(|(surface, side)| (surface.level, *side)).collect();
    let mut volume = Volume::with_components(grid, values, NUMBERS)?.with_name("light");
    volume.description = Some(Contents { mark, parts }.to_string());
    volume.length_unit.clone_from(&kept.volume.length_unit);
    volume.is_anatomical = kept.volume.is_anatomical;
    Ok(Some(volume))
}

/// Writes down what a volume tells of the light that such a mark belongs to.
///
/// # Errors
/// [`SavedLightError`] of a file if the volume holds other light or none at all; nothing is then written.
pub fn load(kept: &Kept, mark: u64, saved: &Volume, file: &Path) -> Result<(), SavedLightError> {
    let foreign = |found: String| SavedLightError::Foreign { file: file.to_owned(), found };
    let Some(lattice) = kept.lattice else { return Ok(()) };
    let text = saved.description.as_deref();
    let contents = text.and_then(|text| text.parse::<Contents>().ok());
    let contents =
        contents.ok_or_else(|| foreign(text.map_or("no description".to_owned(), |text| format!("'{text}'"))))?;
    if contents.mark != mark {
        return Err(SavedLightError::Other { file: file.to_owned(), found: contents.mark, expected: mark });
    }
    let layout = SavedLayout::new(kept, lattice);
    let (dims, of_places) = (saved.grid().dims(), layout.dims(contents.parts.len()));
    let values = match saved.voxels() {
        Voxels::F32(values) if saved.components() == NUMBERS && dims == of_places => values,
        voxels => {
            let what = format!("{} {} at {dims:?} voxels", saved.components(), voxels.voxel_type());
            return Err(foreign(format!("{what}, not {NUMBERS} f32 at {of_places:?}")));
        }
    };
    let bricks = |(level, side): &(Option<f32>, usize)| {
        let surface = kept.surfaces.iter().find(|surface| surface.level == *level);
        surface.map(|surface| &surface.sides[*side]).ok_or_else(|| foreign(format!("light of a surface at {level:?}")))
    };
    let sides = contents.parts.iter().map(bricks).collect::<Result<Vec<_>, _>>()?;
    for (bricks, part) in sides.into_iter().zip(values.chunks_exact(layout.places() * layout.numbers)) {
        (0..layout.places()).into_par_iter().for_each(|place| layout.read(bricks, place, part));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_are_told_in_words() {
        let levels = [None, Some(300.0), Some(-0.1), Some(1e-30), Some(f32::MAX)];
        let parts: Vec<_> = levels.into_iter().flat_map(|level| [(level, 0), (level, 1)]).collect();
        let contents = Contents { mark: 0xab, parts };
        let text = contents.to_string();
        assert!(text.starts_with("light of isosurfaces 00000000000000ab: own below, own above, 300 below, "), "{text}");
        assert_eq!(text.parse(), Ok(contents));
        for other in
            ["", "light", "light of isosurfaces ab", "light of isosurfaces ab: ", "light of isosurfaces x: own below"]
        {
            assert_eq!(other.parse::<Contents>(), Err(()), "{other}");
        }
    }
}
