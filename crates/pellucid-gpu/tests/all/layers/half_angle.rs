//! Half-angle light through several volumes: as the CPU backend draws it, whose pictures are held to closed forms there.

use super::*;
use crate::common::with_holes;
use crate::half_angle::{LIGHTS as SUNS, are_alike};

/// A volume with its transfer function, what it has besides, and tables behind that.
type Layer<'a> = (Arc<Volume>, &'a str, &'a str, &'a str);

/// A stage of volumes in a light.
fn lit(layers: &[Layer], light: &str, technique: &str, rest: &str) -> Stage {
    let own = |(_, tf, keys, tables): &Layer| format!("{keys}\n{tf}\n{tables}");
    let entries: Vec<String> = layers.iter().map(own).collect();
    let layers: Vec<_> = layers.iter().zip(&entries).map(|((volume, ..), entry)| (volume.clone(), &**entry)).collect();
    let (keys, tables) = rest.split_once('|').unwrap_or(("", rest));
    let technique = format!("[technique.half_angle]\nresolution = 40\n{technique}");
    layered(&layers, &format!("{keys}|[[lighting.lights]]\nkind.{light}\n{technique}\n{tables}"), [32, 28])
}

/// The two turned volumes with keys and tables of their own.
fn both<'a>([first, second]: [(&'a str, &'a str); 2]) -> [Layer<'a>; 2] {
    let [ball, waves] = turned();
    [(ball, BALL, first.0, first.1), (waves, WAVES, second.0, second.1)]
}

/// Every rule of what lies where two volumes overlap, as keys of a document.
const RULES: [&str; 5] = [
    "",
    "overlap = \"maximum\"",
    "overlap = \"priority\"",
    "overlap.fused = { color = 1, opacity = 0 }",
    "overlap.fused = { color = 0, opacity = 1 }",
];

const PLAIN: [(&str, &str); 2] = [("shading = false", ""); 2];
const HAZE: &str =
    "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.08]]";
const DENSER: &str =
    "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.15]]";
const NOTHING: &str =
    "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0]]";

#[test]
fn pictures_are_those_of_the_cpu_from_all_sides() {
    let mut renderer = gpu(&Ceiling::default());
    for (name, light) in SUNS {
        for projection in ["perspective.vertical_fov = 30", "orthographic = {}"] {
            let layers = both([("shading = true", "[volumes.scattering]\ntransport = [[0, \"#f0c080\"]]"), PLAIN[1]]);
            let stage = lit(&layers, light, "blur_angle = 40", &format!("[camera.projection]\n{projection}\n"));
            let (expected, found) = are_alike(&mut renderer, &stage, name);
            let seen = [&expected, &found].map(|frame| frame.statistics.samples_visible);
            assert!(seen[0].abs_diff(seen[1]) <= 4, "{name}: {seen:?} samples are seen");
            // Where half of the opacity is reached; a ray on the edge between two samples may find either.
            let pairs = expected.depth.iter().zip(&found.depth).filter(|(a, b)| a.is_finite() || b.is_finite());
            let near = pairs.clone().filter(|(a, b)| (*a - *b).abs() < 1e-2).count();
            let count = pairs.count();
            assert!(count > 50 && (count - near) * 50 <= count, "{name}: {near} of {count} depths agree");
            let turned = expected.normal.iter().zip(&found.normal);
            let turned = turned.filter(|(a, b)| (0..3).any(|axis| (a[axis] - b[axis]).abs() > 0.02)).count();
            assert!(turned * 50 <= count, "{name}: {turned} of {count} normals differ");
        }
    }
}

#[test]
fn every_setting_means_the_same() {
    let mut renderer = gpu(&Ceiling::default());
    let techniques = [
        "indirect = 0.0",
        "correction = \"none\"\ndirect = 0.3",
        "in_scatter = \"direct\"\ninitial_indirect = 0.0",
        "in_scatter = \"direct_from_matter\"\ninitial_indirect = 0.5",
        "in_scatter = \"both_from_matter\"\ntaps = 7",
        "in_scatter = \"both_from_matter\"\ntaps = 1",
        "jitter = \"fixed\"\nblur_scaling = \"per_distance\"\nambient = true",
    ];
    let [first, second] = ["[[0, \"#f0c080\"]]", "[[0, \"#fff4e8\"], [200, \"#f8fcff\"]]"];
    let [first, second] = [first, second].map(|colors| {
        format!("[volumes.scattering]\nphase.henyey_greenstein.g = 0.6\nphase_normalization = \"renormalised\"\ntransport = {colors}")
    });
    // In thick slabs much happens; what lets indirect light through in its own way is the first, the second, or both.
    let thick = "[quality]\nstep = 2.5";
    for (number, technique) in techniques.iter().enumerate() {
        for light in [SUNS[2].1, SUNS[3].1] {
            let own = [[&*first, &*second], [&*first, ""], ["", &*second]][number % 3];
            let layers = both(own.map(|own| ("shading = false", own)));
            for rule in [RULES[0], RULES[1 + number % 4]] {
                let stage = lit(&layers, light, technique, &format!("{rule}|{thick}"));
                are_alike(&mut renderer, &stage, &format!("{rule} {technique} {own:?} {light}"));
            }
        }
    }
}

