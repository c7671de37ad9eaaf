//! All that paths collide with: one volume, or several.

use glam::{DVec3, Vec3};
use pellucid_optics::ResolvedLight;
use pellucid_scene::Ray;

use super::layer::PathLayer;
use super::random::Random;
use super::space::Flight;
use super::values::Values;

/// A collision.
pub struct Encounter {
    /// The number of the volume.
    pub layer: usize,
    /// In world units from where the way begins.
    pub distance: f32,
    /// The data value there.
    pub value: f32,
    /// Index position in the volume.
    pub at: Vec3,
}

/// What paths go through.
pub trait Surroundings: Sync {
    /// The field of a volume.
    type Field: Values;
    /// A straight way through it.
    type Way;

    /// A volume by its number.
    fn layer(&self, number: usize) -> &PathLayer<'_, Self::Field>;

    /// The way of a ray from the eye, of what is between two distances, and how far from the eye it begins; `None` if it
    /// meets nothing.
    fn enter(&self, ray: &Ray, between: [f64; 2]) -> Option<(f64, Self::Way)>;

    /// The way from a position in a volume along a unit vector of the world.
    fn leave(&self, layer: usize, at: Vec3, direction: Vec3) -> Self::Way;

    /// Where in the world a way begins that [leaves](Self::leave) a position.
    fn origin(&self, way: &Self::Way) -> Vec3;

    /// The next collision; as of [`Medium::collide`](super::medium::Medium::collide).
    fn collide(
        &self,
        way: &Self::Way,
        carried: &mut [f32; 3],
        random: &mut Random,
        evaluations: &mut u32,
    ) -> Option<Encounter>;

    /// An estimate of the share of each colour that gets through from a position in a volume, along a unit vector of
    /// the world for so many world units.
    fn transmittance(
        &self,
        from: (usize, Vec3),
        way: (Vec3, f32),
        random: &mut Random,
        evaluations: &mut u32,
    ) -> [f32; 3];

    /// Whether scattered paths look for a light.
    fn meets(&self, light: &ResolvedLight) -> bool;

    /// The normal at a position of the world; zero where there is no surface.
    fn normal(&self, world: DVec3) -> [f32; 3];
}

/// One volume.
pub struct Alone<'a, F>(pub PathLayer<'a, F>);

impl<F: Values> Surroundings for Alone<'_, F> {
    type Field = F;
    type Way = Flight;

    #[inline(always)]
    fn layer(&self, _: usize) -> &PathLayer<'_, F> {
        &self.0
    }

    #[inline(always)]
    fn enter(&self, ray: &Ray, between: [f64; 2]) -> Option<(f64, Flight)> {
        self.0.medium.space.enter(ray, between)
    }

    #[inline(always)]
    fn leave(&self, _: usize, at: Vec3, direction: Vec3) -> Flight {
        self.0.medium.space.leave(at, direction, f32::INFINITY)
    }

    #[inline(always)]
    fn origin(&self, flight: &Flight) -> Vec3 {
        self.0.medium.space.world(flight.origin)
    }

    #[inline(always)]
    fn collide(
        &self,
        flight: &Flight,
        carried: &mut [f32; 3],
        random: &mut Random,
        evaluations: &mut u32,
    ) -> Option<Encounter> {
        let collision = self.0.medium.collide(flight, carried, random, evaluations)?;
        let (distance, value) = (collision.distance, collision.value);
        Some(Encounter { layer: 0, distance, value, at: flight.at(distance) })
    }

    #[inline(always)]
    fn transmittance(
        &self,
        (_, at): (usize, Vec3),
        (direction, most): (Vec3, f32),
        random: &mut Random,
        evaluations: &mut u32,
    ) -> [f32; 3] {
        let flight = self.0.medium.space.leave(at, direction, most);
        self.0.medium.transmittance(&flight, random, evaluations)
    }

    #[inline(always)]
    fn meets(&self, light: &ResolvedLight) -> bool {
        self.0.scattering.meets(light)
    }

    fn normal(&self, world: DVec3) -> [f32; 3] {
        self.0.normal(world)
    }
}

