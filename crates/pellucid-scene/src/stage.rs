//! What a backend draws, and what every one asks of it before.

use glam::DVec3;
use pellucid_field::{Filter, parallel};
use pellucid_optics::{Chroma, LightModel, ResolvedLight, ShadowRays, ShadowVolume, Shadows, Sky};
use rayon::prelude::*;

use crate::origin::smallest_difference;
use crate::{
    Background, Classification, GlobalIllumination, HalfAngle, ImageSettings, Isosurface, Isovalue, LightPath, Mode,
    Overlap, PathTrace, Quality, Region, RenderWarning, Slice, Slicing, StageVolume, SurfaceSearch, Technique,
    Viewpoint,
};

/// A scene with nothing left to choose: what a backend draws.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The volumes.
    pub volumes: Vec<StageVolume>,
    /// What lies where several of them overlap; the sum where the technique heeds no other rule.
    pub overlap: Overlap,
    /// The camera and the size of the picture.
    pub viewpoint: Viewpoint,
    /// Lights, all in the world's frame.
    pub lights: Vec<ResolvedLight>,
    /// Light from everywhere, reflected by the materials' ambient part.
    pub ambient: f32,
    /// Whether what lies between a light and a sample holds light back.
    pub shadows: Shadows,
    /// How samples answer light.
    pub light_model: LightModel,
    /// Technique and its settings; isovalues ascend.
    pub technique: Technique,
    /// Quality settings.
    pub quality: Quality,
    /// Background and encoding.
    pub image: ImageSettings,
    /// Distance between samples in world units.
    pub step: f64,
}

impl Stage {
    /// Whether several volumes are drawn.
    pub fn has_layers(&self) -> bool {
        self.volumes.len() > 1
    }

    /// What is made of the samples.
    pub fn mode(&self) -> &Mode {
        self.technique.mode()
    }

    /// The isovalues that a volume is drawn with, by its number, in ascending order; they count from its origin.
    pub fn isovalues(&self, volume: usize) -> Vec<Isovalue> {
        let Mode::Isosurface(Isosurface { isovalues, .. }) = self.mode() else { return Vec::new() };
        let own = isovalues.iter().filter(|iso| iso.volume.is_none_or(|of| of == volume));
        // Those of the stage count from the first volume's.
        let shift = self.volumes[volume].origin - self.volumes[0].origin;
        own.map(|iso| Isovalue { value: iso.value - shift, ..iso.clone() }).collect()
    }

    /// Whether the field of a volume is a cubic along every ray, between planes of voxels (5.5-8, G-03).
    pub fn is_trilinear(&self, volume: &StageVolume) -> bool {
        self.quality.filter == Filter::Linear && !volume.perturbation.displaces()
    }

    /// Whether rays find every isosurface of a volume.
    pub fn finds_every_surface(&self, volume: &StageVolume) -> bool {
        let is_asked = matches!(self.mode(), Mode::Isosurface(surfaces) if surfaces.search == SurfaceSearch::Exact);
        is_asked && self.is_trilinear(volume)
    }

    /// The settings of all light that arrives at surfaces, if they are lit by it.
    pub fn global_illumination(&self) -> Option<&GlobalIllumination> {
        let is_lit = |volume: &StageVolume| volume.material.is_some();
        let drawn = self.slicing().is_none() && !self.has_layers() && self.volumes.iter().all(is_lit);
        self.mode().global_illumination().filter(|_| drawn)
    }

    /// The settings of slices, if those draw.
    pub fn slicing(&self) -> Option<&Slicing> {
        self.technique.slicing()
    }

    /// The settings of half-angle slicing, if that draws.
    pub fn half_angle(&self) -> Option<&HalfAngle> {
        self.technique.half_angle()
    }

    /// The settings of the path tracer, if that draws.
    pub fn path_trace(&self) -> Option<&PathTrace> {
        self.technique.path_trace()
    }

    /// Whether samples answer light as a cloud, by the volume's `scattering`.
    pub fn scatters(&self) -> bool {
        match self.technique.needs().light {
            LightPath::Arrives => self.light_model == LightModel::Scattering && *self.mode() == Mode::Composite,
            LightPath::Spreads | LightPath::Scatters => true,
        }
    }

    /// Whether samples of a volume, by its number, do: where light arrives at samples, those that give others their colours
    /// alone are not lit once more.
    pub fn scatters_in(&self, volume: usize) -> bool {
        let arrives = self.technique.needs().light == LightPath::Arrives;
        self.scatters() && (!arrives || self.overlap.holds_back(volume))
    }

