//! What light does on its way, looked at in its buffers.

use glam::{DAffine3, DVec3};
use pellucid_field::{Grid, Volume, Voxels};
use pellucid_optics::{
    Color, ColorPoint, Interpolation, Light, LightKind, OpacityPoint, Phase, PhaseNormalization, Scattering,
    TransferFunction, srgb_encode,
};
use pellucid_plan::half_angle::{Geometry, along_light, slice_axis, taps};
use pellucid_scene::{BlurJitter, BlurScaling, HalfAngle, InScatter, Scene, Source, Stage, Technique};

use super::Drawing;
use super::matter::Matter;
use super::sweep::Sweep;
use super::work::Seen;
use crate::field::Any;
use crate::lanes::{Lanes, baseline};
use crate::prepare::{Cache, Prepared};
use crate::test_random::random;

fn direction(random: &mut impl FnMut() -> f64) -> DVec3 {
    loop {
        let v = DVec3::new(random(), random(), random());
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// 6.1-3: both ways cross slices by at least the cosine of 45 degrees, and the eye in the order of their sign.
#[test]
fn slices_lie_halfway() {
    let mut random = random();
    for _ in 0..10_000 {
        let (view, light) = (direction(&mut random), direction(&mut random));
        let axis = slice_axis(view, light);
        assert!(
            axis.dot(light) >= std::f64::consts::FRAC_1_SQRT_2 - 1e-9
                && (axis.dot(view).abs() - axis.dot(light)).abs() < 1e-9
        );
        assert_eq!(axis.dot(view) >= 0.0, view.dot(light) >= 0.0);
        assert!(along_light(axis, light, &[light]).distance(axis) < 1e-12);
        // Rays of a near light may travel against the slices halfway; never against those they lean to.
        let rays = [0, 1, 2].map(|_| (light + direction(&mut random) * 0.9).normalize());
        let leaning = along_light(axis, light, &rays);
        assert!(rays.iter().all(|ray| ray.dot(leaning) >= 0.2 - 1e-12), "{leaning}");
    }
}

/// A stage of a white medium, seen along +y: opacity per unit by value, which is `value` of the index.
fn stage(dims: [usize; 3], value: impl Fn(DVec3) -> f64, opacity: f32, light: LightKind, step: f64) -> Stage {
    let grid = Grid::with_affine(dims, DAffine3::IDENTITY).unwrap();
    let at =
        |i: usize| DVec3::new((i % dims[0]) as f64, (i / dims[0] % dims[1]) as f64, (i / dims[0] / dims[1]) as f64);
    let values: Vec<f32> = (0..grid.len()).map(|i| value(at(i)) as f32).collect();
    let volume = Volume::new(grid, Voxels::from(values)).unwrap();
    let point = |value, opacity| OpacityPoint { value, opacity, interpolation: Interpolation::Linear };
    let white = vec![ColorPoint::new(0.0, Color::WHITE)];
    let tf = TransferFunction::new(white, vec![point(0.0, 0.0), point(1.0, opacity)]).unwrap();
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(tf.with_unit_distance(Some(1.0)).unwrap());
    scene.volumes[0].shading = Some(false);
    scene.camera.view =
        pellucid_scene::View::Orbit(pellucid_scene::Orbit { azimuth: 0.0, elevation: 0.0, ..Default::default() });
    scene.camera.projection = pellucid_scene::Projection::Orthographic { height: None };
    scene.lighting.lights = vec![Light::new(light)];
    scene.quality.step = step;
    scene.resolve(&[std::sync::Arc::new(volume)]).unwrap().0
}

/// Transport of so much light a unit.
fn transporting(stage: &mut Stage, transmittance: [f32; 3]) {
    let color = Color::new(transmittance.map(srgb_encode)).unwrap();
    stage.volumes[0].scattering = Scattering {
        phase: Phase::Isotropic,
        phase_normalization: PhaseNormalization::Renormalised,
        transport: Some(vec![ColorPoint::new(0.0, color)]),
        ..Scattering::default()
    };
}

/// What to do with buffers in front of every slab.
trait Look {
    fn look<S: Lanes>(&mut self, slab: usize, sweep: &mut Sweep<S, Any<S>>, geometry: &Geometry);
}

/// Sends light through `slabs` slabs, or all, and shows what is in front of each.
fn sweep(stage: &Stage, settings: &HalfAngle, slabs: Option<usize>, look: &mut impl Look) {
    let mut cache = Cache::default();
    let stage = &Stage { technique: Technique::HalfAngle(settings.clone()), ..stage.clone() };
    let layers = [Prepared::new(stage, 0, &mut cache).unwrap()];
    let geometry = Geometry::new(stage, layers[0].grid(), settings, &stage.lights[0]).unwrap();
    let drawing = Drawing {
        layers: &layers,
        settings,
        geometry: &geometry,
        light: &stage.lights[0],
        lights: 1,
        is_first: true,
        lengths: vec![super::Lengths::new(&layers[0], geometry.ways).unwrap()],
    };
    fn run<S: Lanes>(s: S, drawing: &Drawing, slabs: Option<usize>, look: &mut impl Look) {
        let Drawing { layers, settings, geometry, .. } = *drawing;
        let field = layers[0].any(layers[0].sampler().unwrap());
        let matter: Vec<Matter<S, Any<S>>> = vec![drawing.matter(s, 0, &field)];
        let mut sweep = Sweep::new(layers, settings, geometry, matter, Seen::InMatter, || false).unwrap();
        for slab in 0..slabs.unwrap_or(drawing.geometry.slabs.count) {
            look.look(slab, &mut sweep, drawing.geometry);
            sweep.pass(slab..slab + 1, || false).unwrap();
        }
        look.look(slabs.unwrap_or(drawing.geometry.slabs.count), &mut sweep, drawing.geometry);
    }
    // What buffers hold is the same for all sets but for roundings, and one is compiled in a third of the time.
    run(baseline!(), &drawing, slabs, look);
}

/// The planes of light after the last slab that was passed, without their padding.
fn planes<S>(sweep: &Sweep<S, Any<S>>) -> (Vec<Vec<f32>>, [usize; 2])
where
    S: Lanes,
{
    let buffer = &sweep.buffers()[sweep.buffers().len() - 1];
    let shape = buffer.shape;
    let (fresh, channels) = (&buffer.fresh, buffer.channels());
    let light = |channel: usize, at: usize| fresh[channel] - buffer.lost[at * channels + channel];
    let plane = |channel: usize| -> Vec<f32> {
        (0..shape.height).flat_map(|y| (0..shape.width).map(move |x| light(channel, shape.at(x, y)))).collect()
    };
    ((0..channels).map(plane).collect(), [shape.width, shape.height])
}

/// A look at one texel.
struct Middle(Vec<Vec<f32>>);

impl Look for Middle {
    fn look<S: Lanes>(&mut self, _: usize, sweep: &mut Sweep<S, Any<S>>, geometry: &Geometry) {
        let (planes, [width, _]) = planes(sweep);
        let [x, y] = geometry.frame.size.map(|n| n / 2);
        self.0.push(planes.iter().map(|plane| plane[y * width + x]).collect());
    }
}

/// 6.1-4: after k slices of a block light has lost what k times their way through it takes, at any angle, and
/// indirect light its own (K-08), each colour by itself.
#[test]
fn light_falls_with_the_way_it_came() {
    for light in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.4, 1.0, -0.3], [1.0, -0.5, 0.7]] {
        let mut stage = stage([49; 3], |_| 1.0, 0.05, LightKind::Directional { direction: light }, 0.7);
        let transmittance = [0.97f32, 0.9, 0.8];
        transporting(&mut stage, transmittance);
        // Around the middle texel ways in the block differ: nothing is mixed.
        let settings = HalfAngle { resolution: 128, blur_angle: 0.0, ..HalfAngle::default() };
        let mut middle = Middle(Vec::new());
        sweep(&stage, &settings, None, &mut middle);
        // The middle texel's way in the volume, in slabs.
        let prepared_axis = DVec3::from_array(light).normalize();
        let axis = slice_axis(stage.viewpoint.forward, prepared_axis);
        let thickness = stage.step * axis.dot(stage.viewpoint.forward).abs();
        let path = thickness / axis.dot(prepared_axis);
        let share = |pair: &[Vec<f32>], plane: usize| f64::from(pair[1][plane] / pair[0][plane]);
        // Where the texel's ray enters and leaves, its way is shorter, and nothing before and behind.
        let (mut whole, mut parts) = (0, 0);
        for pair in middle.0.windows(2).filter(|pair| pair[1][0] > 1e-3) {
            let exact = 0.95f64.powf(path);
            let found = share(pair, 0);
            // What is lost is written down: what is left is known to the rounding of a number near 1.
            let rounding = |plane: usize| 1.2e-7 / f64::from(pair[0][plane]);
            if (found - exact).abs() > 1e-5 + rounding(0) {
                assert!(found > exact && found <= 1.0, "{light:?}: {found}, exact {exact}");
                parts += usize::from(found < 1.0);
                continue;
            }
            whole += 1;
            for channel in 0..3 {
                let (exact, found) = (f64::from(transmittance[channel]).powf(path), share(pair, channel + 1));
                let bound = 3e-5 + rounding(channel + 1);
                assert!((found - exact).abs() < bound, "{light:?}: {found}, exact {exact}");
            }
        }
        assert!(whole > 30 && parts <= 2, "{light:?}: {whole} whole slabs, {parts} parts");
    }
}

