//! One path of light, followed from the eye.

use glam::Vec3;
use pellucid_optics::{ResolvedLight, Scatterer, Sky};
use pellucid_scene::{PathTrace, Ray};

use super::random::Random;
use super::surroundings::{Encounter, Surroundings};
use super::values::Values;
use super::vertex::{Vertex, scale};

/// Everything that paths meet.
pub struct World<'a, M> {
    /// What there is.
    pub matter: M,
    /// Lights that are somewhere.
    pub lights: &'a [ResolvedLight],
    /// Light from far away.
    pub sky: Option<&'a Sky>,
    /// Most scatterings, and when paths may end before.
    pub settings: &'a PathTrace,
}

/// What a path brought.
pub struct Brought {
    /// Whether it met the volume.
    pub met: bool,
    /// Linear RGB radiance.
    pub radiance: [f32; 3],
    /// What it carries of each colour of light from behind, all of which has come through.
    pub passed: [f32; 3],
    /// Distance from the eye to the first collision in world units; infinite if there was none.
    pub depth: f32,
    /// Evaluations of the field.
    pub evaluations: u32,
}

impl<M: Surroundings> World<'_, M> {
    /// Follows a ray from the eye to where its light came from, of which there is some only between two distances.
    pub fn follow(&self, ray: &Ray, between: [f64; 2], random: &mut Random) -> Brought {
        let mut found =
            Brought { met: false, radiance: [0.0; 3], passed: [1.0; 3], depth: f32::INFINITY, evaluations: 0 };
        let Some((entry, mut way)) = self.matter.enter(ray, between) else { return found };
        found.met = true;
        let mut forward = ray.direction.as_vec3();
        let mut throughput = [1.0; 3];
        // Density with which the last scattering chose the direction.
        let mut density = 0.0;
        for scatterings in 0.. {
            let collision = self.matter.collide(&way, &mut throughput, random, &mut found.evaluations);
            if scatterings > 0 {
                let most = collision.as_ref().map_or(f32::INFINITY, |collision| collision.distance);
                self.add_lights(&mut found.radiance, throughput, self.matter.origin(&way), forward, most, density);
            }
            let Some(collision) = collision else {
                if scatterings > 0 {
                    self.add_sky(&mut found.radiance, throughput, forward, density);
                } else {
                    found.passed = throughput;
                }
                return found;
            };
            found.passed = [0.0; 3];
            let Encounter { layer, distance, value, at } = collision;
            if scatterings == 0 {
                found.depth = (entry + f64::from(distance)) as f32;
            }
            let volume = self.matter.layer(layer);
            let [r, g, b, opacity] = volume.table.lookup(value);
            let color = volume.medium.field.color(at, [r, g, b]);
            if let Some(material) = volume.material {
                add(&mut found.radiance, throughput, color.map(|v| v * material.emission));
            }
            if scatterings == self.settings.bounces {
                return found;
            }
            let vertex = volume.surface(at, value, color, -forward, random).unwrap_or_else(|| {
                let scatterer = volume.scattering.at(f64::from(value), [r, g, b, opacity]);
                Vertex::Medium {
                    phase: &volume.scattering.phase,
                    normalization: volume.scattering.phase_normalization,
                    scatterer: Scatterer { albedo: volume.medium.field.color(at, scatterer.albedo), ..scatterer },
                    forward,
                }
            });
            let at = if let Vertex::Surface(surface) = &vertex {
                volume.in_front(at, value, surface.normal(), self.settings.surface_depth)
            } else {
                at
            };
            let direct = self.direct((layer, at), &vertex, random, &mut found.evaluations);
            add(&mut found.radiance, throughput, direct);
            forward = vertex.sample(random);
            density = vertex.pdf(forward);
            let weight = vertex.eval(forward).map(|v| v / density);
            throughput = scale(throughput, weight);
            let brightest = throughput[0].max(throughput[1]).max(throughput[2]);
            // A density of 0 makes NaN, which is no light either.
            if brightest.is_nan() || brightest <= 0.0 {
                return found;
            }
            if scatterings >= self.settings.roulette && brightest < 1.0 {
                if random.number() >= brightest {
                    return found;
                }
                throughput = throughput.map(|v| v / brightest);
            }
            way = self.matter.leave(layer, at, forward);
        }
        found
    }

    /// The normal on a ray at a distance from the eye, towards lower values; zero where there is no surface.
    pub fn normal(&self, ray: &Ray, distance: f32) -> [f32; 3] {
        if !distance.is_finite() {
            return [0.0; 3];
        }
        self.matter.normal(ray.origin + ray.direction * f64::from(distance))
    }

    /// Light that comes straight from a light or from the sky, of which one is asked.
    #[inline]
    fn direct(
        &self,
        (layer, at): (usize, Vec3),
        vertex: &Vertex,
        random: &mut Random,
        evaluations: &mut u32,
    ) -> [f32; 3] {
        let volume = self.matter.layer(layer);
        let sources = self.lights.len() + usize::from(self.sky.is_some());
        if sources == 0 {
            return [0.0; 3];
        }
        let chosen = ((random.number() * sources as f32) as usize).min(sources - 1);
        let (direction, distance, light) = match self.lights.get(chosen) {
            Some(light) => {
                let u = if light.has_extent() { random.pair() } else { [0.0; 2] };
                let sample = light.sample(volume.medium.space.world(at), u);
                let direction = sample.incident.to_light;
                let others = if self.matter.meets(light) { vertex.pdf(direction) * sources as f32 } else { 0.0 };
                let share = 1.0 / (1.0 + others / sample.density);
                (direction, sample.distance, vertex.light(sample.incident).map(|v| v * share))
            }
            None => {
                let Some(sky) = self.sky else { return [0.0; 3] };
                let direction = sky.sample(random.pair());
                let density = sky.pdf(direction) / sources as f32;
                // The balance heuristic (Veach and Guibas 1995): the sky is found by scattering as well.
                let share = 1.0 / (density + vertex.pdf(direction));
                let light = scale(vertex.eval(direction), sky.radiance(direction));
                (direction, f32::INFINITY, light.map(|v| v * share / sources as f32))
            }
        };
        if light.iter().all(|v| *v <= 0.0) {
            return [0.0; 3];
        }
        let transmittance = self.matter.transmittance((layer, at), (direction, distance), random, evaluations);
        scale(light, transmittance).map(|v| v * sources as f32)
    }

    /// The lights that a scattered path meets before its next collision, which is `most` off, with the share that
    /// [`direct`](Self::direct) leaves them. Nothing hides behind a light.
    fn add_lights(
        &self,
        radiance: &mut [f32; 3],
        throughput: [f32; 3],
        origin: Vec3,
        direction: Vec3,
        most: f32,
        density: f32,
    ) {
        let sources = (self.lights.len() + usize::from(self.sky.is_some())) as f32;
        for light in self.lights.iter().filter(|light| self.matter.meets(light)) {
            let seen = light.seen(origin, direction);
            if let Some(seen) = seen.filter(|seen| seen.distance <= most) {
                let share = density / (density + seen.density / sources);
                add(radiance, throughput, seen.radiance.map(|v| v * share));
            }
        }
    }

    /// The sky where a scattered path ends, with the share that [`direct`](Self::direct) leaves it.
    fn add_sky(&self, radiance: &mut [f32; 3], throughput: [f32; 3], direction: Vec3, density: f32) {
        if let Some(sky) = self.sky {
            let sources = (self.lights.len() + 1) as f32;
            let share = density / (density + sky.pdf(direction) / sources);
            add(radiance, throughput, sky.radiance(direction).map(|v| v * share));
        }
    }
}

#[inline(always)]
fn add(sum: &mut [f32; 3], throughput: [f32; 3], light: [f32; 3]) {
    for channel in 0..3 {
        sum[channel] += throughput[channel] * light[channel];
    }
}
