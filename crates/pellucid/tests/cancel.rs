//! Ctrl-C.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
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
