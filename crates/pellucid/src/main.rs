//! The `pellucid` command.

mod cli;
mod memory;

#[global_allocator]
static MEMORY: memory::Memory = memory::Memory;

fn main() -> std::process::ExitCode {
    memory::rehearse();
    cli::main()
}
