//! The formulas of opacity: one meaning in every technique, step, spacing and backend.
//!
//! An opacity holds for a length, its *unit distance*. Over another length the medium of constant
//! extinction `-ln(1 - a) / unit` has the opacity `1 - (1 - a)^(length / unit)` (1.4-13, Eq. 1.17).
//! Associated (premultiplied) colour scales with the opacity, `c * a' / a`; the linear scaling
//! `c * length / unit` of Eq. 1.18 is rejected: at opacity 0.5 it makes an opaque stack 15 %
//! darker at half the step and 33 % brighter at twice the step (1.4-14).

/// The opacity over `ratio` times the length that `alpha` holds for: `1 - (1 - alpha)^ratio`.
///
/// `alpha` is in 0..=1 and `ratio` is not negative. The ends are exact: 0 stays 0, 1 stays 1 for
/// every positive ratio, a ratio of 0 gives 0. What is absent (NaN) has no opacity.
#[inline]
pub fn correct_opacity(alpha: f32, ratio: f32) -> f32 {
    // Written so that NaN fails the test.
    if !(alpha > 0.0 && ratio > 0.0) {
        return 0.0;
    }
    if alpha >= 1.0 {
        return 1.0;
    }
    // powf would cancel for thin media: 1 - (1 - 1e-9) is 0 in f32.
    -(ratio * (-alpha).ln_1p()).exp_m1()
}

/// Extinction per world unit of a medium that has opacity `alpha` over `unit_distance`;
/// infinite for opacity 1.
#[inline]
pub fn extinction(alpha: f64, unit_distance: f64) -> f64 {
    -(-alpha).ln_1p() / unit_distance
}

/// Opacity of `length` world units of a medium with extinction `kappa`: `1 - e^(-kappa * length)`.
#[inline]
pub fn opacity_from_extinction(kappa: f64, length: f64) -> f64 {
    // No length, no opacity: also where an infinite extinction would make the product NaN.
    if !(kappa > 0.0 && length > 0.0) {
        return 0.0;
    }
    -(-kappa * length).exp_m1()
}

/// An associated colour over `ratio` times the length it was computed for: the opacity by
/// [`correct_opacity`], the colour by the same factor `a' / a`, whose limit at opacity 0 is
/// `ratio` (1.4-14). Exact for a constant medium.
#[inline]
pub fn correct_associated([r, g, b, alpha]: [f32; 4], ratio: f32) -> [f32; 4] {
    let corrected = correct_opacity(alpha, ratio);
    let scale = if alpha >= f32::MIN_POSITIVE { corrected / alpha } else { ratio };
    [r * scale, g * scale, b * scale, corrected]
}

/// How far in front of the middle of a medium the light comes from that it sends to the eye, if all of it shines alike:
/// a share of its optical depth, 0 for a thin medium and 1/2 for an opaque one. It is the mean of `1/2 - t` over a depth
/// of t from 0 to 1 under the weights `e^(-depth t)`.
#[inline]
pub fn advance(depth: f64) -> f64 {
    if depth < 0.3 {
        // 1/alpha and 1/depth would cancel.
        let squared = depth * depth;
        return depth * (1.0 / 12.0 - squared * (1.0 / 720.0 - squared * (1.0 / 30_240.0 - squared / 1_209_600.0)));
    }
    1.0 / opacity_from_extinction(depth, 1.0) - 0.5 - 1.0 / depth
}

/// The associated colour of a segment over `ratio` times the length it was computed for (7.3-4), from that and from the
/// colour of the same segment seen from its other end. In a longer segment more of the light comes from the front; the
/// two colours are mixed so that it comes from where it does at this length. Exact in opacity, and in colour where the
/// colour is linear in the optical depth, in particular where the extinction is constant and the colour linear.
#[inline]
pub fn correct_segment(segment: [f32; 4], reversed: [f32; 4], ratio: f32) -> [f32; 4] {
    let depth = extinction(f64::from(segment[3]), 1.0);
    let part = depth * f64::from(ratio);
    // Full opacity has an infinite depth, and all of its light comes from its front.
    let share = match depth {
        d if d < 1e-3 => 0.5 * (1.0 - f64::from(ratio)),
        d if d.is_finite() => 0.5 * (1.0 - advance(part) / advance(d)),
        _ => 0.0,
    } as f32;
    let mixed = [0, 1, 2, 3].map(|c| segment[c] + (reversed[c] - segment[c]) * share);
    correct_associated([mixed[0], mixed[1], mixed[2], segment[3]], ratio)
}

