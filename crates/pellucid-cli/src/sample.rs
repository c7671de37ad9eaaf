//! `pellucid sample`.

use std::path::PathBuf;

use pellucid::field::{VoxelType, closed_form};
use pellucid::io::{WriteOptions, write};
use pellucid::load;
use pellucid::scene::{SampleSource, Scene, Source};

use super::convert::check_output;
use super::failure::Failure;
use super::report::{Report, print};
use super::{interrupt, values};

#[derive(clap::Args)]
pub struct SampleArgs {
    /// Name of the field
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// List the built-in fields, with their own resolution and type
    #[arg(long)]
    list: bool,
    /// Voxels per axis [default: the field's own]
    #[arg(long, value_name = "XxYxZ", value_parser = values::dims)]
    dims: Option<[usize; 3]>,
    /// Type of the values [default: the field's own]
    #[arg(long = "type", value_name = "TYPE", value_parser = values::voxel_type())]
    voxel_type: Option<VoxelType>,
    /// The volume file to write: .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .raw
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &SampleArgs) -> Result<(), Failure> {
    let (Some(name), Some(output), false) = (&args.name, &args.output, args.list) else {
        return list();
    };
    let report = Report { quiet: args.quiet };
    interrupt::listen();
    check_output(output)?;
    let sample = SampleSource { name: name.clone(), dims: args.dims, voxel_type: args.voxel_type };
    let (volumes, _) = load(&Scene::of(Source::Sample(sample)), "")?;
    for volume in &volumes {
        let lost = write(output, volume, &WriteOptions::default())?;
        lost.iter().for_each(|warning| report.warn(warning));
    }
    report.say(format_args!("wrote {}", output.display()));
    Ok(())
}

fn list() -> Result<(), Failure> {
    let mut text = String::new();
    for field in closed_form::names().filter_map(closed_form::by_name) {
        let about = field.about();
        let [x, y, z] = about.dims;
        let own = format!("{x}x{y}x{z} {}", about.voxel_type);
        text.push_str(&format!("{:<16}{own:<18}{}\n", about.name, about.description));
    }
    print(&text)
}
