//! What scenes and headers may name, and what files may cost, on the command line.

use std::path::Path;

use crate::common::{fail_in, files, run_in, succeed_in, text};
use pellucid::io::{PngPixels, Transfer, write_exr, write_png};
use tempfile::{TempDir, tempdir};

const DRAW: [&str; 8] = ["--size", "4x4", "--backend", "cpu", "-q", "--threads", "1", "-o"];

/// A folder with files, and in it one with scenes.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempdir().unwrap();
        std::fs::create_dir(folder.path().join("home")).unwrap();
        for place in ["", "home/"] {
            let path = |name: &str| folder.path().join(format!("{place}{name}"));
            std::fs::write(path("v.raw"), [1; 8]).unwrap();
            std::fs::write(
                path("v.nrrd"),
                "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: text\n\n0 1 2 3 4 5 6 7\n",
            )
            .unwrap();
            std::fs::write(path("mie.csv"), "0 1\n180 2\n").unwrap();
            write_png(path("sky.png"), 2, 2, PngPixels::U8(&[80; 12]), Transfer::Srgb).unwrap();
            write_exr(path("sky.exr"), 1, 2, &[("R", &[1.0; 2]), ("G", &[1.0; 2]), ("B", &[1.0; 2])]).unwrap();
        }
        Self { folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes a scene into the inner folder.
    fn scene(&self, text: &str) {
        std::fs::write(self.path().join("home/s.toml"), text).unwrap();
    }

    fn draw(&self, input: &str, more: &[&str]) -> (Option<i32>, String) {
        let output = run_in(self.path(), &[&["render", input], &DRAW[..], &["a.png"], more].concat());
        (output.status.code(), text(&output.stderr))
    }
}

/// Scenes that name a file, at the place of the percent sign, in every way there is.
const SCENES: [&str; 6] = [
    "[[volumes]]\nsource.file = \"%v.nrrd\"\n",
    "[[volumes]]\nsource.raw = { path = \"%v.raw\", dims = [2, 2, 2], voxel_type = \"u8\" }\n",
    "[[volumes]]\nsource.model.height_field = { map.file = \"%sky.png\", relief = 0.3, slab = [-0.12, 0], ramp = 0.025, \
     dims = [6, 6, 5] }\n",
    "[[volumes]]\nsource.sample = { name = \"ball\", dims = [6, 6, 6] }\nscattering.phase.table.file = \"%mie.csv\"\n\
     [technique.path_trace]\nsamples = 1\n",
    "[[volumes]]\nsource.sample = { name = \"ball\", dims = [6, 6, 6] }\nscattering.phase.table.file = \"%sky.png\"\n\
     [technique.path_trace]\nsamples = 1\n",
    "[[volumes]]\nsource.sample = { name = \"ball\", dims = [6, 6, 6] }\n[technique.path_trace]\nsamples = 1\n\
     environment.image.source.file = \"%sky.exr\"\n",
];

#[test]
fn scenes_name_what_lies_beside_them_and_below() {
    let place = Place::new();
    let absolute = place.path().canonicalize().unwrap().display().to_string();
    for scene in SCENES {
        for (inside, name) in [(true, ""), (true, "../home/"), (false, "../"), (false, &format!("{absolute}/"))] {
            place.scene(&scene.replace('%', name));
            let (code, said) = place.draw("home/s.toml", &[]);
            assert_eq!(code, Some(if inside { 0 } else { 2 }), "{scene} with {name}: {said}");
            if !inside {
                assert!(said.contains("outside of 'home'") && said.contains("hint: --allow-outside"), "{said}");
                let (code, said) = place.draw("home/s.toml", &["--allow-outside"]);
                assert_eq!(code, Some(0), "{scene} with {name}: {said}");
            }
        }
    }
    // From within, the folder has no name.
    place.scene(&SCENES[0].replace('%', "../"));
    let home = place.path().join("home");
    assert!(fail_in(&home, &["info", "s.toml"], 2).contains("outside of '.'"));
    place.scene(&SCENES[0].replace('%', ""));
    succeed_in(&home, &["info", "s.toml"]);
}

