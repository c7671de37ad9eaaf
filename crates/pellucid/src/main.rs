//! The `pellucid` command.

mod cli;
mod memory;

#[global_allocator]
static MEMORY: memory::Memory = memory::Memory;

fn main() -> std::process::ExitCode {
    memory::rehearse();
    quieten_drivers();
    cli::main()
}

/// Vulkan's layers look for a Wayland display and complain on standard error, twice a run and past every `--quiet`,
/// where the variable that says where one would be is not set. With it set to a place that is not there they find none
/// in silence.
#[cfg(target_os = "linux")]
fn quieten_drivers() {
    const PLACE: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(PLACE).is_none() {
        // SAFETY: nothing has started a thread yet, so that none can read the environment meanwhile.
        unsafe { std::env::set_var(PLACE, "/nonexistent") };
    }
}

#[cfg(not(target_os = "linux"))]
fn quieten_drivers() {}
