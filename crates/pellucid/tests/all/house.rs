//! What the house promises of itself: no two files of a crate import each other, directly or around, no type name
//! stands twice in a crate, and a crate uses only what ARCHITECTURE.md's table of rooms gives it.

mod imports;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use imports::{Crate, Module};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every crate of the workspace by its name.
fn crates() -> BTreeMap<String, Crate> {
    let folders = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    folders.map(|path| (name(&path), Crate::read(&path.join("src")))).collect()
}

fn list(items: &[impl ToString]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

#[test]
fn no_two_files_of_a_crate_import_each_other() {
    let crates = crates();
    let files: usize = crates.values().map(|own| own.files().count()).sum();
    let imports: usize = crates.values().flat_map(|own| own.imports().into_values()).map(|targets| targets.len()).sum();
    assert!(files > 250 && imports > 700, "only {imports} imports were found in {files} files: not all were read");

    let told = |(name, own): (&String, &Crate)| {
        let circles = own.circles();
        circles.iter().map(|circle| format!("{name}: {}\n{}", list(circle), own.tell(circle))).collect::<String>()
    };
    let circles: String = crates.iter().map(told).collect();
    let advice = "files import each other, directly or around: what they share belongs in a file that both import";
    assert!(circles.is_empty(), "{advice}\n{circles}");
}

#[test]
fn no_type_name_stands_twice_in_a_crate() {
    let mut found = String::new();
    for (own, source) in crates() {
        let types = source.types();
        assert!(!types.is_empty(), "no type was found in {own}");
        let twice = types.into_iter().filter(|(_, files)| files.len() > 1);
        found.extend(twice.map(|(name, files)| format!("{own}: {name} in {}\n", list(&files))));
    }
    assert!(
        found.is_empty(),
        "types of a crate share a name: call all but one of them by a more precise word\n{found}"
    );
}

/// Where techniques are told apart by name, beside their settings: what makes their renderers in each backend, and the
/// passes of paths. All else asks what they need.
const BY_NAME: [&str; 3] =
    ["pellucid-cpu/src/renderer.rs", "pellucid-gpu/src/renderer.rs", "pellucid/src/progressive/passes.rs"];

#[test]
fn techniques_are_told_apart_in_few_places() {
    let technique = fs::read_to_string(root().join("crates/pellucid-scene/src/technique/mod.rs")).unwrap();
    let variants = technique.split("pub enum Technique {").nth(1).unwrap().split("\n}").next().unwrap();
    let names: Vec<String> = variants
        .lines()
        .filter(|line| line.starts_with("    ") && !line.trim_start().starts_with("///"))
        .filter_map(|line| Some(format!("Technique::{}", line.trim().split_once('(')?.0)))
        .collect();
    assert!(names.len() >= 4, "{names:?}");
    let mut found = BTreeSet::new();
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(root().join("crates")).unwrap().to_string_lossy().replace('\\', "/");
            let is_source = name.contains("/src/")
                && name.ends_with(".rs")
                && !name.ends_with("tests.rs")
                && !name.starts_with("pellucid-scene/src/technique/");
            if is_source && names.iter().any(|name| fs::read_to_string(&path).unwrap().contains(name)) {
                found.insert(name);
            }
        }
    }
    let beside: Vec<_> = found.iter().filter(|name| !BY_NAME.contains(&name.as_str())).collect();
    assert!(beside.is_empty(), "{beside:?} match on techniques: ask `Technique::needs`, or say there what is needed");
    let gone: Vec<_> = BY_NAME.iter().filter(|name| !found.contains(**name)).collect();
    assert!(gone.is_empty(), "{gone:?} match on no technique any more: take them off the list");
}

