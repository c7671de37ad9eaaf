//! Arteries and veins full of contrast agent.

use glam::DVec3;

use super::super::number::Number;
use super::super::shape::{Bundle, Path};
use super::{EDGE, Tissue, hu};

/// Vessels: those in pairs (given on the left), and those that are alone.
#[derive(Clone, Debug)]
pub(super) struct Vessels {
    outer_arteries: Bundle,
    paired_arteries: Bundle,
    single_arteries: Bundle,
    paired_veins: Bundle,
    single_veins: Bundle,
}

/// Courses of arteries that come in pairs: x, y, z and radius.
const PAIRED_ARTERIES: [&[[f64; 4]]; 9] = [
    // Common and internal carotid, through the petrous bone and the siphon to the circle of Willis.
    &[
        [26.0, 4.0, -150.0, 3.6],
        [27.0, 4.0, -125.0, 3.6],
        [28.0, 2.0, -108.0, 4.2],
        [27.0, 4.0, -90.0, 2.7],
        [25.0, 5.0, -60.0, 2.5],
        [25.0, 5.0, -36.0, 2.5],
        [24.0, 3.0, -26.0, 2.4],
        [15.0, -3.0, -20.0, 2.4],
        [10.0, -7.0, -11.0, 2.3],
        [10.0, -16.0, -8.0, 2.3],
        [11.0, -19.0, -2.0, 2.2],
        [11.0, -13.0, 3.0, 2.2],
        [12.0, -12.0, 7.0, 2.1],
    ],
    // Middle cerebral artery and its branches over the insula and the hemisphere.
    &[[12.0, -12.0, 7.0, 1.9], [22.0, -15.0, 6.0, 1.8], [33.0, -14.0, 7.0, 1.7], [42.0, -10.0, 10.0, 1.6]],
    &[
        [42.0, -10.0, 10.0, 1.4],
        [46.0, -2.0, 20.0, 1.3],
        [53.0, 2.0, 32.0, 1.2],
        [53.0, 10.0, 48.0, 1.0],
        [44.0, 18.0, 66.0, 0.8],
    ],
    &[
        [42.0, -10.0, 10.0, 1.4],
        [48.0, 4.0, 14.0, 1.3],
        [56.0, 18.0, 22.0, 1.2],
        [57.0, 36.0, 30.0, 1.0],
        [48.0, 56.0, 42.0, 0.8],
    ],
    &[[42.0, -10.0, 10.0, 1.3], [48.0, -20.0, 20.0, 1.2], [50.0, -28.0, 34.0, 1.0], [43.0, -34.0, 54.0, 0.8]],
    &[[48.0, 4.0, 14.0, 1.1], [56.0, 12.0, 6.0, 1.0], [58.0, 30.0, 8.0, 0.9], [52.0, 52.0, 12.0, 0.8]],
    // Anterior cerebral artery, up and back over the corpus callosum.
    &[
        [12.0, -12.0, 7.0, 1.6],
        [6.0, -19.0, 9.0, 1.5],
        [2.4, -26.0, 12.0, 1.5],
        [2.4, -42.0, 20.0, 1.4],
        [2.6, -47.0, 34.0, 1.3],
        [2.6, -36.0, 48.0, 1.2],
        [2.6, -8.0, 54.0, 1.1],
        [2.6, 24.0, 50.0, 0.9],
    ],
    // Posterior cerebral artery and posterior communicating artery.
    &[
        [0.0, -3.0, 0.0, 1.7],
        [9.0, -1.0, 1.0, 1.6],
        [18.0, 12.0, 3.0, 1.5],
        [18.0, 28.0, 9.0, 1.3],
        [12.0, 46.0, 14.0, 1.1],
        [10.0, 68.0, 18.0, 0.8],
    ],
    &[[12.0, -12.0, 6.0, 1.0], [10.0, -6.0, 3.0, 0.9], [9.0, -1.0, 1.0, 1.0]],
];

/// External carotid, superficial temporal artery up to the temple, and the beginning of the facial artery.
const OUTER_ARTERIES: [&[[f64; 4]]; 2] = [
    &[
        [28.0, 2.0, -108.0, 2.6],
        [36.0, -4.0, -86.0, 2.2],
        [45.0, 6.0, -60.0, 1.9],
        [58.0, 4.0, -40.0, 1.7],
        [67.0, 1.0, -22.0, 1.5],
        [70.5, -4.0, 0.0, 1.0],
    ],
    &[[34.0, -4.0, -92.0, 1.8], [38.0, -24.0, -101.0, 1.5], [34.0, -44.0, -106.0, 1.1]],
];

