//! What the command promises where the system fails it: an exit code, one line, whole files and nothing else.
//! What cannot be made to happen is rehearsed, as SQLite does it: the n-th operation fails, for every n.

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use common::{command, files, run_in, succeed_in, text};
use tempfile::{TempDir, tempdir};

/// Everything in a folder.
fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    files(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Asserts that a command failed over something that it could not help, and that it said so in one line.
fn assert_failed(args: &[&str], code: Option<i32>, said: &str, context: &str) {
    assert_eq!(code, Some(1), "{args:?}, {context}: {said}");
    let is_told = said.starts_with("pellucid: error: ") && said.lines().count() == 1;
    assert!(is_told, "{args:?}, {context}: {said}");
}

/// Runs a command with its n-th operation failing, for n from 1 on, until none is left to fail; `check` looks at
/// what is there after each. Returns how many runs failed.
fn rehearse(folder: &Path, args: &[&str], operation: &str, check: impl Fn(bool, &str)) -> usize {
    let (mut failed, mut calm) = (0, 0);
    for n in 1.. {
        let output = command(args).current_dir(folder).env(operation, n.to_string()).output().unwrap();
        let (code, said) = (output.status.code(), text(&output.stderr));
        let context = format!("{operation} {n}");
        // There may be another way to what one failed at, as there is to hard links.
        let done = code == Some(0);
        check(done, &format!("{args:?}, {context}"));
        if done {
            assert_eq!(said, "", "{args:?}, {context}");
            calm += 1;
            if calm == 2 {
                return failed;
            }
        } else {
            assert_failed(args, code, &said, &context);
            (failed, calm) = (failed + 1, 0);
        }
    }
    failed
}

const RENDER: [&str; 7] = ["render", "sample:ball@8x8x8", "-q", "--backend", "cpu", "--threads", "2"];

#[test]
fn every_failure_of_the_disk_leaves_the_old_files_or_the_new_ones() {
    let input = tempdir().unwrap();
    succeed_in(input.path(), &["sample", "wavelet", "--dims", "5x6x7", "-o", "in.nrrd", "-q"]);
    let from = input.path().join("in.nrrd");
    let convert = ["convert", from.to_str().unwrap(), "-q", "-o"];
    let picture = [&RENDER, &["--size", "8x8", "-o"][..]].concat();
    let writers: [(Vec<&str>, &str); 11] = [
        ([&convert, &["a.nrrd"][..]].concat(), "a.nrrd"),
        ([&convert, &["a.nrrd", "--compress", "6"][..]].concat(), "a.nrrd"),
        ([&convert, &["a.nhdr"][..]].concat(), "a.nhdr"),
        ([&convert, &["a.mha", "--compress", "1"][..]].concat(), "a.mha"),
        ([&convert, &["a.mhd"][..]].concat(), "a.mhd"),
        ([&convert, &["a.nii"][..]].concat(), "a.nii"),
        ([&convert, &["a.nii.gz"][..]].concat(), "a.nii.gz"),
        ([&picture, &["a.png"][..]].concat(), "a.png"),
        ([&picture, &["a.png", "--bits", "16"][..]].concat(), "a.png"),
        ([&picture, &["a.exr"][..]].concat(), "a.exr"),
        ([&RENDER, &["--save-scene", "a.toml"][..]].concat(), "a.toml"),
    ];
    for (args, name) in &writers {
        let fresh = tempdir().unwrap();
        succeed_in(fresh.path(), args);
        let new = content(fresh.path());
        assert!(new.contains_key(*name) && new.keys().all(|name| !name.starts_with('.')), "{new:?}");
        // Where there was nothing, and over what was there.
        let old: BTreeMap<_, _> = new.keys().map(|name| (name.clone(), format!("old {name}").into_bytes())).collect();
        for before in [BTreeMap::new(), old] {
            let folder = tempdir().unwrap();
            let restore = || {
                for name in files(folder.path()) {
                    std::fs::remove_file(folder.path().join(name)).unwrap();
                }
                before.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
            };
            restore();
            let failed = rehearse(folder.path(), args, "PELLUCID_FAULT_DISK", |done, context| {
                assert!(
                    content(folder.path()) == *if done { &new } else { &before },
                    "{context}: {:?}",
                    files(folder.path())
                );
                restore();
            });
            // At the least: made twice (once to see whether it can be), written, dressed, synced, renamed.
            assert!(failed >= 6, "{args:?}: {failed}");
        }
    }
}

#[test]
fn every_failure_to_get_memory_is_told() {
    let input = tempdir().unwrap();
    succeed_in(input.path(), &["sample", "wavelet", "--dims", "30x30x30", "-o", "in.nrrd", "-q"]);
    let from = input.path().join("in.nrrd");
    let from = from.to_str().unwrap();
    let picture = [&RENDER, &["--size", "50x50", "-o"][..]].concat();
    let works: [Vec<&str>; 4] = [
        [&picture, &["a.png"][..]].concat(),
        [&picture, &["a.exr", "--mode", "maximum"][..]].concat(),
        vec!["convert", from, "-q", "-o", "a.nii.gz"],
        vec!["sample", "ball", "--dims", "30x30x30", "-q", "-o", "a.nhdr"],
    ];
    for args in &works {
        let folder = tempdir().unwrap();
        let failed = rehearse(folder.path(), args, "PELLUCID_FAULT_MEMORY", |done, context| {
            let left = files(folder.path());
            assert!(done != left.is_empty() && left.iter().all(|name| name.starts_with("a.")), "{context}: {left:?}");
            left.iter().for_each(|name| std::fs::remove_file(folder.path().join(name)).unwrap());
        });
        assert!(failed >= 3, "{args:?}: {failed}");
    }
}

#[test]
fn an_output_is_made_through_a_link_and_stays_private() {
    let folder = tempdir().unwrap();
    let [real, link] = ["real.png", "link.png"].map(|name| folder.path().join(name));
    std::fs::write(&real, "old").unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&real, std::fs::Permissions::from_mode(0o600)).unwrap();
        std::os::unix::fs::symlink("real.png", &link).unwrap();
        succeed_in(folder.path(), &[&RENDER, &["--size", "9x8", "-o", "link.png"][..]].concat());
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(std::fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(common::picture(&real).width, 9);
    }
}

