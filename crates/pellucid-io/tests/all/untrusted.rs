//! What files may not do, whatever they say: name what is elsewhere, wait, never end, cost what nobody allowed, or have
//! messages repeat what is in others.

use std::path::Path;
use std::time::Duration;

use crate::common::{gzip, message, stored};
use pellucid_io::{
    IoError, Limits, Loaded, PngPixels, RawLayout, ReadOptions, Transfer, locate, open_regular, read, read_bytes,
    read_exr, read_picture, read_picture_bytes, read_png, read_text, write_png,
};

/// A detached header of two bytes that lie in `file`.
fn header(file: &str) -> String {
    format!("NRRD0004\ntype: uint8\ndimension: 1\nsizes: 2\nencoding: raw\ndata file: {file}\n")
}

/// The answer to a question that must not take for ever.
fn in_time<T: Send + 'static>(ask: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(ask()));
    receiver.recv_timeout(Duration::from_secs(20)).expect("an answer within 20 seconds")
}

#[test]
fn headers_name_what_lies_beside_them_and_below() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().join("home");
    std::fs::create_dir_all(home.join("below")).unwrap();
    for place in [folder.path(), &home, &home.join("below")] {
        std::fs::write(place.join("d.raw"), [1, 2]).unwrap();
        std::fs::write(place.join("d0.raw"), [1, 2]).unwrap();
    }
    let mut strict = ReadOptions::default();
    let open = ReadOptions { outside: true, ..strict.clone() };
    let ask = |name: &str, text: String, options: &ReadOptions| {
        std::fs::write(home.join(name), text).unwrap();
        read(home.join(name), options)
    };
    let absolute = |place: &Path| place.join("d.raw").display().to_string();
    for inside in ["d.raw".to_owned(), "./below/../d.raw".into(), "below/d.raw".into(), absolute(&home)] {
        let volume = ask("a.nhdr", header(&inside), &strict).unwrap_or_else(|error| panic!("{inside}: {error}")).volume;
        assert_eq!(stored(&volume), [1.0, 2.0]);
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.path(), home.join("link")).unwrap();
    let leaving = [
        ("a.nhdr", header("../d.raw")),
        ("a.nhdr", header("below/../../d.raw")),
        ("a.nhdr", header(&absolute(folder.path()))),
        ("a.nhdr", header("../d%d.raw 0 0 1")),
        ("a.nhdr", header("LIST\n../d.raw")),
        #[cfg(unix)]
        ("a.nhdr", header("link/d.raw")),
        ("a.mhd", "NDims = 2\nDimSize = 2 1\nElementType = MET_UCHAR\nElementDataFile = ../d.raw\n".into()),
    ];
    for (name, text) in leaving {
        let error = ask(name, text.clone(), &strict).map(|_| ()).expect_err(&text);
        assert!(matches!(error, IoError::Outside { .. }), "{text}: {error}");
        assert_eq!(stored(&ask(name, text, &open).unwrap().volume), [1.0, 2.0]);
    }
    // Whether there is such a file elsewhere is nobody's business; beside the header it is.
    for (name, elsewhere) in [("none.raw", false), ("../none.raw", true), ("/none.raw", true)] {
        let error = ask("a.nhdr", header(name), &strict).map(|_| ()).unwrap_err();
        assert_eq!(matches!(error, IoError::Outside { .. }), elsewhere, "{error}");
    }
    // The image of a NIfTI pair is named by the header's own name.
    #[cfg(unix)]
    {
        let pair = crate::common::nifti::Header::new(1, false).dim(&[3, 2, 1, 1]).datatype(2, 8).vox_offset(0.0);
        let mut bytes = pair.bytes;
        bytes[344..348].copy_from_slice(b"ni1\0");
        std::fs::write(home.join("p.hdr"), bytes).unwrap();
        std::os::unix::fs::symlink(folder.path().join("d.raw"), home.join("p.img")).unwrap();
        assert!(matches!(read(home.join("p.img"), &strict), Err(IoError::Outside { .. })));
        assert_eq!(stored(&read(home.join("p.hdr"), &open).unwrap().volume), [1.0, 2.0]);
    }
    // What the caller names may lie anywhere.
    strict.raw = Some(RawLayout::new([2, 1, 1], pellucid_field::VoxelType::U8));
    assert!(read(home.join("below/../../d.raw"), &strict).is_ok());
}

