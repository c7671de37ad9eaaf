//! NRRD headers as the format's definition and other programs write them.

use crate::common::{gzip, load, message, stored, texts};
use glam::DVec3;
use pellucid_field::{VoxelType, Warning};
use pellucid_io::{IoError, ReadOptions, read, read_bytes};

/// A header with its data after the empty line.
fn attached(header: &str, data: &[u8]) -> Vec<u8> {
    [header.as_bytes(), b"\n", data].concat()
}

fn grid_of(header: &str) -> pellucid_field::Grid {
    *load("v.nrrd", attached(header, &[0; 64])).unwrap().volume.grid()
}

/// The minimal header of the documentation ("Axis ordering, and a minimalist header").
#[test]
fn the_minimal_header_is_read() {
    let header = "NRRD0001\ntype: unsigned char\ndimension: 2\nsizes: 4 3\nencoding: raw\n";
    let loaded = load("v.nrrd", attached(header, b"WYXWYWVUVUUS")).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [4, 3, 1]);
    assert_eq!(loaded.volume.grid().spacing(), [1.0; 3]);
    assert_eq!(stored(&loaded.volume), b"WYXWYWVUVUUS".map(f64::from));
    assert_eq!(loaded.warnings, []);
}

#[test]
fn every_spelling_of_a_type_is_known() {
    let spellings = [
        (VoxelType::I8, "signed char, int8, int8_t"),
        (VoxelType::U8, "uchar, unsigned char, uint8, uint8_t"),
        (VoxelType::I16, "short, short int, signed short, signed short int, int16, int16_t"),
        (VoxelType::U16, "ushort, unsigned short, unsigned short int, uint16, uint16_t"),
        (VoxelType::I32, "int, signed int, int32, int32_t"),
        (VoxelType::U32, "uint, unsigned int, uint32, uint32_t"),
        (VoxelType::F32, "float"),
        (VoxelType::I32, "longlong, long long, long long int, signed long long, signed long long int, int64, int64_t"),
        (VoxelType::I32, "ulonglong, unsigned long long, unsigned long long int, uint64, uint64_t"),
        (VoxelType::F32, "double"),
    ];
    for (expected, names) in spellings {
        for name in names.split(", ") {
            let header = format!("NRRD0004\ntype: {name}\ndimension: 1\nsizes: 2\nendian: little\nencoding: raw\n");
            let loaded = load("v.nrrd", attached(&header, &[0; 16])).unwrap();
            assert_eq!(loaded.volume.voxels().voxel_type(), expected, "{name}");
        }
    }
}

#[test]
fn every_encoding_and_byte_order_gives_the_same_values() {
    use std::io::Write;
    let values = [1i16, -2, 300, i16::MIN, i16::MAX, 0];
    let little: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let big: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    let hex: String = little.iter().map(|byte| format!("{byte:02X}\n")).collect();
    let mut bzip2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    bzip2.write_all(&big).unwrap();
    // Two members, as `cat a.gz b.gz` makes, and padding after them.
    let members = [gzip(&little[..5]), gzip(&little[5..]), vec![0; 7]].concat();
    for (encoding, endian, data) in [
        ("raw", "little", little.clone()),
        ("raw", "big", big.clone()),
        ("gzip", "little", gzip(&little)),
        ("gz", "big", gzip(&big)),
        ("gzip", "little", members),
        ("bzip2", "big", bzip2.finish().unwrap()),
        ("hex", "little", hex.into_bytes()),
        ("ascii", "big", b" 1 -2\n300,-32768\t32767 , 0\n".to_vec()),
        ("text", "little", b"1 -2 300 -32768 32767 0".to_vec()),
    ] {
        let header = format!(
            "NRRD0004\r\n# comment\r\ntype: int16\r\ndimension: 3\r\nsizes: 3 1 2\r\n\
             endian: {endian}\r\nencoding: {encoding}\r\nkey:=value: with colon\r\n\r"
        );
        let loaded = load("v.nrrd", attached(&header, &data)).unwrap();
        assert_eq!(stored(&loaded.volume), values.map(f64::from), "{encoding} {endian}");
        assert_eq!(loaded.warnings, [], "{encoding} {endian}");
    }
}

#[test]
fn text_holds_what_floats_can_be() {
    let header = "NRRD0004\ntype: float\ndimension: 1\nsizes: 5\nencoding: ascii\n";
    let loaded = load("v.nrrd", attached(header, b"1.5e-3 nan -inf +2 .5")).unwrap();
    let found = stored(&loaded.volume);
    assert_eq!((found[0] as f32, found[2], found[3], found[4]), (1.5e-3, f64::NEG_INFINITY, 2.0, 0.5));
    assert!(found[1].is_nan());
    assert_eq!(loaded.warnings, [Warning::NotFinite { nan: 1, infinite: 1 }]);
}