/// Transverse and sigmoid sinus, then the jugular vein.
const PAIRED_VEINS: [&[[f64; 4]]; 1] = [&[
    [0.0, 90.0, 9.0, 3.4],
    [20.0, 87.0, 9.0, 3.4],
    [33.0, 74.0, 6.0, 3.4],
    [44.0, 58.0, 2.0, 3.4],
    [44.0, 44.0, -12.0, 3.6],
    [35.0, 30.0, -26.0, 3.6],
    [32.0, 16.0, -34.0, 3.8],
    [32.0, 14.0, -60.0, 4.2],
    [35.0, 12.0, -100.0, 5.0],
    [36.0, 10.0, -150.0, 5.6],
]];

impl Vessels {
    pub fn new() -> Self {
        let vertebral = |side: f64| {
            let course = [
                [20.0, 20.0, -150.0, 1.9],
                [20.0, 20.0, -80.0, 1.9],
                [26.0, 24.0, -66.0, 1.9],
                [17.0, 36.0, -56.0, 1.8],
                [8.0, 22.0, -44.0, 1.8],
                [0.0, 4.0, -28.0, 1.7],
            ];
            Path::smooth(&course.map(|[x, y, z, r]| [x * side, y, z, r]))
        };
        let basilar = Path::smooth(&[
            [0.0, 4.0, -28.0, 1.9],
            [1.0, -3.0, -18.0, 1.9],
            [-0.5, -5.0, -8.0, 1.8],
            [0.0, -3.0, 0.0, 1.8],
        ]);
        let aneurysm = Path::smooth(&[
            [42.0, -10.0, 10.0, 1.6],
            [45.0, -14.0, 8.0, 2.2],
            [47.0, -16.0, 7.0, 5.2],
            [47.5, -16.5, 6.8, 5.2],
        ]);
        // The superior sagittal sinus runs along the inside of the vault, from the brow to the back.
        let sagittal = (0..=16).map(|i| {
            let t = -1.15 + 2.95 * f64::from(i) / 16.0;
            (DVec3::new(0.0, 10.0 + 81.5 * t.sin(), 26.0 + 65.5 * t.cos()), 1.4 + 0.13 * f64::from(i))
        });
        let straight = Path::smooth(&[[0.0, 26.0, 22.0, 1.6], [0.0, 50.0, 22.0, 1.8], [0.0, 88.0, 10.0, 2.4]]);
        Self {
            outer_arteries: Bundle::new(&OUTER_ARTERIES.map(Path::smooth)),
            paired_arteries: Bundle::new(&PAIRED_ARTERIES.map(Path::smooth)),
            single_arteries: Bundle::new(&[vertebral(1.0), vertebral(-1.0), basilar, aneurysm]),
            paired_veins: Bundle::new(&PAIRED_VEINS.map(Path::smooth)),
            single_veins: Bundle::new(&[Path::through(sagittal.collect()), straight]),
        }
    }

    /// Paints the arteries of face and scalp. They lie on bone, so bone is painted after them.
    pub fn paint_outer<N: Number>(&self, tissue: &mut Tissue<N>, skin: N) {
        let share = self.outer_arteries.inside(tissue.pair, EDGE, tissue.seen);
        if share.value() > 0.0 {
            tissue.paint(hu::ARTERY, share * tissue.inside(skin + 3.0, 2.0));
        }
    }

    /// Paints everything else.
    pub fn paint<N: Number>(&self, tissue: &mut Tissue<N>) {
        tissue.paint(hu::VEIN, self.paired_veins.inside(tissue.pair, EDGE, tissue.seen));
        tissue.paint(hu::VEIN, self.single_veins.inside(tissue.p, EDGE, tissue.seen));
        tissue.paint(hu::ARTERY, self.paired_arteries.inside(tissue.pair, EDGE, tissue.seen));
        tissue.paint(hu::ARTERY, self.single_arteries.inside(tissue.p, EDGE, tissue.seen));
    }
}
