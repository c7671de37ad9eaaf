//! An extinction of its own for each colour, for all lanes: the vectors' form of [`Chroma`], which defines it.

use pellucid_optics::Chroma;

use crate::classify;
use crate::lanes::*;

/// What is left of each colour where these shares of the one that is lost least are left.
#[inline(always)]
pub fn each<S: Lanes>(s: S, chroma: Option<&Chroma>, transmittance: F32<S>) -> [F32<S>; 3] {
    let Some(Chroma { ratios, .. }) = chroma else { return [transmittance; 3] };
    // What is not held back at all passes what lets nothing else through.
    xyz!(C => if ratios[C] == 0.0 { splat(s, 1.0) } else { power(s, transmittance, splat(s, ratios[C])) })
}

/// What is left where these shares of the colour that is lost least are left, lanes being of colours that are lost `ratios`
/// times as often.
#[inline(always)]
pub fn of_lanes<S: Lanes>(s: S, ratios: F32<S>, transmittance: F32<S>) -> F32<S> {
    // As in `each`.
    ratios.simd_eq(splat(s, 0.0)).select(splat(s, 1.0), power(s, transmittance, ratios))
}

/// What is held back of each colour at these opacities of the one that is lost least.
#[inline(always)]
pub fn opacities<S: Lanes>(s: S, chroma: Option<&Chroma>, alpha: F32<S>) -> [F32<S>; 3] {
    match chroma {
        None => [alpha; 3],
        Some(Chroma { ratios, .. }) => {
            let depth = extinction(s, alpha);
            xyz!(C => opacity_of(s, depth * ratios[C]))
        }
    }
}

/// Associated colours over `ratio` times the length they hold for.
#[inline(always)]
pub fn over_length<S: Lanes>(s: S, chroma: Option<&Chroma>, rgba: [F32<S>; 4], ratio: F32<S>) -> [F32<S>; 4] {
    let Some(chroma) = chroma else { return classify::over_length(s, rgba, ratio) };
    let one_step = opacities(s, Some(chroma), rgba[3]);
    let alpha = opacity_over(s, rgba[3], ratio);
    let corrected = opacities(s, Some(chroma), alpha);
    let [r, g, b] = xyz!(C => {
        let thin = one_step[C].simd_lt(splat(s, f32::MIN_POSITIVE));
        rgba[C] * thin.select(ratio, corrected[C] / thin.select(splat(s, 1.0), one_step[C]))
    });
    [r, g, b, alpha]
}

/// Associated colours in front of others.
#[inline(always)]
pub fn over<S: Lanes>(s: S, chroma: Option<&Chroma>, front: [F32<S>; 4], behind: [F32<S>; 4]) -> [F32<S>; 4] {
    let transmittance = splat(s, 1.0) - front[3];
    let [r, g, b] = each(s, chroma, transmittance);
    let transmittance = [r, g, b, transmittance];
    rgba!(C => transmittance[C].mul_add(behind[C], front[C]))
}

/// What is held back of all colours, in the mean.
#[inline(always)]
pub fn coverage<S: Lanes>(s: S, chroma: Option<&Chroma>, alpha: F32<S>) -> F32<S> {
    if chroma.is_none() {
        return alpha;
    }
    let [r, g, b] = opacities(s, chroma, alpha);
    (r + g + b) * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use pellucid_optics::{Color, Scattering, correct_opacity};

    use super::*;

    /// All of them at an opacity: what is left, what is held back, how much of all colours, and a colour over 0.3 steps.
    fn evaluate<S: Lanes>(s: S, chroma: &Chroma, alpha: f32) -> [[f32; 3]; 4] {
        let (alpha, chroma) = (splat(s, alpha), Some(chroma));
        let held = opacities(s, chroma, alpha);
        let [r, g, b] = held;
        let shorter = over_length(s, chroma, [r, g, b, alpha], splat(s, 0.3));
        let left = each(s, chroma, splat(s, 1.0) - alpha);
        let covered = coverage(s, chroma, alpha)[0];
        [xyz!(C => left[C][0]), xyz!(C => held[C][0]), [covered; 3], xyz!(C => shorter[C][0])]
    }

    #[test]
    fn vectors_are_the_definition() {
        for color in [0x00ff_bc80, 0x0020_ff00, 0x0080_8080] {
            let scattering = Scattering { extinction_color: Some(Color::hex(color)), ..Scattering::default() };
            let chroma = Chroma::of(&scattering).unwrap();
            for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
                for k in 0..=100 {
                    let alpha = (k as f32 / 100.0).powi(3);
                    let [left, held, covered, shorter] = dispatch!(set, s => evaluate(s, &chroma, alpha));
                    let exact = chroma.each(1.0 - alpha);
                    let close = |found: f32, exact: f32| (found - exact).abs() < 2e-6 + 2e-5 * exact;
                    for channel in 0..3 {
                        let own = correct_opacity(alpha, chroma.ratios[channel]);
                        let what = format!("{set}, {color:x}, {channel} at {alpha}");
                        assert!(close(left[channel], exact[channel]), "{what}: {left:?}, exact {exact:?}");
                        assert!(close(held[channel], own), "{what}: {held:?}, exact {own}");
                        // Of what is left, not of opacities that have rounded to nearly 1.
                        let own = correct_opacity(alpha, chroma.ratios[channel] * 0.3);
                        assert!(close(shorter[channel], own), "{what}: {shorter:?}, exact {own}");
                    }
                    assert!(close(covered[0], chroma.coverage(alpha)), "{set}: {covered:?}");
                }
            }
        }
    }
}