/// The table of rooms: each crate, in order, and those it may use.
fn rooms() -> Vec<(String, Vec<String>)> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut rooms: Vec<(String, Vec<String>)> = Vec::new();
    for row in text.lines().filter(|line| line.starts_with("| `pellucid")) {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [name, .., uses] = cells[..] else { panic!("a row of the table of rooms has one cell: {row}") };
        let full = |short: &str| if short == "pellucid" { short.to_owned() } else { format!("pellucid-{short}") };
        let uses = match uses {
            "maths only" => Vec::new(),
            "all above" => rooms.iter().map(|(name, _)| name.clone()).collect(),
            listed => listed.split(", ").map(full).collect(),
        };
        let above: BTreeSet<&String> = rooms.iter().map(|(name, _)| name).collect();
        assert!(
            uses.iter().all(|used| above.contains(used)),
            "{name} uses what is not above it in the table: {uses:?}"
        );
        rooms.push((name.trim_matches('`').to_owned(), uses));
    }
    rooms
}

/// The workspace's crates among the dependencies in a manifest, those of tests left out.
fn dependencies(manifest: &str) -> Vec<String> {
    let mut dependencies = Vec::new();
    let mut counts = false;
    for line in manifest.lines() {
        if let Some(section) = line.strip_prefix('[') {
            counts = section.contains("dependencies") && !section.contains("dev-dependencies");
        } else if counts && line.starts_with("pellucid") {
            dependencies.extend(line.split(['.', ' ', '=']).next().map(str::to_owned));
        }
    }
    dependencies
}

#[test]
fn a_crate_uses_only_what_the_table_of_rooms_gives_it() {
    let rooms = rooms();
    let named: BTreeSet<String> = rooms.iter().map(|(name, _)| name.clone()).collect();
    assert_eq!(named, crates().into_keys().collect(), "the table of rooms, and the crates there are");
    let mut found = 0;
    for (name, uses) in rooms {
        let manifest = fs::read_to_string(root().join("crates").join(&name).join("Cargo.toml")).unwrap();
        let dependencies = dependencies(&manifest);
        found += dependencies.len();
        let strange: Vec<&String> = dependencies.iter().filter(|used| !uses.contains(used)).collect();
        assert!(strange.is_empty(), "{name} depends on {strange:?}; the table of rooms gives it {uses:?}");
    }
    assert!(found > 15, "only {found} dependencies were found: the manifests were not read");
}

#[test]
fn circles_and_names_that_are_made_up_are_found() {
    let own = Crate::of([
        ("lib.rs", "mod a; mod b; mod c; mod far; pub use c::Third; use a::{One, Two};"),
        // Nested braces, a renamed module by which a function is called, and a re-export of the parent's.
        (
            "a.rs",
            "use std::{fmt, io::{self, Read}}; use crate::{b as other, far::{deep::{self, Deep}}}; fn f() { other::g() }",
        ),
        ("b.rs", "/* use crate::a; */ fn g() -> &'static str { crate::Third::new(); \"use crate::far;\" }"),
        ("c.rs", "use super::far; #[cfg(test)] mod tests { use crate::b; } struct Third<'a>(&'a str);"),
        ("far/mod.rs", "mod deep; mod near; pub use self::deep::Deep;"),
        ("far/deep.rs", "use super::near::Near; pub struct Deep; macro_rules! m { () => { $crate::a::One } }"),
        ("far/near.rs", "use super::Deep; struct Near; enum Deep {} impl T for Near { type Third = u8; }"),
        ("far/tests.rs", "use crate::c;"),
    ]);
    let circles = own.circles();
    assert_eq!(circles.iter().map(|circle| list(circle)).collect::<Vec<_>>(), ["a, far/deep, far/near"]);
    let told = own.tell(circles.first().unwrap());
    for line in
        ["a imports far/deep (crate::far::deep)", "far/deep imports a (crate::a::One)", "far/near imports far/deep"]
    {
        assert!(told.contains(line), "{line} is not in\n{told}");
    }
    // Neither comments nor texts nor tests import.
    let of = |file| list(&own.imports()[&Module::of(file).unwrap()].keys().collect::<Vec<_>>());
    assert_eq!([of("a.rs"), of("b.rs"), of("c.rs")], ["b, far/deep", "c", "far"]);
    // A type of a trait is none of the file's.
    let twice: Vec<_> = own.types().into_iter().filter(|(_, files)| files.len() > 1).collect();
    assert_eq!(twice, [("Deep".to_owned(), vec!["far/deep".to_owned(), "far/near".to_owned()])]);
}
