//! What is written is what is read, in every type, encoding and format.

use crate::common::{affine_error, dyadic, extremes, oblique, stored};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::{Grid, ValueMap, Volume, Voxel, VoxelType, Warning};
use pellucid_io::{IoError, Mapping, RawLayout, ReadOptions, WriteOptions, read, write};
use proptest::prelude::*;

const NAMES: [&str; 6] = ["v.nrrd", "v.nhdr", "v.mha", "v.mhd", "v.nii", "v.nii.gz"];

fn options(compression: Option<u8>) -> WriteOptions {
    WriteOptions { compression, ..Default::default() }
}

#[test]
fn every_type_format_and_encoding_keeps_values_components_and_grid() {
    let folder = tempfile::tempdir().unwrap();
    for voxel_type in VoxelType::ALL {
        for components in 1..=4 {
            let grid = dyadic([5, 4, 3]);
            let voxels = extremes(voxel_type, grid.len() * components);
            let mut volume = Volume::with_components(grid, voxels, components).unwrap();
            volume.length_unit = Some("mm".to_owned());
            for name in NAMES {
                for compression in [None, Some(1), Some(9)] {
                    let path = folder.path().join(name);
                    let written = write(&path, &volume, &options(compression)).unwrap();
                    let loaded = read(&path, &ReadOptions::default()).unwrap();
                    let context = format!("{voxel_type} x {components} as {name}, {compression:?}");
                    let found = &loaded.volume;
                    assert_eq!(found.components(), components, "{context}");
                    assert_eq!(found.grid().dims(), [5, 4, 3], "{context}");
                    assert_eq!(found.name, "v");
                    assert_eq!(found.length_unit.as_deref(), Some("mm"), "{context}");
                    let error = affine_error(found.grid().world_from_index(), grid.world_from_index());
                    assert!(error < 1e-15, "{context}: {error}");
                    if voxel_type == VoxelType::F16 {
                        // No format has halves; singles hold them exactly.
                        let exact = Warning::Converted { from: "f16".into(), to: VoxelType::F32, largest_error: 0.0 };
                        assert_eq!(written, [exact], "{context}");
                        assert_eq!(found.voxels().voxel_type(), VoxelType::F32);
                        assert_eq!(stored(found), stored(&volume), "{context}");
                    } else {
                        assert_eq!(written, [], "{context}");
                        assert_eq!(found.voxels().voxel_type(), voxel_type, "{context}");
                        assert_eq!(found.voxels().as_bytes(), volume.voxels().as_bytes(), "{context}");
                    }
                }
            }
            let path = folder.path().join("v.raw");
            write(&path, &volume, &options(None)).unwrap();
            let layout = RawLayout { components, ..RawLayout::new([5, 4, 3], voxel_type) };
            let found = read(&path, &ReadOptions { raw: Some(layout), ..Default::default() }).unwrap().volume;
            assert_eq!(found.voxels().as_bytes(), volume.voxels().as_bytes());
        }
    }
}

#[test]
fn nothing_but_the_files_asked_for_is_left_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume::new(dyadic([2, 2, 2]), vec![1u8; 8]).unwrap();
    for name in NAMES {
        write(folder.path().join(name), &volume, &options(None)).unwrap();
    }
    let mut names: Vec<_> =
        std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    // Data files are named after the whole header, so that no v.raw of the user's is overwritten.
    assert_eq!(names, ["v.mha", "v.mhd", "v.mhd.raw", "v.nhdr", "v.nhdr.raw", "v.nii", "v.nii.gz", "v.nrrd"]);
}

#[test]
fn value_maps_and_units_survive_or_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let map = ValueMap { scale: 0.25, offset: -1024.0 };
    let volume = Volume::new(dyadic([3, 1, 1]), vec![0i16, 7, 4096]).unwrap().with_value_map(map).unwrap();
    for name in NAMES {
        let mut volume = volume.clone();
        volume.value_unit = Some("HU".to_owned());
        let path = folder.path().join(name);
        let warnings = write(&path, &volume, &options(None)).unwrap();
        let found = read(&path, &ReadOptions::default()).unwrap().volume;
        assert_eq!(found.value_map(), map, "{name}");
        assert_eq!(found.value([2, 0, 0], 0), 0.0);
        let is_nrrd = name.contains(".n") && !name.contains(".nii");
        assert_eq!(found.value_unit.as_deref(), is_nrrd.then_some("HU"), "{name}");
        assert_eq!(warnings.len(), 1, "{name}: {warnings:?}");
    }
}

