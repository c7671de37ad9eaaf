//! A technique is added in the places that ARCHITECTURE.md names and nowhere else: a made-up one is added there to a copy of
//! the crates, and everything compiles.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

const SETTINGS: &str = include_str!("made_up/settings.rs");
const PROCESSOR: &str = include_str!("made_up/processor.rs");

/// Lines of files in `crates/`, and what is added behind each.
const ADDED: [(&str, &str, &str); 9] = [
    // The document.
    ("pellucid-scene/src/technique/mod.rs", "mod half_angle;", "mod made_up;"),
    ("pellucid-scene/src/technique/mod.rs", "pub use mode::{", "pub use made_up::MadeUp;"),
    ("pellucid-scene/src/technique/mod.rs", "    PathTrace(PathTrace),", "    /// One gray.\n    MadeUp(MadeUp),"),
    (
        "pellucid-scene/src/technique/mod.rs",
        "            Self::PathTrace(settings) => settings,",
        "            Self::MadeUp(settings) => settings,",
    ),
    (
        "pellucid-scene/src/technique/names.rs",
        "    (\"path-trace\", Technique::by_paths),",
        "    (\"made-up\", |technique| technique.plain()),",
    ),
    ("pellucid-scene/src/lib.rs", "mod technique;", "pub use technique::MadeUp;"),
    // The processor.
    ("pellucid-cpu/src/lib.rs", "mod lanes;", "mod made_up;"),
    ("pellucid-cpu/src/renderer.rs", "use crate::lanes::", "use crate::made_up;"),
    (
        "pellucid-cpu/src/renderer.rs",
        "    match &stage.technique {",
        "        Technique::MadeUp(settings) => {\n            drawing = Instant::now();\n            \
         tiles.draw(control, |tile| {\n                made_up::draw(settings, tile);\n                Ok(())\n            \
         })?;\n        }",
    ),
];

#[test]
fn a_made_up_technique_compiles_through_its_places() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let copy = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("made-up");
    for file in ["Cargo.lock", "README.md"] {
        write(&copy.join(file), &fs::read(root.join(file)).unwrap());
    }
    // Of another version, what is compiled here is not taken for the crates themselves.
    let manifest = fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let version = "version = \"0.1.0\"\nedition";
    assert!(manifest.contains(version));
    write(&copy.join("Cargo.toml"), manifest.replace(version, "version = \"0.1.1\"\nedition").as_bytes());
    let mut copied = Vec::new();
    for entry in fs::read_dir(root.join("crates")).unwrap().map(Result::unwrap) {
        for part in ["Cargo.toml", "src"] {
            list(&entry.path().join(part), &copy.join("crates").join(entry.file_name()).join(part), &mut copied);
        }
    }
    assert!(copied.len() > 300, "only {} files were copied", copied.len());
    let crates = copy.join("crates");
    write(&crates.join("pellucid-scene/src/technique/made_up.rs"), SETTINGS.as_bytes());
    write(&crates.join("pellucid-cpu/src/made_up.rs"), PROCESSOR.as_bytes());
    for file in copied {
        let name = file.strip_prefix(&crates).unwrap().to_str().unwrap().to_owned();
        let bytes = fs::read(root.join("crates").join(&name)).unwrap();
        let added: Vec<_> = ADDED.iter().filter(|(of, ..)| *of == name).collect();
        if added.is_empty() {
            write(&file, &bytes);
            continue;
        }
        let mut text = String::from_utf8(bytes).unwrap();
        for (_, line, more) in added {
            assert!(text.lines().any(|found| found.starts_with(line)), "{name} has no line {line:?}");
            let behind = |found: &str| match found.starts_with(line) {
                true => format!("{found}\n{more}\n"),
                false => format!("{found}\n"),
            };
            text = text.lines().map(behind).collect();
        }
        write(&file, text.as_bytes());
    }
    // What lints have compiled is there already.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let cargo = Command::new(env!("CARGO"))
        .args(["check", "--workspace", "--offline", "--quiet"])
        .current_dir(&copy)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap();
    assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
}

/// Lists the files of a folder, as they are called in a copy of it.
fn list(source: &Path, copy: &Path, copied: &mut Vec<PathBuf>) {
    if source.is_dir() {
        for entry in fs::read_dir(source).unwrap().map(Result::unwrap) {
            list(&entry.path(), &copy.join(entry.file_name()), copied);
        }
    } else if source.exists() {
        copied.push(copy.to_owned());
    }
}

/// Writes a file that is not yet like this: what has not changed is not compiled again.
fn write(path: &Path, bytes: &[u8]) {
    if fs::read(path).is_ok_and(|found| found == bytes) {
        return;
    }
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}