/// The light behind everything.
struct Behind(Vec<Vec<f32>>, [usize; 2]);

impl Look for Behind {
    fn look<S: Lanes>(&mut self, _: usize, sweep: &mut Sweep<S, Any<S>>, _: &Geometry) {
        (self.0, self.1) = planes(sweep);
    }
}

/// 6.3-4: an empty volume leaves all light as it is, to the bit.
#[test]
fn nothing_takes_no_light() {
    let down = LightKind::Directional { direction: [0.2, 0.3, -1.0] };
    let point = LightKind::Point { position: [60.0, -20.0, 10.0], falloff: Default::default() };
    for kind in [down, point] {
        for in_scatter in [InScatter::Indirect, InScatter::Direct, InScatter::DirectFromMatter] {
            let mut stage = stage([24; 3], |p| p.x - 100.0, 0.5, kind, 0.5);
            stage.quality.empty_space_skipping = false;
            transporting(&mut stage, [0.9; 3]);
            let settings = HalfAngle { resolution: 64, in_scatter, taps: 3, ..HalfAngle::default() };
            let mut behind = Behind(Vec::new(), [0; 2]);
            sweep(&stage, &settings, None, &mut behind);
            assert!(behind.0.iter().flatten().all(|light| *light == 1.0), "{in_scatter:?}");
        }
    }
}

