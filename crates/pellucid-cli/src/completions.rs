//! `pellucid completions`.

use clap::CommandFactory;
use clap_complete::Shell;

use super::failure::Failure;
use super::report::print_as_is;

#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell; for bash: pellucid completions bash > ~/.local/share/bash-completion/completions/pellucid
    shell: Shell,
}

pub fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut super::Cli::command(), "pellucid", &mut script);
    print_as_is(&script)
}
