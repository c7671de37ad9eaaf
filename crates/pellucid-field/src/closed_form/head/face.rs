//! Skin, flesh, airways, eyes and ears.

use glam::DVec3;

use super::super::noise::{fractal, noise};
use super::super::number::Number;
use super::super::shape::{bar, blob, common, ellipsoid, join, length, position, relative, ring, rod};
use super::{EDGE, Tissue, both_sides, hu};

const EYE: DVec3 = DVec3::new(31.5, -74.5, -8.0);

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Distance to the skin.
pub(super) fn skin<N: Number>(p: [N; 3]) -> N {
    let pair = both_sides(p, 4.5);
    let skull = ellipsoid(p, v(0.0, 9.0, 25.0), v(78.0, 99.0, 85.0));
    let face = ellipsoid(p, v(0.0, -34.0, -44.0), v(60.0, 58.0, 62.0));
    let jaw = rod(pair, (v(40.0, -20.0, -76.0), 18.0), (v(9.0, -72.0, -94.0), 19.0));
    let neck = ellipsoid(p, v(0.0, 20.0, -120.0), v(55.0, 58.0, 130.0));
    let throat = common(neck, p[2] + 20.0, 30.0);
    let temple = rod(pair, (v(46.0, -57.0, -27.0), 16.0), (v(54.0, 26.0, -32.0), 18.0));
    let cheek = ellipsoid(pair, v(32.0, -40.0, -58.0), v(18.0, 30.0, 20.0));
    let low = join(join(jaw, cheek, 16.0), throat, 22.0);
    let mut skin = join(join(join(skull, face, 26.0), temple, 26.0), low, 28.0);
    let at = position(p);
    if position_is_far(skin) {
        return skin;
    }
    if at.y > -30.0 {
        let near = (at - v(79.0 * at.x.signum(), 15.0, -14.0)).abs().cmplt(v(32.0, 36.0, 48.0)).all();
        return if near { join(skin, ear(pair), 4.0) } else { skin };
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
    let nostril = rod(pair, (v(5.5, -96.0, -44.0), 3.0), (v(7.5, -102.0, -57.0), 3.2));
    skin = common(skin, -nostril, 2.5);
    let upper_lip = rod(pair, (v(0.0, -92.0, -67.0), 6.0), (v(21.0, -82.0, -70.0), 2.5));
    let lower_lip = rod(pair, (v(0.0, -91.0, -77.0), 6.5), (v(19.0, -82.0, -72.0), 2.5));
    skin = join(skin, upper_lip.min(lower_lip), 4.0);
    // The mole on the left cheek.
    let mole = length(relative(p, v(36.0, -83.0, -52.0))) - 2.1;
    join(skin, mole, 1.5)
}

/// Nothing on the surface stands out further than the tip of the nose and the rim of an ear.
fn position_is_far<N: Number>(skin: N) -> bool {
    skin.value() > 45.0 || skin.value() < -40.0
}

/// Distance to an ear: a plate that stands off at the back, with a rolled rim (helix), the fold inside it, a bowl, the
/// flap in front of the bowl (tragus) and a lobe.
fn ear<N: Number>(pair: [N; 3]) -> N {
    let [x, y, z] = relative(pair, v(78.0, 15.0, -14.0));
    let (x, y) = (x * 0.87 - y * 0.5, x * 0.5 + y * 0.87);
    let y = y + z * -0.22;
    let q = [x, y, z];
    // Egg-shaped: the outline narrows downwards.
    let wide = [x, y * (z * -0.009 + 1.08), z];
    let shell = ellipsoid(wide, v(0.0, 0.0, 0.0), v(3.4, 15.5, 27.0));
    let rim = ring([wide[1] * 1.72, x * 1.3 - 1.2, z], v(0.0, 0.0, 1.0), 25.0, 3.0) * 0.7;
    let rim = common(rim, (y + 9.0) * -1.0 - z * 0.25, 5.0);
    let fold = ring([(wide[1] - 1.0) * 1.7, x * 1.3 - 1.0, z - 2.0], v(0.0, 0.0, 0.0), 15.5, 2.6) * 0.7;
    let fold = common(fold, y * -1.0 - z * 0.2 - 1.0, 5.0);
    let bowl = ellipsoid(q, v(6.5, -4.0, -5.0), v(7.5, 8.0, 11.0));
    let tragus = ellipsoid(q, v(2.0, -12.5, -6.0), v(3.2, 4.0, 5.5));
    let lobe = ellipsoid(q, v(0.5, -4.5, -24.0), v(3.6, 6.5, 7.5));
    let canal = rod(q, (v(-10.0, -7.0, -5.0), 3.0), (v(4.0, -7.0, -5.0), 3.4));
    let plate = common(join(join(shell, rim, 3.0), fold, 3.0), -join(bowl, canal, 3.0), 3.5);
    join(join(plate, tragus, 4.0), lobe, 5.0)
}

/// Fat under the skin, muscle under the fat, and the planes of fat between muscles.
pub(super) fn paint_flesh<N: Number>(tissue: &mut Tissue<N>, skin: N) {
    if skin.value() > -1.0 {
        return;
    }
    let p = tissue.p;
    let fold = fractal(p.map(|x| x * (1.0 / 17.0)), 2, 17.0, tissue.seen);
    tissue.fill(hu::FAT, skin + 2.4, 1.6);
    // Cheeks and neck are fatter than the scalp.
    let low = ((p[2] + 10.0) * (-1.0 / 40.0)).smoothstep();
    let muscle = skin + fold * 3.0 + low * 4.0 + 5.5;
    tissue.fill(hu::MUSCLE, muscle, 2.0);
    // Planes of fat: where a slowly varying noise changes sign.
    let plane = noise([p[0] * 0.05, p[1] * 0.05, p[2] * 0.022]).abs() * 18.0 - 0.5;
    tissue.paint(hu::FAT, tissue.inside(common(plane, muscle + 2.0, 1.0), 1.6) * low);
    // What is painted whole must not reach the skin, or its outline would show there.
    let under = tissue.inside(skin + 5.0, 3.0);
    let pair = tissue.pair;
    for (center, radii) in [([31.0, -78.0, -46.0], [13.0, 9.0, 13.0]), ([50.0, -46.0, -52.0], [6.0, 14.0, 14.0])] {
        tissue.paint(hu::FAT, blob(pair, center, radii, EDGE, tissue.seen) * under);
    }
    // Masseter, temporal muscle and the long muscle of the neck.
    for (center, radii) in [([54.0, -22.0, -56.0], [6.5, 15.0, 26.0]), ([66.0, -26.0, 4.0], [6.0, 28.0, 28.0])] {
        tissue.paint(hu::MUSCLE, blob(pair, center, radii, EDGE, tissue.seen) * under);
    }
    let long = bar(pair, (v(62.0, 34.0, -44.0), 8.0), (v(34.0, -8.0, -145.0), 11.0), 1.6, tissue.seen);
    tissue.paint(hu::MUSCLE, long * under);
    tissue.blob(hu::MUSCLE, [0.0, -52.0, -74.0], [21.0, 28.0, 14.0]);
    // Cartilage of nose and ears.
    tissue.rods(hu::CARTILAGE, (v(0.0, -98.0, -22.0), 1.6), (v(0.0, -108.0, -44.0), 2.2));
}

/// Whatever is full of air: sinuses, nose, mouth, throat, ear canals and the mastoid.
pub(super) fn paint_airways<N: Number>(tissue: &mut Tissue<N>, skin: N) {
    let (p, pair) = (tissue.p, tissue.pair);
    if p[2].value() > 40.0 || p[1].value() > 50.0 {
        return;
    }
    // Frontal sinuses, the left one larger; the divided sphenoid sinus.
    tissue.blob(hu::AIR, [9.0, -75.5, 13.5], [7.0, 2.2, 5.5]);
    tissue.blob(hu::AIR, [-8.0, -75.5, 12.5], [5.5, 2.0, 5.0]);
    tissue.blob(hu::AIR, [7.5, -26.0, -13.0], [7.0, 11.0, 8.5]);
    tissue.blob(hu::AIR, [-7.0, -27.0, -13.0], [5.5, 9.0, 7.5]);
    tissue.blobs(hu::AIR, [26.0, -58.0, -39.0], [10.5, 11.0, 13.5]);
    paint_ethmoid(tissue);
    // Nasal cavity, then what stands in it: the bent septum and the turbinates.
    let nose = blob(pair, [6.0, -62.0, -36.0], [8.5, 33.0, 20.0], EDGE, tissue.seen) * tissue.inside(skin + 4.0, EDGE);
    tissue.paint(hu::AIR, nose);
    let bend = (p[1] * 0.055).sin() * 1.8 - 0.4;
    let septum = tissue.inside((p[0] - bend).abs() - 0.8, EDGE) * nose;
    tissue.paint(hu::CARTILAGE, septum);
    tissue.paint(hu::THIN_BONE, septum * ((p[1] + 72.0) * 0.1).smoothstep());
    for (z, x, r) in [(-46.0, 8.5, 4.2), (-35.0, 7.5, 3.2)] {
        tissue.rods(hu::MUSCLE, (v(x, -78.0, z), r), (v(x, -44.0, z - 2.0), r * 0.9));
        tissue.rods(hu::THIN_BONE, (v(x, -76.0, z), 0.7), (v(x, -48.0, z - 2.0), 0.7));
    }
    tissue.rods(hu::AIR, (v(6.0, -86.0, -44.0), 3.6), (v(6.0, -96.0, -45.0), 3.0));
    if pair[0].value() < 20.0 {
        let throat = rod(p, (v(0.0, -34.0, -40.0), 8.0), (v(0.0, -16.0, -60.0), 7.5));
        let larynx = rod(p, (v(0.0, -16.0, -60.0), 7.5), (v(0.0, -20.0, -104.0), 6.5));
        let windpipe = rod(p, (v(0.0, -20.0, -104.0), 6.5), (v(0.0, -26.0, -150.0), 9.0));
        tissue.fill(hu::AIR, join(throat, join(larynx, windpipe, 4.0), 4.0), EDGE);
    }
    tissue.blob(hu::AIR, [0.0, -50.0, -60.5], [17.0, 26.0, 2.2]);
    tissue.rods(hu::AIR, (v(68.0, 11.0, -18.0), 3.2), (v(44.0, 10.0, -19.0), 2.6));
    // Mastoid: cells with thin walls between them.
    let mastoid = blob(pair, [58.0, 28.0, -26.0], [3.5, 6.5, 8.0], 3.0, tissue.seen);
    if mastoid.value() > 0.0 {
        let cells = noise(pair.map(|x| x * 0.24));
        tissue.paint(hu::AIR, mastoid * tissue.inside(cells.abs() * -4.0 + 0.7, EDGE));
    }
}

/// The cells between the orbits: paper-thin sheets of bone around air.
fn paint_ethmoid<N: Number>(tissue: &mut Tissue<N>) {
    let block = blob(tissue.pair, [6.5, -58.0, -9.0], [6.5, 23.0, 13.0], EDGE, tissue.seen);
    if block.value() == 0.0 {
        return;
    }
    let [x, y, z] = tissue.pair;
    let wall = |t: N, period: f64| (t * (std::f64::consts::PI / period)).sin().abs() * (period / std::f64::consts::PI);
    let sheets = wall(x - 0.5, 6.0).min(wall(y + z * 0.2, 8.5)).min(wall(z - y * 0.15, 9.0));
    tissue.paint(hu::AIR, block);
    tissue.paint(hu::THIN_BONE, tissue.inside(sheets - 0.45, EDGE) * block);
}

/// Globe, lens, optic nerve and the four straight muscles.
pub(super) fn paint_eyes<N: Number>(tissue: &mut Tissue<N>) {
    let pair = tissue.pair;
    let globe = length(relative(pair, EYE)) - 12.2;
    if globe.value() > 40.0 {
        return;
    }
    tissue.rods(hu::MUSCLE, (v(31.0, EYE.y + 11.0, -8.0), 2.0), (v(14.0, -34.0, -2.0), 2.0));
    for (dx, dz) in [(11.0, 0.0), (-11.0, 0.0), (0.0, 11.0), (0.0, -11.0)] {
        let belly = v(EYE.x - 4.0 + dx, -64.0, EYE.z + dz);
        tissue.rods(hu::MUSCLE, (v(EYE.x + dx, EYE.y + 2.0, EYE.z + dz), 0.8), (belly, 2.2));
        tissue.rods(hu::MUSCLE, (belly, 2.2), (v(19.0, -42.0, -5.0), 0.8));
    }
    tissue.fill(hu::MUSCLE, globe, EDGE);
    tissue.fill(hu::WATER, globe + 1.4, EDGE);
    tissue.blobs(hu::LENS, [EYE.x, EYE.y - 8.2, EYE.z], [4.6, 2.2, 4.6]);
}