const RAW: &str = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";

/// One sample 10 mm to the right, 20 to the front, 30 up, in every frame there is.
#[test]
fn frames_land_in_lps_millimetres() {
    for (space, origin, unit) in [
        ("right-anterior-superior", "(10,20,30)", ""),
        ("RAS", "(10,20,30)", "mm"),
        ("left-anterior-superior", "(-10,20,30)", "mm"),
        ("LPS", "(-1,-2,3)", "cm"),
        ("left-posterior-superior", "(-0.01,-0.02,0.03)", "m"),
        ("LAS", "(-10000,20000,30000)", "um"),
    ] {
        let units =
            if unit.is_empty() { String::new() } else { format!("space units: \"{unit}\" \"{unit}\" \"{unit}\"\n") };
        let header =
            format!("{RAW}space: {space}\nspace origin: {origin}\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n{units}");
        let loaded = load("v.nrrd", attached(&header, &[0; 8])).unwrap();
        let first = loaded.volume.grid().world_from_index().translation;
        assert!(first.distance(DVec3::new(-10.0, -20.0, 30.0)) < 1e-9, "{space}: {first}");
        assert_eq!(loaded.volume.length_unit.as_deref(), Some("mm"), "{space}");
    }
}

#[test]
fn without_a_frame_positions_stay_as_they_are() {
    let header = format!(
        "{RAW}space dimension: 3\nspace origin: (10, 20 ,30)\nspace directions: (2,0,0) ( 0,0,3 ) (0,4,0)\nspace units: \"um\" \"um\" \"um\"\n"
    );
    let loaded = load("v.nrrd", attached(&header, &[0; 8])).unwrap();
    let affine = loaded.volume.grid().world_from_index();
    assert_eq!(affine.transform_point3(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(12.0, 24.0, 33.0));
    assert_eq!(loaded.volume.length_unit.as_deref(), Some("um"));
}

#[test]
fn a_left_handed_space_is_mirrored_with_a_warning() {
    let header = format!("{RAW}space: 3D-left-handed\nspace directions: (1,0,0) (0,1,0) (0,0,2)\n");
    let loaded = load("v.nrrd", attached(&header, &[0; 8])).unwrap();
    assert_eq!(loaded.volume.grid().world_from_index().matrix3.z_axis, DVec3::new(0.0, 0.0, -2.0));
    assert!(texts(&loaded.warnings)[0].contains("left-handed"));
}

#[test]
fn spacings_minima_and_centres_place_samples() {
    let grid = grid_of(&format!("{RAW}spacings: 1 0.5 -2\n"));
    assert_eq!(grid.world_from_index().transform_point3(DVec3::ONE), DVec3::new(1.0, 0.5, -2.0));
    // A cell of width 4 from 0 to 8 in two: samples at 2 and 6. Nodes: at 0 and 8.
    let grid = grid_of(&format!("{RAW}axis mins: 0 0 nan\naxismaxs: 8 8 nan\ncenterings: cell node ???\n"));
    let affine = grid.world_from_index();
    assert_eq!(affine.translation, DVec3::new(2.0, 0.0, 0.0));
    assert_eq!(affine.transform_point3(DVec3::ONE), DVec3::new(6.0, 8.0, 1.0));
    // A slice in space gets a third direction of its own.
    let header = "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 2 2\nencoding: raw\nspace dimension: 3\nspace directions: (0,2,0) (0,0,4)\n";
    assert_eq!(grid_of(header).world_from_index().matrix3.z_axis, DVec3::new(3.0, 0.0, 0.0));
}

#[test]
fn components_come_first_or_last_and_time_is_chosen() {
    let header = |kinds: &str, sizes: &str| {
        format!("NRRD0004\ntype: uint8\ndimension: 4\nsizes: {sizes}\nencoding: raw\nkinds: {kinds}\n")
    };
    let data: Vec<u8> = (0..24).collect();
    let read = |header: &str, time| {
        let options = ReadOptions { time, ..Default::default() };
        read_bytes("v.nrrd", attached(header, &data), &options)
    };
    let rgb = read(&header("RGB-color domain domain domain", "3 2 2 2"), 0).unwrap().volume;
    assert_eq!((rgb.components(), rgb.value([1, 1, 1], 2)), (3, 23.0));
    let planar = read(&header("domain domain domain vector", "2 2 2 3"), 0).unwrap().volume;
    assert_eq!((planar.components(), planar.value([1, 0, 1], 2)), (3, 16.0 + 5.0));
    let series = header("domain domain domain time", "2 2 2 3");
    let first = read(&series, 0).unwrap();
    assert!(texts(&first.warnings)[0].contains("3 time points"), "{:?}", first.warnings);
    assert_eq!(stored(&read(&series, 2).unwrap().volume), [16., 17., 18., 19., 20., 21., 22., 23.]);
    let error = read(&series, 3).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("time point 3") && error.contains("has 3"), "{error}");
    let error = read(&header("domain vector domain domain", "2 3 2 2"), 0).map(|_| ()).unwrap_err();
    assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
    let five =
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 6 2 2 1\nencoding: raw\nkinds: vector domain domain domain\n";
    assert!(read(five, 0).map(|_| ()).unwrap_err().to_string().contains("6 components"));
    // "none" for a direction says the same as a kind.
    let slicer = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\nencoding: raw\nspace: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: vector domain domain domain\n";
    assert_eq!(read(slicer, 0).unwrap().volume.components(), 3);
}

