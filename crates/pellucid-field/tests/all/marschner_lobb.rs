//! The signal of Marschner and Lobb (1994), whose spectrum lies just below the Nyquist frequency of
//! 40 voxels: the usual yardstick of reconstruction filters (BM9).

use std::f64::consts::PI;

use glam::DVec3;
use pellucid_field::{Filter, Gradient, Sampler, SincWindow};

use crate::gradient::gradient_of;
use crate::{Random, volume};

const N: usize = 40;

/// The signal over [-1, 1]^3 with f_M = 6 and alpha = 1/4.
fn signal(p: DVec3) -> f64 {
    let radial = (2.0 * PI * 6.0 * (0.5 * PI * p.x.hypot(p.y)).cos()).cos();
    (1.0 - (0.5 * PI * p.z).sin() + 0.25 * (1.0 + radial)) / (2.0 * 1.25)
}

fn world(index: DVec3) -> DVec3 {
    index * (2.0 / (N - 1) as f64) - 1.0
}

fn true_normal(index: DVec3) -> DVec3 {
    let h = 1e-4;
    let slope = |axis: DVec3| signal(world(index + h * axis)) - signal(world(index - h * axis));
    DVec3::from_array(DVec3::AXES.map(slope)).normalize()
}

/// Errors at random points: root mean square of values, and mean angle of normals in degrees for
/// each gradient.
fn errors(filter: Filter, gradients: &[Gradient]) -> (f64, Vec<f64>) {
    let sampled = volume([N; 3], |p| signal(world(p)));
    let sampler = Sampler::new(&sampled, 0, filter).unwrap();
    let mut random = Random(1994);
    let points: Vec<DVec3> = (0..400).map(|_| random.point(6.0, 33.0)).collect();
    let mean = |error: &dyn Fn(DVec3) -> f64| points.iter().map(|&p| error(p)).sum::<f64>() / points.len() as f64;
    let square = mean(&|p| (sampler.value(p) - signal(world(p))).powi(2));
    let angle = |&kind: &Gradient| mean(&|p| gradient_of(&sampler, kind, p).angle_between(true_normal(p)).to_degrees());
    (square.sqrt(), gradients.iter().map(angle).collect())
}

/// Measured errors, to within 3 %: a change of a kernel or a stencil shows here. The order
/// is the literature's: smoother and wider filters find better normals, one-sided differences and
/// smoothing stencils lose detail near the Nyquist frequency.
#[test]
fn errors_of_filters_and_gradients() {
    let kinds = [Gradient::Forward, Gradient::Central, Gradient::Sobel, Gradient::SobelIsotropic, Gradient::BSpline];
    let lanczos = Filter::Sinc { window: SincWindow::Lanczos, half_width: 3 };
    let measured = [
        (Filter::Nearest, 0.0469, [52.9, 31.7, 33.4, 30.9, 16.2]),
        (Filter::Linear, 0.0266, [48.7, 24.7, 32.8, 29.0, 16.2]),
        (Filter::BSpline { prefilter: false }, 0.0397, [49.1, 32.0, 40.9, 37.8, 16.2]),
        (Filter::MITCHELL, 0.0239, [48.3, 23.3, 31.5, 27.5, 16.2]),
        (Filter::CATMULL_ROM, 0.0176, [48.4, 21.0, 27.7, 23.6, 16.2]),
        (lanczos, 0.0099, [48.5, 18.5, 24.6, 20.2, 16.2]),
        (Filter::BSpline { prefilter: true }, 0.0100, [48.4, 18.6, 25.0, 20.6, 6.9]),
    ];
    for (filter, value, angles) in measured {
        let (value_error, angle_errors) = errors(filter, &kinds);
        assert!((0.97..1.03).contains(&(value_error / value)), "{filter:?}: {value_error}");
        for (angle, expected) in angle_errors.iter().zip(angles) {
            assert!((0.97..1.03).contains(&(angle / expected)), "{filter:?}: {angle_errors:?}");
        }
    }
}
