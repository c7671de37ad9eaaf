//! What lies where layers overlap, for all lanes.

use pellucid_scene::Overlap;

use crate::element::Element;
use crate::lanes::*;

/// The elements of all layers in one. But for [`Overlap::Priority`] and [`Overlap::Fused`], it does not depend on their
/// order.
#[inline(always)]
pub fn merged<S: Lanes>(s: S, overlap: Overlap, elements: &[Element<S>]) -> Element<S> {
    match overlap {
        Overlap::Add => added(s, elements),
        Overlap::Maximum => chosen(elements, s, larger::<S>),
        Overlap::Priority => chosen(
            elements,
            s,
            #[inline(always)]
            |_, _| all(s, false),
        ),
        Overlap::Fused { color, opacity } => match (elements.get(color), elements.get(opacity)) {
            (Some(color), Some(opacity)) => fused(s, color, opacity),
            _ => Element::nothing(s),
        },
    }
}

/// Leaves of elements over the same length those that hold light back, in the colours in which they are seen: extinctions
/// of what is left add.
#[inline(always)]
pub fn settle<S: Lanes>(s: S, overlap: Overlap, elements: &mut [Element<S>]) {
    match overlap {
        Overlap::Add => {}
        Overlap::Maximum => leave_best(elements, s, larger::<S>),
        Overlap::Priority => leave_best(
            elements,
            s,
            #[inline(always)]
            |_, _| all(s, false),
        ),
        Overlap::Fused { opacity, .. } => {
            let fused = merged(s, overlap, elements);
            elements.fill(Element::nothing(s));
            elements[opacity] = fused;
        }
    }
}

/// Extinctions add, and so does emission, weighted by them: `C = A sum(tau c) / sum(tau)` with `A = 1 - e^-sum(tau)`.
#[inline(always)]
fn added<S: Lanes>(s: S, elements: &[Element<S>]) -> Element<S> {
    /// The largest opacity below 1: full opacity has no depth that a number could tell.
    const OPAQUE: f32 = 1.0 - f32::EPSILON / 2.0;
    let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
    let (mut only, mut several) = (Element::nothing(s), all(s, false));
    for Element { rgba, visible } in elements {
        several |= only.visible & *visible;
        only.rgba = rgba!(C => visible.select(rgba[C], only.rgba[C]));
        only.visible |= *visible;
    }
    if !several.any_true() {
        return only;
    }
    let (mut depth, mut alpha, mut color) = (zero, zero, [zero; 3]);
    for Element { rgba, visible } in elements {
        let own_depth = visible.select(extinction(s, rgba[3].min(splat(s, OPAQUE))), zero);
        let straight = own_depth / visible.select(rgba[3], one);
        depth += own_depth;
        alpha = visible.select((one - alpha).mul_add(rgba[3], alpha), alpha);
        color = xyz!(C => visible.select(rgba[C].mul_add(straight, color[C]), color[C]));
    }
    let share = alpha / several.select(depth, one);
    let [r, g, b] = xyz!(C => color[C] * share);
    let together = [r, g, b, alpha];
    Element { rgba: rgba!(C => several.select(together[C], only.rgba[C])), visible: only.visible }
}

/// Of the visible elements the first, but where a later one is better.
#[inline(always)]
fn chosen<S: Lanes>(
    elements: &[Element<S>],
    s: S,
    better: impl Fn(&[F32<S>; 4], &[F32<S>; 4]) -> Mask<S>,
) -> Element<S> {
    let mut best = Element::nothing(s);
    for Element { rgba, visible } in elements {
        let takes = *visible & (!best.visible | better(rgba, &best.rgba));
        best.rgba = rgba!(C => takes.select(rgba[C], best.rgba[C]));
        best.visible |= *visible;
    }
    best
}

/// Leaves of the visible elements the one that [`chosen`] gives.
#[inline(always)]
fn leave_best<S: Lanes>(elements: &mut [Element<S>], s: S, better: impl Fn(&[F32<S>; 4], &[F32<S>; 4]) -> Mask<S>) {
    let mut best = Element::nothing(s);
    for k in 0..elements.len() {
        let Element { rgba, visible } = elements[k];
        let takes = visible & (!best.visible | better(&rgba, &best.rgba));
        best.rgba = rgba!(C => takes.select(rgba[C], best.rgba[C]));
        best.visible |= visible;
        for other in &mut elements[..k] {
            other.visible &= !takes;
        }
        elements[k].visible = takes;
    }
}

/// More opacity or, where that is the same, the brighter colour: a choice that no order decides.
#[inline(always)]
fn larger<S: Lanes>(own: &[F32<S>; 4], other: &[F32<S>; 4]) -> Mask<S> {
    let mut more = own[3].simd_gt(other[3]);
    let mut same = own[3].simd_eq(other[3]);
    for channel in 0..3 {
        more |= same & own[channel].simd_gt(other[channel]);
        same &= own[channel].simd_eq(other[channel]);
    }
    more
}

/// What one layer sends to the eye in the colour of the other: light of the first, whose colours are white, times
/// the opaque colours of the second. It keeps its own where the other is absent.
#[inline(always)]
fn fused<S: Lanes>(s: S, color: &Element<S>, opacity: &Element<S>) -> Element<S> {
    let (one, there) = (splat(s, 1.0), color.visible);
    let straight = one / there.select(color.rgba[3], one);
    let mut fused = *opacity;
    for channel in 0..3 {
        let own = fused.rgba[channel];
        fused.rgba[channel] = there.select(own * color.rgba[channel] * straight, own);
    }
    fused
}
