//! Skin, flesh, airways, eyes and ears.

use glam::DVec3;

use super::super::noise::{fractal, noise};
use super::super::number::Number;
use super::super::shape::{blob, common, ellipsoid, inside, join, length, relative, ring, rod};
use super::{EDGE, Tissue, both_sides, hu};

const EYE: DVec3 = DVec3::new(31.5, -74.5, -8.0);

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Distance to the skin.
pub(super) fn skin<N: Number>(p: [N; 3]) -> N {
    let pair = both_sides(p, 4.5);
    let skull = ellipsoid(p, v(0.0, 9.0, 25.0), v(76.0, 97.0, 83.0));
    let face = ellipsoid(p, v(0.0, -34.0, -44.0), v(60.0, 58.0, 62.0));
    let jaw = rod(pair, (v(40.0, -20.0, -76.0), 18.0), (v(9.0, -72.0, -94.0), 19.0));
    let neck = ellipsoid(p, v(0.0, 20.0, -120.0), v(55.0, 58.0, 130.0));
    let throat = common(neck, p[2] + 20.0, 30.0);
    let temple = rod(pair, (v(46.0, -57.0, -27.0), 16.0), (v(56.0, 26.0, -32.0), 18.0));
    let mut skin = join(join(join(skull, face, 26.0), temple, 16.0), join(jaw, throat, 22.0), 24.0);
    if position_is_far(skin) {
        return skin;
    }
    let chin = ellipsoid(p, v(0.0, -88.0, -98.0), v(15.0, 11.0, 12.0));
    let brow = rod(pair, (v(0.0, -80.0, 9.0), 8.0), (v(38.0, -68.0, 10.0), 9.0));
    let cheek = ellipsoid(pair, v(41.0, -66.0, -32.0), v(17.0, 16.0, 15.0));
    skin = join(join(skin, chin, 14.0), join(brow, cheek, 10.0), 14.0);
    // Sockets in front of the eyes, then lids over them.
    let socket = ellipsoid(pair, v(33.0, -99.0, -8.0), v(17.0, 15.0, 12.0));
    skin = common(skin, -socket, 14.0);
    let lid = length(relative(pair, EYE)) - 14.8;
    let slit = (pair[2] + 9.5 + (pair[0] - EYE.x).square() * 0.012).square().sqrt() - 0.5;
    skin = join(skin, common(lid, -slit, 1.5), 4.0);
    let nose = rod(p, (v(0.0, -88.0, 0.0), 6.0), (v(0.0, -108.0, -40.0), 9.0));
    let wing = ellipsoid(pair, v(9.5, -98.0, -45.0), v(7.0, 9.5, 6.0));
    skin = join(skin, join(nose, wing, 9.0), 8.0);
    let upper_lip = rod(pair, (v(0.0, -92.0, -67.0), 6.0), (v(21.0, -82.0, -70.0), 2.5));
    let lower_lip = rod(pair, (v(0.0, -91.0, -77.0), 6.5), (v(19.0, -82.0, -72.0), 2.5));
    skin = join(skin, upper_lip.min(lower_lip), 4.0);
    join(skin, ear(pair), 4.0)
}

/// Nothing on the surface stands out further than the tip of the nose and the rim of an ear.
fn position_is_far<N: Number>(skin: N) -> bool {
    skin.value() > 45.0 || skin.value() < -40.0
}

/// Distance to an ear: a bowl with a rim and a lobe, turned a little forward.
fn ear<N: Number>(pair: [N; 3]) -> N {
    let [x, y, z] = relative(pair, v(79.0, 15.0, -14.0));
    let (x, y) = (x * 0.9 - y * 0.43, x * 0.43 + y * 0.9);
    let y = y + z * -0.18;
    let q = [x, y, z];
    let shell = ellipsoid(q, v(0.0, 0.0, 0.0), v(4.0, 15.0, 27.0));
    let bowl = ellipsoid(q, v(5.0, -3.0, -4.0), v(5.0, 8.0, 13.0));
    // The rim is a ring squeezed to the outline of the shell, open in front.
    let rim = ring([y * 1.75, x * 1.3, z], v(0.0, 1.6, 1.0), 24.0, 3.3) * 0.7;
    let rim = common(rim, -q[1] - 11.0, 4.0);
    let inner = ring([y * 1.8, x * 1.3, z], v(2.0, 2.0, 2.0), 15.0, 2.4) * 0.7;
    let inner = common(inner, -q[1] - 2.0, 3.0);
    let lobe = ellipsoid(q, v(0.0, -4.0, -25.0), v(3.5, 6.5, 7.0));
    join(common(join(join(shell, rim, 2.0), inner, 2.0), -bowl, 3.0), lobe, 4.0)
}

