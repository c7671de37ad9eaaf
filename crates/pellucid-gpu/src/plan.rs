//! What a frame needs on the device, added up before anything is uploaded.

use std::fmt;

use pellucid_scene::{Stage, StageVolume};

use crate::bricks::{self, Brick};
use crate::optics::Optics;
use crate::staging::Staging;
use crate::targets::Targets;
use crate::texture::{Layout, Source};
use crate::uniforms::STATE_BYTES;
use crate::{Device, GpuError};

/// The memory of a frame, in bytes, and what had to be done to make it fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryPlan {
    /// What is allowed; `u64::MAX` if nothing was said.
    pub budget: u64,
    /// Voxels: of the volume, or of as many bricks as are there at the same time.
    pub voxels: u64,
    /// Pieces that the volume is cut into; 1 if it is whole.
    pub bricks: usize,
    /// How many of them are there at the same time; of a volume in stacks, how many stacks.
    pub loaded: usize,
    /// How voxels lie in textures.
    pub layout: Layout,
    /// Buffers that voxels pass through on their way.
    pub staging: u64,
    /// The map of empty space.
    pub blocks: u64,
    /// Tables, lights and everything else that is small.
    pub tables: u64,
    /// Rays and pixels of a band of the picture.
    pub targets: u64,
    /// Rows of the picture that are drawn at once, at most.
    pub rows: u32,
}

/// What a technique wants of the memory.
pub(crate) struct Demands {
    /// How voxels shall lie in textures, if there is room for it.
    pub layout: Layout,
    /// Voxels beyond a brick's cells that its samples need.
    pub border: usize,
    /// Bytes per pixel beyond those of [`Targets`].
    pub pixel_bytes: u64,
    /// Bytes of what a frame needs whatever its size.
    pub frame_bytes: u64,
}

impl MemoryPlan {
    /// The most states of rays that there are at once: a buffer may be bound up to twice as large.
    const MOST_PIXELS: u64 = 1 << 20;

    /// The most bricks at a time: every texture costs its driver more than its voxels.
    const MOST_BRICKS: usize = 512;

    /// Fits a stage into a budget: the volume whole if it can be, or in bricks.
    ///
    /// # Errors
    /// [`GpuError::Budget`] if that cannot be done.
    pub(crate) fn new(
        device: &Device,
        budget: u64,
        stage: &Stage,
        volume: &StageVolume,
        sources: &[Source],
        optics: &Optics,
        Demands { layout: wanted_layout, border, pixel_bytes, frame_bytes }: Demands,
    ) -> Result<(Self, Vec<Brick>), GpuError> {
        let (width, height) = (stage.viewpoint.width as u64, stage.viewpoint.height as u64);
        let tables = frame_bytes + optics.table_bytes() + 4 * (pellucid_plan::BLUE_NOISE_TILE as u64).pow(2);
        let blocks = optics.block_bytes();
        let voxel_bytes: usize = sources.iter().map(|source| source.encoding.bytes).sum();
        // Rays that are followed through volumes apart have a state in each.
        let states = if optics.pass.is_apart() { stage.volumes.len() as u64 } else { 1 };
        let row = width * (Targets::PIXEL_BYTES + (states - 1) * STATE_BYTES + pixel_bytes);
        let dims = volume.volume.grid().dims();
        let advice = "allow more memory or draw a narrower picture";
        let fixed = tables
            + blocks
            + row
            + sources
                .iter()
                .map(|source| Staging::least(wanted_layout.axes().map(|axis| dims[axis]), &source.encoding))
                .max()
                .unwrap_or(0);
        let Some(free) = budget.checked_sub(fixed) else {
            let what = "a row of the picture with the tables, without any voxels,".to_owned();
            return Err(GpuError::Budget { what, needed: fixed, budget, advice });
        };
        // One row is paid for; more of them and larger buffers make it faster.
        let wanted = (Self::MOST_PIXELS / states / width).clamp(1, height);
        let whole = dims.iter().map(|&n| n as u64).product::<u64>() * voxel_bytes as u64;
        let roomy = (wanted - 1) * row + Staging::WANTED;
        let side = device.capabilities.limits.max_texture_dimension_3d as usize;
        let bytes_of =
            |brick: &Brick| brick.voxels.dims().map(|n| n as u64).iter().product::<u64>() * voxel_bytes as u64;
        let (extra, room) = if whole <= free.saturating_sub(roomy) {
            (wanted - 1, free - roomy)
        } else {
            let rows = (free / 4 / row).min(wanted - 1);
            (rows, free - rows * row - (free / 8).min(Staging::WANTED))
        };
        let cut = |most| bricks::cut(dims, border, side, voxel_bytes, most);
        let mut pieces = cut(1 << 62)?;
        let mut loaded = pieces.len();
        let mut voxels = pieces.iter().map(bytes_of).sum::<u64>();
        let mut layout = Layout::Solid;
        if loaded == 1 && voxels <= room && wanted_layout != Layout::Solid && wanted_layout.fits(dims, device) {
            // One stack for each axis, if there is room for them.
            layout = wanted_layout;
            loaded = if 3 * voxels <= room { 3 } else { 1 };
            voxels *= loaded as u64;
        } else if voxels > room || loaded > Self::MOST_BRICKS {
            // One is drawn while the next one comes.
            pieces = cut(room / 2)?;
            let largest = pieces.iter().map(bytes_of).max().unwrap_or(0).max(1);
            loaded = ((room / largest) as usize).min(pieces.len()).min(Self::MOST_BRICKS);
            voxels = largest * loaded as u64;
        }
        let targets = (1 + extra) * row;
        let staging = (budget - tables - blocks - targets - voxels).min(Staging::WANTED);
        let rows = 1 + extra as u32;
        Ok((
            Self { budget, voxels, bricks: pieces.len(), loaded, layout, staging, blocks, tables, targets, rows },
            pieces,
        ))
    }

    /// What stays on the device, however much of the picture is drawn at once.
    pub(crate) fn kept(&self) -> u64 {
        self.voxels + self.staging + self.blocks + self.tables
    }

    /// The plan of two volumes in one picture.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            budget: self.budget,
            voxels: self.voxels + other.voxels,
            bricks: self.bricks.max(other.bricks),
            staging: self.staging + other.staging,
            blocks: self.blocks + other.blocks,
            tables: self.tables + other.tables,
            targets: self.targets.min(other.targets),
            rows: self.rows.min(other.rows),
            ..self
        }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.kept() + self.targets
    }
}

impl fmt::Display for MemoryPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
        write!(f, "{} MiB", mib(self.total()))?;
        if self.budget < u64::MAX {
            write!(f, " of {}", mib(self.budget))?;
        }
        let how = match (self.bricks, self.loaded) {
            (1, stacks) if self.layout != Layout::Solid => format!("in {stacks} stacks of slices"),
            (1, _) => "whole".to_owned(),
            (bricks, loaded) if bricks == loaded => format!("in {bricks} bricks"),
            (bricks, loaded) => format!("{loaded} of {bricks} bricks at a time"),
        };
        write!(
            f,
            " (voxels {}, {how}; upload {}, empty space {}, tables {}, picture {})",
            mib(self.voxels),
            mib(self.staging),
            mib(self.blocks),
            mib(self.tables),
            mib(self.targets)
        )
    }
}