#[test]
fn descriptions_survive_or_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let mut volume = Volume::new(dyadic([3, 1, 1]), vec![0i16, 7, 4096]).unwrap();
    volume.description = Some("a \"thing\": 1,\n2".to_owned());
    for name in NAMES.into_iter().chain(["v.raw"]) {
        let path = folder.path().join(name);
        let warnings = write(&path, &volume, &options(None)).unwrap();
        let is_nrrd = name.contains(".n") && !name.contains(".nii");
        let told = warnings.iter().filter(|warning| warning.to_string().contains("description")).count();
        assert_eq!(told, usize::from(!is_nrrd), "{name}: {warnings:?}");
        if is_nrrd {
            let found = read(&path, &ReadOptions::default()).unwrap().volume.description;
            assert_eq!(found.as_deref(), Some("a 'thing': 1, 2"), "{name}");
        }
    }
}

/// Values that only an offset tells from others survive every format, whatever that knows of offsets.
fn survives<T: Voxel>(differences: [T; 6], offset: f64) {
    let folder = tempfile::tempdir().unwrap();
    for components in [1, 2] {
        let grid = dyadic([6 / components, 1, 1]);
        let volume = Volume::with_components(grid, differences.to_vec(), components).unwrap();
        let volume = volume.with_value_map(ValueMap { scale: 1.0, offset }).unwrap();
        for name in NAMES {
            let path = folder.path().join(name);
            let warnings = write(&path, &volume, &options(None)).unwrap();
            assert!(warnings.is_empty(), "{name}: {warnings:?}");
            let found = read(&path, &ReadOptions::default()).unwrap().volume;
            for (place, difference) in differences.iter().enumerate() {
                let value = found.value([place / components, 0, 0], place % components);
                assert_eq!(value, offset + difference.to_f64(), "{name}, {place}");
            }
        }
    }
}

/// What was read from 64-bit integers and doubles is written as such.
#[test]
fn values_far_from_0_survive_every_format() {
    survives([0u32, 1, u32::MAX, 5, 6, 7], 1_234_567_890_123.0);
    survives([i32::MIN, i32::MAX, -1, 0, 1, 2], -1_234_567_890_123.0);
    survives([0.0f32, 0.5, 70.0, 5.25, 6.0, 7.0], 1e9 + 0.25);
}

#[test]
fn nifti_warns_of_what_single_precision_loses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nii");
    let map = ValueMap { scale: 0.1, offset: 0.0 };
    let volume = Volume::new(oblique([3, 4, 5]), vec![0u8; 60]).unwrap().with_value_map(map).unwrap();
    let warnings = write(&path, &volume, &options(None)).unwrap();
    let texts = crate::common::texts(&warnings);
    assert!(texts.iter().any(|text| text.contains("positions are rounded")), "{texts:?}");
    assert!(texts.iter().any(|text| text.contains("slope and intercept")), "{texts:?}");
    let found = read(&path, &ReadOptions::default()).unwrap().volume;
    let error = affine_error(found.grid().world_from_index(), volume.grid().world_from_index());
    assert!(error < 1e-7, "{error}");
}

#[test]
fn an_axis_too_long_for_nifti_1_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume::new(Grid::new([40_000, 1, 1]).unwrap(), vec![0u8; 40_000]).unwrap();
    let error = write(folder.path().join("long.nii"), &volume, &options(None)).unwrap_err();
    assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("40000"), "{error}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
}

#[test]
fn an_unknown_extension_is_refused() {
    let volume = Volume::new(Grid::new([1; 3]).unwrap(), vec![0u8]).unwrap();
    let error = write("/nowhere/v.xyz", &volume, &options(None)).unwrap_err().to_string();
    assert!(error.contains(".xyz") && error.contains(".nrrd"), "{error}");
}

