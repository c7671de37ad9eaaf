//! Curves with midpoint and sharpness (VTK's piecewise functions) to curves of control points
//! and back.

use super::SlicerWarning;
use super::file::{ColorKnot, Knot, PiecewiseFunction};
use crate::control_point::Interpolation;
use crate::polyline::polyline;
use crate::{Color, ColorPoint, OpacityPoint, OpticsError, TransferFunction};

const OPACITIES: fn(f32, f32, f32) -> f32 = |a, b, t| a + (b - a) * t;

pub(super) fn read_opacities(
    list: &'static str,
    points: &Option<PiecewiseFunction<Knot<f32>>>,
    warnings: &mut Vec<SlicerWarning>,
) -> Vec<OpacityPoint> {
    let knots = points.as_ref().map_or(&[][..], |points| &points.points);
    let points = read(list, knots, OPACITIES, false, warnings);
    points.into_iter().map(|(value, opacity, interpolation)| OpacityPoint { value, opacity, interpolation }).collect()
}

pub(super) fn read_colors(
    knots: &[ColorKnot],
    warnings: &mut Vec<SlicerWarning>,
) -> Result<Vec<ColorPoint>, OpticsError> {
    let list = "rgbTransferFunction";
    let knot = |(index, &ColorKnot { x, color, midpoint, sharpness }): (usize, &ColorKnot)| {
        let color = Color::new(color);
        let y = color.map_err(|error| OpticsError::Point { list, index, value: x, problem: error.to_string() })?;
        Ok(Knot { x, y, midpoint, sharpness })
    };
    let knots: Vec<Knot<Color>> = knots.iter().enumerate().map(knot).collect::<Result<_, OpticsError>>()?;
    let points = read(list, &knots, Color::lerp, true, warnings);
    Ok(points.into_iter().map(|(value, color, interpolation)| ColorPoint { value, color, interpolation }).collect())
}

pub(super) fn read_greys(
    points: &Option<PiecewiseFunction<Knot<f32>>>,
    warnings: &mut Vec<SlicerWarning>,
) -> Result<Vec<ColorPoint>, OpticsError> {
    let knots = points.as_ref().map_or(&[][..], |points| &points.points);
    let color = |&Knot { x, y, midpoint, sharpness }: &Knot<f32>| ColorKnot { x, color: [y; 3], midpoint, sharpness };
    read_colors(&knots.iter().map(color).collect::<Vec<_>>(), warnings)
}

/// How far VTK's curve is on its way to the next point, a fraction `t` of the way there. In its
/// opacities even the full sharpness of 1 is a steep curve, whatever its documentation says; in
/// its colours it is a step.
fn progress(t: f64, midpoint: f64, sharpness: f64) -> f64 {
    let centered = if t < midpoint { 0.5 * t / midpoint } else { 0.5 + 0.5 * (t - midpoint) / (1.0 - midpoint) };
    let pushed = |half: f64| 0.5 * (2.0 * half).powf(1.0 + 10.0 * sharpness);
    let u = if centered < 0.5 { pushed(centered) } else { 1.0 - pushed(1.0 - centered) };
    // Hermite's cubic with the slope 1 - sharpness at both ends.
    let slopes = (u * u * u - 2.0 * u * u + u) + (u * u * u - u * u);
    (u * u * (3.0 - 2.0 * u) + slopes * (1.0 - sharpness)).clamp(0.0, 1.0)
}

/// The largest number that is told apart from `x` and below it; not a denormal one.
fn just_below(x: f64) -> f64 {
    if x == 0.0 { -f64::MIN_POSITIVE } else { x.next_down() }
}

