//! Runs the command.

#![allow(dead_code)] // Every test file uses its own part.

use std::path::Path;
use std::process::{Command, Output};

use pellucid::io::Picture;
use serde_json::Value;

/// The command, not yet started.
pub fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    // As in every session: without it Mesa's drivers complain on standard error of their own accord.
    command.args(args).env("XDG_RUNTIME_DIR", std::env::temp_dir());
    command
}

/// Runs the command to its end in a folder.
pub fn run_in(folder: &Path, args: &[&str]) -> Output {
    command(args).current_dir(folder).output().expect("the command starts")
}

/// Standard output of a command that must succeed.
pub fn succeed_in(folder: &Path, args: &[&str]) -> String {
    let output = run_in(folder, args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Standard error of a command that must fail with this exit code: one line, and perhaps a hint.
pub fn fail_in(folder: &Path, args: &[&str], code: i32) -> String {
    let output = run_in(folder, args);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    let lines: Vec<&str> = message.lines().collect();
    assert!(lines[0].starts_with("pellucid: error: "), "{args:?}: {message}");
    assert!(lines.len() <= 2 && lines[1..].iter().all(|line| line.starts_with("pellucid: hint: ")), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

/// The scene that `render INPUT FLAGS` would draw, as JSON.
pub fn scene_in(folder: &Path, args: &[&str]) -> Value {
    let all = [&["render", "--quiet", "--save-scene", "saved.json"], args].concat();
    succeed_in(folder, &all);
    let text = std::fs::read_to_string(folder.join("saved.json")).expect("the scene was saved");
    serde_json::from_str(&text).expect("a saved scene is JSON")
}

/// A picture the command has written.
pub fn picture(path: &Path) -> Picture {
    pellucid::io::read_png(path).expect("the picture can be read")
}

/// Names of the files in a folder.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Bytes as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