/// A look at how much light there is, and where: sums of a plane, and second moments around the middle.
struct Moments {
    plane: usize,
    /// Only this much of a first slab is kept, as a beam: (radius in texels).
    beam: f32,
    found: Vec<[f64; 3]>,
}

impl Look for Moments {
    fn look<S: Lanes>(&mut self, slab: usize, sweep: &mut Sweep<S, Any<S>>, _: &Geometry) {
        if slab == 0 {
            sweep.shine(self.beam);
        }
        let (planes, [width, height]) = planes(sweep);
        let mut sums = [0.0f64; 3];
        for (i, light) in planes[self.plane].iter().enumerate() {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let middle = [width as f64 / 2.0 - 0.5, height as f64 / 2.0 - 0.5];
            sums[0] += f64::from(*light);
            sums[1] += f64::from(*light) * (x - middle[0]).powi(2);
            sums[2] += f64::from(*light) * (y - middle[1]).powi(2);
        }
        self.found.push([sums[0], sums[1] / sums[0], sums[2] / sums[0]]);
    }
}

/// K-09: the blur keeps light, and spreads it by half the square of its radius a slice on the rim of the cone, a
/// quarter over its disc, besides what fetches between texels spread.
#[test]
fn a_beam_spreads_as_the_cone_says() {
    let slices = 60;
    let moments = |jitter, seed, angle: f64| {
        let mut stage =
            stage([65; 3], |p| p.x - 100.0, 0.5, LightKind::Directional { direction: [0.0, 1.0, 0.0] }, 1.0);
        stage.quality.empty_space_skipping = false;
        let settings = HalfAngle { resolution: 208, jitter, seed, blur_angle: angle, ..HalfAngle::default() };
        let mut moments = Moments { plane: 1, beam: 16.0, found: Vec::new() };
        sweep(&stage, &settings, Some(slices), &mut moments);
        moments.found
    };
    // 208 texels from edge to edge of 64 units, slices of a unit: whole vectors, for beside the picture is light.
    let angle = 50.0f64;
    let radius = (angle.to_radians() / 2.0).tan() * 207.0 / 64.0;
    let spread = |found: &[[f64; 3]], axis: usize| (found[slices][axis] - found[0][axis]) / slices as f64;
    let fixed = moments(BlurJitter::Fixed, 0, angle);
    assert!((fixed[slices][0] / fixed[0][0] - 1.0).abs() < 1e-4, "{:?}", fixed[slices]);
    // Four taps at right angles: two of them move along an axis by the radius, and are fetched off a texel.
    let fraction = radius.fract();
    let expected = radius * radius / 2.0 + fraction * (1.0 - fraction) / 2.0;
    for axis in 1..3 {
        let found = spread(&fixed, axis);
        assert!((found / expected - 1.0).abs() < 0.03, "fixed: {found}, exact {expected}");
    }
    let seeds = [1, 2, 3].map(|seed| moments(BlurJitter::PerSlice, seed, angle));
    for found in &seeds {
        assert!((found[slices][0] / found[0][0] - 1.0).abs() < 1e-4, "{:?}", found[slices]);
    }
    let expected = radius * radius / 4.0 + 1.0 / 6.0;
    let found = seeds.iter().map(|found| (spread(found, 1) + spread(found, 2)) / 6.0).sum::<f64>();
    assert!((found / expected - 1.0).abs() < 0.05, "per slice: {found}, exact {expected}");
    let still = moments(BlurJitter::PerSlice, 0, 0.0);
    assert_eq!(still[0], still[slices], "no angle, no blur");
}

