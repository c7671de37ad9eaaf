//! What lights isosurfaces: lights, or all light there is (Wyman et al. 2006).

use std::path::PathBuf;

use pellucid_optics::{Bands, Color, Environment, MOST_BANDS, Window};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, join, positive, require};
use crate::check_optics;
use crate::scene::Held;

/// What lights surfaces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Illumination {
    /// The lights, each by itself, with `lighting.shadows` and the material (default).
    #[default]
    Lights,
    /// All light that arrives, from around and from other places of the surface.
    Global(GlobalIllumination),
}

/// Light from lights, from all around, and from one place of a surface to another, on matte surfaces (Wyman et al. 2006).
///
/// A place of an isosurface is lit by what paths of light find that start there and meet that very surface again: so what was
/// found for places in a lattice stays true while the camera moves. Material, ambient light and `lighting.shadows` have no
/// part in it; clips and crops cut the surface for every path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GlobalIllumination {
    /// Where paths of light start. Default lattice.
    pub method: IlluminationMethod,
    /// Light from far away, all around; white if nothing is said.
    pub environment: Environment,
    /// Paths from every place, 1 to 65536. Default 100.
    pub samples: u32,
    /// How often light goes from one place of the surface to another, 0 to 64; with 0 there is light from lights and from
    /// around alone. Default 4.
    pub bounces: u32,
    /// Whether surfaces hold light back. Without, there is light from lights and from around alone. Default true.
    pub shadows: bool,
    /// How far away surfaces hold light back, in world units; left out, anywhere.
    pub distance: Option<f64>,
    /// What is kept of light at places of the lattice. Default irradiance.
    pub basis: IlluminationBasis,
    /// Which surface places of the lattice lie on. Default drawn.
    pub surfaces: PlacesOn,
    /// Places of the lattice for each voxel and axis, 0.125 to 4: 0.5, 1 and 2 are an eighth, one and eight for each voxel.
    /// Default 1.
    pub resolution: f64,
    /// What lies between places of the lattice. Default linear.
    pub interpolation: IlluminationInterpolation,
    /// What paths take for the surface's normals. Default derivative.
    pub normals: SurfaceNormals,
    /// How far off the surface, along its normal, paths start, in voxels, 0 to 4: where sampled data are rough, light would
    /// be held back by the roughness. Default 0.5.
    pub offset: f64,
    /// Where light was saved by `pellucid bake`; a relative path starts at the scene's folder. It must be the light of these very
    /// data and settings, and what it does not hold is found anew.
    pub file: Option<PathBuf>,
    /// What is in that file, once it is read.
    #[serde(skip)]
    pub baked: Held,
}

/// Where paths of light start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IlluminationMethod {
    /// At the places of a lattice: those beside a surface that is seen, once, and kept. Light between them is interpolated.
    #[default]
    Lattice,
    /// At every place that is seen, anew in every picture: slow, and what the lattice is measured by.
    Pixels,
}

/// What is kept of light at places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum IlluminationBasis {
    /// How much arrives, of lights and a sky that stay as they are.
    #[default]
    Irradiance,
    /// How it follows from light far away, in spherical harmonics: the sky and directional lights may then turn and change in
    /// every picture, and what is sharp in them is soft. Lights that have a place in the scene do not shine.
    Harmonics(HarmonicTransfer),
}

/// Light in spherical harmonics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HarmonicTransfer {
    /// How many bands of them, 1 to 6: five have 25 coefficients of each colour. Default 5.
    pub bands: u32,
    /// What keeps sharp light from making waves. Default none.
    pub window: HarmonicWindow,
}

impl Default for HarmonicTransfer {
    fn default() -> Self {
        Self { bands: 5, window: HarmonicWindow::default() }
    }
}

/// Weights of the bands of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HarmonicWindow {
    /// All count as they are.
    #[default]
    None,
    /// Gently less from band to band.
    Lanczos,
    /// Much less.
    Hanning,
}