#[test]
fn each_volume_has_optics_of_its_own() {
    let shaded = "shading = true\nmaterial = { specular = 0.6, shininess = 20 }";
    let noisy =
        "perturbation = { displacement.amplitude = 0.8, optics = { color = 0.5, opacity = 0.4, transport = 0.3 } }";
    let cut = "crop = { from = [3, 2, 4], to = [14, 12, 15.5] }";
    let by_values = (shaded, "[volumes.scattering]\nsurface.values = [[0.3, 0.2], [0.8, 1]]");
    let by_gradient = (shaded, "[volumes.scattering]\nsurface.gradient = { low = 2, high = 20 }");
    let backward = ("shading = false", "[volumes.scattering]\nphase.schlick.g = -0.6");
    let perturbed = (noisy, "[volumes.scattering]\ntransport = [[0, \"#f0c080\"]]");
    let cropped = (cut, "[volumes.scattering]\nphase = \"rayleigh\"");
    let cases = [
        ([by_values, PLAIN[1]], SUNS[0], "[quality]\nsupersampling = 2\njitter.blue_noise.seed = 3"),
        ([backward, by_gradient], SUNS[2], "[quality]\nempty_space_skipping = false\nstep = 0.7"),
        ([perturbed, cropped], SUNS[3], ""),
        ([perturbed, by_gradient], SUNS[2], "overlap = \"maximum\"|"),
        (
            [by_values, perturbed],
            SUNS[1],
            "overlap = \"priority\"|[quality]\nsupersampling = 2\njitter.blue_noise.seed = 3",
        ),
        ([by_gradient, cropped], SUNS[3], "overlap.fused = { color = 1, opacity = 0 }|"),
        (
            [perturbed, backward],
            SUNS[0],
            "overlap.fused = { color = 0, opacity = 1 }|[quality]\nempty_space_skipping = false",
        ),
        ([PLAIN[0], cropped], SUNS[0], "[[clips]]\nplane = { point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }"),
        ([by_values, by_gradient], SUNS[1], "[quality]\nfilter = { bc = { b = 0.3, c = 0.3 } }\ngradient = \"sobel\""),
        ([backward, cropped], SUNS[4], "[quality]\nearly_termination = 0.6\nclassification = \"pre_integrated\""),
    ];
    let mut renderer = gpu(&Ceiling::default());
    for (own, (name, light), rest) in cases {
        are_alike(&mut renderer, &lit(&both(own), light, "", rest), &format!("{own:?} {name} {rest}"));
    }
    // Voxels that are absent in one of them.
    let [_, waves] = both(PLAIN);
    let holes = placed(&with_holes("wavelet", [20, 22, 18]), DAffine3::from_scale(DVec3::splat(0.5)));
    are_alike(&mut renderer, &lit(&[waves, (holes, WAVES, "shading = true", "")], SUNS[0].1, "", ""), "holes");
}