/// Whether a volume's values lie inside a mapping of a file in the folder.
#[cfg(target_os = "linux")]
fn is_mapped(volume: &Volume, folder: &std::path::Path) -> bool {
    let address = volume.voxels().as_bytes().as_ptr() as usize;
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    maps.lines().filter(|line| line.contains(folder.to_str().unwrap())).any(|line| {
        let (low, high) = line.split_once(' ').unwrap().0.split_once('-').unwrap();
        let bound = |text| usize::from_str_radix(text, 16).unwrap();
        (bound(low)..bound(high)).contains(&address)
    })
}

/// Plain files are mapped, not copied, where the caller vouches for them, and otherwise never.
#[cfg(target_os = "linux")]
#[test]
fn plain_native_files_are_mapped_by_leave() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume::new(oblique([7, 5, 3]), vec![1.5f32; 105]).unwrap();
    // SAFETY: nobody else knows of the files.
    let mapping = ReadOptions { map: Some(unsafe { Mapping::new() }), ..ReadOptions::default() };
    for (name, compression, mapped) in [
        ("v.nrrd", None, true),
        ("v.nhdr", None, true),
        ("v.mha", None, true),
        ("v.mhd", None, true),
        ("v.nii", None, true),
        ("v.nii.gz", None, false),
        ("v.nrrd", Some(1), false),
    ] {
        let path = folder.path().join(name);
        write(&path, &volume, &options(compression)).unwrap();
        let loaded = read(&path, &mapping).unwrap();
        assert_eq!(is_mapped(&loaded.volume, folder.path()), mapped, "{name}, {compression:?}");
        let again = read(&path, &ReadOptions::default()).unwrap();
        assert!(!is_mapped(&again.volume, folder.path()), "{name}, {compression:?}");
        assert_eq!(again.volume.voxels().as_bytes(), loaded.volume.voxels().as_bytes());
    }
}

/// Millimetres do not make a patient: a machine part stays one.
#[test]
fn nrrd_states_a_patients_axes_only_of_a_patient() {
    let folder = tempfile::tempdir().unwrap();
    let grid = dyadic([5, 4, 3]);
    for is_anatomical in [false, true] {
        let mut volume = Volume::new(grid, extremes(VoxelType::U8, grid.len())).unwrap();
        (volume.length_unit, volume.is_anatomical) = (Some("mm".to_owned()), is_anatomical);
        for name in ["v.nrrd", "v.nhdr"] {
            let path = folder.path().join(name);
            write(&path, &volume, &options(None)).unwrap();
            let found = read(&path, &ReadOptions::default()).unwrap().volume;
            assert_eq!(found.is_anatomical, is_anatomical, "{name}");
            assert_eq!(found.length_unit.as_deref(), Some("mm"), "{name}");
            let header = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
            assert_eq!(header.contains("left-posterior-superior"), is_anatomical, "{header}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any affine returns to 1e-9 where the format has the digits for it.
    #[test]
    fn affines_return(
        columns in prop::array::uniform9(-5.0f64..5.0),
        translation in prop::array::uniform3(-1e4f64..1e4),
        dims in prop::array::uniform3(1usize..6),
        values in prop::collection::vec(any::<i16>(), 125),
    ) {
        let matrix3 = DMat3::from_cols_array(&columns);
        prop_assume!(matrix3.determinant().abs() > 1e-3);
        let affine = DAffine3 { matrix3, translation: DVec3::from_array(translation) };
        let grid = Grid::with_affine(dims, affine).unwrap();
        let volume = Volume::new(grid, values[..grid.len()].to_vec()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for name in NAMES {
            let path = folder.path().join(name);
            write(&path, &volume, &options(None)).unwrap();
            let found = read(&path, &ReadOptions::default()).unwrap().volume;
            let error = affine_error(found.grid().world_from_index(), affine);
            let bound = if name.contains(".nii") { 1e-7 } else { 1e-14 };
            prop_assert!(error < bound, "{}: {}", name, error);
            prop_assert_eq!(found.voxels().as_bytes(), volume.voxels().as_bytes());
        }
    }
}
