//! The graphics processor: which one, what it can do, and what goes wrong on it.

mod adapter;
mod capabilities;

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::naga::Module;
use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, COPY_BUFFER_ALIGNMENT, DeviceDescriptor, DeviceLostReason,
    ExperimentalFeatures, MemoryHints, PollType, SubmissionIndex, Trace,
};

pub use adapter::{AdapterChoice, AdapterSummary, adapters};
pub use capabilities::Capabilities;

use crate::GpuError;
use crate::shaders::{Constants, Linker, Variant};

/// An open device. Errors that the driver reports late are kept and come out of [`Device::check`].
pub struct Device {
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// Which adapter it is.
    pub adapter: AdapterSummary,
    /// What it can do.
    pub capabilities: Capabilities,
    trouble: Arc<Mutex<Option<GpuError>>>,
    linker: Mutex<Linker>,
}

impl Device {
    /// Opens an adapter, with the limits lowered to `ceiling` where that has any.
    ///
    /// # Errors
    /// [`GpuError::Adapter`] if there is none of the kind, [`GpuError::Device`] if it does not open.
    pub fn open(choice: &AdapterChoice, ceiling: &Ceiling) -> Result<Self, GpuError> {
        let (adapter, summary) = adapter::choose(choice)?;
        let capabilities = Capabilities::of(&adapter, ceiling);
        let descriptor = DeviceDescriptor {
            label: Some("pellucid"),
            required_features: capabilities.features,
            required_limits: capabilities.limits.clone(),
            experimental_features: ExperimentalFeatures::disabled(),
            memory_hints: MemoryHints::Performance,
            trace: Trace::Off,
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::Device { adapter: summary.to_string(), reason: error.to_string() })?;
        let trouble = Arc::new(Mutex::new(None));
        let place = trouble.clone();
        device.on_uncaptured_error(Arc::new(move |error| note(&place, typed(error))));
        let place = trouble.clone();
        device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            let expected = reason == DeviceLostReason::Destroyed && message.contains("dropped");
            if !expected {
                note(&place, GpuError::Lost { reason: message });
            }
        });
        Ok(Self { device, queue, adapter: summary, capabilities, trouble, linker: Mutex::default() })
    }

    /// Waits for everything submitted so far.
    ///
    /// # Errors
    /// As [`Device::check`].
    pub fn wait(&self) -> Result<(), GpuError> {
        self.poll(PollType::wait_indefinitely())
    }

    /// Waits for a submission and those before it.
    pub(crate) fn wait_for(&self, submission: SubmissionIndex) -> Result<(), GpuError> {
        self.poll(PollType::Wait { submission_index: Some(submission), timeout: None })
    }

    fn poll(&self, what: PollType) -> Result<(), GpuError> {
        if let Err(error) = self.device.poll(what) {
            self.note(GpuError::Lost { reason: error.to_string() });
        }
        self.check()
    }

    /// Where its shaders find what is the same for all of their invocations.
    pub(crate) fn constants(&self) -> Constants {
        if self.adapter.is_software() { Constants::Stored } else { Constants::Uniform }
    }

    /// The shader of a variant, or of those of several volumes.
    ///
    /// # Errors
    /// As [`Linker::link`].
    pub(crate) fn link(&self, layers: &[Variant]) -> Result<Module, GpuError> {
        let mut linker = self.linker.lock().unwrap_or_else(|left| {
            // What a panic left half made is not known: it is made again.
            self.linker.clear_poison();
            let mut linker = left.into_inner();
            *linker = Linker::default();
            linker
        });
        linker.link(layers, self.constants())
    }

    /// A buffer of constants.
    pub(crate) fn constant_buffer(&self, label: &str, contents: &[u8]) -> Buffer {
        let usage = match self.constants() {
            Constants::Uniform => BufferUsages::UNIFORM,
            Constants::Stored => BufferUsages::STORAGE,
        };
        self.buffer(label, contents, usage)
    }

    /// A buffer with something in it. Where there is no memory it is one without use, and
    /// [`Device::check`] says so; the helper of wgpu would panic.
    pub(crate) fn buffer(&self, label: &str, contents: &[u8], usage: BufferUsages) -> Buffer {
        let size = (contents.len() as u64).next_multiple_of(COPY_BUFFER_ALIGNMENT).max(COPY_BUFFER_ALIGNMENT);
        let buffer =
            self.device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: true });
        if let Ok(mut view) = buffer.get_mapped_range_mut(..) {
            view.slice(..contents.len()).copy_from_slice(contents);
        }
        buffer.unmap();
        buffer
    }

    /// Keeps an error until the next look.
    pub(crate) fn note(&self, error: GpuError) {
        note(&self.trouble, error);
    }

    /// The first thing that went wrong since the last look, if anything did.
    ///
    /// # Errors
    /// [`GpuError::Lost`] (which stays), [`GpuError::Memory`] or [`GpuError::Rejected`].
    pub fn check(&self) -> Result<(), GpuError> {
        let went_wrong = || self.trouble.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if went_wrong() {
            // A device that is gone rejects commands before it is said to be gone.
            let _ = self.device.poll(PollType::Poll);
        }
        let mut trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        match trouble.clone() {
            None => Ok(()),
            Some(lost @ GpuError::Lost { .. }) => Err(lost),
            Some(other) => {
                *trouble = None;
                Err(other)
            }
        }
    }
}

/// Limits below what an adapter has, to be careful with memory or to test with little of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ceiling {
    /// Most voxels per axis of a texture.
    pub texture_side: Option<u32>,
    /// Most bytes of volumes, tables and targets at the same time.
    pub memory: Option<u64>,
    /// No limit above those that WebGPU guarantees.
    pub guaranteed: bool,
}

/// Keeps the first error; a lost device outranks what follows from it.
fn note(place: &Mutex<Option<GpuError>>, error: GpuError) {
    let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
    if place.is_none() || matches!(error, GpuError::Lost { .. }) {
        *place = Some(error);
    }
}

fn typed(error: wgpu::Error) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { source } => GpuError::Memory { reason: source.to_string() },
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
            GpuError::Rejected { reason: description }
        }
    }
}