/// Front-to-back compositing: what is `accumulated` in front, over the next `sample` behind it;
/// both associated (1.4-8).
#[inline]
pub fn over(accumulated: [f32; 4], sample: [f32; 4]) -> [f32; 4] {
    let transparency = 1.0 - accumulated[3];
    std::array::from_fn(|channel| accumulated[channel] + transparency * sample[channel])
}

/// The extinction of an opacity as paths of light see it, per world unit. Full opacity is that of a unit distance that
/// lets 6e-8 of the light through, which single precision cannot tell from none.
pub fn path_extinction(opacity: f32, unit_distance: f64) -> f32 {
    const MOST_OPACITY: f32 = 1.0 - f32::EPSILON / 2.0;
    extinction(f64::from(opacity.min(MOST_OPACITY)), unit_distance) as f32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn published_values() {
        // 9.1-3
        for (alpha, ratio, expected) in
            [(0.5, 0.5, 0.292893), (0.1, 2.0, 0.19), (0.1, 0.5, 0.051317), (0.3, 0.25, 0.085309)]
        {
            assert!((correct_opacity(alpha, ratio) - expected).abs() < 1e-6, "{alpha} over {ratio}");
            let by_extinction = opacity_from_extinction(extinction(alpha as f64, 2.0), 2.0 * ratio as f64);
            assert!((by_extinction - expected as f64).abs() < 1e-6);
        }
    }

    #[test]
    fn light_comes_from_the_front_of_what_is_opaque() {
        // The mean of t under e^(-depth t), by the midpoint rule.
        for depth in [1e-3, 0.1, 0.29, 0.31, 1.0, 4.0, 30.0f64] {
            const PARTS: u32 = 100_000;
            let (mut sum, mut weights) = (0.0, 0.0);
            for i in 0..PARTS {
                let t = (f64::from(i) + 0.5) / f64::from(PARTS);
                let weight = (-depth * t).exp();
                (sum, weights) = (sum + weight * t, weights + weight);
            }
            let exact = 0.5 - sum / weights;
            assert!((advance(depth) - exact).abs() < 1e-8 + 1e-6 * exact, "{depth}: {} {exact}", advance(depth));
        }
    }

    #[test]
    fn parts_of_a_ramp_of_colour_are_exact() {
        // A medium of extinction k a length whose colour rises from p to q: the closed form of its light.
        let light = |k: f64, p: f64, q: f64, length: f64| {
            let depth = k * length;
            let alpha = -(-depth).exp_m1();
            let rise = if depth > 0.0 { (alpha - depth * (-depth).exp()) / depth } else { 0.0 };
            [p * alpha + (q - p) * rise, alpha]
        };
        for k in [1e-5, 0.01, 0.4, 2.0, 9.0] {
            let [ahead, alpha] = light(k, 0.9, 0.1, 1.0);
            let [behind, _] = light(k, 0.1, 0.9, 1.0);
            for ratio in [1e-3, 0.25, 0.5, 1.0, 2.5] {
                let of = |light: f64| [light as f32, 0.0, 0.0, alpha as f32];
                let found = correct_segment(of(ahead), of(behind), ratio);
                let exact = light(k, 0.9, 0.1, f64::from(ratio));
                for (found, exact) in [(found[0], exact[0]), (found[3], exact[1])] {
                    let near = (f64::from(found) - exact).abs() < 1e-3 * exact.min(1e-2) + 2e-5 * exact;
                    assert!(near, "extinction {k} over {ratio}: {found}, exact {exact}");
                }
            }
        }
        assert_eq!(correct_segment([0.5, 0.5, 0.5, 1.0], [0.9, 0.9, 0.9, 1.0], 0.5), [0.5, 0.5, 0.5, 1.0]);
        assert_eq!(correct_segment([0.0; 4], [0.0; 4], 0.5), [0.0; 4]);
    }

    #[test]
    fn ends_are_exact() {
        for ratio in [1e-6, 0.25, 1.0, 7.0, 1e6] {
            assert_eq!(correct_opacity(0.0, ratio), 0.0);
            assert_eq!(correct_opacity(1.0, ratio), 1.0);
            assert_eq!(correct_associated([0.25, 0.5, 1.0, 1.0], ratio), [0.25, 0.5, 1.0, 1.0]);
            assert_eq!(correct_associated([0.25, 0.5, 1.0, 0.0], ratio), [0.25 * ratio, 0.5 * ratio, ratio, 0.0]);
        }
        for alpha in [0.0, 0.3, 1.0] {
            assert_eq!(correct_opacity(alpha, 0.0), 0.0);
        }
        assert_eq!(correct_opacity(f32::NAN, 1.0), 0.0);
        assert_eq!(opacity_from_extinction(extinction(1.0, 1.0), 0.0), 0.0);
        assert_eq!(opacity_from_extinction(extinction(1.0, 1.0), 1e-9), 1.0);
    }

    #[test]
    fn thin_media_do_not_vanish() {
        // (1 - 1e-9)^0.5 in f32 is 1: the naive formula returns 0.
        let thin = correct_opacity(1e-9, 0.5);
        assert!((thin / 0.5e-9 - 1.0).abs() < 1e-5, "{thin}");
    }

    /// Radiance of an opaque stack of equal samples.
    fn stack(sample: [f32; 4]) -> f64 {
        // The geometric series: c / alpha.
        sample[0] as f64 / sample[3] as f64
    }

    #[test]
    fn exact_colour_is_invariant_and_the_linear_form_is_not() {
        for alpha in [0.001f32, 0.1, 0.5, 0.9] {
            let unit = [0.7 * alpha, 0.0, 0.0, alpha];
            for ratio in [0.25, 0.5, 2.0, 4.0] {
                let stacked = stack(correct_associated(unit, ratio));
                assert!((stacked - 0.7).abs() < 1e-6, "alpha {alpha} ratio {ratio}: {stacked}");
            }
        }
        // 1.4-14: the errors of Eq. 1.18.
        for (alpha, ratio, percent) in [(0.1f32, 0.5, -2.6), (0.1, 2.0, 5.3), (0.5, 0.5, -15.0), (0.5, 2.0, 33.0)] {
            let linear = [alpha * ratio, 0.0, 0.0, correct_opacity(alpha, ratio)];
            assert!((100.0 * (stack(linear) - 1.0) - percent).abs() < 0.5, "alpha {alpha} ratio {ratio}");
        }
    }

    proptest! {
        #[test]
        fn sub_steps_compose(alpha in 0.0f32..=1.0, color in 0.0f32..=1.0, k in 1usize..=64) {
            let whole = [color * alpha, 0.0, 0.0, alpha];
            let part = correct_associated(whole, 1.0 / k as f32);
            let composed = (0..k).fold([0.0; 4], |accumulated, _| over(accumulated, part));
            prop_assert!((composed[3] - alpha).abs() < 2e-6, "{} for {}", composed[3], alpha);
            prop_assert!((composed[0] - whole[0]).abs() < 2e-6, "{} for {}", composed[0], whole[0]);
        }

        #[test]
        fn opacity_grows_with_length_and_stays_in_range(alpha in 0.0f32..=1.0, a in 0.0f32..8.0, b in 0.0f32..8.0) {
            let (near, far) = (correct_opacity(alpha, a.min(b)), correct_opacity(alpha, a.max(b)));
            prop_assert!((0.0..=1.0).contains(&near) && near <= far && far <= 1.0);
        }

        #[test]
        fn slab_opacity_does_not_depend_on_the_step(kappa in 0.0f64..5.0, substeps in 1usize..=16) {
            let unit = opacity_from_extinction(kappa, 1.0) as f32;
            let step = correct_opacity(unit, 1.0 / substeps as f32);
            let slab = (0..substeps * 3).fold([0.0; 4], |a, _| over(a, [0.0, 0.0, 0.0, step]));
            prop_assert!((slab[3] as f64 - opacity_from_extinction(kappa, 3.0)).abs() < 1e-5);
        }
    }
}
