//! Ctrl-C.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::{command, files};
use tempfile::tempdir;

/// Far more work than the test waits for.
const LONG: [&str; 7] = ["sample:sines@16x16x16", "--size", "8000x8000", "--step", "0.01", "--no-skip", "--threads=2"];

/// Starts a command that takes long, interrupts it once it draws, and looks at what it leaves: its
/// exit code, its last word, and no file.
fn interrupt(args: &[&str], drawing: &str) {
    let folder = tempdir().unwrap();
    let all = [args, &LONG].concat();
    let mut child = command(&all).current_dir(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
    let mut remarks = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains(drawing) {
        assert_ne!(remarks.read_line(&mut said).unwrap(), 0, "it ended early: {said}");
    }
    std::thread::sleep(Duration::from_millis(300));
    let interrupted = Instant::now();
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if interrupted.elapsed() > Duration::from_secs(5) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("it did not stop");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    remarks.read_to_string(&mut said).unwrap();
    assert_eq!(status.code(), Some(130), "{said}");
    assert!(said.ends_with("pellucid: error: cancelled, no picture was written\n"), "{said}");
    assert_eq!(files(folder.path()), [""; 0]);
}

#[test]
fn an_interrupted_render_leaves_nothing_behind() {
    // The camera is the last thing chosen before the drawing begins.
    interrupt(&["render", "-o", "long.png"], "camera:");
}

#[test]
fn an_interrupted_mean_of_frames_leaves_nothing_behind() {
    interrupt(&["render", "--accumulate", "9", "-o", "long.png"], "camera:");
}

#[test]
fn an_interrupted_measurement_leaves_nothing_behind() {
    interrupt(&["bench", "--json", "long.json"], "camera:");
}

/// Paths without an end, of little work each.
const PATHS: &str = "[[volumes]]\nsource.sample = { name = \"ball\", dims = [16, 16, 16] }\n\
                     [technique.path_trace]\nsamples = 1000000\ndenoise = true\n\
                     environment.constant = { color = \"white\" }\n";

fn signal(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Waits for a command to end, but not for ever: its exit code, and the rest of what it says.
fn outcome(mut child: Child, mut remarks: impl Read) -> (Option<i32>, String) {
    let asked = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if asked.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("it did not stop");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut said = String::new();
    remarks.read_to_string(&mut said).unwrap();
    (status.code(), said)
}

/// A path-traced picture that is interrupted is there, of a size that was asked for, and says of how many samples it
/// is: on both backends.
#[test]
fn an_interrupted_picture_of_paths_is_kept() {
    for backend in [&["--backend", "cpu"][..], &["--adapter", "software"]] {
        let folder = tempdir().unwrap();
        std::fs::write(folder.path().join("paths.toml"), PATHS).unwrap();
        // Nobody outside knows when the first pass is done: on a machine with much to do it takes long.
        let kept = [1, 4, 16, 60].into_iter().find_map(|seconds| {
            let args = [&["render", "paths.toml", "--size", "48x32", "-o", "paths.png", "--json"], backend].concat();
            let mut command = command(&args);
            command.current_dir(folder.path()).stderr(Stdio::piped()).stdout(Stdio::piped());
            let mut child = command.spawn().unwrap();
            let (remarks, mut out) = (child.stderr.take().unwrap(), child.stdout.take().unwrap());
            std::thread::sleep(Duration::from_secs(seconds));
            signal(&child);
            let (code, said) = outcome(child, remarks);
            assert_eq!(code, Some(130), "{said}");
            let mut json = String::new();
            out.read_to_string(&mut json).unwrap();
            (!said.ends_with("cancelled, no picture was written\n")).then_some((said, json))
        });
        let (said, json) = kept.expect("a pass is done within a minute");
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let taken = &json["samples_per_pixel"]["taken"];
        let last = said.lines().last().unwrap_or_default();
        let expected =
            format!("pellucid: error: interrupted: the picture of {taken} of 1000000 samples a pixel is in paths.png");
        assert_eq!(last, expected, "{said}");
        assert!((2..1_000_000).contains(&taken.as_u64().unwrap()), "{json}");
        let picture = common::picture(&folder.path().join("paths.png"));
        assert_eq!([picture.width, picture.height], [48, 32]);
        let drawn = picture.pixels.iter().filter(|pixel| **pixel != picture.pixels[0]).count();
        assert!(drawn > 100, "{drawn} pixels with anything in them");
        assert_eq!(files(folder.path()), ["paths.png", "paths.toml"]);
    }
}

/// Interrupted again while it writes what there is, it ends at once and leaves nothing.
#[test]
fn interrupted_twice_a_picture_of_paths_leaves_nothing_behind() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("paths.toml"), PATHS).unwrap();
    for seconds in [4, 16, 60] {
        // So many pixels take seconds to be made smooth, and few each to be traced twice.
        let args = ["render", "paths.toml", "--size", "700x700", "-o", "paths.png", "--backend", "cpu"];
        let mut child = command(&args).current_dir(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
        let mut remarks = BufReader::new(child.stderr.take().unwrap());
        std::thread::sleep(Duration::from_secs(seconds));
        signal(&child);
        let mut said = String::new();
        while !said.contains("interrupted: ") && remarks.read_line(&mut said).unwrap() > 0 {}
        let is_writing = said.contains("once more quits at once");
        if is_writing {
            signal(&child);
        }
        let again = Instant::now();
        let (code, rest) = outcome(child, remarks);
        assert_eq!((code, files(folder.path())), (Some(130), vec!["paths.toml".to_owned()]), "{said}{rest}");
        if is_writing {
            assert!(again.elapsed() < Duration::from_secs(2) && rest.is_empty(), "{:?}: {rest}", again.elapsed());
            return;
        }
    }
    panic!("two passes take more than a minute");
}
