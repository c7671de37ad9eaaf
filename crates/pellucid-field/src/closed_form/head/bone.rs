//! The skull and the upper spine.

use glam::DVec3;

use super::super::footprint::inside;
use super::super::noise::fractal;
use super::super::number::Number;
use super::super::shape::{Path, common, ellipsoid, join, length, relative, ring, rod};
use super::{EDGE, Tissue, hu};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Distance to the space the brain and the spinal cord lie in.
pub(super) fn cavity<N: Number>(p: [N; 3], pair: [N; 3]) -> N {
    let vault = ellipsoid(p, v(0.0, 10.0, 26.0), v(65.0, 84.0, 68.0));
    // Three steps of the floor from front to back: over the orbits, where it dips to the nose;
    // beside the sella, which stands up in the middle; under the cerebellum.
    let middle = (pair[0] * (-1.0 / 20.0) + 1.0).smoothstep();
    let step = |from: f64, over: f64| ((p[1] - from) * over.recip()).smoothstep();
    let floor = (middle * -8.0 + 13.0).mix(middle * 20.0 - 26.0, step(-46.0, 26.0));
    let floor = floor.mix(N::constant(-50.0), step(2.0, 24.0));
    let upper = common(vault, (floor - p[2]) * 0.7, 10.0);
    let temporal = ellipsoid(pair, v(36.0, -4.0, -1.0), v(25.0, 32.0, 23.0));
    let posterior = ellipsoid(p, v(0.0, 45.0, -10.0), v(48.0, 38.0, 31.0));
    let stem = rod(p, (v(0.0, 20.0, -10.0), 15.0), (v(0.0, 33.0, -56.0), 10.5));
    let canal = rod(p, (v(0.0, 33.0, -56.0), 10.0), (v(0.0, 37.0, -160.0), 9.5));
    let hollow = join(join(join(upper, temporal, 9.0), posterior, 9.0), join(stem, canal, 4.0), 8.0);
    // The petrous ridges stand up between the temporal lobes and the cerebellum.
    let ridge = rod(pair, (v(62.0, 20.0, -20.0), 12.0), (v(16.0, -4.0, -21.0), 6.0));
    common(hollow, -ridge, 6.0)
}

/// How far from a bone its distance is of interest: beyond all fillets and edges.
const REACH: f64 = 30.0;

/// Bones that are rods: jaw, cheek and hyoid.
#[derive(Clone, Debug)]
pub(super) struct Rods {
    jaw: Vec<Path>,
    arch: Path,
    hyoid: Path,
}

impl Rods {
    pub fn new() -> Self {
        let jaw = [
            // Condyle, neck, angle, body, chin; coronoid process; the ridge that carries the teeth.
            &[
                [50.0, 1.0, -29.0, 5.5],
                [49.5, 2.0, -40.0, 4.6],
                [47.0, -4.0, -70.0, 5.5],
                [42.0, -18.0, -86.0, 6.5],
                [28.0, -54.0, -94.0, 7.0],
                [13.0, -78.0, -97.0, 7.5],
                [0.0, -82.0, -97.0, 8.0],
            ][..],
            &[[48.5, -25.0, -36.0, 2.2], [48.0, -22.0, -55.0, 4.5], [42.0, -24.0, -76.0, 6.0]],
            &[
                [39.0, -22.0, -80.0, 5.0],
                [28.5, -46.0, -83.0, 5.2],
                [24.0, -62.0, -85.0, 5.2],
                [14.0, -77.0, -86.5, 5.2],
                [0.0, -82.5, -87.5, 5.2],
            ],
        ];
        Self {
            jaw: jaw.map(Path::smooth).to_vec(),
            arch: Path::smooth(&[
                [44.0, -68.0, -29.0, 6.5],
                [56.0, -56.0, -29.0, 4.8],
                [62.5, -34.0, -29.5, 3.2],
                [64.0, -14.0, -28.0, 3.2],
                [62.0, 3.0, -25.0, 4.5],
            ]),
            hyoid: Path::smooth(&[[0.0, -40.0, -108.0, 4.0], [12.0, -36.0, -108.0, 3.0], [21.0, -18.0, -104.0, 2.0]]),
        }
    }
}

/// Paints every bone but the teeth.
pub(super) fn paint<N: Number>(tissue: &mut Tissue<N>, cavity: N, skin: N, rods: &Rods) {
    paint_braincase(tissue, cavity);
    if tissue.p[2].value() < 40.0 {
        paint_face(tissue, cavity, skin, rods);
        paint_jaw(tissue, rods);
        paint_spine(tissue);
    }
}