#[test]
fn a_folder_may_be_the_current_one() {
    let here = std::env::current_dir().unwrap();
    assert_eq!(locate("", "Cargo.toml", false).unwrap(), Path::new("Cargo.toml"));
    assert!(locate("", here.join("Cargo.toml"), false).is_ok());
    assert!(matches!(locate("", "../Cargo.toml", false), Err(IoError::Outside { .. })));
    assert!(matches!(locate("no such folder", "a", false), Err(IoError::Io { .. })));
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_opened_and_nothing_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.nrrd");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let socket = folder.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    std::fs::write(folder.path().join("pipe.nhdr"), header("pipe.nrrd")).unwrap();
    let raw = ReadOptions {
        raw: Some(RawLayout::new([4, 1, 1], pellucid_field::VoxelType::U8)),
        outside: true,
        ..ReadOptions::default()
    };
    for (path, kind) in [
        (pipe, "a pipe"),
        (folder.path().join("pipe.nhdr"), "a pipe"),
        ("/dev/zero".into(), "a device"),
        (socket, "a socket"),
        (folder.path().to_owned(), "a folder"),
    ] {
        let options = if kind == "a device" { raw.clone() } else { ReadOptions::default() };
        let messages: Vec<String> = in_time(move || {
            let is_header = path.extension().is_some_and(|extension| extension == "nhdr");
            let mut messages = vec![message(read(&path, &options))];
            if !is_header {
                messages.push(open_regular(&path).unwrap_err().to_string());
                messages.push(read_text(&path, &Limits::default()).unwrap_err().to_string());
                messages.push(read_png(&path).unwrap_err().to_string());
                messages.push(read_exr(&path).unwrap_err().to_string());
            }
            messages
        });
        for message in messages {
            assert!(message.contains(&format!("{kind}, expected a regular file")), "{message}");
        }
    }
}

#[test]
fn messages_never_repeat_what_is_in_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let secret = "swordfish";
    for text in [secret.to_owned(), format!("1 {secret}"), format!("0\n{secret}\n")] {
        std::fs::write(folder.path().join("secret"), &text).unwrap();
        for encoding in ["text", "hex", "gzip", "bzip2"] {
            let header = format!(
                "NRRD0004\ntype: float\ndimension: 1\nsizes: 3\nencoding: {encoding}\nendian: little\ndata file: secret\n"
            );
            let error = message(read_bytes(folder.path().join("a.nhdr"), header.into_bytes(), &ReadOptions::default()));
            assert!(!error.contains("sword") && error.contains("secret"), "{encoding}: {error}");
        }
    }
}

#[test]
fn texts_have_a_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, "a = 1\n").unwrap();
    let limits = |text| Limits { text, ..Limits::default() };
    assert_eq!(read_text(&path, &limits(6)).unwrap(), "a = 1\n");
    let error = read_text(&path, &limits(5)).unwrap_err();
    assert!(matches!(error, IoError::Limit { setting: "text", found: 6, allowed: 5, .. }), "{error}");
    std::fs::write(&path, b"abc\xff").unwrap();
    assert!(read_text(&path, &limits(5)).unwrap_err().to_string().contains("byte 3 is not UTF-8"));
    // A file whose size is unknown until it is read.
    #[cfg(target_os = "linux")]
    assert!(matches!(read_text("/proc/self/maps", &limits(100)), Err(IoError::Limit { .. })));
}

/// Callers set what may be decoded, also of plain files.
#[test]
fn limits_are_the_callers() {
    let header = |encoding: &str| format!("NRRD0004\ntype: uint8\ndimension: 1\nsizes: 1000\nencoding: {encoding}\n\n");
    let zeros = vec![0; 1000];
    let files = [
        [header("raw").as_bytes(), &zeros].concat(),
        [header("gzip").as_bytes(), &gzip(&zeros)].concat(),
        [header("text").as_bytes(), "0 ".repeat(1000).as_bytes()].concat(),
        [header("hex").as_bytes(), "00".repeat(1000).as_bytes()].concat(),
    ];
    let ask = |bytes: &[u8], limits| -> Result<Loaded, IoError> {
        read_bytes("a.nrrd", bytes.to_vec(), &ReadOptions { limits, ..ReadOptions::default() })
    };
    for bytes in &files {
        assert!(ask(bytes, Limits { bytes: Some(1000), ..Limits::default() }).is_ok());
        let error = ask(bytes, Limits { bytes: Some(999), ..Limits::default() }).map(|_| ()).unwrap_err();
        assert!(matches!(error, IoError::Limit { setting: "bytes", found: 1000, allowed: 999, .. }), "{error}");
        assert!(error.to_string().contains("1000 bytes, once decoded, exceed limits.bytes, 999"), "{error}");
    }
    let listed = "NRRD0004\ntype: uint8\ndimension: 1\nsizes: 4\nencoding: raw\ndata file: LIST\na\nb\n";
    let error = ask(listed.as_bytes(), Limits { files: 1, ..Limits::default() }).map(|_| ()).unwrap_err();
    assert!(matches!(error, IoError::Limit { setting: "files", found: 2, allowed: 1, .. }), "{error}");
}

/// The same packed file under many names is no more than one.
#[test]
fn a_file_named_twice_vouches_once() {
    let folder = tempfile::tempdir().unwrap();
    let packed = gzip(&vec![0; 1 << 24]);
    std::fs::write(folder.path().join("z.gz"), &packed).unwrap();
    let names: String = (0..2048).map(|k| format!("{}z.gz\n", "./".repeat(k % 7))).collect();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4096 4096 2048\nencoding: gzip\ndata file: LIST\n";
    let header = format!("{header}{names}").into_bytes();
    // Names of files that exist are enough: only the first few are decoded.
    let error = read_bytes(folder.path().join("a.nhdr"), header, &ReadOptions::default()).map(|_| ()).unwrap_err();
    assert!(matches!(error, IoError::Limit { setting: "bytes", allowed: Limits::TRUSTED, .. }), "{error}");
}