/// Which surface places of a lattice lie on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlacesOn {
    /// On those that are drawn, where these are nearest: what is found is as right as the lattice is fine, and found anew
    /// for every isovalue.
    #[default]
    Drawn,
    /// Each on its own, that of its own value: what was found stays true while isovalues move (Wyman et al. 2006). Where
    /// matter has sharp borders, the surfaces beside the one that is drawn are very different, and their light shows in it.
    Own,
}

/// What lies between places of a lattice of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IlluminationInterpolation {
    /// The mean of the eight around, by how near they are.
    #[default]
    Linear,
    /// The light of the nearest place.
    Nearest,
    /// Of the eight around, that of the one whose isovalue is nearest to the surface's.
    NearestIsovalue,
    /// The mean of the 64 around under a cubic B-spline: smooth, over surfaces that differ more.
    Cubic,
}

/// Normals of a surface whose voxels are noisy, over 4 x 4 x 4 voxels and more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceNormals {
    /// Of the field under a cubic B-spline.
    #[default]
    Derivative,
    /// The means of central differences under a cubic B-spline, smoother.
    Differences,
    /// Those of `quality.gradient`.
    Data,
}

impl Illumination {
    pub(super) fn check(&self, path: &str) -> Checked {
        match self {
            Self::Lights => Ok(()),
            Self::Global(global) => global.check(&join(path, "global")),
        }
    }
}

impl Default for GlobalIllumination {
    fn default() -> Self {
        Self {
            method: IlluminationMethod::default(),
            environment: Environment::Constant { color: Color::hex(0xff_ff_ff), intensity: 1.0 },
            samples: 100,
            bounces: 4,
            shadows: true,
            distance: None,
            basis: IlluminationBasis::default(),
            surfaces: PlacesOn::default(),
            resolution: 1.0,
            interpolation: IlluminationInterpolation::default(),
            normals: SurfaceNormals::default(),
            offset: 0.5,
            file: None,
            baked: Held::default(),
        }
    }
}

impl GlobalIllumination {
    /// What a place sees of the sky, over so many world units if that is said: ambient occlusion, or vicinity shading
    /// (G-19).
    pub fn ambient_occlusion(distance: Option<f64>) -> Self {
        Self { bounces: 0, distance, ..Self::default() }
    }

    /// The bands of light that is kept in spherical harmonics, if it is, and the window over them.
    pub fn harmonics(&self) -> Option<(Bands, Option<Window>)> {
        let IlluminationBasis::Harmonics(HarmonicTransfer { bands, window }) = self.basis else { return None };
        let window = match window {
            HarmonicWindow::None => None,
            HarmonicWindow::Lanczos => Some(Window::Lanczos),
            HarmonicWindow::Hanning => Some(Window::Hanning),
        };
        let in_lattice = self.method == IlluminationMethod::Lattice;
        Bands::new(bands as usize).ok().filter(|_| in_lattice).map(|bands| (bands, window))
    }

    fn check(&self, path: &str) -> Checked {
        check_optics::environment(&join(path, "environment"), &self.environment)?;
        require((1..=65536).contains(&self.samples), path, "samples", self.samples, "1 to 65536")?;
        require(self.bounces <= 64, path, "bounces", self.bounces, "0 to 64")?;
        self.distance.map_or(Ok(()), |distance| positive(path, "distance", distance, "a length above 0"))?;
        let resolution = self.resolution;
        require((0.125..=4.0).contains(&resolution), path, "resolution", resolution, "0.125 to 4 for each voxel")?;
        if let IlluminationBasis::Harmonics(HarmonicTransfer { bands, .. }) = self.basis {
            let path = join(path, "basis.harmonics");
            require((1..=MOST_BANDS as u32).contains(&bands), &path, "bands", bands, "1 to 6")?;
        }
        require((0.0..=4.0).contains(&self.offset), path, "offset", self.offset, "0 to 4 voxels")
    }
}
