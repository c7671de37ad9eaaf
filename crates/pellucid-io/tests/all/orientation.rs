//! The same object in files of different frames stands at the same place in the world.

use crate::common::load;
use crate::common::nifti::Header;
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use proptest::prelude::*;

/// A voxel's world position through each file: its value names it.
fn positions(bytes: Vec<u8>, name: &str) -> Vec<(f64, DVec3)> {
    let volume = load(name, bytes).unwrap().volume;
    let [x, y, z] = volume.grid().dims();
    let mut found = Vec::new();
    for index in 0..x * y * z {
        let voxel = [index % x, index / x % y, index / (x * y)];
        let point = DVec3::from_array(voxel.map(|i| i as f64));
        found.push((volume.value(voxel, 0), volume.grid().world_from_index().transform_point3(point)));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

fn vector(v: DVec3) -> String {
    format!("({},{},{})", v.x, v.y, v.z)
}

fn nrrd(space: &str, affine: DAffine3, values: &[u8]) -> Vec<u8> {
    let m = affine.matrix3;
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nencoding: raw\nspace: {space}\n\
         space directions: {} {} {}\nspace origin: {}\n\n",
        vector(m.x_axis),
        vector(m.y_axis),
        vector(m.z_axis),
        vector(affine.translation)
    );
    [header.as_bytes(), values].concat()
}

fn metaimage(affine: DAffine3, values: &[u8]) -> Vec<u8> {
    let m = affine.matrix3;
    let axes = [m.x_axis, m.y_axis, m.z_axis];
    let words = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let header = format!(
        "NDims = 3\nDimSize = 2 3 2\nElementType = MET_UCHAR\nAnatomicalOrientation = RAI\nTransformMatrix = {}\n\
         ElementSpacing = {}\nOffset = {}\nElementDataFile = LOCAL\n",
        axes.map(|axis| words(axis.normalize())).join(" "),
        words(DVec3::from_array(axes.map(DVec3::length))),
        words(affine.translation)
    );
    [header.as_bytes(), values].concat()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn frames_agree(
        angles in prop::array::uniform3(-3.0f64..3.0),
        spacing in prop::array::uniform3(0.1f64..5.0),
        mirror in prop::array::uniform3(prop::bool::ANY),
        origin in prop::array::uniform3(-500.0f64..500.0),
    ) {
        let signed: [f64; 3] = std::array::from_fn(|axis| if mirror[axis] { -spacing[axis] } else { spacing[axis] });
        let rotation = DMat3::from_quat(DQuat::from_euler(EulerRot::XYZ, angles[0], angles[1], angles[2]));
        let matrix3 = rotation * DMat3::from_diagonal(DVec3::from_array(signed));
        // Where each voxel is, in the words of three frames.
        let lps = DAffine3 { matrix3, translation: DVec3::from_array(origin) };
        let ras = DAffine3::from_scale(DVec3::new(-1.0, -1.0, 1.0)) * lps;
        let las = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)) * lps;
        let values: Vec<u8> = (0..12).collect();
        let rows = [0, 1, 2].map(|k| {
            let row = ras.matrix3.row(k);
            [row.x, row.y, row.z, ras.translation[k]]
        });
        // The same object stored back to front: the first axis runs the other way from its end.
        let flip = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), translation: DVec3::X };
        let flipped: Vec<u8> = values.chunks(2).flat_map(|pair| [pair[1], pair[0]]).collect();
        let expected: Vec<(f64, DVec3)> = (0..12)
            .map(|k| (k as f64, lps.transform_point3(DVec3::new((k % 2) as f64, (k / 2 % 3) as f64, (k / 6) as f64))))
            .collect();
        for (name, bytes) in [
            ("lps.nrrd", nrrd("left-posterior-superior", lps, &values)),
            ("ras.nrrd", nrrd("right-anterior-superior", ras, &values)),
            ("las.nrrd", nrrd("left-anterior-superior", las, &values)),
            ("flip.nrrd", nrrd("RAS", ras * flip, &flipped)),
            ("lps.mha", metaimage(lps, &values)),
            ("ras.nii", Header::new(2, false).datatype(2, 8).sform(1, rows).with(&values)),
        ] {
            for (found, expected) in positions(bytes, name).iter().zip(&expected) {
                prop_assert_eq!(found.0, expected.0);
                prop_assert!(found.1.distance(expected.1) < 1e-9, "{}: {} {}", name, found.1, expected.1);
            }
        }
    }
}
