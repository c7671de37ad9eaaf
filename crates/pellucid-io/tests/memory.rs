//! Headers that promise more than their file holds cost neither memory nor time.
#![cfg(target_os = "linux")]

mod common;

use std::io::Write;
use std::time::{Duration, Instant};

use common::nifti::Header;
use common::{gzip, load, message};
use pellucid_io::{IoError, ReadOptions, read};

/// The most memory this process has ever reserved, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmPeak:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

/// The only test in its process, so that nothing else reserves memory meanwhile.
#[test]
fn lying_sizes_fail_fast_without_allocating() {
    let mut bzip2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    bzip2.write_all(&vec![0; 1 << 20]).unwrap();
    let bzip2 = bzip2.finish().unwrap();
    let nrrd = |sizes: &str, kind: &str, encoding: &str, data: &[u8]| {
        let header =
            format!("NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nendian: big\nencoding: {encoding}\n\n");
        ("a.nrrd", [header.as_bytes(), data].concat())
    };
    let zeros = gzip(&vec![0; 1 << 20]);
    let meta = b"NDims = 3\nDimSize = 4096 4096 4096\nElementType = MET_FLOAT\nCompressedData = True\nElementDataFile = LOCAL\n";
    let files = [
        nrrd("4096 4096 4096", "float", "raw", &[0; 64]),
        nrrd("4096 4096 4096", "double", "raw", &[0; 64]),
        nrrd("4096 4096 4096", "float", "hex", &[b'0'; 64]),
        nrrd("4096 4096 4096", "float", "ascii", b"1 2 3"),
        nrrd("4096 4096 4096", "float", "gzip", &zeros),
        nrrd("4096 4096 4096", "int64", "gzip", &zeros),
        nrrd("4096 4096 4096", "float", "bzip2", &bzip2),
        nrrd("4096 4096 4096", "int64", "bzip2", &bzip2),
        // Two gigabytes could be had.
        nrrd("1024 1024 512", "float", "raw", &[0; 64]),
        nrrd("1024 1024 512", "float", "hex", &[b'0'; 64]),
        nrrd("1024 1024 512", "float", "ascii", b"1 2 3"),
        nrrd("1024 1024 512", "float", "gzip", &zeros),
        nrrd("1024 1024 512", "float", "bzip2", &bzip2),
        nrrd("4294967296 4294967296 4294967296", "float", "raw", &[0; 64]),
        nrrd("9223372036854775807 1 1", "uint8", "bzip2", &bzip2),
        nrrd("18446744073709551615 1 1", "uint8", "gzip", &zeros),
        ("a.mha", [meta.as_slice(), &zeros].concat()),
        ("a.nii", Header::new(1, false).dim(&[7, 32767, 32767, 32767, 32767]).with_counting(5)),
        ("a.nii.gz", gzip(&Header::new(2, false).dim(&[3, 1 << 20, 1 << 20, 1 << 20]).with_counting(5))),
        ("a.nii.gz", gzip(&Header::new(2, false).dim(&[3, 1024, 1024, 1024]).vox_offset(1e15).with_counting(5))),
    ];
    let (before, start) = (peak(), Instant::now());
    for (index, (name, bytes)) in files.into_iter().enumerate() {
        let result = load(name, bytes);
        let error = result.map(|_| ()).expect_err("a file that lies");
        let grown = peak() - before;
        assert!(grown < 96 << 20, "file {index} reserved {grown} bytes: {error}");
    }
    for (name, bytes) in bombs() {
        let result = load(name, bytes);
        let grown = peak() - before;
        assert!(grown < 96 << 20, "{name} reserved {grown} bytes");
        let error = result.map(|_| ()).expect_err("a bomb");
        assert!(matches!(error, IoError::Limit { setting: "bytes", .. }), "{error}");
    }
    // A pattern of as many files as headers may name, with a long name, and of more.
    let folder = tempfile::tempdir().unwrap();
    let header = |count: usize| {
        let (name, last) = ("a".repeat(900), count - 1);
        format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {count} 3 2\nencoding: raw\ndata file: {name}%d 0 {last} 1\n"
        )
    };
    let path = folder.path().join("many.nhdr");
    let read = |text: String| {
        std::fs::write(&path, text).unwrap();
        message(read(&path, &ReadOptions::default()))
    };
    let many = read(header(131_072));
    assert!(many.contains("aaa0") || many.contains("too long"), "{many}");
    let more = read(header(1 << 40));
    assert!(more.contains("1099511627776 files of values") && more.contains("131072"), "{more}");
    let long = read(header(10).replace("file: a", &format!("file: {}", "b".repeat(2000))));
    assert!(long.contains("a name of at most 1024 bytes") && long.len() < 400, "{long}");
    let grown = peak() - before;
    assert!(grown < 96 << 20, "names of files reserved {grown} bytes");
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

/// Honest headers over packed zeros, of far more bytes than so few should become.
fn bombs() -> [(&'static str, Vec<u8>); 4] {
    let header = |size: &str, encoding: &str| {
        format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {size}\nencoding: {encoding}\n").into_bytes()
    };
    // Both formats are read as many streams, one after the other.
    let block = vec![0; 1 << 24];
    let mut packed = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    packed.write_all(&block).unwrap();
    let (bzip2, gzip) = (packed.finish().unwrap().repeat(64), gzip(&block).repeat(64));
    // What is skipped is decoded, too.
    let skip = [&header("1 1 1", "bzip2")[..], b"byte skip: 1073741823\n\n", &bzip2].concat();
    [
        ("bzip2.nrrd", [&header("1024 1024 1024", "bzip2")[..], b"\n", &bzip2].concat()),
        ("gzip.nrrd", [&header("1024 1024 1024", "gzip")[..], b"\n", &gzip].concat()),
        ("skip.nrrd", skip),
        ("a.nii.gz", packed_nifti(&gzip)),
    ]
}

/// A header of its own, and what follows it.
fn packed_nifti(zeros: &[u8]) -> Vec<u8> {
    let header = Header::new(2, false).dim(&[3, 1 << 29, 1, 1]);
    [gzip(&header.bytes), zeros.to_vec()].concat()
}
