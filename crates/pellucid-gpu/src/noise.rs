//! Noise on a volume as shaders take it: the structure of `frame.wgsl`.

use bytemuck::{Pod, Zeroable, cast_slice};
use pellucid_field::Noise as Texels;
use pellucid_plan::Tables;
use wgpu::{TextureFormat, TextureView};

use crate::four::Four;
use crate::{Device, texture};

/// A noise in a sum.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Term {
    pub scale: Four,
    pub start: Four,
}

/// What moves and varies a volume.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Noise {
    pub amplitude: Four,
    pub reach: Four,
    pub spacing: Four,
    pub between: Four,
    pub weights: Four,
    pub counts: [u32; 4],
    pub terms: [Term; 16],
}

/// The noise of a volume, uploaded.
pub struct UploadedNoise {
    /// Random numbers.
    pub texels: TextureView,
    /// What they do.
    pub numbers: Noise,
}

impl Noise {
    /// Of the tables of a volume; `None` if nothing perturbs it.
    fn new(tables: &Tables) -> Option<Self> {
        let (displacer, variation) = (tables.displacer.as_ref(), tables.variation.as_ref());
        if displacer.is_none() && variation.is_none() {
            return None;
        }
        let mut noise = Self::default();
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let moving = displacer.map_or(&[][..], |by| by.turbulence().terms());
        let varying = variation.map_or(&[][..], |by| by.turbulence().terms());
        if let Some(by) = displacer {
            (noise.amplitude, noise.reach, noise.spacing) = (four(by.amplitude), four(by.reach), four(by.spacing));
            noise.between = by.between.map_or([0.0; 4], |[none, full]| [none, full, 1.0, 0.0]);
        }
        if let Some(by) = variation {
            noise.weights = four(by.weights);
        }
        noise.counts = [moving.len() as u32, varying.len() as u32, 0, 0];
        for (place, term) in noise.terms.iter_mut().zip(moving.iter().chain(varying)) {
            let [x, y, z] = term.scale;
            *place = Term { scale: [x, y, z, term.weight], start: four(term.start) };
        }
        Some(noise)
    }
}

impl UploadedNoise {
    /// The noise of tables, if there is some.
    pub fn new(device: &Device, tables: &Tables) -> Option<Self> {
        let numbers = Noise::new(tables)?;
        let displacing = tables.displacer.as_ref().map(|by| by.turbulence());
        let sum = displacing.or(tables.variation.as_ref().map(|by| by.turbulence()))?;
        let texels = cast_slice(sum.noise().texels());
        let texels = texture::solid(device, "noise", TextureFormat::Rgba8Unorm, [Texels::SIZE; 3], texels);
        Some(Self { texels, numbers })
    }
}
