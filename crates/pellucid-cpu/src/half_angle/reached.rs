//! What rays through slabs have found when all light has passed: their colours, and the surface where half of their opacity
//! is reached.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use pellucid_scene::Stage;

use super::crossing::Crossings;
use super::look::{EyeLayers, EyePacket};
use super::pieces::{MetLayer, PerLayer, Share, each_piece, leap_back};
use crate::chroma;
use crate::field::{Field, lane_position};
use crate::integrator::Found;
use crate::lanes::*;

/// Where opacity first reaches one half.
struct Reached<S: Lanes> {
    /// Lanes in which it does.
    met: Mask<S>,
    /// Normals there.
    normal: Vec3<S>,
    /// Index positions, in each of the layers.
    places: Vec<Vec3<S>>,
}

impl<S: Lanes, F: Field<S>> EyeLayers<'_, S, F> {
    /// What the rays of a packet found, where half of their opacity is reached, and the surface there; `worlds` are
    /// those of the layers' index positions.
    pub fn finish(&self, packet: &EyePacket, stage: &Stage, worlds: &[DAffine3], mut each: impl FnMut(usize, Found)) {
        let (s, chroma) = (self.first().s, self.first().chroma.as_ref());
        let (surface, alpha, opacities) = s.vectorize(
            #[inline(always)]
            || {
                let alpha = load(s, &packet.color[3]);
                (self.half(packet), chroma::coverage(s, chroma, alpha), chroma::opacities(s, chroma, alpha))
            },
        );
        let Reached { met, normal, places } = surface;
        let bits = met.to_bitmask();
        for lane in 0..width::<S>() {
            let Some(layer) = packet.crossings.iter().position(|crossing| crossing.lanes().any(|l| l == lane)) else {
                continue;
            };
            let is_met = bits >> lane & 1 == 1;
            let to_eye = DVec3::from_array([0, 1, 2].map(|axis| f64::from(packet.to_eye[axis][lane])));
            let depth = || {
                let world = worlds[layer].transform_point3(lane_position::<S>(&places[layer], lane));
                (stage.viewpoint.eye - world).dot(to_eye) as f32
            };
            let found = Found {
                color: [packet.color[0][lane], packet.color[1][lane], packet.color[2][lane], alpha[lane]],
                opacities: [opacities[0][lane], opacities[1][lane], opacities[2][lane]],
                depth: if is_met { depth() } else { f32::INFINITY },
                normal: if is_met { [0, 1, 2].map(|axis| normal[axis][lane]) } else { [0.0; 3] },
                samples: packet.samples[lane] as u32,
            };
            each(lane, found);
        }
    }

    /// Where opacity first reaches one half, from the eye.
    #[inline(always)]
    fn half(&self, packet: &EyePacket) -> Reached<S> {
        let (s, zero) = (self.first().s, splat(self.first().s, 0.0));
        let mut lines = PerLayer::new();
        for crossing in &packet.crossings {
            lines.push(Crossings::new(s, crossing));
        }
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let met = load(s, &packet.color[3]).simd_ge(splat(s, 0.5));
        if !met.any_true() {
            return Reached { met, normal: [zero; 3], places: vec![[zero; 3]; lines.len()] };
        }
        let layers = self.met(lines.iter());
        let mut half = load(s, &packet.half);
        if (met & backward).any_true() {
            half = backward.select(self.half_from_eye(&layers, packet.slabs(), met & backward), half);
        }
        // By rounding, opacity may reach one half on the one way and not on the other.
        let met = met & half.is_finite();
        let half = met.select(half, zero);
        let mut places = Vec::with_capacity(lines.len());
        for rays in &lines {
            places.push(rays.at(half));
        }
        let normal = match (self.layers.as_slice(), places.as_slice()) {
            ([eye], [place]) => eye.normals(*place, met),
            _ => self.normals_of_densest(&layers, half, met),
        };
        Reached { met, normal, places }
    }

    /// Normals of the layer that has most opacity at coordinates.
    #[inline(never)]
    fn normals_of_densest(&self, met: &[MetLayer<S, F>], half: F32<S>, lanes: Mask<S>) -> Vec3<S> {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let (mut normal, mut most) = ([splat(s, 0.0); 3], splat(s, 0.0));
                let (_, shares) = self.shares(
                    met,
                    #[inline(always)]
                    |rays| rays.sample(s, half).within(lanes),
                );
                for Share { layer, passage, sample } in &shares {
                    let more = sample.visible & sample.rgba[3].simd_gt(most);
                    if more.any_true() {
                        let own = self.layers[*layer].normals(passage.index, more);
                        normal = xyz!(I => more.select(own[I], normal[I]));
                        most = more.select(sample.rgba[3], most);
                    }
                }
                normal
            },
        )
    }

    /// Coordinates at which opacity first reaches one half, infinite if never: rays whose last slabs were seen first
    /// are followed once more.
    #[inline(always)]
    fn half_from_eye(&self, met: &[MetLayer<S, F>], slabs: Range<usize>, lanes: Mask<S>) -> F32<S> {
        let s = self.first().s;
        let (mut found, mut transmittance, mut open) = (splat(s, f32::INFINITY), splat(s, 1.0), lanes);
        let mut end = slabs.end;
        while end > slabs.start && open.any_true() {
            let k = end - 1;
            let leap = leap_back(met, k);
            if leap > 0 {
                end = end.saturating_sub(leap);
                continue;
            }
            end = k;
            let [left, place] = self.left_of(met, k, open);
            transmittance *= left;
            let here = open & transmittance.simd_le(splat(s, 0.5)) & place.is_finite();
            found = here.select(place, found);
            open &= !here;
        }
        found
    }

    /// What gets through a slab to the eye, and the coordinate of what is there; infinite where nothing is.
    #[inline(never)]
    fn left_of(&self, met: &[MetLayer<S, F>], k: usize, lanes: Mask<S>) -> [F32<S>; 2] {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let (mut left, mut place) = (splat(s, 1.0), splat(s, f32::INFINITY));
                each_piece(
                    s,
                    met,
                    k,
                    #[inline(always)]
                    |ends| {
                        let (_, shares) = self.shares(
                            met,
                            #[inline(always)]
                            |rays| rays.between(s, ends).within(lanes),
                        );
                        for Share { passage, sample, .. } in &shares {
                            let alpha = opacity_over(s, sample.rgba[3], passage.ratio);
                            left = sample.visible.select(left * (splat(s, 1.0) - alpha), left);
                            place = sample.visible.select(passage.place, place);
                        }
                    },
                );
                [left, place]
            },
        )
    }
}
