//! Several volumes whose rays are followed one volume after the other, and merged where all is known of them: by modes
//! whose samples have no order, and by surfaces, which have their distances.

use pellucid_plan::Merging;

use crate::element::Element;
use crate::integrator::{Counter, Integrator, Tally, Traced};
use crate::isosurface::{Hit, Surfaced};
use crate::lanes::*;
use crate::medium::merged;
use crate::packet::Packet;

/// Projections of several volumes: what each makes of a ray is merged as samples are.
pub struct Apart<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The projections of each.
    pub layers: Vec<Box<dyn Integrator + 'a>>,
    /// How they are merged.
    pub merging: Merging,
    /// Of the lattice, in world units.
    pub step: f64,
}

impl<S: Lanes> Integrator for Apart<'_, S> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let group = self.layers.len() + 1;
        let mut each = Vec::with_capacity(self.layers.len());
        for (number, layer) in self.layers.iter().enumerate() {
            let own: Vec<Packet> = wave.iter().skip(number + 1).step_by(group).cloned().collect();
            let mut found = vec![Traced::NOTHING; own.len()];
            layer.trace(&own, &mut found, tally);
            for ((found, packet), whole) in found.iter_mut().zip(&own).zip(wave.iter().step_by(group)) {
                for lane in (0..width::<S>()).filter(|&lane| packet.count[lane] > 0.0) {
                    found.depth[lane] += ((packet.entry[lane] - whole.entry[lane]) / self.step) as f32;
                }
            }
            each.push(found);
        }
        for (number, traced) in traced.iter_mut().enumerate() {
            let own: Vec<&Traced> = each.iter().map(|found| &found[number]).collect();
            self.s.vectorize(
                #[inline(always)]
                || self.merge(&own, traced),
            );
        }
    }
}

impl<S: Lanes> Apart<'_, S> {
    #[inline(always)]
    fn merge(&self, each: &[&Traced], traced: &mut Traced) {
        let (s, zero) = (self.s, splat(self.s, 0.0));
        let (mut elements, mut sum, mut samples) = (Vec::with_capacity(each.len()), [zero; 3], zero);
        let mut transmittance = splat(s, 1.0);
        let (mut most, mut depth, mut normal) = (zero, splat(s, f32::INFINITY), [zero; 3]);
        for found in each {
            let rgba = rgba!(C => load(s, &found.color[C]));
            sum = xyz!(C => sum[C] + rgba[C]);
            transmittance -= transmittance * rgba[3];
            samples += load(s, &found.samples);
            // What is seen best tells where.
            let best = rgba[3].simd_gt(most);
            most = best.select(rgba[3], most);
            depth = best.select(load(s, &found.depth), depth);
            normal = xyz!(I => best.select(load(s, &found.normal[I]), normal[I]));
            elements.push(Element { rgba, visible: rgba[3].simd_gt(zero) });
        }
        let color = match self.merging {
            Merging::Sum => [sum[0], sum[1], sum[2], splat(s, 1.0) - transmittance],
            Merging::Overlap(overlap) => {
                let Element { rgba, visible } = merged(s, overlap, &elements);
                rgba!(C => visible.select(rgba[C], zero))
            }
        };
        traced.set_color::<S>(color);
        traced.set_surface(s, depth.is_finite(), depth, normal);
        store::<S>(samples, &mut traced.samples);
    }
}

/// Isosurfaces of several volumes, in the order in which rays meet them.
pub struct Isosurfaced<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The surfaces of each.
    pub layers: Vec<Box<dyn Surfaced<S> + 'a>>,
    /// Of the lattice, in world units.
    pub step: f64,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

impl<S: Lanes> Integrator for Isosurfaced<'_, S> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        for (packets, traced) in wave.chunks_exact(self.layers.len() + 1).zip(traced) {
            let (whole, own) = (&packets[0], &packets[1..]);
            let mut counter = Counter::new(self.s);
            let each = self.layers.iter().zip(own).map(|(layer, packet)| layer.hits(packet, &mut counter));
            let each: Vec<Vec<Hit<S>>> = each.collect();
            for lane in 0..width::<S>() {
                let mut met: Vec<(f32, &Hit<S>)> = Vec::new();
                for (hits, packet) in each.iter().zip(own) {
                    let entry = ((packet.entry[lane] - whole.entry[lane]) / self.step) as f32;
                    let meet = hits.iter().filter(|hit| hit.lanes.to_bitmask() >> lane & 1 == 1);
                    met.extend(meet.map(|hit| (hit.distance[lane] + entry, hit)));
                }
                met.sort_by(|(a, _), (b, _)| a.total_cmp(b));
                self.composite(&met, lane, traced);
            }
            counter.finish(traced, tally);
        }
    }
}

impl<S: Lanes> Isosurfaced<'_, S> {
    /// Surfaces from the nearest on, until nothing behind them is seen.
    fn composite(&self, met: &[(f32, &Hit<S>)], lane: usize, traced: &mut Traced) {
        let Some((depth, nearest)) = met.first() else { return };
        traced.depth[lane] = *depth;
        for (to, from) in traced.normal.iter_mut().zip(nearest.normal) {
            to[lane] = from[lane];
        }
        for (_, hit) in met {
            let transmittance = 1.0 - traced.color[3][lane];
            for (to, from) in traced.color.iter_mut().zip(hit.rgba) {
                to[lane] += transmittance * from[lane];
            }
            if traced.color[3][lane] >= self.early_termination {
                return;
            }
        }
    }
}