/// Sizes whose product overflows are the file's mistake, not a lack of memory.
#[test]
fn sizes_beyond_counting_are_malformed() {
    for sizes in ["4294967296 4294967296 4294967296", "9223372036854775807 2 1", "9223372036854775808 1 1"] {
        for kind in ["uint8", "double"] {
            let header =
                format!("NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nendian: little\nencoding: raw\n\n1234");
            let error = read_bytes("a.nrrd", header.into_bytes(), &ReadOptions::default()).map(|_| ()).unwrap_err();
            assert!(matches!(error, IoError::Malformed { .. } | IoError::Field { .. }), "{error}");
        }
    }
}

/// Another program shortens a file while it is read.
#[test]
fn files_that_shrink_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.raw");
    let dims = [512, 512, 128];
    let options =
        ReadOptions { raw: Some(RawLayout::new(dims, pellucid_field::VoxelType::U8)), ..ReadOptions::default() };
    let mut shortened = 0;
    for round in 0..40u64 {
        let file = std::fs::File::create(&path).unwrap();
        file.set_len(dims.iter().product::<usize>() as u64).unwrap();
        let reader = std::thread::spawn({
            let (path, options) = (path.clone(), options.clone());
            move || read(&path, &options)
        });
        std::thread::sleep(Duration::from_millis(round % 8));
        file.set_len(4096).unwrap();
        match reader.join().unwrap() {
            Ok(loaded) => assert_eq!(loaded.volume.statistics().max, 0.0),
            Err(IoError::Truncated { found: 4096.., expected, .. }) => {
                assert_eq!(expected, dims.iter().product::<usize>() as u64);
                shortened += 1;
            }
            // Before it was opened.
            Err(IoError::Malformed { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
    assert!(shortened > 0, "never while it was read");
}

/// A PNG of one row with this palette, as a chunk that no encoder would write.
fn with_palette(bytes: usize) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], body: &[u8]| {
        let mut checksum = flate2::Crc::new();
        checksum.update(name);
        checksum.update(body);
        png.extend((body.len() as u32).to_be_bytes());
        png.extend(name.iter().chain(body));
        png.extend(checksum.sum().to_be_bytes());
    };
    chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 1, 8, 3, 0, 0, 0]);
    chunk(b"PLTE", &vec![51; bytes]);
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut zlib, &[0, 0, 255]).unwrap();
    chunk(b"IDAT", &zlib.finish().unwrap());
    chunk(b"IEND", &[]);
    png
}

#[test]
fn palettes_have_three_bytes_for_each_colour() {
    let limits = Limits::default();
    for bytes in 0..800 {
        let result = read_picture_bytes("a.png", &with_palette(bytes), &limits);
        if bytes > 0 && bytes <= 768 && bytes % 3 == 0 {
            let picture = result.unwrap();
            assert_eq!(picture.pixels[0], [0.2, 0.2, 0.2, 1.0], "{bytes}");
        } else {
            assert!(matches!(result, Err(IoError::Damaged { encoding: "PNG", .. })), "{bytes}: {result:?}");
        }
    }
}

/// 8000 x 8000 pixels of one bit fit into some kilobytes, and take a gigabyte as numbers.
#[test]
fn pictures_have_limits() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8000, 8000);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(&vec![0; 8_000_000]).unwrap();
    assert!(bytes.len() < 20_000, "{}", bytes.len());
    let error = read_picture_bytes("a.png", &bytes, &Limits::default()).unwrap_err();
    // 16 bytes a pixel, and the one that is decoded.
    let found = 8000 * 8000 * 17;
    assert!(
        matches!(error, IoError::Limit { setting: "bytes", found: f, allowed: Limits::TRUSTED, .. } if f == found),
        "{error}"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_png(&path, 9, 5, PngPixels::U8(&[7; 135]), Transfer::Srgb).unwrap();
    let limits = |bytes| Limits { bytes: Some(bytes), ..Limits::default() };
    assert!(read_picture(&path, &limits(9 * 5 * 19)).is_ok());
    assert!(matches!(read_picture(&path, &limits(9 * 5 * 19 - 1)), Err(IoError::Limit { .. })));
    let path = folder.path().join("a.exr");
    let light = vec![0.5; 45];
    pellucid_io::write_exr(&path, 9, 5, &[("R", &light), ("G", &light), ("B", &light)]).unwrap();
    assert!(read_picture(&path, &limits(9 * 5 * 28)).is_ok());
    assert!(matches!(read_picture(&path, &limits(9 * 5 * 28 - 1)), Err(IoError::Limit { .. })));
}
