//! Brain, ventricles and the membranes between its parts.

use glam::DVec3;

use super::super::noise::{fractal, noise};
use super::super::number::Number;
use super::super::shape::{common, ellipsoid, join, rod};
use super::{EDGE, Tissue, hu};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Paints what lies in the braincase. `cavity` is the distance to its wall.
pub(super) fn paint<N: Number>(tissue: &mut Tissue<N>, cavity: N) {
    if cavity.value() > -1.0 {
        return;
    }
    paint_cerebrum(tissue, cavity);
    paint_ventricles(tissue);
    paint_hindbrain(tissue, cavity);
    // A fresh haemorrhage in the right parietal lobe, with its rim of swelling.
    tissue.blob(hu::WATER + 12.0, [-37.0, 34.0, 50.0], [14.0, 17.0, 13.0]);
    tissue.blob(hu::BLOOD, [-37.0, 34.0, 50.0], [10.0, 13.0, 9.0]);
}

/// Both hemispheres: grey matter folded around white.
fn paint_cerebrum<N: Number>(tissue: &mut Tissue<N>, cavity: N) {
    let (p, pair) = (tissue.p, tissue.pair);
    let [x, y, z] = p;
    // The tent of the cerebellum rises towards the middle; hemispheres end above it.
    let tent = z * -1.0 + 11.0 - (pair[0] * (-1.0 / 34.0) + 1.0).smoothstep() * 9.0;
    let behind = ((y - 8.0) * (1.0 / 20.0)).smoothstep();
    let floor = tent.mix(N::constant(-60.0), -behind + 1.0);
    let bark = common(cavity + 2.2, floor + 1.5, 4.0);
    // The cleft between the hemispheres ends at the corpus callosum.
    let below_cleft = ellipsoid(p, v(0.0, 2.0, 14.0), v(40.0, 44.0, 24.0));
    let cleft = common((x - (y * 0.05).sin() * 0.6).abs() - 1.3, -below_cleft, 6.0);
    // Furrows: where a slowly varying noise changes sign, narrowing with depth.
    let warp = noise(p.map(|x| x * 0.03)) * 0.8;
    let folds = noise([x * 0.062 + warp, y * 0.062 - warp, z * 0.062 + warp + 0.5]).abs() * 12.0
        - fractal(p.map(|x| x * 0.12), 2, 1.0 / 0.12, tissue.seen).square() * 1.5;
    let furrow = folds - 0.6 + (bark + 2.0) * -0.10;
    // The fissure above the temporal lobe.
    let sylvian = common((z - 4.0 - (y + 10.0) * 0.35).abs() - 1.4, (pair[0] - 30.0) * -1.0, 4.0);
    let sylvian = common(sylvian, (y - 26.0).max(y * -1.0 - 36.0), 4.0);
    let surface = common(common(bark, -cleft, 2.0), common(-furrow, -sylvian, 2.0), 1.6);
    tissue.fill(hu::GREY_MATTER, surface, EDGE);
    tissue.fill(hu::WHITE_MATTER, surface + 3.6, 1.6);
    // Deep grey: caudate, lentiform nucleus, thalamus.
    tissue.blobs(hu::GREY_MATTER, [12.5, -16.0, 24.0], [4.5, 9.0, 7.0]);
    tissue.blobs(hu::GREY_MATTER, [24.0, -4.0, 15.0], [6.0, 14.0, 8.5]);
    tissue.blobs(hu::GREY_MATTER, [10.0, 10.0, 17.0], [7.0, 11.0, 7.5]);
    let falx = common(x.abs() - 0.5, -below_cleft + 3.0, 3.0);
    tissue.paint(hu::DURA, tissue.inside(falx, EDGE) * (z * 0.1).smoothstep());
    let sheet = (tent.abs() - 0.5).max((behind - 0.6) * -40.0);
    tissue.fill(hu::DURA, sheet, EDGE);
}

fn paint_ventricles<N: Number>(tissue: &mut Tissue<N>) {
    let pair = tissue.pair;
    // The left ventricle is the wider one.
    let wide = if tissue.p[0].value() > 0.0 { 0.5 } else { 0.0 };
    let points = [
        (v(7.0, -26.0, 24.0), 3.0),
        (v(7.0, -14.0, 29.0), 4.2 + wide),
        (v(9.0, 14.0, 33.0), 4.0 + wide),
        (v(19.0, 34.0, 24.0), 6.0 + wide),
        (v(17.0, 54.0, 19.0), 2.4),
    ];
    let body = points.windows(2).map(|ends| rod(pair, ends[0], ends[1]));
    let temporal = rod(pair, points[3], (v(31.0, 8.0, 0.0), 1.8));
    let lateral = body.fold(temporal, |union, part| join(union, part, 3.0));
    tissue.fill(hu::WATER, lateral, EDGE);
    tissue.blob(hu::WATER, [0.0, 3.0, 15.0], [2.2, 12.0, 9.0]);
    // Calcified choroid plexus and pineal gland.
    tissue.blobs(hu::SPONGE, [19.0, 35.0, 22.0], [1.8, 3.0, 1.8]);
    tissue.blob(hu::MARROW, [0.0, 21.0, 14.0], [2.0, 2.4, 2.0]);
}

/// Cerebellum, brain stem and spinal cord.
fn paint_hindbrain<N: Number>(tissue: &mut Tissue<N>, cavity: N) {
    let (p, pair) = (tissue.p, tissue.pair);
    let [x, y, z] = p;
    let lobes = ellipsoid(pair, v(21.0, 54.0, -15.0), v(26.0, 29.0, 25.0));
    let worm = ellipsoid(p, v(0.0, 52.0, -11.0), v(12.0, 24.0, 24.0));
    let cerebellum = common(join(lobes, worm, 6.0), cavity + 2.2, 3.0);
    // Leaves: thin parallel folds around the stem.
    let leaves = ((z - (y - 40.0) * 0.35 + x.square() * 0.004) * 1.05).sin();
    tissue.fill(hu::GREY_MATTER, cerebellum, EDGE);
    tissue.paint(
        hu::WATER,
        tissue.inside(cerebellum, EDGE) * tissue.inside(leaves * 2.0 + 2.3 - (cerebellum + 5.0) * 0.6, 2.0) * 0.7,
    );
    tissue.fill(hu::WHITE_MATTER, cerebellum + 8.0 + leaves, 2.0);
    let midbrain = ellipsoid(p, v(0.0, 12.0, -2.0), v(15.0, 12.0, 14.0));
    let pons = ellipsoid(p, v(0.0, 10.0, -18.0), v(16.0, 13.0, 14.0));
    let medulla = rod(p, (v(0.0, 17.0, -26.0), 9.5), (v(0.0, 32.0, -58.0), 5.8));
    let cord = rod(p, (v(0.0, 32.0, -58.0), 5.8), (v(0.0, 36.5, -160.0), 5.6));
    let stem = join(join(midbrain, pons, 5.0), join(medulla, cord, 3.0), 4.0);
    let stem = join(stem, rod(pair, (v(8.0, 14.0, -16.0), 7.0), (v(20.0, 40.0, -16.0), 7.0)), 4.0);
    tissue.fill(hu::WHITE_MATTER + 3.0, stem, EDGE);
    tissue.blob(hu::WATER, [0.0, 29.0, -16.0], [6.5, 4.0, 9.0]);
}
