//! Which graphics processors there are, and which one to take.

use std::fmt;

use wgpu::{Backends, DeviceType, Instance, InstanceDescriptor};

use super::{Capabilities, Ceiling};
use crate::GpuError;

/// Which adapter to draw with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The best that is real hardware: dedicated before integrated before virtual.
    #[default]
    Hardware,
    /// The best there is, a driver that runs on the processor if there is no hardware.
    Any,
    /// A driver that runs on the processor.
    Software,
    /// The first whose description has this text in it, whatever the case.
    Named(String),
}

/// What an adapter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// Its name.
    pub name: String,
    /// "dedicated", "integrated", "virtual", "software" or "other".
    pub kind: &'static str,
    /// The interface it is reached by: "vulkan", "metal", "dx12", "gl".
    pub api: String,
    /// Its driver, with version, as far as it says.
    pub driver: String,
}

impl AdapterSummary {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let kind = match info.device_type {
            DeviceType::DiscreteGpu => "dedicated",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "software",
            DeviceType::Other => "other",
        };
        let driver = format!("{} {}", info.driver, info.driver_info);
        Self { name: info.name, kind, api: info.backend.to_string(), driver: driver.trim().to_owned() }
    }

    /// Whether it runs on the processor.
    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.kind, self.api)?;
        if !self.driver.is_empty() {
            write!(f, ", {}", self.driver)?;
        }
        f.write_str(")")
    }
}

/// All adapters with what they can do, the best first.
pub fn adapters() -> Vec<(AdapterSummary, Capabilities)> {
    let capabilities = |adapter: &_| Capabilities::of(adapter, &Ceiling::default());
    found().into_iter().map(|(adapter, summary)| (summary, capabilities(&adapter))).collect()
}

fn found() -> Vec<(wgpu::Adapter, AdapterSummary)> {
    let mut descriptor = InstanceDescriptor::new_without_display_handle();
    descriptor.backends = Backends::PRIMARY;
    let of = |descriptor| {
        let instance = Instance::new(descriptor);
        pollster::block_on(instance.enumerate_adapters(Backends::all()))
    };
    let mut adapters: Vec<_> = of(descriptor).into_iter().map(|a| (AdapterSummary::of(&a), a)).collect();
    adapters.sort_by_key(|(summary, _)| {
        ["dedicated", "integrated", "virtual", "other", "software"].iter().position(|kind| *kind == summary.kind)
    });
    adapters.into_iter().map(|(summary, adapter)| (adapter, summary)).collect()
}

/// The adapter of a choice.
pub(crate) fn choose(choice: &AdapterChoice) -> Result<(wgpu::Adapter, AdapterSummary), GpuError> {
    let found = found();
    let listed: Vec<String> = found.iter().map(|(_, summary)| summary.to_string()).collect();
    let fits = |summary: &AdapterSummary| match choice {
        AdapterChoice::Hardware => !summary.is_software(),
        AdapterChoice::Any => true,
        AdapterChoice::Software => summary.is_software(),
        AdapterChoice::Named(text) => summary.to_string().to_lowercase().contains(&text.to_lowercase()),
    };
    found.into_iter().find(|(_, summary)| fits(summary)).ok_or_else(|| GpuError::Adapter {
        wanted: match choice {
            AdapterChoice::Hardware => "that is hardware".to_owned(),
            AdapterChoice::Any => {
                "at all (Debian: mesa-vulkan-drivers brings one that runs on the processor)".to_owned()
            }
            AdapterChoice::Software => "that runs on the processor (Debian: mesa-vulkan-drivers)".to_owned(),
            AdapterChoice::Named(text) => format!("called '{text}'"),
        },
        found: if listed.is_empty() { "none".to_owned() } else { listed.join("; ") },
    })
}
