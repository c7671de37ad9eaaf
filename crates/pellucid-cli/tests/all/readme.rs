//! What the README and the scene guide print works as printed.

use std::path::{Path, PathBuf};

use crate::common::{command, picture, run_in, succeed_in, text};
use pellucid::field::{Grid, Volume, Voxels};
use pellucid::io::{WriteOptions, write};
use pellucid::scene::{Format, Scene};
use tempfile::{TempDir, tempdir};

fn document(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// The blocks of a language in a Markdown text.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let open = format!("```{language}\n");
    let parts = text.split(&open).skip(1);
    parts.map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

/// Commands that a test cannot run, and why.
const NOT_RUN: [(&str, &str); 3] = [
    ("./test", "it runs this test"),
    ("./test --quick", "it runs this test"),
    ("cargo install --path crates/pellucid-cli", "it builds everything once more, outside of the checkout"),
];

/// Words of a line of a shell, of which the README quotes none with blanks in it.
fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(|word| word.replace(['"', '\''], "")).collect()
}

/// A folder with small files under the names that the README gives to a reader's own.
fn with_files() -> TempDir {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let volume = |dims: [usize; 3], value: &dyn Fn(usize) -> i16| {
        let count = dims.iter().product();
        let values: Vec<i16> = (0..count).map(value).collect();
        Volume::new(Grid::new(dims).unwrap(), Voxels::from(values)).unwrap()
    };
    let middle = |k: usize| [k % 12, k / 12 % 12, k / 144].iter().all(|i| (3..9).contains(i));
    let scan = volume([12; 3], &|k| if middle(k) { 700 } else { -1000 });
    write(at("scan.nii.gz"), &scan, &WriteOptions::default()).unwrap();
    let bytes: Vec<u8> = (0..12 * 12 * 12).map(|k| (k % 256) as u8).collect();
    let engine = Volume::new(Grid::new([12; 3]).unwrap(), Voxels::from(bytes)).unwrap();
    write(at("engine.nrrd"), &engine, &WriteOptions::default()).unwrap();
    let two: Vec<u8> = (0..2 * 12 * 12 * 12).map(|k| (k % 251) as u8).collect();
    let cells = Volume::with_components(Grid::new([12; 3]).unwrap(), Voxels::from(two), 2).unwrap();
    write(at("cells.nrrd"), &cells, &WriteOptions::default()).unwrap();
    let scene = "volumes = [{ source.sample = { name = \"head\", dims = [20, 24, 24] } }]\n\
        image = { width = 40, height = 30 }\n";
    std::fs::write(at("scene.toml"), scene).unwrap();
    // 512 x 512 x 300 values of two bytes, none of them on the disk.
    let stack = std::fs::File::create(at("stack.raw")).unwrap();
    stack.set_len(8 * 8 * 6 * 2).unwrap();
    folder
}

/// A command of the README in small: built-in fields and headerless files of few voxels, pictures of few pixels.
fn small(mut words: Vec<String>) -> Vec<String> {
    for word in &mut words {
        match word.as_str() {
            "sample:head" => *word = "sample:head@20x24x24".to_owned(),
            "512x512x300" => *word = "8x8x6".to_owned(),
            _ => {}
        }
    }
    let draws =
        ["render", "bake", "bench", "compare"].contains(&words[0].as_str()) && !words.contains(&"--help".to_owned());
    if draws {
        words.extend(["--size", "40x30"].map(str::to_owned));
    }
    words
}

