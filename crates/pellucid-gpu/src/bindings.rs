//! What shaders are given of a scene, whichever technique draws it.

use bytemuck::{bytes_of, cast_slice};
use pellucid_field::{Filter, Gradient};
use pellucid_optics::SurfaceShare;
use pellucid_scene::{Stage, StageVolume};
use wgpu::{BindGroup, BindingResource, Buffer, FilterMode, Sampler, SamplerDescriptor, TextureFormat, TextureView};

use crate::bounds::BoundsBuffer;
use crate::drawing::Interpolation;
use crate::four::Four;
use crate::groups::{Groups, Named};
use crate::kernels::Kernels;
use crate::lights::Light;
use crate::noise::Noise;
use crate::optics::{Optics, lights};
use crate::resident::Resident;
use crate::shaders::Variant;
use crate::uniforms::{self, Frame};
use crate::uploads::{Uploads, storage};
use crate::window::Window;
use crate::{Device, texture};

/// The buffers of a frame: those that every technique reads.
pub struct Bindings<'a> {
    device: &'a Device,
    uploads: &'a Uploads,
    /// The part of the picture that is drawn.
    pub window: Window,
    /// What is compiled into shaders that look at the volume.
    pub variant: Variant,
    /// Most looks at the blocks in a pass.
    pub most_looks: u32,
    kernels: Option<Buffer>,
    /// If the texture unit interpolates.
    sampler: Option<Sampler>,
    /// What is left of lights where samples may be in shadow; a single point where rays are cast.
    points: Option<TextureView>,
    /// Bounds of the extinction, for paths.
    majorants: Option<TextureView>,
    /// Frame, planes, lights.
    parts: [Buffer; 3],
}

