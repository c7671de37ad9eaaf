//! Spoilt texts: scenes, tables of phase functions and volume properties, in bounded memory and time.

#[path = "../../pellucid-io/tests/common/ledger.rs"]
mod ledger;
#[path = "../../pellucid-io/tests/common/mutate.rs"]
mod mutate;

use std::path::PathBuf;

use ledger::Ledger;
use mutate::{Random, Seed, mutate, session};
use pellucid::load_optics;
use pellucid::optics::{Phase, PhaseEntries, PhaseTable, TableAngles, TransferFunction, VolumeProperty};
use pellucid::scene::{Format, Scene};

#[global_allocator]
static LEDGER: Ledger = Ledger;

/// Memory for a small text and what it says.
const MOST: usize = 4 << 20;

fn spoil(seed: &Seed, seeds: &[Seed], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.bytes.clone();
    mutate(&mut bytes, seeds, random);
    bytes
}

fn text(bytes: &[u8]) -> Result<&str, String> {
    str::from_utf8(bytes).map_err(|error| error.to_string())
}

/// The scenes of the gallery, as both kinds of text.
fn scenes() -> Vec<Seed> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    assert!(!paths.is_empty());
    let both = |path: PathBuf| {
        let bytes = std::fs::read(&path).unwrap();
        let scene = Scene::parse(str::from_utf8(&bytes).unwrap(), Format::Toml).unwrap();
        let json = scene.to_text(Format::Json).unwrap().into_bytes();
        [Seed { path: path.with_extension("json"), bytes: json }, Seed { path, bytes }]
    };
    paths.into_iter().flat_map(both).collect()
}

#[test]
fn scene_documents() {
    let seeds = scenes();
    let folder = tempfile::tempdir().unwrap();
    session(
        6_000,
        &seeds,
        MOST,
        |seed, random| spoil(seed, &seeds, random),
        |seed, bytes| {
            let format = Format::of(&seed.path).unwrap();
            let mut scene = Scene::parse(text(bytes)?, format).map_err(|error| error.to_string())?;
            // What is accepted can be written, and is read as the same.
            let again = scene.to_text(format).unwrap();
            assert_eq!(Scene::parse(&again, format).unwrap(), scene);
            // The folder is empty: whatever file the scene names is not there, or not its own to name.
            load_optics(&mut scene, folder.path()).map_err(|error| error.to_string())
        },
    );
}

#[test]
fn tables_of_phase_functions() {
    let seeds: Vec<Seed> = [
        "theta,value\n0, 4\n90;2 # half\n\n180\t1\n",
        "# from a program\n-1 1 2 3\n0.5 4 5 6\n1 7 8 9\n",
        "0 1e3\n10 1e2\n20 1e1\n40 1\n80 1e-1\n160 1e-2\n180 1e-3\n",
    ]
    .into_iter()
    .map(|text| Seed { path: "table.csv".into(), bytes: text.into() })
    .collect();
    session(
        20_000,
        &seeds,
        MOST,
        |seed, random| spoil(seed, &seeds, random),
        |_, bytes| {
            let entries = PhaseEntries::from_text(text(bytes)?).map_err(|error| error.to_string())?;
            let table = PhaseTable::of_file(TableAngles::Theta, "table.csv").unwrap();
            let mut phase = Phase::Table(table);
            phase.fill(&entries).map_err(|error| error.to_string())?;
            for k in 0..=8 {
                let value = phase.eval(0.0, k as f32 / 4.0 - 1.0);
                assert!(value.iter().all(|value| *value >= 0.0), "{value:?}");
            }
            Ok(())
        },
    );
}

#[test]
fn transfer_functions_and_volume_properties() {
    const SLICER: &str = r#"{ "@schema": "https://raw.githubusercontent.com/Slicer/Slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#",
        "volumeProperties": [{ "effectiveRange": [-1000, 5000], "isoSurfaceValues": [],
        "independentComponents": true, "interpolationType": "linear", "components": [{ "componentWeight": 1.0,
        "shade": true, "lighting": { "ambient": 0.1, "diffuse": 0.9, "specular": 0.2, "specularPower": 10 },
        "scalarOpacityUnitDistance": 0.89,
        "gradientOpacity": { "points": [{ "x": 0, "y": 1, "midpoint": 0.5, "sharpness": 0 }] },
        "scalarOpacity": { "points": [{ "x": -3024, "y": 0, "midpoint": 0.5, "sharpness": 0.3 },
            { "x": 143.5, "y": 0.2, "midpoint": 0.4, "sharpness": 0 }] },
        "rgbTransferFunction": { "points": [{ "x": -3024, "color": [0, 0, 0], "midpoint": 0.5, "sharpness": 0 },
            { "x": 640, "color": [1, 0.5, 0.25], "midpoint": 0.5, "sharpness": 0 }] } }] }] }"#;
    const OWN: &str = r##"{ "colors": [{ "value": 0, "color": "#102030" }, { "value": 9, "color": [1, 0.5, 0] }],
        "opacities": [{ "value": 0, "opacity": 0 }, { "value": 9, "opacity": 0.75 }], "unit_distance": 2 }"##;
    let seed = |name: &str, text: &str| Seed { path: name.into(), bytes: text.into() };
    let seeds = [seed("a.vp.json", SLICER), seed("a.json", OWN)];
    VolumeProperty::from_slicer(SLICER).unwrap();
    serde_json::from_str::<TransferFunction>(OWN).unwrap();
    session(
        20_000,
        &seeds,
        MOST,
        |seed, random| spoil(seed, &seeds, random),
        |seed, bytes| {
            if seed.path.ends_with("a.vp.json") {
                VolumeProperty::from_slicer(text(bytes)?).map_err(|error| error.to_string())?;
            } else {
                serde_json::from_str::<TransferFunction>(text(bytes)?).map_err(|error| error.to_string())?;
            }
            Ok(())
        },
    );
}