/// Several volumes, whose extinctions add: the first collision with any of them is one with all, as the processes
/// that bring them are independent.
pub struct Together<'a>(pub Vec<PathLayer<'a, Box<dyn Values + 'a>>>);

/// A way through several volumes.
pub struct Flights {
    origin: Vec3,
    /// How far from there the way in each volume begins, if it meets it.
    flights: Vec<Option<(f32, Flight)>>,
}

impl Together<'_> {
    fn ways(&self, origin: DVec3, direction: DVec3, between: [f64; 2]) -> Flights {
        let ray = Ray { origin, direction };
        let flight = |layer: &PathLayer<_>| {
            let (start, flight) = layer.medium.space.enter(&ray, between)?;
            Some((start as f32, flight))
        };
        Flights { origin: origin.as_vec3(), flights: self.0.iter().map(flight).collect() }
    }

    fn from(&self, layer: usize, at: Vec3, direction: Vec3, most: f64) -> Flights {
        let space = &self.0[layer].medium.space;
        self.ways(space.world_of(at), direction.as_dvec3(), [0.0, most])
    }
}

impl<'a> Surroundings for Together<'a> {
    type Field = Box<dyn Values + 'a>;
    type Way = Flights;

    fn layer(&self, number: usize) -> &PathLayer<'_, Self::Field> {
        &self.0[number]
    }

    fn enter(&self, ray: &Ray, between: [f64; 2]) -> Option<(f64, Flights)> {
        let ways = self.ways(ray.origin, ray.direction, between);
        ways.flights.iter().any(Option::is_some).then_some((0.0, ways))
    }

    fn leave(&self, layer: usize, at: Vec3, direction: Vec3) -> Flights {
        self.from(layer, at, direction, f64::INFINITY)
    }

    fn origin(&self, ways: &Flights) -> Vec3 {
        ways.origin
    }

    fn collide(
        &self,
        ways: &Flights,
        carried: &mut [f32; 3],
        random: &mut Random,
        evaluations: &mut u32,
    ) -> Option<Encounter> {
        let mut nearest: Option<Encounter> = None;
        for (number, (layer, flight)) in self.0.iter().zip(&ways.flights).enumerate() {
            let Some((start, mut flight)) = *flight else { continue };
            if let Some(met) = &nearest {
                flight.length = flight.length.min(met.distance - start);
            }
            if flight.length <= 0.0 {
                continue;
            }
            if let Some(collision) = layer.medium.collide(&flight, carried, random, evaluations) {
                let distance = start + collision.distance;
                let at = flight.at(collision.distance);
                nearest = Some(Encounter { layer: number, distance, value: collision.value, at });
            }
        }
        nearest
    }

    fn transmittance(
        &self,
        (layer, at): (usize, Vec3),
        (direction, most): (Vec3, f32),
        random: &mut Random,
        evaluations: &mut u32,
    ) -> [f32; 3] {
        let ways = self.from(layer, at, direction, f64::from(most));
        let mut transmittance = [1.0; 3];
        for (layer, flight) in self.0.iter().zip(&ways.flights) {
            let Some((_, flight)) = flight else { continue };
            let own = layer.medium.transmittance(flight, random, evaluations);
            transmittance = super::vertex::scale(transmittance, own);
            if transmittance == [0.0; 3] {
                break;
            }
        }
        transmittance
    }

    fn meets(&self, light: &ResolvedLight) -> bool {
        self.0.iter().any(|layer| layer.scattering.meets(light))
    }

    /// That of the volume which is densest there.
    fn normal(&self, world: DVec3) -> [f32; 3] {
        let density = |layer: &&PathLayer<_>| layer.medium.extinction(world).unwrap_or(0.0);
        let densest = self.0.iter().max_by(|a, b| density(a).total_cmp(&density(b)));
        densest.map_or([0.0; 3], |layer| layer.normal(world))
    }
}
