//! An extinction of its own for each colour, for all lanes: the vectors' form of [`Chroma`], which defines it.

use pellucid_optics::Chroma;

use crate::classify;
use crate::lanes::*;

/// What is left of each colour where these shares of the one that is lost least are left.
#[inline(always)]
pub fn each<S: Lanes>(s: S, chroma: Option<&Chroma>, through: F32<S>) -> [F32<S>; 3] {
    let Some(Chroma { ratios, .. }) = chroma else { return [through; 3] };
    // What is not held back at all passes what lets nothing else through.
    xyz!(C => if ratios[C] == 0.0 { splat(s, 1.0) } else { power(s, through, splat(s, ratios[C])) })
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
    let through = splat(s, 1.0) - front[3];
    let [r, g, b] = each(s, chroma, through);
    let through = [r, g, b, through];
    rgba!(C => through[C].mul_add(behind[C], front[C]))
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
