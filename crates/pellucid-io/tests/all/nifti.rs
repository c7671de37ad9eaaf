//! NIfTI files assembled at the standard's offsets, and its rules of precedence.

use crate::common::nifti::Header;
use crate::common::{gzip, load, message, stored, texts};
use glam::{DVec3, DVec4};
use pellucid_field::{ValueMap, VoxelType, Warning};
use pellucid_io::{IoError, ReadOptions, read, read_bytes};

const VARIANTS: [(u8, bool); 4] = [(1, false), (1, true), (2, false), (2, true)];

const SFORM: [[f64; 4]; 3] = [[-2.0, 0.0, 0.5, 90.0], [0.0, 3.0, 0.0, -126.0], [0.25, 0.0, 4.0, -72.0]];

/// LPS of an index by the standard's formula, the other way round in x and y.
fn lps(rows: [[f64; 4]; 3], index: DVec3) -> DVec3 {
    let point = DVec4::new(index.x, index.y, index.z, 1.0);
    let ras = rows.map(|row| DVec4::from_array(row).dot(point));
    DVec3::new(-ras[0], -ras[1], ras[2])
}

#[test]
fn both_versions_in_both_byte_orders_packed_and_plain() {
    for (version, big) in VARIANTS {
        let header = Header::new(version, big).sform(1, SFORM).slope(0.5, -1024.0);
        let file = header.with_counting(12);
        for (name, bytes) in [("a.nii", file.clone()), ("a.nii.gz", gzip(&file)), ("nameless", file)] {
            let loaded = load(name, bytes).unwrap();
            assert_eq!(loaded.warnings, [], "version {version}, big {big}, {name}");
            let volume = loaded.volume;
            assert_eq!(volume.grid().dims(), [2, 3, 2]);
            assert_eq!(volume.voxels().voxel_type(), VoxelType::I16);
            assert_eq!(stored(&volume), (0..12).map(f64::from).collect::<Vec<_>>());
            assert_eq!(volume.value_map(), ValueMap { scale: 0.5, offset: -1024.0 });
            assert_eq!(volume.length_unit.as_deref(), Some("mm"));
            for index in [DVec3::ZERO, DVec3::new(1.0, 2.0, 1.0)] {
                let found = volume.grid().world_from_index().transform_point3(index);
                assert_eq!(found, lps(SFORM, index));
            }
        }
    }
}

/// s-form before q-form before voxel sizes.
#[test]
fn the_standard_precedence_holds() {
    for (version, big) in VARIANTS {
        let sized = || Header::new(version, big).pixdim(&[-1.0, 2.0, 3.0, 4.0, 1.0, 1.0, 1.0, 1.0]);
        let affine = |header: Header| {
            let loaded = load("a.nii", header.with_counting(12)).unwrap();
            (loaded.volume.grid().world_from_index(), texts(&loaded.warnings).join("\n"))
        };
        // A quarter turn about z, cos 45 = sin 45 = sqrt(1/2), with the third axis mirrored:
        // index (1,0,0) goes along +y of RAS, (0,1,0) along -x, (0,0,1) along -z.
        let turn = [0.0, 0.0, 0.5f64.sqrt()];
        let q = || sized().qform(1, turn, [10.0, 20.0, 30.0]);
        let (found, warnings) = affine(q());
        assert_eq!(warnings, "");
        let close = |a: DVec3, b: DVec3| assert!(a.distance(b) < 2e-6, "{a} is not {b}");
        close(found.translation, DVec3::new(-10.0, -20.0, 30.0));
        close(found.matrix3.x_axis, DVec3::new(0.0, -2.0, 0.0));
        close(found.matrix3.y_axis, DVec3::new(3.0, 0.0, 0.0));
        close(found.matrix3.z_axis, DVec3::new(0.0, 0.0, -4.0));
        // A half turn about x has a = 0, whichever way b is rounded.
        let (half, _) = affine(sized().qform(2, [1.000_000_1, 0.0, 0.0], [0.0; 3]));
        close(half.matrix3.y_axis, DVec3::new(0.0, 3.0, 0.0));
        close(half.matrix3.z_axis, DVec3::new(0.0, 0.0, 4.0));

        let (found, _) = affine(q().sform(4, SFORM));
        assert_eq!(found.transform_point3(DVec3::ONE), lps(SFORM, DVec3::ONE));
        let (found, _) = affine(q().sform(0, SFORM));
        close(found.translation, DVec3::new(-10.0, -20.0, 30.0));
        // Method 1: sizes only, no frame, no place; pixdim[0] has no meaning.
        let (found, warnings) = affine(sized());
        assert_eq!(found.transform_point3(DVec3::ONE), DVec3::new(2.0, 3.0, 4.0));
        assert!(warnings.contains("not known"), "{warnings}");
    }
}