#[test]
fn every_command_of_the_readme_runs() {
    let (mut run, mut left) = (0, 0);
    let folder = with_files();
    for line in blocks(&document("README.md"), "sh").iter().flat_map(|block| block.lines()) {
        let line = line.split(" #").next().unwrap();
        for part in line.split(';').map(str::trim).filter(|part| !part.is_empty()) {
            if NOT_RUN.iter().any(|(known, _)| *known == part) {
                left += 1;
                continue;
            }
            let words = words(part);
            let words = match words[0].as_str() {
                "pellucid" => words[1..].to_vec(),
                "cargo" => {
                    assert!(part.starts_with("cargo run --release -- "), "{part}");
                    words[4..].to_vec()
                }
                other => panic!("the README has a command of {other} that this test cannot run: {part}"),
            };
            // What a shell does with the output.
            let (words, redirected) = match words.iter().position(|word| word == ">") {
                Some(at) => (words[..at].to_vec(), words.get(at + 1).cloned()),
                None => (words, None),
            };
            let words = small(words);
            let output = run_in(folder.path(), &words.iter().map(String::as_str).collect::<Vec<_>>());
            assert_eq!(output.status.code(), Some(0), "{part}: {}", text(&output.stderr));
            if let Some(name) = redirected {
                std::fs::write(folder.path().join(name), &output.stdout).unwrap();
            }
            let told = text(&output.stderr);
            assert!(!told.contains("has no effect"), "{part}: {told}");
            let written = words.iter().position(|word| word == "-o").map(|at| folder.path().join(&words[at + 1]));
            assert!(written.is_none_or(|path: PathBuf| path.is_file()), "{part}");
            run += 1;
        }
    }
    assert!(run >= 18 && left <= 3, "{run} commands run, {left} left out");
}

/// What the program says in the README it says.
#[test]
fn the_console_of_the_readme_is_what_is_said() {
    let folder = with_files();
    let console = blocks(&document("README.md"), "console");
    let mut lines = console[0].lines();
    let line = words(lines.next().unwrap().strip_prefix("$ pellucid ").unwrap());
    let line: Vec<&str> = line.iter().map(String::as_str).chain(["--size", "40x30"]).collect();
    let said = text(&run_in(folder.path(), &line).stderr);
    let said: Vec<&str> = said.lines().collect();
    // Numbers are those of the data; what is said of them is the program's.
    let topic = |line: &str| line.split_inclusive(':').take(2).collect::<String>();
    let mut count = 0;
    for line in lines {
        assert!(said.iter().any(|told| topic(told) == topic(line)), "{line} is not in {said:#?}");
        count += 1;
    }
    assert!(count >= 3, "{count}");
}

#[test]
fn every_scene_of_the_guide_draws_without_a_warning() {
    let guide = document("docs/scene.md");
    let folder = tempdir().unwrap();
    let colors: Vec<u8> = (0..3 * 8 * 8 * 8).map(|k| (k % 251) as u8).collect();
    let slide = Volume::with_components(Grid::new([8; 3]).unwrap(), colors, 3).unwrap();
    write(folder.path().join("slide.nrrd"), &slide, &WriteOptions::default()).unwrap();
    let examples = blocks(&guide, "toml");
    assert!(examples.len() >= 10, "{}", examples.len());
    for example in &examples {
        let scene = Scene::parse(example, Format::Toml).unwrap_or_else(|error| panic!("{error} in\n{example}"));
        if example.contains("stack.raw") {
            continue;
        }
        std::fs::write(folder.path().join("scene.toml"), example).unwrap();
        let args = ["render", "scene.toml", "-o", "a.png", "--size", "24x24", "--backend", "cpu"];
        let output = run_in(folder.path(), &args);
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(0) && !said.contains("warning"), "{said} in\n{example}");
        assert!(!scene.volumes.is_empty());
        assert_eq!(picture(&folder.path().join("a.png")).width, 24);
    }
}

/// Nobody finds a book by the number of its section alone.
#[test]
fn the_schema_cites_nothing_that_is_not_named() {
    let schema = succeed_in(tempdir().unwrap().path(), &["schema"]);
    for part in ["(K-", "(MOD-", "chapter", "(section", "Eq.", "the book", "(3.", "(4.", "(6.", "(9.", "he paper"] {
        let around = schema.find(part).map(|at| &schema[at.saturating_sub(80)..at + 20]);
        assert!(around.is_none(), "'{part}' in: {}", around.unwrap_or_default());
    }
    assert!(document("docs/scene.md").contains("Real-Time\nVolume Graphics"));
}

/// The driver of a graphics adapter has nothing to say to somebody who wants a picture.
#[test]
fn drivers_are_silent() {
    let folder = tempdir().unwrap();
    let args = ["render", "sample:ball@8x8x8", "--size", "8x8", "-o", "a.png", "-q", "--adapter", "software"];
    let output = command(&args).current_dir(folder.path()).env_remove("XDG_RUNTIME_DIR").output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
}
