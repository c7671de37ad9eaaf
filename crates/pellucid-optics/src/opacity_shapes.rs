//! Opacity curves by the names PyVista gives them (`pyvista.opacity_transfer_function`).

use crate::error::unknown_name;
use crate::polyline::polyline;
use crate::transfer_function::ascending;
use crate::{OpacityPoint, OpticsError};

/// PyVista's tables have this many entries of 8 bits; what is less than their smallest step is 0.
const LEVELS: f64 = 255.0;

/// The curve of a name over a window of data values, as few points as follow it within 1/1000.
///
/// - `linear`: 0 to 1.
/// - `geom`: grows by the same factor everywhere, from 1e-6/255 to 1.
/// - `sigmoid_A`, A from 1 to 20: `1 / (1 + e^-x)` for x from -A to A; `sigmoid` is `sigmoid_10`.
/// - `foreground`: 0 at the lower end of the window, 1 from 1/255 of it on.
///
/// With `_r` behind the name the curve is reversed (not `foreground`). As in PyVista's 8-bit
/// tables, opacities under 1/255 are none at all.
///
/// # Errors
/// [`OpticsError::Name`], with the names there are; [`OpticsError::Interval`] unless the window
/// ascends and is finite.
pub fn opacity_shape(name: &str, window: [f64; 2]) -> Result<Vec<OpacityPoint>, OpticsError> {
    ascending("window of an opacity curve", window)?;
    let (plain, reversed) = name.strip_suffix("_r").map_or((name, false), |plain| (plain, true));
    let unknown = || {
        let names: Vec<String> = opacity_shape_names().collect();
        unknown_name("opacity curve", name, names.iter().map(String::as_str))
    };
    let steepness = plain.strip_prefix("sigmoid_").and_then(|digits| {
        let mut offered = SIGMOIDS;
        offered.find(|a| a.to_string() == digits)
    });
    let mut curve = match (plain, steepness) {
        (_, Some(a)) => polyline(sigmoid(a as f64)),
        ("sigmoid", _) => polyline(sigmoid(10.0)),
        ("linear", _) => vec![(0.0, 0.0), (1.0, 1.0)],
        ("geom", _) => polyline(|t| (1e-6 / LEVELS).powf(1.0 - t)),
        ("foreground", _) if !reversed => vec![(0.0, 0.0), (1.0 / LEVELS, 1.0), (1.0, 1.0)],
        _ => return Err(unknown()),
    };
    if reversed {
        curve = curve.into_iter().rev().map(|(t, opacity)| (1.0 - t, opacity)).collect();
    }
    let point = |(t, opacity): (f64, f64)| {
        let opacity = if opacity < 1.0 / LEVELS { 0.0 } else { opacity };
        OpacityPoint::new(window[0] * (1.0 - t) + window[1] * t, opacity as f32)
    };
    Ok(curve.into_iter().map(point).collect())
}

/// The steepnesses a sigmoid is offered in.
const SIGMOIDS: std::ops::RangeInclusive<u32> = 1..=20;

/// The names [`opacity_shape`] knows, without the reversed ones.
pub fn opacity_shape_names() -> impl Iterator<Item = String> {
    let plain = ["linear", "geom", "foreground", "sigmoid"].map(str::to_owned);
    plain.into_iter().chain(SIGMOIDS.map(|a| format!("sigmoid_{a}")))
}