#[test]
fn detached_data_are_found_in_every_way_of_naming_them() {
    let folder = tempfile::tempdir().unwrap();
    let data: Vec<u8> = (0..8).collect();
    let file = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    file("whole.raw", &data);
    file("with header.raw", &[b"P5\n2 4\n255\nxyz".as_slice(), &data].concat());
    file("packed.raw.gz", &gzip(&[b"skip".as_slice(), &data].concat()));
    for (k, slice) in data.chunks(4).enumerate() {
        file(&format!("slice{:03}.raw", 7 + k), slice);
        file(&format!("z{}.raw", 3 - 2 * k as i64), slice);
    }
    let base = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n";
    for fields in [
        "encoding: raw\ndata file: whole.raw\n",
        "encoding: raw\ndatafile: ./whole.raw\n\n",
        "encoding: raw\nline skip: 3\nbyte skip: 3\ndata file: with header.raw\n",
        "encoding: raw\nbyte skip: -1\ndata file: with header.raw\n",
        "encoding: gzip\nbyte skip: 4\ndata file: packed.raw.gz\n",
        "encoding: raw\ndata file: LIST\nslice007.raw\nslice008.raw\n",
        "encoding: raw\ndata file: LIST 2\nslice007.raw\r\nslice008.raw",
        "encoding: raw\ndata file: slice%03d.raw 7 8 1\n",
        "encoding: raw\ndata file: slice%03d.raw 7 8 1 2\n",
        "encoding: raw\ndata file: ./z%d.raw 3 1 -2\n",
    ] {
        let path = folder.path().join("v.nhdr");
        std::fs::write(&path, format!("{base}{fields}")).unwrap();
        let loaded = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{fields}: {error}"));
        assert_eq!(stored(&loaded.volume), [0., 1., 2., 3., 4., 5., 6., 7.], "{fields}");
        assert_eq!(loaded.warnings, [], "{fields}");
    }
    let fails = |fields: &str| {
        let path = folder.path().join("v.nhdr");
        std::fs::write(&path, format!("{base}{fields}")).unwrap();
        message(read(&path, &ReadOptions::default()))
    };
    assert!(fails("encoding: raw\ndata file: absent.raw\n").contains("absent.raw"));
    assert!(fails("encoding: raw\ndata file: LIST\n").contains("number of data files' is '0'"));
    assert!(fails("encoding: raw\ndata file: slice%03d.raw 7 9 1\n").contains("number of data files' is '3'"));
    assert!(fails("encoding: raw\ndata file: z%d.raw 0 999999999999 1\n").contains("limits.files"));
    assert!(fails("encoding: raw\n").contains("'data file' is missing"));
    let short = fails("encoding: raw\ndata file: slice007.raw\n");
    assert!(short.contains("slice007.raw") && short.contains("4 bytes") && short.contains("expected 8"), "{short}");
}

/// One line that names file, field, what was found and what was expected.
#[test]
fn messages_are_exact() {
    let fails = |header: &str| message(load("engine.nrrd", attached(header, &[0; 8])));
    assert_eq!(
        fails("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 256 256\nencoding: raw\n"),
        "engine.nrrd: field 'sizes' is '256 256', expected 3 values to match 'dimension: 3'"
    );
    assert_eq!(
        fails("NRRD0004\ntype: int16\ndimension: 1\nsizes: 4\nencoding: raw\n"),
        "engine.nrrd: field 'endian' is missing, expected 'little' or 'big' for values of several bytes"
    );
    assert_eq!(fails("NRRD0009\n"), "engine.nrrd: field 'magic' is 'NRRD0009', expected NRRD0001 to NRRD0005");
    assert_eq!(fails(&RAW.replace("2 2 2", "2 2 9")), "engine.nrrd: the part with the values has 8 bytes, expected 36");
    for (field, expected) in [
        ("sizes: 2 2 2\n", "only once"),
        ("space: sideways\n", "space"),
        ("space directions: (1,0,0) (0,1,0) (0,0,1)\n", "'space' or 'space dimension'"),
        ("space: RAS\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n", "singular"),
        ("space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,nan)\n", "not finite"),
        ("space: RAS\nspace directions: (1,0,0) (0,1,0)\n", "3 vectors"),
        ("space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1\n", "vectors of 3 numbers"),
        ("spacings: 1 0 1\n", "singular"),
        ("endian: middle\n", "little or big"),
        ("byte skip: -2\n", "0 or more"),
        ("kinds: domain domain\n", "3 values"),
        ("nonsense\n", "'field: value'"),
    ] {
        let text = fails(&format!("{RAW}{field}"));
        assert!(text.starts_with("engine.nrrd: ") && text.contains(expected) && !text.contains('\n'), "{text}");
    }
}

