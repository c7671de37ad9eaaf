//! Volumes with their tables on the device, kept from frame to frame.

use std::sync::Arc;

use pellucid_plan::{ColorGrid, Tables};
use pellucid_scene::StageVolume;

use crate::Device;
use crate::bricks::Brick;
use crate::optics::Optics;
use crate::plan::MemoryPlan;
use crate::resident::Resident;
use crate::texture::Source;
use crate::uploads::Uploads;

/// What is known of a volume before anything of it is on the device.
pub struct Wanted<'s> {
    /// The volume with its optics, and its number.
    pub volume: &'s StageVolume,
    pub number: usize,
    /// Its tables.
    pub tables: Arc<Tables>,
    /// The colours of its voxels, if it is drawn in them.
    pub colors: Option<Arc<ColorGrid>>,
    /// What is read of it.
    pub sources: Vec<Source>,
    /// How it fits into memory.
    pub plan: MemoryPlan,
    /// What it is cut into.
    pub bricks: Vec<Brick>,
}

/// What is kept of a volume.
#[derive(Default)]
pub struct OnDevice {
    uploads: Option<Uploads>,
    /// Its voxels.
    pub resident: Option<Resident>,
}

/// A volume that is drawn.
pub struct Drawn<'a, 'o> {
    /// The volume with its optics.
    pub volume: &'a StageVolume,
    /// Its voxels on the device.
    pub resident: &'a mut Resident,
    /// Its tables.
    pub optics: &'o Optics<'o>,
    /// The same on the device.
    pub uploads: &'a Uploads,
}

impl OnDevice {
    /// Frees the memory of what is not wanted any more.
    pub fn forget_others(&mut self, Wanted { tables, colors, sources, plan, bricks, .. }: &Wanted, optics: &Optics) {
        self.resident.take_if(|resident| !resident.holds(sources, plan, bricks));
        self.uploads.take_if(|uploads| !uploads.are_of(tables, optics, colors.as_ref()));
    }

    /// What is wanted, with its tables uploaded.
    pub fn filled<'a, 'o>(&'a mut self, device: &Device, wanted: Wanted<'a>, optics: &'o Optics<'o>) -> Drawn<'a, 'o> {
        let Wanted { volume, tables, colors, sources, plan, bricks, .. } = wanted;
        let uploads = self.uploads.get_or_insert_with(|| Uploads::new(device, &tables, optics, colors));
        let resident = self.resident.get_or_insert_with(|| Resident::new(device, sources, plan.clone(), bricks));
        resident.plan = plan;
        Drawn { volume, resident, optics, uploads }
    }
}
