//! Files without a header, and what the messages suggest when a layout does not fit.

use crate::common::{message, stored};
use pellucid_field::{VoxelType, Warning};
use pellucid_io::{Endian, IoError, Loaded, RawLayout, ReadOptions, StoredType, read_bytes};

fn load(layout: RawLayout, bytes: &[u8]) -> Result<Loaded, IoError> {
    read_bytes("scan.raw", bytes.to_vec(), &ReadOptions { raw: Some(layout), ..Default::default() })
}

#[test]
fn dims_type_order_skip_and_components_are_the_callers() {
    let layout = RawLayout {
        endian: Endian::Big,
        components: 2,
        spacing: [1.0, 2.0, -3.0],
        skip: Some(3),
        ..RawLayout::new([2, 1, 1], VoxelType::U16)
    };
    let loaded = load(layout, &[9, 9, 9, 0, 1, 0, 2, 1, 0, 255, 255]).unwrap();
    assert_eq!(stored(&loaded.volume), [1., 2., 256., 65535.]);
    assert_eq!(loaded.volume.grid().world_from_index().matrix3.z_axis.z, -3.0);
    assert_eq!(loaded.volume.name, "scan");
    assert_eq!(loaded.warnings, []);
    let doubles = load(RawLayout::new([2, 1, 1], StoredType::F64), &[0; 16]).unwrap();
    let from = "f64".to_owned();
    assert_eq!(doubles.warnings, [Warning::Converted { from, to: VoxelType::F32, largest_error: 0.0 }]);
}

#[test]
fn without_a_skip_the_size_must_match_and_the_message_helps() {
    let bytes = [0; 48];
    let fails = |layout| message(load(layout, &bytes));
    assert_eq!(
        fails(RawLayout::new([4, 3, 2], VoxelType::U8)),
        "scan.raw: field 'file size' is '48', expected 24 bytes (4 x 3 x 2, 1 x u8); it would fit type u16 or i16 or f16, \
         or dims 4 x 3 x 4, or skip 24, if the file begins with a header"
    );
    assert!(fails(RawLayout::new([4, 3, 2], VoxelType::F32)).contains("dims 4 x 3 x 1"));
    assert!(fails(RawLayout::new([5, 3, 9], VoxelType::U8)).ends_with("(5 x 3 x 9, 1 x u8)"));
    assert!(
        fails(RawLayout { skip: Some(25), ..RawLayout::new([4, 3, 2], VoxelType::U8) }).contains("24 bytes after 25")
    );
    for dims in [[0, 1, 1], [usize::MAX, 2, 2], [usize::MAX / 2, 1, 1]] {
        assert!(fails(RawLayout::new(dims, VoxelType::F32)).contains("file size"));
    }
    assert!(fails(RawLayout { components: 0, ..RawLayout::new([4, 3, 2], VoxelType::U8) }).contains("file size"));
    let five = RawLayout { components: 6, ..RawLayout::new([4, 2, 1], VoxelType::U8) };
    assert!(fails(five).contains("6 components"));
    let nan = RawLayout { spacing: [1.0, f64::NAN, 1.0], ..RawLayout::new([4, 3, 4], VoxelType::U8) };
    assert!(fails(nan).contains("not finite"));
}

#[test]
fn names_of_types_are_parsed() {
    for stored in StoredType::ALL {
        assert_eq!(stored.name().parse(), Ok(stored));
    }
    assert!("u24".parse::<StoredType>().unwrap_err().contains("u8, i8, u16"));
}

#[test]
fn without_a_layout_a_raw_file_says_what_it_needs() {
    let error = message(read_bytes("scan.raw", vec![0; 8], &ReadOptions::default()));
    assert!(error.contains("dims and type"), "{error}");
}