#[test]
fn what_is_ignored_is_said() {
    let header = format!("{RAW}old min: 0\nold max: 1\ninvented: 3\ncontent: a thing\n");
    let loaded = load("v.nrrd", attached(&header, &[0; 11])).unwrap();
    let texts = texts(&loaded.warnings).join("\n");
    for part in ["old min", "old max", "'invented'", "3 bytes after the values"] {
        assert!(texts.contains(part), "{texts}");
    }
}

#[test]
fn wide_types_are_narrowed_with_the_error_they_suffer() {
    let read = |name: &str, data: Vec<u8>| {
        let header = format!("NRRD0004\ntype: {name}\ndimension: 1\nsizes: 2\nendian: big\nencoding: raw\n");
        load("v.nrrd", attached(&header, &data)).unwrap()
    };
    let bytes = |a: i64, b: i64| [a.to_be_bytes(), b.to_be_bytes()].concat();
    let converted = |from: &str, to, largest_error| [Warning::Converted { from: from.to_owned(), to, largest_error }];

    let loaded = read("int64", bytes(i32::MIN.into(), i32::MAX.into()));
    assert_eq!(loaded.warnings, converted("i64", VoxelType::I32, 0.0));
    assert_eq!(stored(&loaded.volume), [f64::from(i32::MIN), f64::from(i32::MAX)]);
    let loaded = read("int64", bytes(0, u32::MAX.into()));
    assert_eq!(loaded.warnings, converted("i64", VoxelType::U32, 0.0));
    // Singles near 2^40 are 2^17 apart: the nearest to this one is 2^40 itself.
    let loaded = read("int64", bytes(-5, (1 << 40) + (1 << 15) + 1));
    assert_eq!(loaded.warnings, converted("i64", VoxelType::F32, 32769.0));
    let loaded = read("uint64", bytes(-1, 0));
    assert_eq!(loaded.warnings, converted("u64", VoxelType::F32, 1.0));
    assert_eq!(stored(&loaded.volume), [18446744073709551616.0, 0.0]);

    // Identifiers that differ by less than 2^32 count from the smallest: no two of them become one.
    for first in [1i64 << 33, (1 << 52) + 12345, -(1 << 40)] {
        let ids = [first + 7, first + 8];
        let loaded = read("int64", bytes(ids[0], ids[1]));
        assert_eq!(loaded.warnings, converted("i64", VoxelType::U32, 0.0));
        let values = [0, 1].map(|x| loaded.volume.value([x, 0, 0], 0));
        assert_eq!(values, ids.map(|id| id as f64));
        assert_eq!(loaded.volume.statistics().mean, ids[0] as f64 + 0.5);
    }
    // Data values are doubles, which have every other number here.
    let loaded = read("uint64", bytes((1 << 53) + 1, (1 << 53) + 2));
    assert_eq!(loaded.warnings, converted("u64", VoxelType::U32, 1.0));

    let doubles = [0.1f64.to_be_bytes(), (-2.5f64).to_be_bytes()].concat();
    let error = f64::from(0.1f32) - 0.1;
    assert_eq!(read("double", doubles).warnings, converted("f64", VoxelType::F32, error));
    // Doubles that are far from 0 for what they differ by count from the smallest.
    for far in [[1e9 + 30.0, 1e9 + 100.0], [-1e15 + 100.125, -1e15 + 30.0], [2_451_545.000_25, 2_451_545.000_75]] {
        let loaded = read("double", far.map(f64::to_be_bytes).concat());
        let [Warning::Converted { largest_error, .. }] = loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert!(largest_error <= (far[1] - far[0]).abs() * 1e-6, "{far:?}: {largest_error}");
        for (x, value) in far.into_iter().enumerate() {
            let found = loaded.volume.value([x, 0, 0], 0);
            assert!((found - value).abs() <= largest_error, "{value}: {found}");
        }
    }
}
