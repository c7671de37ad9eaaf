//! What is bound to a pipeline, by the names that its shaders have for it.

use std::sync::Arc;

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry,
    BindingResource, PipelineLayout, PipelineLayoutDescriptor,
};

use crate::shaders::Resource;
use crate::{Device, GpuError};

/// Something that can be bound, and what shaders call it.
pub type Named<'r> = (&'r str, BindingResource<'r>);

/// The groups of a pipeline: what changes with the pass, with the brick, and with the tables.
#[derive(Clone)]
pub struct Groups(Arc<[Group; 3]>);

/// Resources that are bound together.
pub struct Group {
    /// What is drawn with it.
    label: String,
    layout: BindGroupLayout,
    /// Numbers, volumes and names.
    slots: Vec<(u32, usize, String)>,
}

impl Groups {
    /// For shaders that use these resources, each told once for every stage that does.
    pub fn new(device: &Device, label: &str, resources: &[Resource]) -> Self {
        Self(Arc::new([0, 1, 2].map(|group| Group::new(device, label, resources, group))))
    }

    /// What changes with the pass.
    pub fn frame(&self) -> &Group {
        &self.0[0]
    }

    /// What changes with the brick.
    pub fn volume(&self) -> &Group {
        &self.0[1]
    }

    /// What changes with the tables.
    pub fn tables(&self) -> &Group {
        &self.0[2]
    }

    /// The layout of a pipeline; groups of nothing need not be set.
    pub fn pipeline_layout(&self, device: &Device) -> PipelineLayout {
        let layouts = self.0.each_ref().map(|group| (!group.slots.is_empty()).then_some(&group.layout));
        device.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some(&self.frame().label),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        })
    }
}

impl Group {
    fn new(device: &Device, label: &str, resources: &[Resource], group: u32) -> Self {
        let (mut slots, mut entries) = (Vec::new(), Vec::<BindGroupLayoutEntry>::new());
        for Resource { place: [_, binding], layer, name, ty, visibility } in
            resources.iter().filter(|resource| resource.place[0] == group)
        {
            match entries.iter_mut().find(|entry| entry.binding == *binding) {
                Some(entry) => entry.visibility |= *visibility,
                None => {
                    slots.push((*binding, *layer, name.clone()));
                    entries.push(BindGroupLayoutEntry {
                        binding: *binding,
                        visibility: *visibility,
                        ty: *ty,
                        count: None,
                    });
                }
            }
        }
        let descriptor = BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
        Self { label: label.to_owned(), layout: device.device.create_bind_group_layout(&descriptor), slots }
    }

    /// Binds what the shaders use of some resources. One that is not among them is an error of this program, which
    /// [`Device::check`] tells.
    pub fn bind(&self, device: &Device, resources: &[Named]) -> BindGroup {
        self.bind_layers(device, &[resources.to_vec()])
    }

    /// The same where each of several volumes has resources of its own.
    pub fn bind_layers(&self, device: &Device, layers: &[Vec<Named>]) -> BindGroup {
        let mut entries = Vec::with_capacity(self.slots.len());
        for (binding, layer, name) in &self.slots {
            match layers.get(*layer).and_then(|resources| resources.iter().find(|(found, _)| found == name)) {
                Some((_, resource)) => entries.push(BindGroupEntry { binding: *binding, resource: resource.clone() }),
                None => {
                    device.note(GpuError::Rejected { reason: format!("{} is given no {name}", self.label) });
                }
            }
        }
        let descriptor = BindGroupDescriptor { label: Some(&self.label), layout: &self.layout, entries: &entries };
        device.device.create_bind_group(&descriptor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipelines::Pipelines;
    use crate::shaders::{Pass, Variant};
    use crate::{AdapterChoice, Ceiling};

    #[test]
    fn what_is_not_bound_is_told_by_its_name() {
        let open = |choice| Device::open(&choice, &Ceiling::default());
        let device = open(AdapterChoice::Hardware).or_else(|_| open(AdapterChoice::Software)).unwrap();
        let groups = Pipelines::default().get(&device, Variant::of(Pass::Resolve)).unwrap().groups.clone();
        let planes = device.constant_buffer("planes", &[0; 64]);
        groups.frame().bind(&device, &[("planes", planes.as_entire_binding())]);
        let told = device.check();
        assert!(
            matches!(&told, Err(GpuError::Rejected { reason }) if reason.starts_with("Resolve is given no ")),
            "{told:?}"
        );
    }
}
