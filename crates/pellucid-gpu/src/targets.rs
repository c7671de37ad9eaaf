//! What a band of the picture is drawn into, and how it comes back.

use std::num::NonZeroU64;

use bytemuck::cast_slice;
use pellucid_scene::Frame as Picture;
use wgpu::{BindingResource, Buffer, BufferBinding, BufferDescriptor, BufferUsages, CommandEncoder, MapMode};

use crate::uniforms::{ChromaticPixel, Pixel, STATE_BYTES};
use crate::{Device, GpuError};

/// Depth of a pixel that met nothing; `march.wgsl` has the same.
const NOWHERE: f32 = 1e30;

/// The states of a band's rays, its pixels, and a copy of them that can be read.
pub struct Targets {
    /// Pixels per row.
    pub width: u32,
    /// Whether it is told of each colour what is held back.
    chromatic: bool,
    room: u64,
    /// In how many volumes rays are followed apart.
    volumes: u64,
    /// A ray's state per pixel, one volume after the other.
    states: Buffer,
    /// Pixels.
    pub pixels: Buffer,
    copied: Buffer,
}

impl Targets {
    /// Bytes per pixel of a band.
    pub const PIXEL_BYTES: u64 = STATE_BYTES + 2 * size_of::<ChromaticPixel>() as u64;

    /// States of so many volumes begin where they can be bound.
    const ALIGNMENT: u64 = 256 / STATE_BYTES;

    /// Room for a number of pixels.
    fn new(device: &Device, count: u64, volumes: u64) -> Self {
        let count = count.next_multiple_of(Self::ALIGNMENT);
        let buffer = |label, bytes: u64, usage| {
            let descriptor =
                BufferDescriptor { label: Some(label), size: count * bytes, usage, mapped_at_creation: false };
            device.device.create_buffer(&descriptor)
        };
        let pixel = size_of::<ChromaticPixel>() as u64;
        Self {
            width: 0,
            chromatic: false,
            room: count,
            volumes,
            states: buffer("states", STATE_BYTES * volumes, BufferUsages::STORAGE),
            pixels: buffer("pixels", pixel, BufferUsages::STORAGE | BufferUsages::COPY_SRC),
            copied: buffer("copied", pixel, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    /// Those that are there, for a band of a picture `across` pixels wide, if they have room for it, or new ones: the
    /// old ones go first. `chromatic` if shaders tell of each colour what is held back.
    pub fn kept<'t>(slot: &'t mut Option<Self>, device: &Device, shape: (usize, bool), size: [u32; 2]) -> &'t Self {
        Self::kept_apart(slot, device, 1, shape, size)
    }

    /// The same where rays are followed apart in so many volumes.
    pub fn kept_apart<'t>(
        slot: &'t mut Option<Self>,
        device: &Device,
        volumes: usize,
        (across, chromatic): (usize, bool),
        [width, rows]: [u32; 2],
    ) -> &'t Self {
        let (room, volumes) = (across as u64 * u64::from(rows), volumes as u64);
        slot.take_if(|targets| targets.room < room || targets.volumes != volumes);
        let targets = slot.get_or_insert_with(|| Self::new(device, room, volumes));
        (targets.width, targets.chromatic) = (width, chromatic);
        targets
    }

    /// The states of all volumes.
    pub fn states(&self) -> BindingResource<'_> {
        self.states.as_entire_binding()
    }

    /// The states of one of the volumes.
    pub fn states_in(&self, volume: usize) -> BindingResource<'_> {
        let bytes = self.room * STATE_BYTES;
        let (offset, size) = (volume as u64 * bytes, NonZeroU64::new(bytes));
        BindingResource::Buffer(BufferBinding { buffer: &self.states, offset, size })
    }

    fn bytes(&self, rows: u32) -> u64 {
        let pixel = if self.chromatic { size_of::<ChromaticPixel>() } else { size_of::<Pixel>() };
        u64::from(self.width) * u64::from(rows) * pixel as u64
    }

    /// Makes the pixels of a band readable once the commands are done.
    pub fn copy(&self, encoder: &mut CommandEncoder, rows: u32) {
        encoder.copy_buffer_to_buffer(&self.pixels, 0, &self.copied, 0, self.bytes(rows));
        // A failure is reported by the device, too.
        encoder.map_buffer_on_submit(&self.copied, MapMode::Read, ..self.bytes(rows), |_| ());
    }

    /// Waits for a band and puts it into the picture, from a column and a row on.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, device: &Device, from: [u32; 2], rows: u32, picture: &mut Picture) -> Result<(), GpuError> {
        self.read_pixels(device, from, rows, picture, |pixel, place, picture| {
            let [x, y, z, depth] = pixel.surface;
            if depth < NOWHERE {
                picture.normal[place] = [x, y, z];
            }
            let [_, _, skipped, rays] = pixel.counts;
            let statistics = &mut picture.statistics;
            statistics.samples_skipped += u64::from(skipped);
            statistics.rays_hit += u64::from(rays & 0xffff);
            statistics.rays_terminated += u64::from(rays >> 16);
        })
    }

    /// The same where pixels mean more than colour, depth and samples: that is told of each.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_pixels(
        &self,
        device: &Device,
        [column, row]: [u32; 2],
        rows: u32,
        picture: &mut Picture,
        mut each: impl FnMut(&Pixel, usize, &mut Picture),
    ) -> Result<(), GpuError> {
        device.wait()?;
        let slice = self.copied.slice(..self.bytes(rows));
        let mapped = slice.get_mapped_range().map_err(|error| GpuError::Lost { reason: error.to_string() })?;
        let (plain, chromatic): (&[Pixel], &[ChromaticPixel]) =
            if self.chromatic { (&[], cast_slice(&mapped)) } else { (cast_slice(&mapped), &[]) };
        if self.chromatic {
            picture.opacities.resize(picture.color.len(), [0.0; 3]);
        }
        let across = picture.width;
        let start = |line: usize| (row as usize + line) * across + column as usize;
        let width = self.width as usize;
        let pixels = plain.iter().chain(chromatic.iter().map(|pixel| &pixel.pixel));
        for (number, pixel) in pixels.enumerate() {
            let place = start(number / width) + number % width;
            if let Some(ChromaticPixel { held_back: [r, g, b, _], .. }) = chromatic.get(number) {
                picture.opacities[place] = [*r, *g, *b];
            }
            picture.color[place] = pixel.color;
            if pixel.surface[3] < NOWHERE {
                picture.depth[place] = pixel.surface[3];
            }
            let [samples, visible, ..] = pixel.counts;
            picture.samples[place] = samples;
            picture.statistics.samples += u64::from(samples);
            picture.statistics.samples_visible += u64::from(visible);
            each(pixel, place, picture);
        }
        drop(mapped);
        self.copied.unmap();
        Ok(())
    }
}
