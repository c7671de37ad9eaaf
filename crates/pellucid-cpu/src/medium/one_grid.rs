//! One volume with its optics: compiled into the loops of the modes, or one of several layers.

use pellucid_optics::Chroma;

use super::{Beam, Layer, Piece, Run, Span};
use crate::chroma;
use crate::classify::{Classify, Segments};
use crate::cut::Cuts;
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;
use crate::light::{Aim, Lighting, Unlit, normals};
use crate::packet::{Packet, Rays};
use crate::samples::Sample;
use crate::skip::{Levels, SkipGrid};
use crate::vary::Vary;
use crate::walk::Segment;

/// The field of a volume, what it looks like, and the light on it. Its optics `O` are asked for single samples
/// ([`Classify`]) or for pairs ([`Integrals`]).
pub struct OneGrid<'a, S, F, O> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: F,
    /// What it looks like.
    pub optics: O,
    /// Light, if samples are lit.
    pub lighting: Option<Lighting<'a, S>>,
    /// Where matter is cut.
    pub cuts: Cuts,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// The strides that blocks allow, if steps adapt to the data.
    pub levels: Option<&'a Levels>,
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
}

/// Optics of segments: ray integrals of one full step, and what varies them.
pub struct Integrals<'a, V> {
    /// The integrals.
    pub table: Segments<'a>,
    /// What varies them.
    pub vary: V,
}

impl<S: Lanes, F: Field<S>, O> OneGrid<'_, S, F, O> {
    /// What light needs of rays that go on to the eye, if samples are lit.
    #[inline(always)]
    pub fn aim(&self, to_eye: Vec3<S>) -> Option<Aim<S>> {
        Some(self.lighting.as_ref()?.aim(self.s, to_eye))
    }

    /// The same of rays that enter in index directions, with the faces by which they do.
    #[inline(always)]
    pub fn beam(&self, to_eye: Vec3<S>, entry: &Vec3<S>, direction: &Vec3<S>) -> Option<Beam<S>> {
        Some(Beam { aim: self.aim(to_eye)?, cut: self.cuts.met(self.s, entry, direction) })
    }

    /// Shades associated samples, if samples are lit.
    #[inline(always)]
    fn lit(
        &self,
        beam: Option<&Beam<S>>,
        sample: &Unlit<S>,
        front: Option<F32<S>>,
        gradients: impl FnOnce() -> Vec3<S>,
    ) -> [F32<S>; 4] {
        let (s, Some(lighting), Some(beam)) = (self.s, &self.lighting, beam) else { return sample.rgba };
        lighting.shade(
            s,
            sample,
            &beam.aim,
            front,
            #[inline(always)]
            || beam.gradients(s, lighting, &sample.index, gradients()),
        )
    }

    /// Unit normals at index positions, zero where the field is absent.
    #[inline(always)]
    pub fn normals_at(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        let s = self.s;
        let present = self.field.values(s, index, lanes).is_finite();
        let found = normals(s, self.field.gradients(s, index, lanes)).0;
        xyz!(I => present.select(found[I], splat(s, 0.0)))
    }
}

impl<S: Lanes, F: Field<S>, C: Classify<S>> OneGrid<'_, S, F, C> {
    /// What samples send to the eye, with an opacity in front of them; `None` if none has any opacity. A loop that never
    /// lights has registers to spare.
    #[inline(always)]
    pub fn sample<const LIT: bool>(
        &self,
        beam: Option<&Beam<S>>,
        sample: &Sample<S>,
        front: Option<F32<S>>,
    ) -> Option<Element<S>> {
        let s = self.s;
        let (value, near) = if LIT {
            let (value, near) = self.field.values_near(s, sample.index, sample.lanes);
            (value, Some(near))
        } else {
            (self.field.values(s, sample.index, sample.lanes), None)
        };
        let Element { mut rgba, visible } = self.optics.classify(s, value, sample)?;
        if sample.shortened {
            rgba = chroma::over_length(s, self.chroma.as_ref(), rgba, sample.ratio);
        }
        if let Some(near) = near {
            rgba = self.lit(
                beam,
                &Unlit { rgba, value, index: sample.index, lanes: visible },
                front,
                #[inline(always)]
                || self.field.gradients_near(s, &near, visible),
            );
        }
        Some(Element { rgba, visible })
    }

    /// Opacities of samples alone, whatever their colours, and the lanes that have any; `None` if there are none.
    #[inline(always)]
    pub fn opacities(&self, sample: &Sample<S>) -> Option<(F32<S>, Mask<S>)> {
        let s = self.s;
        let value = self.field.values(s, sample.index, sample.lanes);
        let Element { rgba: [.., mut alpha], visible } = self.optics.classify(s, value, sample)?;
        if sample.shortened {
            alpha = sample.ratio.simd_lt(splat(s, 1.0)).select(opacity_over(s, alpha, sample.ratio), alpha);
        }
        Some((alpha, visible))
    }
}

