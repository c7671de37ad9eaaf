//! Volumes as 3D textures: which format holds which voxels, and how they get there.

use std::sync::Arc;

use half::f16;
use pellucid_field::{Volume, Voxel, Voxels, for_voxels};
use pellucid_plan::Tables;
use pellucid_scene::{Stage, StageVolume};
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    Extent3d, Features, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
};

use crate::{Capabilities, Device};

/// How a volume's voxels are held in a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// The texture's format; a shader reads it as one float.
    pub format: TextureFormat,
    /// Bytes per voxel.
    pub bytes: usize,
    /// What a shader reads, times the first and plus the second, is the stored number.
    pub stored: [f64; 2],
    /// Whether some voxels are absent.
    pub holes: bool,
    /// Whether a sampler can interpolate.
    pub filterable: bool,
}

impl Encoding {
    /// The smallest format that keeps every voxel of a volume: integers of 8 and 16 bits as shares of
    /// their range (exact: a float holds each), others as floats.
    pub fn of(volume: &Volume, capabilities: &Capabilities) -> Self {
        let statistics = volume.statistics();
        let holes = statistics.nan + statistics.infinite > 0;
        let norm16 = capabilities.has(Features::TEXTURE_FORMAT_16BIT_NORM);
        let float_filter = capabilities.has(Features::FLOAT32_FILTERABLE);
        let norm = |format, bytes, levels: f64, lowest: f64| Self {
            format,
            bytes,
            stored: [levels, lowest],
            holes: false,
            filterable: true,
        };
        match volume.voxels() {
            Voxels::U8(_) => norm(TextureFormat::R8Unorm, 1, 255.0, 0.0),
            Voxels::I8(_) => norm(TextureFormat::R8Unorm, 1, 255.0, -128.0),
            Voxels::U16(_) if norm16 => norm(TextureFormat::R16Unorm, 2, 65535.0, 0.0),
            Voxels::I16(_) if norm16 => norm(TextureFormat::R16Unorm, 2, 65535.0, -32768.0),
            Voxels::F16(_) if !holes => norm(TextureFormat::R16Float, 2, 1.0, 0.0),
            _ => Self {
                format: TextureFormat::R32Float,
                bytes: 4,
                stored: [1.0, 0.0],
                holes,
                filterable: float_filter && !holes,
            },
        }
    }

    /// Appends voxels of one component: `count` of them from voxel `first` of the grid on, `stride` apart.
    pub fn append(
        &self,
        bytes: &mut Vec<u8>,
        (volume, component): (&Volume, usize),
        first: usize,
        stride: usize,
        count: usize,
    ) {
        let components = volume.components();
        let as_they_are = match volume.voxels() {
            Voxels::U8(_) | Voxels::F16(_) => self.format != TextureFormat::R32Float,
            Voxels::U16(_) => self.format == TextureFormat::R16Unorm,
            Voxels::F32(_) => !self.holes,
            _ => false,
        };
        for_voxels!(volume.voxels(), data => {
            let run = &data[first * components..(first + (count - 1) * stride + 1) * components];
            if as_they_are && components * stride == 1 {
                bytes.extend_from_slice(bytemuck::cast_slice(run));
            } else {
                let voxels = run.iter().skip(component).step_by(components * stride);
                encode(bytes, self.format, self.stored[1] as f32, voxels);
            }
        });
    }

    /// What a shader reads, times the first and plus the second, is the data value.
    pub fn data(&self, volume: &Volume) -> [f64; 2] {
        let map = volume.value_map();
        [self.stored[0] * map.scale, map.value(self.stored[1])]
    }
}

/// A component of a volume, and how it is held.
pub struct Source {
    /// The volume.
    pub volume: Arc<Volume>,
    /// Which of its components.
    pub component: usize,
    /// How its voxels are held.
    pub encoding: Encoding,
}

impl Source {
    /// What a stage reads: the field and, where that is coefficients, the voxels that are classified.
    pub fn of(device: &Device, volume: &StageVolume, tables: &Tables, stage: &Stage) -> Vec<Self> {
        let both = stage.classifies_voxels() && !Arc::ptr_eq(&tables.field, &volume.volume);
        let voxels = both.then_some((&volume.volume, volume.component));
        let source = |(volume, component): (&Arc<Volume>, usize)| Self {
            encoding: Encoding::of(volume, &device.capabilities),
            volume: volume.clone(),
            component,
        };
        std::iter::once((&tables.field, tables.component)).chain(voxels).map(source).collect()
    }