fn paint_braincase<N: Number>(tissue: &mut Tissue<N>, cavity: N) {
    let (p, pair) = (tissue.p, tissue.pair);
    if cavity.value() > 34.0 {
        return;
    }
    // Thick in the vault, thinner at the base; no skull around the canal below it.
    let vault = ((p[2] + 6.0) * (1.0 / 36.0)).smoothstep();
    let mut thickness = vault * 3.6 + 3.4;
    if p[2].value() > 8.0 {
        thickness = thickness - sutures(p) * vault * 1.3;
    }
    let below = p[2] * -1.0 - 46.0;
    let shell = common(cavity - thickness, below, 4.0);
    tissue.paint(hu::BONE, tissue.inside_smooth(shell));
    if vault.value() > 0.0 {
        let pores = fractal(p.map(|x| x * 0.3), 2, 1.0 / 0.3, tissue.seen) * 1.1;
        let diploe = (cavity - thickness * 0.5).abs() - 1.6 + pores;
        tissue.paint(hu::SPONGE, tissue.inside(diploe, 1.5) * vault);
    }
    // The petrous pyramids with the mastoid behind them, and the body of the sphenoid.
    let petrous = rod(pair, (v(58.0, 16.0, -18.0), 12.0), (v(13.0, -6.0, -19.0), 6.0));
    let mastoid = ellipsoid(pair, v(56.0, 27.0, -29.0), v(9.0, 13.0, 17.0));
    let sphenoid = ellipsoid(p, v(0.0, -22.0, -13.0), v(18.0, 19.0, 13.0));
    let clivus = rod(p, (v(0.0, -4.0, -14.0), 8.0), (v(0.0, 14.0, -44.0), 5.0));
    let base = join(join(petrous, mastoid, 6.0), join(sphenoid, clivus, 5.0), 4.0);
    tissue.fill(hu::BONE, base, EDGE);
    tissue.fill(hu::MARROW, join(sphenoid, clivus, 5.0) + 2.5, 2.0);
    // Inner ear: three canals and the vestibule, thinner than a voxel of a usual scan.
    let labyrinth = v(38.0, 10.0, -16.0);
    let [x, y, z] = relative(pair, labyrinth);
    let canal = |q: [N; 3], shift: f64| ring(q, v(shift, 0.0, shift), 3.4, 0.7);
    let canals = canal([x, z, y], 2.2).min(canal([x, y, z], 2.2)).min(canal([z, x, y], 2.2));
    tissue.fill(hu::WATER, canals.min(length([x, y, z]) - 2.0), 1.0);
}

/// Where the plates of the vault meet, 0 to 1: the coronal, the sagittal and the lambdoid suture, winding as they do.
fn sutures<N: Number>(p: [N; 3]) -> N {
    let [x, y, z] = p;
    let wind = |t: N| (t * 0.55).sin() * 0.9 + (t * 1.13 + 1.0).sin() * 0.7;
    let side = x.abs();
    let coronal = y + 22.0 - (z - 60.0) * 0.35 + wind(side + z);
    let lambdoid = (y - 78.0) * 0.8 + (z - 52.0) * 0.35 + side * 0.55 + wind(side - z * 0.6);
    let groove = |t: N| inside(t.abs(), 4.5) * 2.0;
    let line = groove(coronal).max(groove(lambdoid));
    // The sagittal suture runs between the two others.
    let between = inside(coronal * -1.0, 4.0) * inside(lambdoid, 4.0);
    line.max(groove(x + wind(y)) * between * inside(z * -1.0 + 40.0, 8.0))
}

/// The orbit: a cone that narrows towards the optic canal.
fn orbit<N: Number>(pair: [N; 3]) -> N {
    rod(pair, (v(34.0, -78.0, -8.0), 17.5), (v(17.0, -40.0, -3.0), 5.0))
}

fn paint_face<N: Number>(tissue: &mut Tissue<N>, cavity: N, skin: N, rods: &Rods) {
    let (p, pair) = (tissue.p, tissue.pair);
    if p[1].value() > 10.0 {
        return;
    }
    let orbit = orbit(pair);
    // The opening of the orbit recedes towards the temple.
    let open = p[1] * -1.0 - 86.0 + (pair[0] - 33.0) * 0.55;
    let [x, y, z] = relative(pair, v(33.0, -80.0, -8.0));
    let rim = ring([x, y - x * 0.5, z], DVec3::ZERO, 20.5, 4.2);
    let maxilla = ellipsoid(pair, v(20.0, -62.0, -42.0), v(20.0, 20.0, 20.0));
    let alveolar = ellipsoid(p, v(0.0, -59.0, -60.0), v(32.5, 29.0, 8.5));
    let glabella = rod(pair, (v(0.0, -77.0, 10.0), 7.5), (v(34.0, -68.0, 14.0), 5.5));
    let nasal = rod(pair, (v(2.0, -81.0, 5.0), 5.0), (v(2.0, -90.0, -15.0), 3.2));
    let bridge = rod(pair, (v(3.5, -86.0, -10.0), 3.4), (v(14.0, -78.0, -22.0), 4.0));
    let frontal_process = rod(pair, (v(8.5, -80.0, -1.0), 4.5), (v(16.0, -77.0, -38.0), 6.0));
    let pterygoid = ellipsoid(pair, v(14.0, -32.0, -44.0), v(1.3, 9.0, 17.0));
    let face = join(join(maxilla, alveolar, 6.0), join(rim, rods.arch.distance(pair, REACH), 6.0), 4.0);
    let face = join(face, join(join(join(nasal, bridge, 5.0), frontal_process, 6.0), glabella, 6.0), 5.0);
    // The brow grows out of the braincase, whose spongy bone begins above it little by little.
    let above = ((p[2] - 6.0) * (1.0 / 32.0)).smoothstep();
    let forehead = common(cavity - 3.0 + above * 12.0, p[1] + 40.0, 4.0);
    let face = join(face, forehead, 9.0).min(pterygoid);
    tissue.fill(hu::BONE, common(face, skin + 3.5, 3.0), EDGE);
    tissue.fill(hu::SPONGE, join(alveolar, maxilla, 6.0) + 2.2, 2.0);
    // A thin wall around the orbit, then its fat.
    let temple = ((pair[0] - 27.0) * (1.0 / 14.0)).smoothstep();
    let wall = common(common(orbit - 1.6 - temple * 2.4, open, 2.0), skin + 6.0, 2.0);
    tissue.coat(hu::THIN_BONE, wall, common(orbit, skin + 3.0, 2.0), EDGE);
    tissue.fill(hu::FAT, common(orbit, skin + 3.0, 2.0), EDGE);
    // The pear-shaped opening of the nose.
    let pear = ellipsoid(p, v(0.0, -88.0, -36.0), v(11.5, 12.0, 17.0));
    tissue.fill(hu::MUSCLE, pear, EDGE);
}