impl<S: Lanes, F: Field<S>, V: Vary> OneGrid<'_, S, F, Integrals<'_, V>> {
    /// What segments send to the eye, with an opacity in front of them; `None` if none has any opacity.
    #[inline(always)]
    pub fn between(
        &self,
        rays: &Rays<S>,
        beam: Option<&Beam<S>>,
        segment: &Segment<S>,
        hidden: Option<F32<S>>,
    ) -> Option<Element<S>> {
        let s = self.s;
        let (rgba, visible) = self.integral(segment);
        if !visible.any_true() {
            return None;
        }
        let (index, [front, back]) = (rays.at(segment.middle()), segment.value);
        let rgba = self.optics.vary.vary(s, &index, rgba);
        let value = (front.is_finite().select(front, back) + back.is_finite().select(back, front)) * 0.5;
        let rgba = self.lit(
            beam,
            &Unlit { rgba, value, index, lanes: visible },
            hidden,
            #[inline(always)]
            || self.field.gradients(s, index, visible),
        );
        Some(Element { rgba, visible })
    }

    /// The integrals over segments, and the lanes that have any opacity. Where one end is absent
    /// the field reaches half way with the value of the other.
    #[inline(always)]
    fn integral(&self, segment: &Segment<S>) -> ([F32<S>; 4], Mask<S>) {
        let s = self.s;
        let [front, back] = segment.value;
        let present = [front.is_finite(), back.is_finite()];
        let length = (present[0] & present[1]).select(segment.length, segment.length * 0.5);
        let lanes = segment.lanes & (present[0] | present[1]);
        let [from, to] = [present[0].select(front, back), present[1].select(back, front)];
        let rgba = self.optics.table.lookup(s, [from, to], length, lanes);
        (rgba, lanes & rgba[3].simd_gt(splat(s, 0.0)))
    }
}

/// Of optics of segments, as one of several layers.
pub struct Segmented<M>(pub M);

/// Behind one virtual call for a packet, entered with the instruction set switched on.
impl<S: Lanes, F: Field<S>, C: Classify<S>> Layer<S> for OneGrid<'_, S, F, C> {
    fn aim(&self, packet: &Packet, rays: &Rays<S>) -> Option<Beam<S>> {
        self.s.vectorize(
            #[inline(always)]
            || self.beam(packet.to_eye(self.s), &rays.origin, &rays.direction),
        )
    }

    fn clear(&self, rays: &Rays<S>, node: F32<S>, jitter: F32<S>) -> F32<S> {
        let Some(skip) = self.skip else { return splat(self.s, 0.0) };
        self.s.vectorize(
            #[inline(always)]
            || skip.clear(self.s, &rays.at(node + jitter), &rays.inverse),
        )
    }

    fn look(&self, span: &Span<S>, run: &Run<S>, found: (&mut [Element<S>], usize)) {
        let (s, beam) = (self.s, span.beam.as_ref());
        s.vectorize(
            #[inline(always)]
            || match self.lighting {
                Some(_) => run.each(
                    s,
                    span,
                    found,
                    #[inline(always)]
                    |index| self.field.prefetch(s, index),
                    #[inline(always)]
                    |piece| self.sample::<true>(beam, &piece.sample, run.front()),
                ),
                None => run.each(
                    s,
                    span,
                    found,
                    #[inline(always)]
                    |index| self.field.prefetch(s, index),
                    #[inline(always)]
                    |piece| self.sample::<false>(beam, &piece.sample, run.front()),
                ),
            },
        );
    }

    fn normals(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        self.s.vectorize(
            #[inline(always)]
            || self.normals_at(index, lanes),
        )
    }
}

impl<S: Lanes, F: Field<S>, V: Vary> Layer<S> for Segmented<OneGrid<'_, S, F, Integrals<'_, V>>> {
    fn aim(&self, packet: &Packet, rays: &Rays<S>) -> Option<Beam<S>> {
        self.0.s.vectorize(
            #[inline(always)]
            || self.0.beam(packet.to_eye(self.0.s), &rays.origin, &rays.direction),
        )
    }

    fn clear(&self, rays: &Rays<S>, node: F32<S>, _: F32<S>) -> F32<S> {
        let Some(skip) = self.0.skip else { return splat(self.0.s, 0.0) };
        // Both ends of segments count.
        self.0.s.vectorize(
            #[inline(always)]
            || skip.way(self.0.s, &rays.at(node), &rays.inverse).floor(),
        )
    }

    fn look(&self, span: &Span<S>, run: &Run<S>, found: (&mut [Element<S>], usize)) {
        let (medium, s, rays) = (&self.0, self.0.s, &span.rays);
        s.vectorize(
            #[inline(always)]
            || {
                run.each(
                    s,
                    span,
                    found,
                    #[inline(always)]
                    |index| medium.field.prefetch(s, index),
                    #[inline(always)]
                    |Piece { sample: Sample { ratio, lanes, .. }, ends: [from, to] }| {
                        let front = medium.field.values(s, rays.at(*from), *lanes);
                        let back = medium.field.values(s, rays.at(*to), *lanes);
                        let segment =
                            Segment { distance: [*from, *to], length: *ratio, value: [front, back], lanes: *lanes };
                        medium.between(rays, span.beam.as_ref(), &segment, run.front())
                    },
                );
            },
        );
    }

    fn normals(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        self.0.s.vectorize(
            #[inline(always)]
            || self.0.normals_at(index, lanes),
        )
    }
}