fn sigmoid(a: f64) -> impl Fn(f64) -> f64 {
    move |t| 1.0 / (1.0 + (a * (1.0 - 2.0 * t)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Color, ColorPoint, TransferFunction};

    /// Every 17th of the 256 entries of `pyvista.opacity_transfer_function` of PyVista 0.49.
    #[rustfmt::skip]
    const PYVISTA: [(&str, [u8; 16]); 21] = [
        ("linear", [0, 17, 34, 51, 68, 85, 102, 119, 136, 153, 170, 187, 204, 221, 238, 255]),
        ("linear_r", [255, 238, 221, 204, 187, 170, 153, 136, 119, 102, 85, 68, 51, 34, 17, 0]),
        ("geom", [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 5, 19, 70, 255]),
        ("geom_r", [255, 70, 19, 5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        ("sigmoid", [0, 0, 0, 0, 2, 8, 30, 86, 168, 224, 246, 252, 254, 254, 254, 254]),
        ("sigmoid_r", [254, 254, 254, 254, 252, 246, 224, 168, 86, 30, 8, 2, 0, 0, 0, 0]),
        ("sigmoid_1", [68, 75, 82, 90, 98, 106, 114, 123, 131, 140, 148, 156, 164, 172, 179, 186]),
        ("sigmoid_2", [30, 38, 47, 59, 71, 86, 102, 119, 135, 152, 168, 183, 195, 207, 216, 224]),
        ("sigmoid_3", [12, 17, 25, 36, 50, 68, 90, 114, 140, 164, 186, 204, 218, 229, 237, 242]),
        ("sigmoid_3_r", [242, 237, 229, 218, 204, 186, 164, 140, 114, 90, 68, 50, 36, 25, 17, 12]),
        ("sigmoid_4", [4, 7, 12, 21, 34, 53, 79, 110, 144, 175, 201, 220, 233, 242, 247, 250]),
        ("sigmoid_5", [1, 3, 6, 12, 22, 40, 68, 106, 148, 186, 214, 232, 242, 248, 251, 253]),
        ("sigmoid_6", [0, 1, 3, 6, 14, 30, 59, 102, 152, 195, 224, 240, 248, 251, 253, 254]),
        ("sigmoid_7", [0, 0, 1, 3, 9, 22, 50, 98, 156, 204, 232, 245, 251, 253, 254, 254]),
        ("sigmoid_8", [0, 0, 0, 2, 5, 16, 42, 94, 160, 212, 238, 249, 252, 254, 254, 254]),
        ("sigmoid_9", [0, 0, 0, 1, 3, 12, 36, 90, 164, 218, 242, 251, 253, 254, 254, 254]),
        ("sigmoid_10", [0, 0, 0, 0, 2, 8, 30, 86, 168, 224, 246, 252, 254, 254, 254, 254]),
        ("sigmoid_10_r", [254, 254, 254, 254, 252, 246, 224, 168, 86, 30, 8, 2, 0, 0, 0, 0]),
        ("sigmoid_15", [0, 0, 0, 0, 0, 1, 12, 68, 186, 242, 253, 254, 254, 254, 254, 254]),
        ("sigmoid_20", [0, 0, 0, 0, 0, 0, 4, 53, 201, 250, 254, 254, 254, 254, 254, 254]),
        ("foreground", [0, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255]),
    ];

    #[test]
    fn curves_are_those_of_pyvista() {
        for (name, entries) in PYVISTA {
            let points = opacity_shape(name, [-50.0, 205.0]).unwrap();
            let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap();
            for (i, entry) in entries.into_iter().enumerate() {
                // PyVista truncates to 8 bits: its entry is at most one step below the curve. The
                // line up from the last 0 may be one below the entry.
                let ours = 255.0 * tf.opacity(-50.0 + 17.0 * i as f64);
                let above = ours - entry as f32;
                assert!((-1.0..1.3).contains(&above), "{name} at {i}/15: {ours}, PyVista {entry}");
            }
        }
    }

    #[test]
    fn curves_are_few_points_near_the_formula() {
        for a in SIGMOIDS {
            let points = opacity_shape(&format!("sigmoid_{a}"), [0.0, 1.0]).unwrap();
            assert!(points.len() <= 64, "{} points", points.len());
            let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap();
            for i in 0..=1000 {
                let x = a as f64 * (2.0 * i as f64 / 1000.0 - 1.0);
                let exact = 1.0 / (1.0 + (-x).exp());
                let error = (tf.opacity(i as f64 / 1000.0) as f64 - exact).abs();
                assert!(error < 1.5e-3 || (exact < 2.0 / 255.0 && error < 1.0 / 255.0), "sigmoid_{a} at {x}: {error}");
            }
        }
    }

    #[test]
    fn every_name_works_and_others_are_answered_with_the_list() {
        for name in opacity_shape_names() {
            assert!(opacity_shape(&name, [0.0, 1.0]).is_ok(), "{name}");
            assert_eq!(opacity_shape(&format!("{name}_r"), [0.0, 1.0]).is_ok(), name != "foreground", "{name}_r");
        }
        for bad in ["sigmoid_21", "sigmoid_0", "sigmoid_+3", "sigmoid_03", "", "_r", "log"] {
            let message = opacity_shape(bad, [0.0, 1.0]).unwrap_err().to_string();
            assert!(message.contains("linear, geom, foreground, sigmoid, sigmoid_1"), "{message}");
        }
        assert!(opacity_shape("linear", [1.0, f64::NAN]).is_err());
    }
}