#[cfg(unix)]
mod limits {
    //! Where the system refuses by its own limits.

    use std::os::unix::process::CommandExt;
    use std::process::{Command, Output};

    use super::*;

    /// Runs a command under limits that a shell sets.
    fn limited(folder: &Path, limits: &str, args: &[&str]) -> Output {
        let pellucid = command(args);
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{limits} && exec \"$0\" \"$@\"")]).arg(pellucid.get_program()).args(args);
        shell.current_dir(folder).output().unwrap()
    }

    #[test]
    fn little_memory_is_enough_or_is_told() {
        let folder = tempdir().unwrap();
        let args = [&RENDER, &["--size", "2000x2000", "-o", "a.png"][..]].concat();
        let (mut done, mut told) = (0, 0);
        for kilobytes in (300_000..1_500_000).step_by(100_000) {
            let output = limited(folder.path(), &format!("ulimit -v {kilobytes}"), &args);
            let said = text(&output.stderr);
            if output.status.code() == Some(0) {
                done += 1;
            } else {
                assert_failed(&args, output.status.code(), &said, &format!("{kilobytes} kB"));
                assert!(files(folder.path()).iter().all(|name| name == "a.png"), "{:?}", files(folder.path()));
                told += 1;
            }
        }
        assert!(done > 0 && told > 0, "{done} done, {told} told");
    }

    #[test]
    fn a_file_that_grows_too_large_is_told() {
        let folder = tempdir().unwrap();
        let args = ["sample", "wavelet", "--dims", "64x64x64", "--type", "f32", "-q", "-o", "a.nhdr"];
        let output = limited(folder.path(), "ulimit -f 100", &args);
        assert_failed(&args, output.status.code(), &text(&output.stderr), "ulimit -f");
        assert_eq!(files(folder.path()), [""; 0]);
    }

    #[test]
    fn a_lack_of_threads_is_told() {
        let folder = tempdir().unwrap();
        // Stacks for so many do not fit.
        let args = [&RENDER[..5], &["--threads", "1000", "--size", "8x8", "-o", "a.png"]].concat();
        let output = limited(folder.path(), "ulimit -v 4000000", &args);
        assert_failed(&args, output.status.code(), &text(&output.stderr), "1000 threads");
        assert_eq!(files(folder.path()), [""; 0]);
        // One who may have no thread at all, where this is an administrator, to whom such limits do not apply.
        let Some(program) = for_everybody(folder.path()) else { return };
        for args in [&["--threads", "1"][..], &[]] {
            let args = [&RENDER[..5], args, &["--size", "8x8", "-o", "a.png"]].concat();
            let mut nobody = Command::new("sh");
            // Shells differ in what they call it.
            let limit = "{ ulimit -u 1 || ulimit -p 1; } 2>/dev/null && exec \"$0\" \"$@\"";
            nobody.args(["-c", limit]).arg(&program).args(&args);
            let output = nobody.current_dir(folder.path()).uid(NOBODY).gid(NOBODY).output().unwrap();
            assert_failed(&args, output.status.code(), &text(&output.stderr), "no threads");
        }
        assert_eq!(files(folder.path()), ["pellucid"]);
    }

    const NOBODY: u32 = 65534;

    /// The program in a folder that everybody may write to; `None` if this user cannot become another one.
    fn for_everybody(folder: &Path) -> Option<std::path::PathBuf> {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o777)).unwrap();
        Command::new("true").uid(NOBODY).gid(NOBODY).status().ok()?;
        let (from, program) = (env!("CARGO_BIN_EXE_pellucid"), folder.join("pellucid"));
        std::fs::hard_link(from, &program).or_else(|_| std::fs::copy(from, &program).map(drop)).unwrap();
        Some(program)
    }
}