/// Boxes of one value, whose matter ends at their faces: beside each other, in each other, and apart.
#[test]
fn matter_at_faces_is_met_exactly() {
    // Every device takes two volumes.
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let camera = "[camera]\nprojection.orthographic = {}\nview.orbit = { azimuth = 0, elevation = 0 }\n[quality]\nearly_termination = 1\n";
    let first = solid([9; 3], [0.0; 3], [1.0; 3]);
    for (corner, spacing) in
        [([2.2, 4.37, 1.9], [1.3, 0.91, 0.83]), ([8.0, 0.0, 0.0], [1.0; 3]), ([3.0, 2.0, -14.0], [0.7; 3])]
    {
        let second = solid([5, 7, 6], corner, spacing);
        for ((_, light), rule) in SUNS[..4].iter().flat_map(|light| RULES.map(|rule| (light, rule))) {
            let layers = [
                (first.clone(), HAZE, "", ""),
                (second.clone(), DENSER, "", "[volumes.scattering]\nphase = \"rayleigh\""),
            ];
            let stage = lit(&layers, light, "taps = 6", &format!("{rule}|{camera}"));
            let (_, found) = are_alike(&mut renderer, &stage, &format!("{rule} {light}"));
            let both = [0.08f64, 0.15].map(|opacity| -(1.0 - opacity).ln());
            let view = &stage.viewpoint;
            let mut met = 0;
            for (pixel, color) in found.color.iter().enumerate() {
                let ray = view.ray((pixel % view.width) as f64 + 0.5, (pixel / view.width) as f64 + 0.5);
                let inside = |volume: &Arc<Volume>| {
                    let corners = volume.grid().world_corners();
                    let (low, high) = (corners[0], corners[7]);
                    let is_in = [0, 2].iter().all(|&axis| (low[axis]..=high[axis]).contains(&ray.origin[axis]));
                    if is_in { [low.y, high.y] } else { [0.0; 2] }
                };
                let [a, b] = [&first, &second].map(inside);
                let shared = (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
                // How far each holds light back.
                let [mut own, mut other] = [a, b].map(|[from, to]| to - from);
                match rule {
                    "" => {}
                    "overlap = \"maximum\"" => own -= shared,
                    "overlap = \"priority\"" => other -= shared,
                    _ if stage.overlap.holds_back(0) => other = 0.0,
                    _ => own = 0.0,
                }
                let depths = both[0] * own + both[1] * other;
                let exact = -(-depths).exp_m1();
                met += usize::from(exact > 0.1);
                let apart = (f64::from(color[3]) - exact).abs();
                assert!(apart < 1e-4, "{rule} {light}, pixel {pixel}: {color:?}, exact {exact}");
            }
            // Of two that are fused one may be small.
            assert!(met > 10, "{rule}: only {met} rays meet a box");
        }
    }
}

#[test]
fn neither_the_order_of_the_list_nor_what_is_empty_changes_a_bit() {
    let [ball, waves] = turned();
    // The third is behind the eye, the fourth beside the others.
    let third = solid([4, 5, 6], [2.0, -90.0, -2.0], [1.7, 2.3, 1.1]);
    let fourth = solid([4, 5, 6], [-1.0, -9.0, -2.0], [1.7, 2.3, 1.1]);
    let layers: [Layer; 4] = [
        (ball, BALL, "shading = false", "[volumes.scattering]\ntransport = [[0, \"#f0c080\"]]"),
        (waves, WAVES, "shading = true", ""),
        (third, HAZE, "", ""),
        (fourth, HAZE, "", ""),
    ];
    let camera = "[camera]\nview.orbit = { target = [0, 0, 0], distance = 60 }\n[quality]\nempty_space_skipping = ";
    let mut renderer = gpu(&Ceiling::default());
    let mut draw = |layers: &[Layer], rule: &str, is_skipping: bool| {
        let stage = lit(layers, SUNS[0].1, "in_scatter = \"direct\"", &format!("{rule}|{camera}{is_skipping}"));
        if is_skipping { are_alike(&mut renderer, &stage, "four").1 } else { draw(&mut renderer, &stage) }
    };
    let bits = |frame: &Frame| {
        let numbers = [frame.color.as_flattened(), &frame.depth, frame.normal.as_flattened()].concat();
        numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>()
    };
    for rule in &RULES[..2] {
        let first = draw(&layers, rule, true);
        let [a, b, c, d] = layers.clone();
        assert!(bits(&draw(&[d, b, a, c], rule, true)) == bits(&first), "the order changes the picture: {rule}");
        let whole = draw(&layers, rule, false);
        assert!(whole.statistics.samples > first.statistics.samples);
        assert!(bits(&whole) == bits(&first), "what is empty changes the picture: {rule}");
    }
}

/// Beside a volume of nothing in the same box, light is looked at in the same texels.
#[test]
fn beside_nothing_a_volume_is_as_alone() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let mut renderer = gpu(&Ceiling::default());
    let scattering = "[volumes.scattering]\ntransport = [[0, \"#f0c080\"]]";
    let layers: [Layer; 2] =
        [(volume.clone(), WAVES, "shading = true", scattering), (volume, NOTHING, "shading = true", scattering)];
    // What is seen of nothing would move the eye.
    let camera = "[camera]\nview.orbit = { target = [0, 0, 0], distance = 40 }\n";
    for (name, light) in SUNS {
        let mut draw = |layers: &[Layer]| draw(&mut renderer, &lit(layers, light, "in_scatter = \"direct\"", camera));
        let (alone, beside) = (draw(&layers[..1]), draw(&layers));
        assert!(alone.color.iter().filter(|pixel| pixel[3] > 0.3).count() > 100, "{name} shows nothing");
        let apart = difference(&alone, &beside);
        assert!(apart < 1e-4, "{name}: {apart}");
        // A frame of one volume and one of two leave nothing to each other.
        assert!(draw(&layers[..1]).color == alone.color && draw(&layers).color == beside.color, "{name}");
    }
}

#[test]
fn more_volumes_than_a_pass_takes_are_counted() {
    let layers: Vec<Layer> =
        (0..9).map(|k| (solid([3; 3], [f64::from(k), 0.0, 0.0], [1.0; 3]), HAZE, "", "")).collect();
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let refused = renderer.render(&lit(&layers, SUNS[0].1, "", ""), &Control::default()).unwrap_err();
    let GpuError::Volumes { found: 9, most } = refused else { panic!("{refused}") };
    assert!((2..9).contains(&most), "{refused}");
    draw(&mut renderer, &lit(&layers[..most], SUNS[0].1, "", ""));
}