/// Fat under the skin, muscle under the fat, and the planes of fat between muscles.
pub(super) fn paint_flesh<N: Number>(tissue: &mut Tissue<N>, skin: N) {
    if skin.value() > -1.0 {
        return;
    }
    let p = tissue.p;
    let fold = fractal(p.map(|x| x * (1.0 / 17.0)), 2);
    tissue.paint(hu::FAT, inside(skin + 2.4, 1.6));
    // Cheeks and neck are fatter than the scalp.
    let low = ((p[2] + 10.0) * (-1.0 / 40.0)).smoothstep();
    let muscle = skin + fold * 3.0 + low * 4.0 + 5.5;
    tissue.paint(hu::MUSCLE, inside(muscle, 2.0));
    // Planes of fat: where a slowly varying noise changes sign.
    let plane = noise([p[0] * 0.05, p[1] * 0.05, p[2] * 0.022]).abs() * 18.0 - 0.5;
    tissue.paint(hu::FAT, inside(common(plane, muscle + 2.0, 1.0), 1.6) * low);
    for (center, radii) in [([31.0, -80.0, -46.0], [13.0, 9.0, 13.0]), ([50.0, -46.0, -52.0], [6.0, 14.0, 14.0])] {
        tissue.blobs(hu::FAT, center, radii);
    }
    // Masseter, temporal muscle and the long muscle of the neck.
    tissue.blobs(hu::MUSCLE, [54.0, -22.0, -56.0], [6.5, 15.0, 26.0]);
    tissue.blobs(hu::MUSCLE, [66.0, -26.0, 4.0], [6.0, 28.0, 28.0]);
    tissue.paint(hu::MUSCLE, inside(rod(tissue.pair, (v(62.0, 34.0, -44.0), 8.0), (v(34.0, -8.0, -145.0), 11.0)), 1.6));
    tissue.blob(hu::MUSCLE, [0.0, -52.0, -74.0], [21.0, 28.0, 14.0]);
    // Cartilage of nose and ears.
    tissue.paint(hu::CARTILAGE, inside(rod(p, (v(0.0, -98.0, -22.0), 1.6), (v(0.0, -108.0, -44.0), 2.2)), EDGE));
}

