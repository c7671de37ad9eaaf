//! What lies where layers overlap, for all lanes.

use pellucid_scene::Overlap;

use crate::element::Element;
use crate::lanes::*;

/// The elements of all layers in one; `None` if none has any opacity. But for [`Overlap::Priority`], it does not depend
/// on their order.
#[inline(always)]
pub fn merged<S: Lanes>(s: S, overlap: Overlap, elements: &[Option<Element<S>>]) -> Option<Element<S>> {
    match overlap {
        Overlap::Add => added(s, elements),
        Overlap::Maximum => chosen(elements, s, larger::<S>),
        Overlap::Priority => chosen(
            elements,
            s,
            #[inline(always)]
            |_, _| all(s, false),
        ),
        Overlap::Fused { color, opacity } => fused(s, elements.get(color)?.as_ref(), elements.get(opacity)?.as_ref()),
    }
}

/// Extinctions add, and so does emission, weighted by them: `C = A sum(tau c) / sum(tau)` with `A = 1 - e^-sum(tau)`.
#[inline(always)]
fn added<S: Lanes>(s: S, elements: &[Option<Element<S>>]) -> Option<Element<S>> {
    /// The largest opacity below 1: full opacity has no depth that a number could tell.
    const OPAQUE: f32 = 1.0 - f32::EPSILON / 2.0;
    let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
    let mut present = elements.iter().flatten();
    let first = present.next()?;
    let (mut only, mut visible, mut several) = (first.rgba, first.visible, all(s, false));
    for Element { rgba, visible: own } in present {
        several |= visible & *own;
        only = rgba!(C => own.select(rgba[C], only[C]));
        visible |= *own;
    }
    if !visible.any_true() {
        return None;
    }
    if !several.any_true() {
        return Some(Element { rgba: only, visible });
    }
    let (mut depth, mut color) = (zero, [zero; 3]);
    for Element { rgba, visible: own } in elements.iter().flatten() {
        let own_depth = own.select(extinction(s, rgba[3].min(splat(s, OPAQUE))), zero);
        let straight = own_depth / own.select(rgba[3], one);
        depth += own_depth;
        color = xyz!(C => own.select(rgba[C].mul_add(straight, color[C]), color[C]));
    }
    let alpha = opacity_of(s, depth);
    let share = alpha / several.select(depth, one);
    let [r, g, b] = xyz!(C => color[C] * share);
    let together = [r, g, b, alpha];
    Some(Element { rgba: rgba!(C => several.select(together[C], only[C])), visible })
}

/// Of the visible elements the first, but where a later one is better.
#[inline(always)]
fn chosen<S: Lanes>(
    elements: &[Option<Element<S>>],
    s: S,
    better: impl Fn(&[F32<S>; 4], &[F32<S>; 4]) -> Mask<S>,
) -> Option<Element<S>> {
    let (mut rgba, mut visible) = ([splat(s, 0.0); 4], all(s, false));
    for Element { rgba: own, visible: there } in elements.iter().flatten() {
        let takes = *there & (!visible | better(own, &rgba));
        rgba = rgba!(C => takes.select(own[C], rgba[C]));
        visible |= *there;
    }
    visible.any_true().then_some(Element { rgba, visible })
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
fn fused<S: Lanes>(s: S, color: Option<&Element<S>>, opacity: Option<&Element<S>>) -> Option<Element<S>> {
    let Element { rgba, visible } = opacity?;
    let mut fused = *rgba;
    if let Some(Element { rgba: other, visible: there }) = color {
        let straight = splat(s, 1.0) / there.select(other[3], splat(s, 1.0));
        for channel in 0..3 {
            fused[channel] = there.select(rgba[channel] * other[channel] * straight, fused[channel]);
        }
    }
    Some(Element { rgba: fused, visible: *visible })
}