#[test]
fn lengths_become_millimetres() {
    for (code, scale, unit) in [
        (1, 1000.0, Some("mm")),
        (2, 1.0, Some("mm")),
        (3, 0.001, Some("mm")),
        (0, 1.0, None),
        (8 + 2, 1.0, Some("mm")),
    ] {
        let file = Header::new(1, false).sform(1, SFORM).units(code).with_counting(12);
        let volume = load("a.nii", file).unwrap().volume;
        let found = volume.grid().world_from_index().translation;
        assert!(found.distance(lps(SFORM, DVec3::ZERO) * scale) < 1e-9 * scale, "{code}: {found}");
        assert_eq!(volume.length_unit.as_deref(), unit);
    }
}

#[test]
fn slopes_of_zero_and_nan_mean_none() {
    for (slope, inter, expected) in [
        (0.0, 5.0, ValueMap::IDENTITY),
        (f64::NAN, 5.0, ValueMap::IDENTITY),
        (1.0, 0.0, ValueMap::IDENTITY),
        (2.0, f64::NAN, ValueMap { scale: 2.0, offset: 0.0 }),
        (-2.0, 3.0, ValueMap { scale: -2.0, offset: 3.0 }),
    ] {
        let volume = load("a.nii", Header::new(2, false).slope(slope, inter).with_counting(12)).unwrap().volume;
        assert_eq!(volume.value_map(), expected, "{slope} {inter}");
    }
}