impl<'a> Bindings<'a> {
    /// Uploads what changes with the camera. `alter` has the last word on the frame's numbers.
    pub fn new(
        device: &'a Device,
        resident: &Resident,
        (stage, volume): (&Stage, &StageVolume),
        (optics, uploads): (&Optics, &'a Uploads),
        interpolation: Interpolation,
        alter: impl FnOnce(&mut Frame),
    ) -> Self {
        let grid = volume.volume.grid();
        let region = stage.region(volume);
        let (filter, gradient) = (optics.tables.filter, stage.quality.gradient);
        let encoding = resident.field().encoding;
        let kernels =
            Self::needs_kernels(stage, optics).then(|| Kernels::new(filter, gradient, resident.voxels().data()));
        let variant = Variant {
            hardware: interpolation == Interpolation::Hardware && encoding.filterable && filter == Filter::Linear,
            holes: encoding.holes,
            bricks: !resident.is_whole(),
            shaded: optics.shaded,
            weighted: optics.weighted,
            scattered: optics.tables.light.scatter.is_some(),
            shadowed: stage.shadow_step(volume).is_some(),
            perturbed: uploads.perturbation.is_some(),
            chromatic: stage.chroma(volume).is_some(),
            knots: !optics.nodes.knots().is_empty(),
            painted: uploads.colors.is_some(),
            exact: stage.finds_every_surface(volume),
            opaque: optics.opaque,
            kernels: kernels.is_some(),
            layered: stage.has_layers(),
            ..Variant::of(optics.pass)
        };
        let mut frame = Frame::new(stage, volume, &region);
        let window = Window::of(&stage.viewpoint, uniforms::corners(stage));
        frame.set_window(&window);
        frame.set_values(resident.field().data());
        let knots = list_length(&uploads.entries) - optics.nodes.knots().len() as u64;
        frame.set_nodes(&optics.nodes, knots);
        frame.level_count = optics.levels.len() as u32;
        frame.scattering = uploads.scattering;
        frame.noise = uploads.perturbation.as_ref().map_or(Noise::default(), |noise| noise.numbers);
        // Where the length of a gradient tells something, a cut must not lengthen it.
        let by_gradient = stage.scatters() && matches!(volume.scattering.surface, SurfaceShare::Gradient(_));
        if volume.gradient_weight.is_none() && !by_gradient {
            frame.set_rise(optics.tables.table.nodes());
        }
        if let Some(blocks) = optics.blocks {
            frame.set_blocks(blocks.dims, blocks.size);
        }
        alter(&mut frame);
        let light = |light| Light::new(light, stage.volumes.iter().any(|volume| volume.scattering.meets(light)));
        let lights: Vec<Light> = stage.lights.iter().map(light).collect();
        let parts = [
            device.constant_buffer("frame", bytes_of(&frame)),
            storage(device, "planes", &uniforms::planes(&region, grid)),
            storage(device, "lights", &lights),
        ];
        let kernels = kernels.filter(|_| variant.canonical().kernels);
        Self {
            device,
            uploads,
            window,
            variant,
            most_looks: kernels.as_ref().map_or(u32::MAX, Kernels::most_looks),
            kernels: kernels.map(|kernels| device.constant_buffer("kernels", cast_slice(&kernels.to_fours()))),
            sampler: variant.canonical().hardware.then(|| sampler(device)),
            points: variant.shadowed.then(|| one_point(device)),
            majorants: None,
            parts,
        }
    }

    /// The same with shadows that the points of light volumes tell of, if there are some; the frame's numbers must say
    /// so, too.
    pub fn with_light(mut self, points: Option<TextureView>) -> Self {
        if points.is_some() {
            self.variant.shadowed = true;
            self.points = points;
        }
        self
    }

    /// The same with bounds of the extinction.
    pub fn with_majorants(self, majorants: Option<TextureView>) -> Self {
        Self { majorants, ..self }
    }

    /// Whether the filter is not linear, or the gradient not of central differences.
    pub fn needs_kernels(stage: &Stage, optics: &Optics) -> bool {
        optics.tables.filter != Filter::Linear || (stage.quality.gradient != Gradient::Central && lights(stage.mode()))
    }

    /// What shaders are told of the frame and its passes.
    pub fn of_frame<'r>(&'r self, bounds: &'r BoundsBuffer) -> Vec<Named<'r>> {
        let [frame, planes, lights] = &self.parts;
        let Uploads { blue_noise, levels, .. } = self.uploads;
        let all = [("frame", frame), ("planes", planes), ("lights", lights), ("levels", levels)];
        let all = all.map(|(name, buffer)| (name, buffer.as_entire_binding()));
        let more = [("bounds", bounds.binding()), ("blue_noise", BindingResource::TextureView(blue_noise))];
        let majorants = self.majorants.iter().map(|majorants| ("majorants", BindingResource::TextureView(majorants)));
        all.into_iter().chain(more).chain(majorants).collect()
    }

    /// Entries, planes and lights: what all volumes of a pass have in lists that they share.
    pub fn lists(&self) -> [&Buffer; 3] {
        let [_, planes, lights] = &self.parts;
        [&self.uploads.entries, planes, lights]
    }

    /// What shaders are told of a brick, and of the volume that it is of.
    pub fn of_volume<'r>(&'r self, [field, voxels]: &'r [TextureView; 2]) -> Vec<Named<'r>> {
        use BindingResource::{Sampler, TextureView};
        let Uploads { blocks, perturbation, colors, .. } = self.uploads;
        let mut all =
            vec![("volume", TextureView(field)), ("voxels", TextureView(voxels)), ("blocks", TextureView(blocks))];
        all.extend(self.sampler.as_ref().map(|sampler| ("linear", Sampler(sampler))));
        all.extend(self.kernels.as_ref().map(|kernels| ("kernels", kernels.as_entire_binding())));
        all.extend(self.points.as_ref().map(|points| ("points", TextureView(points))));
        all.extend(colors.as_ref().map(|(_, colors)| ("colors", TextureView(colors))));
        all.extend(perturbation.as_ref().map(|noise| ("noise_texels", TextureView(&noise.texels))));
        all
    }

    /// The tables that a pipeline reads.
    pub fn table_group(&self, groups: &Groups) -> BindGroup {
        groups.tables().bind(self.device, &[("entries", self.uploads.entries.as_entire_binding())])
    }
}

/// How many rows of four numbers a list has.
fn list_length(list: &Buffer) -> u64 {
    list.size() / size_of::<Four>() as u64
}

fn one_point(device: &Device) -> TextureView {
    texture::solid(device, "light volume", TextureFormat::R32Float, [1; 3], bytes_of(&1.0f32))
}

fn sampler(device: &Device) -> Sampler {
    device.device.create_sampler(&SamplerDescriptor {
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..Default::default()
    })
}