fn paint_jaw<N: Number>(tissue: &mut Tissue<N>, rods: &Rods) {
    let (p, pair) = (tissue.p, tissue.pair);
    if p[2].value() > -20.0 || p[1].value() > 15.0 {
        return;
    }
    let ramus = ellipsoid(pair, v(47.5, -11.0, -58.0), v(3.6, 14.0, 24.0));
    let chin = ellipsoid(p, v(0.0, -86.0, -100.0), v(12.0, 6.0, 7.0));
    let far = N::constant(60.0);
    let jaw = rods.jaw.iter().fold(far, |jaw, path| join(jaw, path.distance(pair, REACH), 5.0));
    let jaw = join(join(jaw, ramus, 4.0), chin, 5.0);
    tissue.fill(hu::BONE, jaw, EDGE);
    tissue.fill(hu::MARROW, jaw + 2.8, 2.0);
    let hyoid = rods.hyoid.inside(pair, EDGE, tissue.seen);
    tissue.paint(hu::THIN_BONE, hyoid);
}

fn paint_spine<N: Number>(tissue: &mut Tissue<N>) {
    let (p, pair) = (tissue.p, tissue.pair);
    if p[2].value() > -40.0 || p[1].value() < -20.0 {
        return;
    }
    // Atlas: a ring around the canal with thick sides; axis: a body with a tooth.
    let [x, y, z] = relative(p, v(0.0, 30.0, -63.0));
    let atlas = join(
        ring([x * 0.8, z, y], DVec3::ZERO, 17.5, 4.2),
        ellipsoid(pair, v(22.0, 24.0, -62.0), v(8.5, 10.0, 8.0)),
        4.0,
    );
    let tooth = rod(p, (v(0.0, 16.0, -84.0), 6.0), (v(0.0, 17.0, -58.0), 4.6));
    let mut bone = atlas.min(tooth);
    let mut core = tooth + 2.2;
    for (level, z) in [-83.0, -102.0, -120.5, -139.0].into_iter().enumerate() {
        if (p[2].value() - z).abs() > REACH {
            continue;
        }
        let y = 35.0 + level as f64 * 0.7;
        let [dx, dy, dz] = relative(p, v(0.0, y - 20.0, z));
        // Drum-shaped: flat ends, waisted sides.
        let drum = common((dx.square() * 0.7 + dy.square()).sqrt() - 9.2 - dz.square() * 0.015, dz.abs() - 7.8, 3.0);
        let pillar = ellipsoid(pair, v(20.0, y - 4.0, z), v(6.5, 7.5, 10.5));
        let pedicle = rod(pair, (v(7.0, y - 19.0, z), 4.0), (v(19.0, y - 8.0, z), 3.6));
        let [ax, ay, az] = relative(p, v(0.0, y, z - 2.0));
        let arch = common(ring([ax * 0.82, az * 0.6, ay], DVec3::ZERO, 14.5, 3.0), ay * -1.0, 6.0);
        let spine =
            rod(p, (v(0.0, y + 14.0, z - 3.0), 3.4), (v(0.0, y + 27.0, z - 9.0), if level == 0 { 5.5 } else { 3.2 }));
        bone = bone.min(join(join(drum, join(pillar, pedicle, 3.0), 3.0), join(arch, spine, 4.0), 3.0));
        core = core.min(drum + 1.8);
    }
    tissue.fill(hu::BONE, bone, EDGE);
    tissue.fill(hu::MARROW, core, 2.0);
}