/// A table that is none is not told about.
#[test]
fn errors_do_not_repeat_what_is_in_other_files() {
    let place = Place::new();
    for secret in ["root:swordfish:0:0\nx\n", "0 1\nswordfish 2\n", "0 1\n180 2 swordfish\n", "swordfish\nswordfish\n"]
    {
        std::fs::write(place.path().join("home/mie.csv"), secret).unwrap();
        place.scene(&SCENES[3].replace('%', ""));
        let (code, said) = place.draw("home/s.toml", &[]);
        assert!(code == Some(2) && said.contains("mie.csv") && !said.contains("sword"), "{said}");
    }
}

#[test]
fn what_the_command_line_names_may_lie_anywhere() {
    let place = Place::new();
    let home = place.path().join("home");
    let absolute = place.path().join("v.nrrd").display().to_string();
    for name in ["../v.nrrd", &absolute] {
        succeed_in(&home, &["info", name]);
        succeed_in(&home, &["convert", name, "-o", "c.nrrd", "-q"]);
    }
    succeed_in(&home, &["info", "../v.raw", "--dims", "2x2x2", "--type", "u8"]);
    place.scene(&SCENES[0].replace('%', ""));
    let set = format!("volumes[0].source.file={absolute}");
    let (code, said) = place.draw("home/s.toml", &["--set", &set]);
    assert_eq!(code, Some(0), "{said}");
    // The scene's own name is not made the user's by naming another.
    place.scene(&SCENES[0].replace('%', "../"));
    assert_eq!(place.draw("home/s.toml", &["--set", "quality.step=0.5"]).0, Some(2));
    // Nor is what a header names.
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: ../v.raw\n";
    std::fs::write(home.join("v.nhdr"), header).unwrap();
    let said = fail_in(&home, &["info", "v.nhdr"], 2);
    assert!(said.contains("../v.raw is outside of '.'") && said.contains("--allow-outside"), "{said}");
    succeed_in(&home, &["info", "v.nhdr", "--allow-outside"]);
}