/// A midpoint is a further point, a step a jump; other curves become straight lines.
fn read<V: Copy>(
    list: &'static str,
    knots: &[Knot<V>],
    lerp: fn(V, V, f32) -> V,
    can_step: bool,
    warnings: &mut Vec<SlicerWarning>,
) -> Vec<(f64, V, Interpolation)> {
    let mut points = Vec::with_capacity(knots.len());
    for (index, knot) in knots.iter().enumerate() {
        let &Knot { x, y, midpoint, sharpness } = knot;
        let Some(next) = knots.get(index + 1).filter(|next| next.x > x) else {
            points.push((x, y, Interpolation::Linear));
            continue;
        };
        // The limits are VTK's.
        let midpoint = midpoint.clamp(1e-5, 1.0 - 1e-5);
        let middle = x + (next.x - x) * midpoint;
        if x >= just_below(next.x) {
            points.push((next.x, y, Interpolation::Linear));
        } else if sharpness > 0.99 && can_step {
            points.push((x, y, Interpolation::Step));
            points.push((middle, next.y, Interpolation::Linear));
        } else if sharpness < 0.01 {
            points.push((x, y, Interpolation::Linear));
            if midpoint != 0.5 {
                points.push((middle, lerp(y, next.y, 0.5), Interpolation::Linear));
            }
        } else {
            warnings.push(SlicerWarning::Sampled { list, index });
            let lines = polyline(|t| progress(t, midpoint, sharpness.min(1.0)));
            let inner = &lines[..lines.len() - 1];
            points.extend(
                inner.iter().map(|&(t, u)| (x + (next.x - x) * t, lerp(y, next.y, u as f32), Interpolation::Linear)),
            );
        }
    }
    points
}

pub(super) fn write_opacities(
    list: &'static str,
    points: &[OpacityPoint],
    warnings: &mut Vec<SlicerWarning>,
) -> Vec<Knot<f32>> {
    let points: Vec<_> = points.iter().map(|point| (point.value, point.opacity, point.interpolation)).collect();
    write(list, &points, OPACITIES, warnings)
}

pub(super) fn write_colors(tf: &TransferFunction, warnings: &mut Vec<SlicerWarning>) -> Vec<ColorKnot> {
    let encoded = |point: &ColorPoint| {
        let color = point.color.to_srgb(tf.color_space());
        (point.value, color, point.interpolation)
    };
    let points: Vec<_> = tf.colors().iter().map(encoded).collect();
    let knot = |Knot { x, y, midpoint, sharpness }: Knot<Color>| ColorKnot { x, color: y.rgb(), midpoint, sharpness };
    write("rgbTransferFunction", &points, Color::lerp, warnings).into_iter().map(knot).collect()
}

/// VTK keeps one point per value, so the lower side of a jump moves down by the least there is. A
/// step is written as what it is, a constant and a jump.
fn write<V: Copy>(
    list: &'static str,
    points: &[(f64, V, Interpolation)],
    lerp: fn(V, V, f32) -> V,
    warnings: &mut Vec<SlicerWarning>,
) -> Vec<Knot<V>> {
    let straight = |x: f64, y: V| Knot { x, y, midpoint: 0.5, sharpness: 0.0 };
    let mut knots: Vec<Knot<V>> = Vec::with_capacity(points.len());
    for (index, &(x, y, interpolation)) in points.iter().enumerate() {
        let Some(next) = points.get(index + 1) else {
            knots.push(straight(x, y));
            continue;
        };
        if next.0 == x {
            // After a step that ends here, the lower side of the jump is never reached.
            if knots.last().is_none_or(|last| last.x < just_below(x)) {
                knots.push(straight(just_below(x), y));
            }
            continue;
        }
        knots.push(straight(x, y));
        match interpolation {
            Interpolation::Linear => {}
            Interpolation::Step => knots.push(straight(just_below(next.0), y)),
            Interpolation::Smooth => {
                warnings.push(SlicerWarning::Sampled { list, index });
                let lines = polyline(|t| t * t * (3.0 - 2.0 * t));
                let inner = &lines[1..lines.len() - 1];
                knots.extend(inner.iter().map(|&(t, u)| straight(x + (next.0 - x) * t, lerp(y, next.1, u as f32))));
            }
        }
    }
    knots
}
