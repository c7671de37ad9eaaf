//! Ctrl-C.
#![cfg(unix)]

mod common;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{command, files, text};
use tempfile::tempdir;

/// Far more work than the test waits for.
const LONG: [&str; 9] =
    ["render", "sample:sines@16x16x16", "--size", "8000x8000", "--step", "0.01", "--no-skip", "-o", "long.png"];

#[test]
fn an_interrupted_render_leaves_nothing_behind() {
    for delay in [50, 1000] {
        let folder = tempdir().unwrap();
        let child = command(&LONG).current_dir(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        let interrupted = Instant::now();
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(interrupted.elapsed() < Duration::from_secs(2), "it took {:?}", interrupted.elapsed());
        assert!(!said.contains("panicked"), "{said}");
        assert_eq!(files(folder.path()), [""; 0]);
    }
}