    /// Whether it is the same component of the same volume.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume) && self.component == other.component
    }

    /// What a shader reads, times the first and plus the second, is the data value.
    pub fn data(&self) -> [f64; 2] {
        self.encoding.data(&self.volume)
    }
}

/// How voxels lie in a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// A 3D texture.
    #[default]
    Solid,
    /// A stack of 2D textures across an axis (3.2-1).
    Stack(usize),
}

impl Layout {
    /// The axes of the volume that run along the texture's.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Self::Stack(0) => [1, 2, 0],
            Self::Stack(1) => [0, 2, 1],
            Self::Stack(_) | Self::Solid => [0, 1, 2],
        }
    }

    /// Whether a device has textures of such dimensions.
    pub fn fits(self, dims: [usize; 3], device: &Device) -> bool {
        let limits = &device.capabilities.limits;
        let most = match self {
            Self::Solid => [limits.max_texture_dimension_3d; 3],
            Self::Stack(_) => {
                let side = limits.max_texture_dimension_2d.min(limits.max_texture_dimension_3d);
                [side, side, limits.max_texture_array_layers]
            }
        };
        self.axes().into_iter().zip(most).all(|(axis, most)| dims[axis] <= most as usize)
    }
}

/// Voxels from the first on and up to the second, along every axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// First voxel.
    pub low: [usize; 3],
    /// One beyond the last.
    pub high: [usize; 3],
}

impl Part {
    /// Voxels per axis.
    pub fn dims(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.high[axis] - self.low[axis])
    }

    /// The voxels of both, if there are any.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let low = [0, 1, 2].map(|axis| self.low[axis].max(other.low[axis]));
        let high = [0, 1, 2].map(|axis| self.high[axis].min(other.high[axis]));
        (0..3).all(|axis| low[axis] < high[axis]).then_some(Self { low, high })
    }
}

/// An empty texture for voxels.
pub fn create(device: &Device, encoding: &Encoding, layout: Layout, dims: [usize; 3]) -> Texture {
    device.device.create_texture(&TextureDescriptor {
        label: Some("volume"),
        size: extent(layout.axes().map(|axis| dims[axis])),
        mip_level_count: 1,
        sample_count: 1,
        dimension: if layout == Layout::Solid { TextureDimension::D3 } else { TextureDimension::D2 },
        format: encoding.format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// A 3D texture filled with bytes, x fastest.
pub fn solid(device: &Device, label: &str, format: TextureFormat, dims: [usize; 3], bytes: &[u8]) -> TextureView {
    filled(device, label, (TextureDimension::D3, format), dims, bytes)
}

/// A 2D texture filled with bytes, row by row.
pub fn flat(device: &Device, label: &str, format: TextureFormat, size: [usize; 2], bytes: &[u8]) -> TextureView {
    filled(device, label, (TextureDimension::D2, format), [size[0], size[1], 1], bytes)
}

fn filled(
    device: &Device,
    label: &str,
    (dimension, format): (TextureDimension, TextureFormat),
    dims: [usize; 3],
    bytes: &[u8],
) -> TextureView {
    let descriptor = TextureDescriptor {
        label: Some(label),
        size: extent(dims),
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let texture =
        device.device.create_texture_with_data(&device.queue, &descriptor, TextureDataOrder::default(), bytes);
    texture.create_view(&Default::default())
}

pub(crate) fn extent([width, height, depth]: [usize; 3]) -> Extent3d {
    Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: depth as u32 }
}

/// Appends voxels, one component of several, in a format.
fn encode<'v, T: Voxel>(bytes: &mut Vec<u8>, format: TextureFormat, lowest: f32, voxels: impl Iterator<Item = &'v T>) {
    match format {
        TextureFormat::R8Unorm => bytes.extend(voxels.map(|v| (v.to_f32() - lowest) as u8)),
        TextureFormat::R16Unorm => bytes.extend(voxels.flat_map(|v| ((v.to_f32() - lowest) as u16).to_ne_bytes())),
        TextureFormat::R16Float => bytes.extend(voxels.flat_map(|v| f16::from_f32(v.to_f32()).to_ne_bytes())),
        // WGSL knows no NaN: absence is a number that no voxel has.
        _ => bytes.extend(voxels.flat_map(|v| {
            let v = v.to_f32();
            if v.is_finite() { v } else { f32::MAX }.to_ne_bytes()
        })),
    }
}