#[cfg(unix)]
mod signals {
    //! Ends that are asked for while a file is written.

    use std::process::{Child, Command};
    use std::time::{Duration, Instant};

    use super::*;

    /// 64 MiB that are slow to compress.
    fn noise() -> TempDir {
        let folder = tempdir().unwrap();
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 60) as u8
        };
        std::fs::write(folder.path().join("in.raw"), (0..1 << 26).map(|_| next()).collect::<Vec<u8>>()).unwrap();
        folder
    }

    const CONVERT: [&str; 9] = ["convert", "in.raw", "--dims", "1024x256x256", "--type", "u8", "-q", "-o", "a.nii.gz"];

    /// Waits until a file is being written.
    fn until_it_writes(folder: &Path, child: &mut Child) -> String {
        let started = Instant::now();
        loop {
            let grows = |name: &String| std::fs::metadata(folder.join(name)).is_ok_and(|file| file.len() > 0);
            if let Some(name) = files(folder).into_iter().find(|name| name.ends_with(".tmp") && grows(name)) {
                return name;
            }
            assert!(child.try_wait().unwrap().is_none() && started.elapsed().as_secs() < 60, "it does not write");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn send(signal: &str, child: &Child) {
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    #[test]
    fn whatever_asks_for_the_end_leaves_nothing_behind() {
        let folder = noise();
        for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129), ("QUIT", 131)] {
            let mut child = command(&CONVERT).current_dir(folder.path()).spawn().unwrap();
            until_it_writes(folder.path(), &mut child);
            let sent = Instant::now();
            send(signal, &child);
            assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
            assert!(sent.elapsed() < Duration::from_secs(3), "{signal}: {:?}", sent.elapsed());
            assert_eq!(files(folder.path()), ["in.raw"], "{signal}");
        }
    }

    #[test]
    fn what_outlives_the_terminal_goes_on() {
        let folder = noise();
        let mut shell = Command::new("sh");
        shell.args(["-c", "trap '' HUP && exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_pellucid")]).args(CONVERT);
        let mut child = shell.current_dir(folder.path()).spawn().unwrap();
        until_it_writes(folder.path(), &mut child);
        send("HUP", &child);
        std::thread::sleep(Duration::from_millis(300));
        assert!(child.try_wait().unwrap().is_none(), "it ended at a signal that is ignored");
        send("TERM", &child);
        assert_eq!(child.wait().unwrap().code(), Some(143));
        assert_eq!(files(folder.path()), ["in.raw"]);
    }

    #[test]
    fn what_the_killed_left_is_removed_by_the_next() {
        let folder = noise();
        let mut child = command(&CONVERT).current_dir(folder.path()).spawn().unwrap();
        let left = until_it_writes(folder.path(), &mut child);
        // While it lives, nobody takes its file away.
        let output = run_in(folder.path(), &["sample", "ball", "--dims", "4x4x4", "-q", "-o", "a.nii.gz"]);
        assert_eq!(output.status.code(), Some(0));
        assert!(files(folder.path()).contains(&left));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(files(folder.path()), [&*left, "a.nii.gz", "in.raw"]);
        succeed_in(folder.path(), &["sample", "ball", "--dims", "4x4x4", "-q", "-o", "b.nii.gz"]);
        assert!(files(folder.path()).contains(&left), "another file's");
        succeed_in(folder.path(), &["sample", "ball", "--dims", "4x4x4", "-q", "-o", "a.nii.gz"]);
        assert_eq!(files(folder.path()), ["a.nii.gz", "b.nii.gz", "in.raw"]);
    }

    #[test]
    fn a_second_signal_ends_a_render_at_once() {
        let folder = tempdir().unwrap();
        let args =
            ["render", "sample:sines@16x16x16", "--size", "4000x4000", "--step", "0.01", "--no-skip", "--backend"];
        let args = [&args[..], &["cpu", "--threads=2", "-q", "-o", "a.png"]].concat();
        let mut child = command(&args).current_dir(folder.path()).stderr(std::process::Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        send("TERM", &child);
        send("TERM", &child);
        assert_eq!(child.wait().unwrap().code(), Some(143));
        assert_eq!(files(folder.path()), [""; 0]);
    }
}
