//! MetaImage headers as the MetaIO documentation and ITK write them.

use crate::common::{load, message, stored, texts};
use glam::DVec3;
use pellucid_field::{Grid, ValueMap, Volume, VoxelType};
use pellucid_io::{ReadOptions, WriteOptions, read, read_bytes, write};

fn zlib(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The minimum of the documentation: dims, spacing, type, and local data.
#[test]
fn the_minimal_header_is_read() {
    let header = "NDims = 3\nDimSize = 2 1 2\nElementSpacing = 0.55 0.57 1.0\nElementType = MET_USHORT\n\
                  ElementByteOrderMSB = False\nElementDataFile = LOCAL\n";
    let loaded = load("no-extension", [header.as_bytes(), &[1, 0, 2, 0, 3, 0, 0, 1]].concat()).unwrap();
    assert_eq!(stored(&loaded.volume), [1., 2., 3., 256.]);
    assert_eq!(loaded.volume.grid().spacing(), [0.55, 0.57, 1.0]);
    assert_eq!((loaded.volume.length_unit, loaded.warnings), (None, vec![]));
}

/// As ITK writes it: the matrix lists the direction of each axis of the image in turn.
#[test]
fn directions_offset_and_byte_order() {
    let header = "ObjectType = Image\r\nNDims = 3\r\nBinaryData = True\r\nBinaryDataByteOrderMSB = True\r\n\
        CompressedData = False\r\nTransformMatrix = 0 1 0 -1 0 0 0 0 -1\r\nOffset = 10 20 30\r\n\
        CenterOfRotation = 0 0 0\r\nAnatomicalOrientation = RAI\r\nElementSpacing = 2 3 4\r\nDimSize = 2 1 2\r\n\
        ElementType = MET_SHORT\r\nElementDataFile = LOCAL\r\n";
    let loaded = load("a.mha", [header.as_bytes(), &[0, 1, 0xff, 0xff, 0, 3, 4, 0]].concat()).unwrap();
    assert_eq!(stored(&loaded.volume), [1., -1., 3., 1024.]);
    let affine = loaded.volume.grid().world_from_index();
    assert_eq!(affine.translation, DVec3::new(10.0, 20.0, 30.0));
    assert_eq!(affine.matrix3.x_axis, DVec3::new(0.0, 2.0, 0.0));
    assert_eq!(affine.matrix3.y_axis, DVec3::new(-3.0, 0.0, 0.0));
    assert_eq!(affine.matrix3.z_axis, DVec3::new(0.0, 0.0, -4.0));
    assert_eq!(loaded.volume.length_unit.as_deref(), Some("mm"));
}

#[test]
fn types_channels_units_and_slopes() {
    let base = "NDims = 2\nDimSize = 2 1\nElementType = TYPE\nEXTRA\nElementDataFile = LOCAL\n";
    let read = |kind: &str, extra: &str| {
        let header = base.replace("TYPE", kind).replace("EXTRA", extra);
        load("a.mha", [header.as_bytes(), &[0; 64]].concat()).unwrap()
    };
    for (name, expected) in [
        ("MET_CHAR", VoxelType::I8),
        ("MET_UCHAR", VoxelType::U8),
        ("MET_SHORT", VoxelType::I16),
        ("MET_USHORT", VoxelType::U16),
        ("MET_INT", VoxelType::I32),
        ("MET_LONG", VoxelType::I32),
        ("MET_UINT", VoxelType::U32),
        ("MET_LONG_LONG", VoxelType::I32),
        ("MET_ULONG_LONG", VoxelType::I32),
        ("MET_FLOAT", VoxelType::F32),
        ("MET_DOUBLE", VoxelType::F32),
        ("MET_UCHAR_ARRAY", VoxelType::U8),
    ] {
        assert_eq!(read(name, "").volume.voxels().voxel_type(), expected, "{name}");
    }
    let loaded = read("MET_UCHAR", "ElementNumberOfChannels = 3");
    assert_eq!((loaded.volume.components(), loaded.volume.grid().dims()), (3, [2, 1, 1]));
    let loaded = read("MET_UCHAR", "ElementSpacing = 2 3\nOffset = 1 0\nDistanceUnits = cm");
    let affine = loaded.volume.grid().world_from_index();
    assert_eq!(affine.transform_point3(DVec3::ONE), DVec3::new(30.0, 30.0, 25.0));
    let loaded = read("MET_SHORT", "ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -3");
    assert_eq!(loaded.volume.value_map(), ValueMap { scale: 2.0, offset: -3.0 });
    let loaded = read("MET_SHORT", "CenterOfRotation = 1 2");
    assert!(texts(&loaded.warnings).join("\n").contains("CenterOfRotation"));
}

#[test]
fn data_are_found_in_every_way_of_naming_them() {
    let folder = tempfile::tempdir().unwrap();
    let data: Vec<u8> = (0..8).collect();
    let file = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    file("whole.raw", &data);
    file("with header.raw", &[b"header".as_slice(), &data].concat());
    file("packed.zraw", &zlib(&data));
    file("packed.gz", &crate::common::gzip(&data));
    file("ascii.txt", b"0 1 2 3\n4 5 6 7\n");
    for (k, slice) in data.chunks(4).enumerate() {
        file(&format!("slice{k:02}.raw"), slice);
    }
    let path = folder.path().join("v.mhd");
    let describe = |tags: &str| {
        std::fs::write(&path, format!("NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n{tags}")).unwrap();
        read(&path, &ReadOptions::default())
    };
    for tags in [
        "ElementDataFile = whole.raw\n",
        "HeaderSize = 6\nElementDataFile = with header.raw\n",
        "HeaderSize = -1\nElementDataFile = with header.raw\n",
        "CompressedData = True\nElementDataFile = packed.zraw\n",
        "CompressedData = True\nElementDataFile = packed.gz\n",
        "BinaryData = False\nElementDataFile = ascii.txt\n",
        "ElementDataFile = LIST\nslice00.raw\nslice01.raw\n\n",
        "ElementDataFile = LIST 2D\r\nslice00.raw\r\nslice01.raw",
        "ElementDataFile = slice%02d.raw 0 1 1\n",
    ] {
        let loaded = describe(tags).unwrap_or_else(|error| panic!("{tags}: {error}"));
        assert_eq!(stored(&loaded.volume), [0., 1., 2., 3., 4., 5., 6., 7.], "{tags}");
        assert_eq!(loaded.warnings, [], "{tags}");
    }
    assert!(message(describe("ElementDataFile = absent.raw\n")).contains("absent.raw"));
    assert!(message(describe("ElementDataFile = slice%02d.raw 1 0 1\n")).contains("ElementDataFile"));
    assert!(message(describe("HeaderSize = -2\nElementDataFile = whole.raw\n")).contains("HeaderSize"));
    assert!(message(describe("")).contains("'ElementDataFile' is missing"));
}

#[test]
fn time_points_are_chosen() {
    let header =
        "NDims = 4\nDimSize = 2 1 1 3\nElementSpacing = 1 1 2 5\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    let file = [header.as_bytes(), &[0, 1, 2, 3, 4, 5]].concat();
    let loaded = read_bytes("a.mha", file, &ReadOptions { time: 1, ..Default::default() }).unwrap();
    assert_eq!(stored(&loaded.volume), [2.0, 3.0]);
    assert!(texts(&loaded.warnings)[0].contains("3 time points"));
}

#[test]
fn messages_are_exact() {
    let fails = |header: &str| message(load("a.mha", header));
    assert_eq!(
        fails("NDims = 3\nDimSize = 256 256\n"),
        "a.mha: field 'DimSize' is '256 256', expected 3 values to match 'NDims = 3'"
    );
    assert_eq!(
        fails("NDims = 3\n"),
        "a.mha: field 'DimSize' is missing, expected the number of voxels along each axis"
    );
    assert_eq!(fails("ObjectType = Tube\nNDims = 3\n"), "a.mha: field 'ObjectType' is 'Tube', expected Image");
    assert!(fails("NDims = 7\n").contains("NDims 7 is not supported"));
    assert!(fails("NDims = 2\nDimSize = 0 1\n").contains("at least 1 voxel"));
    assert!(fails("NDims = 2\nDimSize = 1 1\nElementType = MET_STRING\n").contains("MET_STRING"));
    assert!(fails("NDims\n").contains("'tag = value'"));
}

/// MetaIO cannot unpack local data without the size that the header states.
#[test]
fn the_size_of_packed_data_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume::new(Grid::new([40, 30, 20]).unwrap(), vec![7u8; 24_000]).unwrap();
    let options = WriteOptions { compression: Some(6), ..Default::default() };
    for (name, data_name) in [("v.mha", "v.mha"), ("v.mhd", "v.mhd.zraw")] {
        write(folder.path().join(name), &volume, &options).unwrap();
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let stated = text.lines().find_map(|line| line.strip_prefix("CompressedDataSize = ")).unwrap();
        let data = std::fs::read(folder.path().join(data_name)).unwrap();
        let start = if name == data_name {
            let tag = b"LOCAL\n";
            data.windows(tag.len()).position(|window| window == tag).unwrap() + tag.len()
        } else {
            0
        };
        assert_eq!(stated.trim().parse(), Ok(data.len() - start), "{name}");
    }
}