#[test]
fn every_datatype_of_the_standard_is_read_or_refused_by_name() {
    for (code, bits, expected, components) in [
        (2, 8, VoxelType::U8, 1),
        (4, 16, VoxelType::I16, 1),
        (8, 32, VoxelType::I32, 1),
        (16, 32, VoxelType::F32, 1),
        (64, 64, VoxelType::F32, 1),
        (128, 24, VoxelType::U8, 3),
        (256, 8, VoxelType::I8, 1),
        (512, 16, VoxelType::U16, 1),
        (768, 32, VoxelType::U32, 1),
        (1024, 64, VoxelType::I32, 1),
        (1280, 64, VoxelType::I32, 1),
        (2304, 32, VoxelType::U8, 4),
    ] {
        let file = Header::new(1, true).datatype(code, bits).with(&vec![0; 12 * bits as usize / 8]);
        let volume = load("a.nii", file).unwrap().volume;
        assert_eq!((volume.voxels().voxel_type(), volume.components()), (expected, components), "{code}");
    }
    for (code, name) in
        [(1, "binary"), (32, "complex64"), (1536, "float128"), (1792, "complex128"), (2048, "complex256"), (77, "77")]
    {
        let error = message(load("a.nii", Header::new(1, false).datatype(code, 8).with_counting(99)));
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn values_of_every_size_are_read_in_both_byte_orders() {
    for big in [false, true] {
        let order = |little: &[u8]| {
            let mut bytes = little.to_vec();
            if big {
                bytes.reverse();
            }
            bytes.repeat(12)
        };
        for (code, bits, data, value) in [
            (512, 16, order(&0x1234u16.to_le_bytes()), f64::from(0x1234)),
            (8, 32, order(&(-123_456_789i32).to_le_bytes()), -123_456_789.0),
            (16, 32, order(&(-1.5e-3f32).to_le_bytes()), f64::from(-1.5e-3f32)),
            (64, 64, order(&(-0.125f64).to_le_bytes()), -0.125),
            (1024, 64, order(&(-123_456_789i64).to_le_bytes()), -123_456_789.0),
        ] {
            let file = Header::new(2, big).datatype(code, bits).with(&data);
            for file in [gzip(&file), file] {
                assert_eq!(stored(&load("a.nii", file).unwrap().volume), [value; 12], "{code}, big {big}");
            }
        }
    }
}

/// What narrowing costs is told in data values, not in stored ones.
#[test]
fn conversion_errors_are_in_data_values() {
    let data: Vec<u8> = (0..12).flat_map(|_| 0.1f64.to_le_bytes()).collect();
    let loaded = load("a.nii", Header::new(2, false).datatype(64, 64).slope(-8.0, 3.0).with(&data)).unwrap();
    let largest_error = 8.0 * (f64::from(0.1f32) - 0.1);
    let expected = Warning::Converted { from: "f64".into(), to: VoxelType::F32, largest_error };
    assert!(loaded.warnings.contains(&expected), "{:?}", loaded.warnings);
}

/// Colours are interleaved, vectors along the fifth axis are planar.
#[test]
fn components_are_interleaved() {
    let data: Vec<u8> = (0..36).collect();
    let rgb = load("a.nii", Header::new(1, false).datatype(128, 24).slope(7.0, 1.0).with(&data)).unwrap().volume;
    assert_eq!(rgb.value([1, 2, 1], 2), 35.0);
    let vector = Header::new(1, false).dim(&[5, 2, 3, 2, 1, 3, 1, 1]).datatype(2, 8).with(&data);
    let vector = load("a.nii", vector).unwrap().volume;
    assert_eq!(vector.components(), 3);
    assert_eq!(vector.value([1, 0, 0], 2), 24.0 + 1.0);
}

#[test]
fn time_points_are_chosen() {
    for (version, big) in VARIANTS {
        for packed in [false, true] {
            let file = Header::new(version, big).dim(&[4, 2, 3, 2, 5, 1, 1, 1]).with_counting(60);
            let file = if packed { gzip(&file) } else { file };
            let at = |time| read_bytes("a.nii", file.clone(), &ReadOptions { time, ..Default::default() });
            let loaded = at(3).unwrap();
            assert_eq!(stored(&loaded.volume)[0], 36.0);
            assert!(texts(&loaded.warnings).join("\n").contains("5 time points"), "{:?}", loaded.warnings);
            let error = at(5).map(|_| ()).unwrap_err();
            assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
        }
    }
}

#[test]
fn extensions_are_skipped_and_odd_offsets_are_read() {
    let mut header = Header::new(1, false).vox_offset(369.0);
    header.bytes.extend([7; 17]);
    assert_eq!(stored(&load("a.nii", header.with_counting(12)).unwrap().volume)[11], 11.0);
    let loaded = load("a.nii", Header::new(1, false).vox_offset(0.0).with_counting(12)).unwrap();
    assert_eq!(stored(&loaded.volume)[11], 11.0);
    assert!(texts(&loaded.warnings).join("\n").contains("vox_offset 0"));
}

#[test]
fn pairs_are_read_from_either_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = Header::new(1, false).vox_offset(0.0).sform(1, SFORM);
    header.bytes.truncate(348);
    header.bytes[344..348].copy_from_slice(b"ni1\0");
    let data: Vec<u8> = (0..12i16).flat_map(i16::to_le_bytes).collect();
    let file = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    file("plain.hdr", &header.bytes);
    file("plain.img", &data);
    file("packed.hdr.gz", &gzip(&header.bytes));
    file("packed.img.gz", &gzip(&data));
    file("half.hdr", &header.bytes);
    for name in ["plain.hdr", "plain.img", "packed.hdr.gz", "packed.img.gz"] {
        let volume = read(folder.path().join(name), &ReadOptions::default()).unwrap().volume;
        assert_eq!(stored(&volume)[11], 11.0, "{name}");
    }
    assert!(message(read(folder.path().join("half.hdr"), &ReadOptions::default())).contains("half.img"));
    header.bytes[344] = 0;
    file("half.hdr", &header.bytes);
    assert!(message(read(folder.path().join("half.hdr"), &ReadOptions::default())).contains("ANALYZE 7.5"));
}

#[test]
fn impossible_headers_are_refused() {
    let fails = |header: Header| message(load("a.nii", header.with_counting(12)));
    let good = || Header::new(1, false);
    for (header, part) in [
        (good().dim(&[0]), "dim[0]' is '0'"),
        (good().dim(&[8]), "dim[0]' is '8'"),
        (good().dim(&[3, 2, 0]), "dim[2]' is '0'"),
        (good().dim(&[3, -2]), "dim[1]' is '-2'"),
        (good().dim(&[5, 2, 3, 1, 2, 2]), "not supported"),
        (good().dim(&[6, 2, 3, 1, 1, 1, 2]), "not supported"),
        (good().dim(&[3, 2, 3, 3]), "has 24 bytes, expected 36"),
        (good().vox_offset(f64::NAN), "vox_offset"),
        (good().vox_offset(-1.0), "vox_offset"),
        (good().vox_offset(1e30), "vox_offset"),
        (good().vox_offset(1e9), "has 0 bytes"),
        (good().sform(1, [[f64::NAN; 4]; 3]), "singular or not finite"),
        (good().sform(1, [[0.0; 4]; 3]), "singular"),
        (good().qform(1, [f64::NAN, 0.0, 0.0], [0.0; 3]), "not finite"),
    ] {
        let text = fails(header);
        assert!(text.starts_with("a.nii: ") && text.contains(part), "{text}");
    }
    let huge = Header::new(2, false).dim(&[3, i64::MAX, i64::MAX, i64::MAX]);
    assert!(fails(huge).contains("fewer than 2^63 bytes"));
}
