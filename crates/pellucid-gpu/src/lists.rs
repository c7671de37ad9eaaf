//! Lists of several volumes, one behind the other: a pass has room for few buffers, however many volumes it follows.

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor};

use crate::Device;
use crate::four::Four;
use crate::groups::Named;
use crate::lights::Light;

/// Entries, planes and lights: what shaders call them, and bytes of an element.
const LISTS: [(&str, u64); 3] = [
    ("entries", size_of::<Four>() as u64),
    ("planes", size_of::<Four>() as u64),
    ("lights", size_of::<Light>() as u64),
];

/// The lists of all volumes of a pass.
pub struct Lists([Buffer; 3]);

impl Lists {
    /// Where the lists of a volume begin behind those of the volumes before it, in elements.
    pub fn places<'b>(before: impl IntoIterator<Item = [&'b Buffer; 3]>) -> [u32; 3] {
        let mut places = [0; 3];
        for lists in before {
            for ((place, list), (_, bytes)) in places.iter_mut().zip(lists).zip(LISTS) {
                *place += (list.size() / bytes) as u32;
            }
        }
        places
    }

    /// The lists of volumes, joined.
    pub fn joined(device: &Device, volumes: &[[&Buffer; 3]]) -> Self {
        let mut encoder = device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("lists") });
        let joined = [0, 1, 2].map(|number| {
            let (label, bytes) = LISTS[number];
            // Only whole elements are counted.
            let size = |lists: &[&Buffer; 3]| lists[number].size() / bytes * bytes;
            let descriptor = BufferDescriptor {
                label: Some(label),
                size: volumes.iter().map(size).sum(),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            };
            let buffer = device.device.create_buffer(&descriptor);
            let mut place = 0;
            for lists in volumes {
                encoder.copy_buffer_to_buffer(lists[number], 0, &buffer, place, size(lists));
                place += size(lists);
            }
            buffer
        });
        device.queue.submit([encoder.finish()]);
        Self(joined)
    }

    /// The lists by what shaders call them.
    pub fn named(&self) -> impl Iterator<Item = Named<'_>> {
        self.0.iter().zip(LISTS).map(|(buffer, (name, _))| (name, buffer.as_entire_binding()))
    }
}
