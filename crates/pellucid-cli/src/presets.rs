//! `pellucid presets`.

use pellucid::optics::{ColorMap, Preset, Scale, opacity_shape_names};
use pellucid::scene::Look;
use serde_json::{Value, json};

use super::failure::Failure;
use super::report::{print, print_json};

#[derive(clap::Args)]
pub struct PresetsArgs {
    /// Print this preset in full, as a file that render --transfer-function takes
    #[arg(conflicts_with_all = ["colormaps", "opacities"])]
    name: Option<String>,
    /// List the colour maps instead
    #[arg(long, conflicts_with = "opacities")]
    colormaps: bool,
    /// List the opacity shapes instead
    #[arg(long)]
    opacities: bool,
    /// List the looks instead, ready-made light for any data: 'render --look NAME'
    #[arg(long, conflicts_with_all = ["name", "colormaps", "opacities"])]
    looks: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &PresetsArgs) -> Result<(), Failure> {
    if let Some(name) = &args.name {
        let preset = Preset::by_name(name).map_err(Failure::input)?;
        return show(preset, args.json);
    }
    let names: Vec<String> = match (args.colormaps, args.opacities) {
        _ if args.looks && args.json => Look::ALL.map(|look| look.name().to_owned()).into(),
        _ if args.looks => Look::ALL.map(|look| format!("{:<16}{}", look.name(), look.title())).into(),
        (true, _) => ColorMap::names().map(str::to_owned).collect(),
        (_, true) => opacity_shape_names().collect(),
        _ if args.json => Preset::all().iter().map(|preset| preset.name.clone()).collect(),
        _ => Preset::all().iter().map(|preset| format!("{:<16}{}", preset.name, preset.title)).collect(),
    };
    if args.json { print_json(&json!(names)) } else { print(&(names.join("\n") + "\n")) }
}

fn show(preset: &Preset, as_json: bool) -> Result<(), Failure> {
    let document: Value = serde_json::to_value(preset).map_err(Failure::work)?;
    if as_json {
        return print_json(&document);
    }
    let unit = match &preset.scale {
        Scale::Absolute { unit } => format!("values in {unit}"),
        Scale::Relative => "values as parts of the window, 0 to 1".into(),
    };
    let text = toml::to_string(preset).map_err(Failure::work)?;
    print(&format!(
        "# To be changed at will; save it and give it to: render DATA --transfer-function FILE.toml\n# {unit}\n{text}"
    ))
}
