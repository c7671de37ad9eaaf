//! `pellucid convert`.

use std::path::{Path, PathBuf};

use pellucid::io::{Format, WriteOptions, write};

use super::failure::Failure;
use super::input::{Input, RawFlags};
use super::report::Report;
use super::{interrupt, output};

#[derive(clap::Args)]
pub struct ConvertArgs {
    /// A volume file, or sample:NAME
    input: Input,
    /// The volume file to write: .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .raw
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Deflate the values, 1 (fast) to 9 (small) [default: plain values]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u8).range(1..=9))]
    compress: Option<u8>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    raw: RawFlags,
}

pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let report = Report { quiet: args.quiet };
    interrupt::listen();
    check_output(&args.output)?;
    let base = args.input.open(&args.raw)?;
    let (volumes, warnings) = base.load(&base.scene)?;
    let [volume] = volumes.as_slice() else {
        return Err(Failure::input(format_args!("convert takes one volume, the scene lists {}", volumes.len())));
    };
    warnings.iter().for_each(|warning| report.warn(warning));
    let options = WriteOptions { compression: args.compress, ..WriteOptions::default() };
    let lost = write(&args.output, volume, &options)?;
    lost.iter().for_each(|warning| report.warn(warning));
    report.say(format_args!("wrote {}", args.output.display()));
    Ok(())
}

/// Refuses before long work a volume file that could not be written after it.
pub fn check_output(path: &Path) -> Result<(), Failure> {
    if Format::from_extension(path).is_none() {
        let problem = format_args!("{}: the extension names no volume format", path.display());
        return Err(Failure::input(problem).hint("known are .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz and .raw"));
    }
    output::writable(path)
}
