//! Slabs as several layers cut them: their pieces end at the borders of layers, so that constant matter is exact wherever
//! layers begin and whatever the rule of their overlap.

use pellucid_scene::Overlap;
use smallvec::SmallVec;

use super::crossing::{Crossings, Passage};
use super::optics::{SlabOptics, SlabSample};
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;
use crate::medium::{OneGrid, settle};

/// What there is of each layer: of a single one, as most often, without memory of its own.
pub type PerLayer<T> = SmallVec<[T; 1]>;

/// A layer, and rays as they cross slabs in it.
pub type MetLayer<'m, 'a, S, F> = (&'m OneGrid<'a, S, &'a F, SlabOptics<'a>>, &'m Crossings<S>);

/// What one of several layers holds where rays pass: as much as the rule of their overlap leaves of it.
pub struct Share<S: Lanes> {
    /// Its place among the layers.
    pub layer: usize,
    /// What rays pass there.
    pub passage: Passage<S>,
    /// What is there, visible where it holds light back, which may be nowhere.
    pub sample: SlabSample<S>,
}

/// Goes through the pieces of slab k, by the coordinates of their ends.
#[inline(always)]
pub fn each_piece<S: Lanes, F>(s: S, layers: &[MetLayer<S, F>], k: usize, mut look: impl FnMut([F32<S>; 2])) {
    let (mut front, back) = (splat(s, k as f32), splat(s, (k + 1) as f32));
    while front.simd_lt(back).any_true() {
        let mut end = back;
        for (_, rays) in layers {
            end = rays.border(front, end);
        }
        look([front, end]);
        front = end;
    }
}

/// The lanes in which rays meet any layer where they pass, and what is left there of those that hold anything; indirect
/// light goes so many times its length.
#[inline(always)]
pub fn shares<'m, 'a: 'm, S: Lanes, F: Field<S> + 'a>(
    s: S,
    overlap: Overlap,
    layers: &[MetLayer<'m, 'a, S, F>],
    passage: impl Fn(&Crossings<S>) -> Passage<S>,
    ratio: impl Fn(&Passage<S>) -> F32<S>,
) -> (Mask<S>, Vec<Share<S>>) {
    let (mut met, mut found, mut elements) = (all(s, false), Vec::new(), Vec::new());
    for (layer, (medium, rays)) in layers.iter().enumerate() {
        let passage = passage(rays);
        met |= passage.lanes;
        let mut element = Element::nothing(s);
        if passage.lanes.any_true()
            && let Some(sample) = medium.at(&passage.index, passage.lanes, ratio(&passage))
        {
            element = Element { rgba: sample.rgba, visible: sample.visible };
            found.push(Share { layer, passage, sample });
        }
        elements.push(element);
    }
    settle(s, overlap, &mut elements);
    for Share { layer, sample, .. } in &mut found {
        (sample.rgba, sample.visible) = (elements[*layer].rgba, elements[*layer].visible);
    }
    (met, found)
}

/// How many slabs from slab k on, itself included, certainly add nothing in any layer.
#[inline(always)]
pub fn leap<'m, 'a: 'm, S: Lanes, F: Field<S> + 'a>(layers: &[MetLayer<'m, 'a, S, F>], k: usize) -> usize {
    let mut least = usize::MAX;
    for (OneGrid { s, skip, .. }, rays) in layers {
        let Some(skip) = skip else { return 0 };
        // What rays have left behind lets them leap however far, and another layer is still ahead.
        let leap = rays.leap(
            *s,
            k,
            #[inline(always)]
            |index| skip.clear(*s, index, &rays.inverse),
        );
        // Samples of the pieces of slabs that are cut are elsewhere.
        least = least.min(if layers.len() > 1 { leap.min(rays.uncut(*s, k)) } else { leap });
    }
    least
}

/// The same from slab k back.
#[inline(always)]
pub fn leap_back<'m, 'a: 'm, S: Lanes, F: Field<S> + 'a>(layers: &[MetLayer<'m, 'a, S, F>], k: usize) -> usize {
    let mut least = usize::MAX;
    for (OneGrid { s, skip, .. }, rays) in layers {
        let Some(skip) = skip else { return 0 };
        let back = xyz!(I => -rays.inverse[I]);
        let leap = rays.leap_back(
            *s,
            k,
            #[inline(always)]
            |index| skip.clear(*s, index, &back),
        );
        least = least.min(if layers.len() > 1 { leap.min(rays.uncut_back(*s, k)) } else { leap });
    }
    least
}