    /// The step of shadow rays in world units, if what is lit of a volume asks for such.
    pub fn shadow_step(&self, volume: &StageVolume) -> Option<f64> {
        let smallest = self.volumes.iter().map(|volume| volume.volume.grid().smallest_spacing());
        let smallest = smallest.fold(f64::INFINITY, f64::min);
        let surfaces = matches!(self.mode(), Mode::Isosurface(_));
        let step = match self.shadows {
            _ if !self.technique.needs().shadows => return None,
            Shadows::Rays(rays) => rays.step,
            // Shadows of surfaces have edges.
            Shadows::Volume(_) if surfaces => ShadowRays::default().step,
            Shadows::Volume(_) | Shadows::None => return None,
        };
        // What casts shadows need not be lit itself.
        let lit = self.volumes.iter().any(|other| other.material.is_some());
        (self.scatters() || volume.material.is_some() || self.has_layers() && lit).then_some(step * smallest)
    }

    /// How each colour of light is held back on its way to the eye and from lights, where techniques composite samples
    /// themselves and not all colours are lost alike (K-13).
    pub fn chroma(&self, volume: &StageVolume) -> Option<Chroma> {
        let needed = self.technique.needs().extinction_color && !self.has_layers();
        Chroma::of(&volume.scattering).filter(|_| needed)
    }

    /// Whether colours from behind are held back each in its own way, which one alpha cannot tell
    /// ([`Frame::opacities`](crate::Frame)).
    pub fn holds_back_each_color(&self) -> bool {
        let by_paths = self.technique.needs().light == LightPath::Scatters;
        self.volumes.iter().any(|volume| match by_paths {
            true => volume.scattering.extinction_factors().is_some() && !self.has_layers(),
            false => self.chroma(volume).is_some(),
        })
    }

    /// Points of a light volume for each voxel and axis, if what is lit asks for one: that of all volumes together.
    pub fn light_resolution(&self) -> Option<f64> {
        let Shadows::Volume(ShadowVolume { resolution }) = self.shadows else { return None };
        let asked = self.technique.needs().shadows && *self.mode() == Mode::Composite;
        let lit = self.scatters() || self.volumes.iter().any(|volume| volume.material.is_some());
        (asked && lit).then_some(resolution)
    }

    /// How many steps of a length off the sample shadow rays begin: off surfaces, as far as the roughness of sampled
    /// data reaches.
    pub fn shadow_offset(&self, volume: &StageVolume, length: f64) -> f64 {
        const ROUGHNESS_VOXELS: f64 = 2.0;
        match self.mode() {
            Mode::Isosurface(_) => (ROUGHNESS_VOXELS * volume.volume.grid().smallest_spacing() / length).max(1.0),
            _ => 0.0,
        }
    }

    /// Whether voxels are classified and their colours interpolated (4.2).
    pub fn classifies_voxels(&self) -> bool {
        self.quality.classification == Classification::Pre && self.technique.needs().classification
    }

    /// Whether segments between samples are integrated (4.6); integrals hold all colours back alike.
    pub fn integrates_segments(&self) -> bool {
        let asked = self.quality.classification == Classification::PreIntegrated;
        asked && *self.mode() == Mode::Composite && self.volumes.iter().all(|volume| self.chroma(volume).is_none())
    }