/// Whatever is full of air: sinuses, nose, mouth, throat, ear canals and the mastoid.
pub(super) fn paint_airways<N: Number>(tissue: &mut Tissue<N>) {
    let (p, pair) = (tissue.p, tissue.pair);
    // Frontal sinuses, the left one larger; the divided sphenoid sinus.
    tissue.blob(hu::AIR, [9.0, -76.4, 18.0], [8.0, 2.4, 10.0]);
    tissue.blob(hu::AIR, [-8.0, -76.4, 15.0], [6.0, 2.2, 7.0]);
    tissue.blob(hu::AIR, [7.5, -26.0, -13.0], [7.0, 11.0, 8.5]);
    tissue.blob(hu::AIR, [-7.0, -27.0, -13.0], [5.5, 9.0, 7.5]);
    tissue.blobs(hu::AIR, [26.5, -62.0, -39.0], [11.0, 12.0, 14.0]);
    paint_ethmoid(tissue);
    // Nasal cavity, then what stands in it: the bent septum and the turbinates.
    let nose = blob(pair, [6.0, -62.0, -36.0], [8.5, 33.0, 20.0], EDGE);
    tissue.paint(hu::AIR, nose);
    let bend = (p[1] * 0.055).sin() * 1.8 - 0.4;
    let septum = inside((p[0] - bend).abs() - 0.8, EDGE) * nose;
    tissue.paint(hu::CARTILAGE, septum);
    tissue.paint(hu::THIN_BONE, septum * ((p[1] + 72.0) * 0.1).smoothstep());
    for (z, x, r) in [(-46.0, 8.5, 4.2), (-35.0, 7.5, 3.2)] {
        let turbinate = rod(pair, (v(x, -78.0, z), r), (v(x, -44.0, z - 2.0), r * 0.9));
        tissue.paint(hu::MUSCLE, inside(turbinate, EDGE));
        tissue.paint(hu::THIN_BONE, inside(rod(pair, (v(x, -76.0, z), 0.7), (v(x, -48.0, z - 2.0), 0.7)), EDGE));
    }
    let nostril = rod(pair, (v(6.0, -86.0, -44.0), 3.6), (v(7.0, -101.0, -56.0), 3.8));
    let throat = rod(p, (v(0.0, -34.0, -40.0), 8.0), (v(0.0, -16.0, -60.0), 7.5));
    let larynx = rod(p, (v(0.0, -16.0, -60.0), 7.5), (v(0.0, -20.0, -104.0), 6.5));
    let windpipe = rod(p, (v(0.0, -20.0, -104.0), 6.5), (v(0.0, -26.0, -150.0), 9.0));
    tissue.paint(hu::AIR, inside(join(nostril, join(throat, join(larynx, windpipe, 4.0), 4.0), 4.0), EDGE));
    tissue.blob(hu::AIR, [0.0, -50.0, -60.5], [17.0, 26.0, 2.2]);
    let canal = rod(pair, (v(84.0, 13.0, -18.0), 3.4), (v(44.0, 10.0, -19.0), 2.6));
    tissue.paint(hu::AIR, inside(canal, EDGE));
    // Mastoid: cells with thin walls between them.
    let mastoid = blob(pair, [60.0, 28.0, -28.0], [5.5, 9.0, 12.0], 3.0);
    if mastoid.value() > 0.0 {
        let cells = noise(pair.map(|x| x * 0.24));
        tissue.paint(hu::AIR, mastoid * inside(cells.abs() * -4.0 + 0.7, EDGE));
    }
}

/// The cells between the orbits: paper-thin sheets of bone around air.
fn paint_ethmoid<N: Number>(tissue: &mut Tissue<N>) {
    let block = blob(tissue.pair, [6.5, -58.0, -9.0], [6.5, 23.0, 13.0], EDGE);
    if block.value() == 0.0 {
        return;
    }
    let [x, y, z] = tissue.pair;
    let wall = |t: N, period: f64| (t * (std::f64::consts::PI / period)).sin().abs() * (period / std::f64::consts::PI);
    let sheets = wall(x - 0.5, 6.0).min(wall(y + z * 0.2, 8.5)).min(wall(z - y * 0.15, 9.0));
    tissue.paint(hu::AIR, block);
    tissue.paint(hu::THIN_BONE, inside(sheets - 0.45, EDGE) * block);
}

/// Globe, lens, optic nerve and the four straight muscles.
pub(super) fn paint_eyes<N: Number>(tissue: &mut Tissue<N>) {
    let pair = tissue.pair;
    let globe = length(relative(pair, EYE)) - 12.2;
    if globe.value() > 40.0 {
        return;
    }
    let nerve = rod(pair, (v(31.0, EYE.y + 11.0, -8.0), 2.0), (v(14.0, -34.0, -2.0), 2.0));
    tissue.paint(hu::MUSCLE, inside(nerve, EDGE));
    for (dx, dz) in [(11.0, 0.0), (-11.0, 0.0), (0.0, 11.0), (0.0, -11.0)] {
        let belly = v(EYE.x - 4.0 + dx, -64.0, EYE.z + dz);
        let front = rod(pair, (v(EYE.x + dx, EYE.y + 2.0, EYE.z + dz), 0.8), (belly, 2.2));
        let back = rod(pair, (belly, 2.2), (v(19.0, -42.0, -5.0), 0.8));
        tissue.paint(hu::MUSCLE, inside(front.min(back), EDGE));
    }
    tissue.paint(hu::MUSCLE, inside(globe, EDGE));
    tissue.paint(hu::WATER, inside(globe + 1.4, EDGE));
    tissue.blobs(hu::LENS, [EYE.x, EYE.y - 8.2, EYE.z], [4.6, 2.2, 4.6]);
}

/// The stud in the left ear.
pub(super) fn paint_stud<N: Number>(tissue: &mut Tissue<N>) {
    tissue.blob(hu::ENAMEL, [82.0, 8.0, -40.0], [2.2, 2.2, 2.2]);
}