/// K-09's trap and its remedy: for a given depth the blur of the paper shrinks with the root of the slices'
/// distance, the other one does not.
#[test]
fn the_blur_follows_the_number_of_slices_or_does_not() {
    let spread = |blur_scaling, step: f64| {
        let mut stage =
            stage([65; 3], |p| p.x - 100.0, 0.5, LightKind::Directional { direction: [0.0, 1.0, 0.0] }, step);
        stage.quality.empty_space_skipping = false;
        let settings = HalfAngle { resolution: 400, blur_scaling, blur_angle: 60.0, ..HalfAngle::default() };
        let mut moments = Moments { plane: 2, beam: 10.0, found: Vec::new() };
        sweep(&stage, &settings, Some((48.0 / step) as usize), &mut moments);
        let last = moments.found.last().unwrap();
        ((last[1] + last[2] - moments.found[0][1] - moments.found[0][2]) / 2.0).sqrt()
    };
    let paper = spread(BlurScaling::PerSlice, 1.0) / spread(BlurScaling::PerSlice, 4.0);
    assert!((paper - 0.5).abs() < 0.05, "{paper}");
    let same = spread(BlurScaling::PerDistance, 1.0) / spread(BlurScaling::PerDistance, 4.0);
    assert!((same - 1.0).abs() < 0.06, "{same}");
}

/// 6.3-6: what in-scattering takes from direct light it gives to indirect light, where nothing is absorbed.
#[test]
fn direct_light_becomes_indirect_light() {
    for (in_scatter, total) in [
        (InScatter::Indirect, None),
        (InScatter::Direct, Some(2.0)),
        (InScatter::DirectFromMatter, Some(2.0)),
        (InScatter::BothFromMatter, Some(2.0)),
    ] {
        let mut stage = stage([33, 33, 33], |_| 1.0, 0.1, LightKind::Directional { direction: [0.0, 1.0, 0.0] }, 1.0);
        transporting(&mut stage, [1.0; 3]);
        let settings = HalfAngle { resolution: 96, in_scatter, blur_angle: 4.0, ..HalfAngle::default() };
        let mut middle = Middle(Vec::new());
        sweep(&stage, &settings, Some(20), &mut middle);
        for light in &middle.0 {
            match total {
                Some(total) => assert!((light[0] + light[1] - total).abs() < 1e-5, "{in_scatter:?}: {light:?}"),
                None => assert_eq!(light[1], 1.0),
            }
        }
        assert!(middle.0[20][0] < 0.2);
    }
}

/// 6.3-7 c: no light is scattered where nothing is, and with d none gets through a gap but direct light.
#[test]
fn gaps_scatter_nothing() {
    let slab = |p: DVec3| if (4.0..=8.0).contains(&p.y) { 1.0 } else { 0.0 };
    let draw = |in_scatter| {
        let mut stage = stage([33, 33, 33], slab, 0.3, LightKind::Directional { direction: [0.0, 1.0, 0.0] }, 1.0);
        transporting(&mut stage, [0.95; 3]);
        stage.quality.empty_space_skipping = false;
        let settings = HalfAngle { resolution: 96, in_scatter, initial_indirect: 0.0, ..HalfAngle::default() };
        let mut middle = Middle(Vec::new());
        sweep(&stage, &settings, None, &mut middle);
        middle.0
    };
    let [direct, gated, both] = [InScatter::Direct, InScatter::DirectFromMatter, InScatter::BothFromMatter].map(draw);
    let last = |light: &[Vec<f32>]| light.last().unwrap()[1];
    assert!(last(&direct) > 0.3 && last(&gated) > 0.3, "{} {}", last(&direct), last(&gated));
    assert_eq!(last(&both), 0.0);
    assert!(gated.iter().all(|light| light[1] == 0.0 || light[0] < 1.0));
    assert!(draw(InScatter::Indirect).iter().all(|light| light[1] == 0.0));
}

#[test]
fn taps_do_not_move_light() {
    for taps in 2..=16 {
        for jitter in [BlurJitter::Fixed, BlurJitter::PerSlice] {
            let settings = HalfAngle { taps, jitter, seed: 5, ..HalfAngle::default() };
            for slab in 0..50 {
                let offsets = taps::offsets(&settings, slab);
                assert_eq!(offsets.len(), taps as usize);
                let sum = |axis: usize| offsets.iter().map(|offset| offset[axis]).sum::<f32>();
                assert!(sum(0).abs() < 1e-5 && sum(1).abs() < 1e-5);
                assert!(offsets.iter().all(|[x, y]| x.hypot(*y) <= 1.0 + 1e-6));
            }
        }
    }
    assert!(taps::offsets(&HalfAngle { taps: 1, ..HalfAngle::default() }, 0).is_empty());
}