    /// What is drawn otherwise than the scene asks for: only paths find the size of a light, blending
    /// units hold all colours back alike, and points of a transfer function may be too close to be told apart.
    pub fn fallbacks(&self) -> impl Iterator<Item = RenderWarning> {
        let (needs, name) = (self.technique.needs(), self.technique.name());
        let by_paths = needs.light == LightPath::Scatters;
        let sized = self.lights.iter().enumerate().filter(|(_, light)| light.has_extent());
        let lights = sized.map(move |(number, _)| {
            format!("lighting.lights[{number}] has a size, which {name} does not draw: its middle shines")
        });
        let volumes = self.volumes.iter().enumerate();
        let colored = volumes.filter(|(_, volume)| volume.scattering.extinction_factors().is_some());
        let volumes = colored.filter_map(move |(number, volume)| {
            let setting = format!("volumes[{number}].scattering.extinction_color");
            match self.chroma(volume) {
                None => Some(format!("{setting} is not drawn by {name}: all colours are lost alike")),
                Some(_) if needs.classification && self.quality.classification == Classification::PreIntegrated => {
                    Some(format!(
                        "{setting} is drawn with post-classification, as integrals hold all colours back alike"
                    ))
                }
                Some(_) => None,
            }
        });
        let unseen = self.image.background == Background::Environment && self.sky().is_none();
        let unseen = unseen.then(|| format!("image.background is the environment, and {name} has none: it is black"));
        let finds_lights = by_paths || self.global_illumination().is_some();
        let ignored =
            lights.filter(move |_| !finds_lights).chain(volumes.filter(move |_| !by_paths || self.has_layers()));
        let volumes = self.volumes.iter().enumerate();
        let merged = volumes.filter_map(|(number, staged)| {
            let (range, gap) = (staged.volume.statistics(), smallest_difference(&staged.volume)?);
            Some(format!(
                "volumes[{number}] has integers from {} to {}, which are drawn in single precision: the largest are told \
                 apart from {gap} on",
                range.min, range.max
            ))
        });
        let points = self.volumes.iter().enumerate().filter_map(|(number, volume)| {
            let [a, b] = volume.transfer_function.merged_points()?.map(|value| value + volume.origin);
            Some(format!(
                "volumes[{number}].transfer_function has points at {a} and {b}, which are one number in the single \
                 precision of samples: what it shows between them is not seen; shift and scale the data's values"
            ))
        });
        let moved = |volume: &StageVolume| volume.colors.is_some() && volume.perturbation.displaces();
        let volumes = self.volumes.iter().enumerate().filter(move |(_, volume)| moved(volume));
        let unmoved = volumes.map(|(number, _)| {
            format!("volumes[{number}].perturbation moves opacities, and not the colours of the data")
        });
        let far = self.global_illumination().is_some_and(|global| global.harmonics().is_some());
        let near = self.lights.iter().enumerate().filter(move |(_, light)| far && !light.is_directional());
        let near = near.map(|(number, _)| {
            format!("lighting.lights[{number}] has a place, and spherical harmonics hold light from far away: it does not shine")
        });
        let global = self.mode().global_illumination().is_some() && self.global_illumination().is_none();
        let locally = match (self.slicing().is_some(), self.has_layers()) {
            (true, _) => Some("slices"),
            (_, true) => Some("surfaces of several volumes"),
            _ => None,
        };
        let locally = locally
            .filter(|_| global)
            .map(|what| format!("{what} are not lit by isosurface.illumination.global: the lights alone light them"));
        ignored
            .chain(unmoved)
            .chain(locally)
            .chain(near)
            .chain(unseen)
            .chain(merged)
            .chain(points)
            .map(|reason| RenderWarning::Fallback { reason })
    }

    /// The environment, if the technique has one that is not dark.
    pub fn sky(&self) -> Option<Sky> {
        self.technique.environment()?.resolve().ok().flatten()
    }

    /// The environment's radiance behind every pixel, linear RGB by rows, where the background is that; else nothing.
    pub fn backdrop(&self) -> Vec<[f32; 3]> {
        let view = &self.viewpoint;
        let Some(sky) = self.sky().filter(|_| self.image.background == Background::Environment) else {
            return Vec::new();
        };
        let radiance = |pixel: usize| {
            let ray = view.ray((pixel % view.width) as f64 + 0.5, (pixel / view.width) as f64 + 0.5);
            sky.radiance(ray.direction.as_vec3())
        };
        parallel(|| (0..view.width * view.height).into_par_iter().map(radiance).collect())
    }

    /// The clips of a volume and, for a thick slice, the planes of its slab.
    pub fn region(&self, volume: &StageVolume) -> Region {
        let mut region = volume.region.clone();
        if let Mode::Slice(slice) = self.mode()
            && slice.thickness > 0.0
        {
            let (point, normal) = self.slice_plane(volume, slice);
            let half = normal * (slice.thickness / 2.0);
            region.keep(normal, point - half);
            region.keep(-normal, point + half);
        }
        region
    }

    /// A slice's point and unit normal, with their automatic values filled in.
    pub fn slice_plane(&self, volume: &StageVolume, slice: &Slice) -> (DVec3, DVec3) {
        // Of several volumes the middle is that of all of them.
        let points = self.volumes.iter().map(|volume| volume.slice_point(slice));
        let point = match &*self.volumes {
            [_, _, ..] => points.sum::<DVec3>() / self.volumes.len() as f64,
            _ => volume.slice_point(slice),
        };
        let normal = slice.normal.map_or(-self.viewpoint.forward, DVec3::from_array);
        (point, normal.normalize())
    }

    /// Steps along the diagonal of a volume's box: no ray is longer inside.
    pub fn most_steps(&self, volume: &StageVolume) -> f64 {
        let grid = volume.volume.grid();
        let (low, high) = grid.index_bounds();
        let corner =
            |signs: [f64; 3]| grid.world_from_index().transform_vector3((high - low) * DVec3::from_array(signs));
        let diagonals = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];
        diagonals.map(|signs| corner(signs).length()).into_iter().fold(0.0, f64::max) / self.step
    }
}