/// A scene is saved so that it can be drawn, without a further word if its data lie below it.
#[test]
fn saved_scenes_are_drawn_in_one_step() {
    let place = Place::new();
    let save = |input: &str, to: &str| {
        let output = run_in(place.path(), &["render", input, "--save-scene", to]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        (text(&output.stderr), std::fs::read_to_string(place.path().join(to)).unwrap())
    };
    for scene in SCENES {
        place.scene(&scene.replace('%', ""));
        let (said, saved) = save("home/s.toml", "above.toml");
        assert!(!said.contains("--allow-outside"), "{said}");
        assert!(saved.contains("\"home/"), "{saved}");
        let (code, said) = place.draw("above.toml", &[]);
        assert_eq!(code, Some(0), "{scene}: {said}");
        std::fs::create_dir_all(place.path().join("beside")).unwrap();
        let (said, _) = save("home/s.toml", "beside/s.toml");
        assert!(said.contains("draw it with --allow-outside"), "{said}");
        assert_eq!(place.draw("beside/s.toml", &[]).0, Some(2));
        let (code, said) = place.draw("beside/s.toml", &["--allow-outside"]);
        assert_eq!(code, Some(0), "{scene}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_at_once() {
    let place = Place::new();
    let home = place.path().join("home");
    for name in ["pipe", "pipe.nrrd", "pipe.toml", "pipe.json", "pipe.png", "pipe.csv", "pipe.vp.json"] {
        assert!(std::process::Command::new("mkfifo").arg(home.join(name)).status().unwrap().success());
    }
    let ask = |args: &[&str]| {
        // A command that waits is killed: 124.
        let program = env!("CARGO_BIN_EXE_pellucid");
        let mut command = std::process::Command::new("timeout");
        command.args(["60", program]).args(args).current_dir(&home).env("XDG_RUNTIME_DIR", std::env::temp_dir());
        let output = command.output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(said.contains("expected a regular file"), "{args:?}: {said}");
    };
    ask(&["info", "pipe.nrrd"]);
    ask(&["info", "pipe", "--dims", "2x2x2", "--type", "u8"]);
    ask(&["info", "pipe.toml"]);
    ask(&["info", "pipe.json"]);
    ask(&["info", "/dev/zero"]);
    ask(&["render", "sample:ball@4x4x4", "-o", "a.png", "--transfer-function", "pipe.vp.json"]);
    std::fs::write(
        home.join("v.nhdr"),
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: pipe\n",
    )
    .unwrap();
    ask(&["info", "v.nhdr"]);
    for scene in SCENES {
        for (file, pipe) in [
            ("mie.csv", "pipe.csv"),
            ("sky.png", "pipe.png"),
            ("sky.exr", "pipe"),
            ("v.nrrd", "pipe"),
            ("v.raw", "pipe"),
        ] {
            if scene.contains(file) {
                place.scene(&scene.replace('%', "").replace(file, pipe));
                ask(&["render", "s.toml", "-o", "a.png"]);
                place.scene(&scene.replace('%', "").replace(file, "/dev/zero"));
                ask(&["render", "s.toml", "-o", "a.png", "--allow-outside"]);
            }
        }
    }
    assert!(!files(&home).contains(&"a.png".to_owned()));
}

#[test]
fn files_cost_no_more_than_is_allowed() {
    let place = Place::new();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1000 1000 1000\nencoding: bzip2\n\n";
    // An empty stream: more is not looked at.
    let bytes = [header.as_bytes(), b"BZh9\x17\x72\x45\x38\x50\x90\0\0\0\0"].concat();
    std::fs::write(place.path().join("bomb.nrrd"), bytes).unwrap();
    let said = fail_in(place.path(), &["info", "bomb.nrrd"], 2);
    assert!(
        said.contains("1000000000 bytes") && said.contains("536870912") && said.contains("--max-bytes 954M"),
        "{said}"
    );
    let said = fail_in(place.path(), &["info", "bomb.nrrd", "--max-bytes", "954M"], 2);
    assert!(said.contains("has 0 bytes"), "{said}");
    for wrong in ["1.5G", "M", "-1", "1X", "99999999999T"] {
        fail_in(place.path(), &["info", "bomb.nrrd", &format!("--max-bytes={wrong}")], 2);
    }
    fail_in(place.path(), &["info", "v.nrrd", "--max-bytes", "7"], 2);
    succeed_in(place.path(), &["info", "v.nrrd", "--max-bytes", "8"]);
    succeed_in(place.path(), &["info", "v.nrrd", "--map"]);
    let long = format!("title = \"{}\"\n", "x".repeat(5 << 20));
    std::fs::write(place.path().join("long.toml"), long).unwrap();
    let said = fail_in(place.path(), &["info", "long.toml"], 2);
    assert!(said.contains("bytes of text exceed limits.text, 4194304"), "{said}");
}

/// An 84-byte PNG with a palette of 4 bytes, wherever a picture can stand.
#[test]
fn a_short_palette_is_an_error_of_one_line() {
    const PNG: &[u8] = &[
        0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13, b'I', b'H', b'D', b'R', 0, 0, 0, 2, 0, 0, 0, 1, 8, 3, 0,
        0, 0,
    ];
    let place = Place::new();
    let mut png = PNG.to_vec();
    let mut chunk = |body: &[u8]| {
        png.extend(crc(body).to_be_bytes());
    };
    chunk(&PNG[12..29]);
    for (name, body) in [
        (b"PLTE", &[1u8, 2, 3, 4][..]),
        (b"IDAT", &[0x78, 1, 1, 3, 0, 0xfc, 0xff, 0, 0, 0, 0, 3, 0, 1]),
        (b"IEND", &[]),
    ] {
        png.extend((body.len() as u32).to_be_bytes());
        let named = [&name[..], body].concat();
        png.extend(&named);
        png.extend(crc(&named).to_be_bytes());
    }
    std::fs::write(place.path().join("home/sky.png"), &png).unwrap();
    for scene in SCENES.iter().filter(|scene| scene.contains("sky.")) {
        place.scene(&scene.replace('%', "").replace("sky.exr", "sky.png"));
        let (code, said) = place.draw("home/s.toml", &[]);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("the palette has 4 bytes") && said.lines().count() == 1, "{said}");
    }
}

/// The checksum of a PNG's chunks, by its definition.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc: u32, _| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}
