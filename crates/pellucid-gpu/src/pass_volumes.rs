//! The volumes that a pass is given: one, whole or in bricks, or several whole ones together.

use pellucid_scene::{Control, StageVolume};
use wgpu::BindGroup;

use crate::bindings::Bindings;
use crate::bounds::BoundsBuffer;
use crate::bricks::Brick;
use crate::dispatch::Bound;
use crate::groups::{Groups, Named};
use crate::lists::Lists;
use crate::on_device::Drawn;
use crate::pipelines::Pipeline;
use crate::resident::Resident;
use crate::shaders::Variant;
use crate::{Device, GpuError};

/// A volume on the device, and what shaders are given of it.
pub struct PassVolume<'a> {
    /// The volume with its optics.
    pub volume: &'a StageVolume,
    /// Its voxels.
    pub resident: &'a mut Resident,
    /// What shaders are given besides.
    pub bindings: Bindings<'a>,
}

/// Volumes that are drawn together.
pub struct PassVolumes<'a> {
    device: &'a Device,
    /// In the order in which they are merged.
    each: Vec<PassVolume<'a>>,
    /// Their lists, if they are several.
    lists: Option<Lists>,
}

/// What is drawn together: all volumes, or each by itself where what they make of rays is merged at the end.
pub fn parts<'a, 'o>(drawn: Vec<Drawn<'a, 'o>>) -> Vec<Vec<Drawn<'a, 'o>>> {
    match drawn.iter().any(|volume| volume.optics.pass.is_apart()) {
        true => drawn.into_iter().map(|volume| vec![volume]).collect(),
        false => vec![drawn],
    }
}

impl<'a> PassVolumes<'a> {
    /// Volumes with the bindings that a technique makes for each: it is told where the volume's lists lie, for
    /// `Frame::lists`.
    pub fn new<'o>(
        device: &'a Device,
        drawn: Vec<Drawn<'a, 'o>>,
        mut bindings: impl FnMut(&Drawn<'a, 'o>, [u32; 4]) -> Bindings<'a>,
    ) -> Self {
        let mut each: Vec<PassVolume> = Vec::with_capacity(drawn.len());
        for drawn in drawn {
            let [entries, planes, lights] = Lists::places(each.iter().map(|volume| volume.bindings.lists()));
            let bindings = bindings(&drawn, [entries, planes, lights, 0]);
            each.push(PassVolume { volume: drawn.volume, resident: drawn.resident, bindings });
        }
        let lists: Vec<_> = each.iter().map(|volume| volume.bindings.lists()).collect();
        let lists = (each.len() > 1).then(|| Lists::joined(device, &lists));
        Self { device, each, lists }
    }

    /// The first of the volumes: what all have in common is told of it.
    pub fn first(&self) -> &PassVolume<'a> {
        &self.each[0]
    }

    /// All of them.
    pub fn each(&self) -> &[PassVolume<'a>] {
        &self.each
    }

    /// What is compiled into shaders that look at the volumes.
    pub fn variants(&self) -> impl Iterator<Item = Variant> {
        self.each.iter().map(|volume| volume.bindings.variant)
    }

    /// The voxels of all.
    pub fn residents(&mut self) -> impl Iterator<Item = &mut Resident> {
        self.each.iter_mut().map(|volume| &mut *volume.resident)
    }

    /// Whether all voxels are on the device.
    pub fn are_complete(&self) -> bool {
        self.each.iter().all(|volume| volume.resident.is_complete())
    }

    /// The textures of a brick or, of several volumes, of all of them: bound.
    ///
    /// # Errors
    /// As [`Resident::textures`].
    pub fn volume_group(&mut self, groups: &Groups, brick: &Brick, control: &Control) -> Result<BindGroup, GpuError> {
        let mut views = Vec::with_capacity(self.each.len());
        for (number, PassVolume { resident, .. }) in self.each.iter_mut().enumerate() {
            // Of several volumes each is whole.
            let brick = if number == 0 { *brick } else { resident.bricks[0] };
            views.push(resident.textures(self.device, &brick, control)?);
        }
        let of = self.each.iter().zip(&views).map(|(volume, views)| volume.bindings.of_volume(views));
        Ok(groups.volume().bind_layers(self.device, &of.collect::<Vec<_>>()))
    }

    /// What a pipeline is told of the frame and its passes, with what is the pass's own.
    pub fn frame_group(&self, groups: &Groups, passes: &BoundsBuffer, own: &[Named]) -> BindGroup {
        self.frame_group_of_each(groups, passes, own, &[])
    }

    /// The same with something of each volume's own.
    fn frame_group_of_each(&self, groups: &Groups, passes: &BoundsBuffer, own: &[Named], each: &[Named]) -> BindGroup {
        let mut layers: Vec<_> = self.each.iter().map(|volume| volume.bindings.of_frame(passes)).collect();
        layers.iter_mut().zip(each).for_each(|(layer, own)| layer.push(own.clone()));
        // What is found first is bound.
        layers[0].splice(0..0, self.lists.iter().flat_map(Lists::named).chain(own.iter().cloned()));
        groups.frame().bind_layers(self.device, &layers)
    }

    /// The tables that a pipeline reads.
    pub fn table_group(&self, groups: &Groups) -> BindGroup {
        match &self.lists {
            Some(lists) => groups.tables().bind(self.device, &lists.named().collect::<Vec<_>>()),
            None => self.first().bindings.table_group(groups),
        }
    }

    /// A pipeline with all that it is told of whole volumes: of the frame and its passes, with what is the pass's own and
    /// something of each volume's, of voxels and of tables.
    ///
    /// # Errors
    /// As [`PassVolumes::volume_group`].
    pub fn bound<'p>(
        &mut self,
        Pipeline { pipeline, groups, .. }: &'p Pipeline,
        passes: &BoundsBuffer,
        (own, each): (&[Named], &[Named]),
        control: &Control,
    ) -> Result<Bound<'p>, GpuError> {
        let brick = self.first().resident.bricks[0];
        let volume = self.volume_group(groups, &brick, control)?;
        let frame = self.frame_group_of_each(groups, passes, own, each);
        Ok(Bound { pipeline, groups: [frame, volume, self.table_group(groups)] })
    }

    /// Most looks at the blocks in a pass.
    pub fn most_looks(&self) -> u32 {
        self.each.iter().map(|volume| volume.bindings.most_looks).min().unwrap_or(u32::MAX)
    }

    /// Most rows of the picture at once.
    pub fn most_rows(&self) -> u32 {
        self.each.iter().map(|volume| volume.resident.plan.rows).min().unwrap_or(1)
    }
}
