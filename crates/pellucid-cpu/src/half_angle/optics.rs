//! Optics of slabs: what samples look like, and what they let through of indirect light (K-08, 6.3-1).

use super::transport;
use crate::classify::{Lookup, Post};
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;
use crate::medium::OneGrid;
use crate::vary::Placed;

/// Optics of samples, for a length of theirs.
pub struct SlabOptics<'a> {
    /// Associated colours and opacities over the length.
    pub classifier: Post<'a>,
    /// What gets through of indirect light over a length, if that is something else.
    pub transport: Option<Lookup<'a>>,
    /// What depends on the place.
    pub placed: Placed<'a>,
}

/// What is there at samples.
pub struct SlabSample<S: Lanes> {
    /// Data values.
    pub value: F32<S>,
    /// Associated colours and opacities over the length of the optics.
    pub rgba: [F32<S>; 4],
    /// Lanes with any opacity.
    pub visible: Mask<S>,
    /// What gets through of indirect light, if that is something else.
    pub transmittance: Option<[F32<S>; 3]>,
}

impl<S: Lanes, F: Field<S>> OneGrid<'_, S, F, SlabOptics<'_>> {
    /// What is there at index positions, where indirect light goes `ratio` times its length; `None` if none has any
    /// opacity.
    #[inline(always)]
    pub fn at(&self, index: &Vec3<S>, lanes: Mask<S>, ratio: F32<S>) -> Option<SlabSample<S>> {
        let (s, SlabOptics { classifier, transport, placed }) = (self.s, &self.optics);
        let value = self.field.values(s, *index, lanes);
        let Element { rgba, visible } = classifier.of_level(s, value, lanes, None)?;
        if !visible.any_true() {
            return None;
        }
        let transmittance = transport.as_ref().map(
            #[inline(always)]
            |table| transport::transmittance(s, table, value, ratio),
        );
        let (rgba, transmittance) = placed.at(s, index, rgba, transmittance);
        Some(SlabSample { value, rgba, visible, transmittance })
    }
}
