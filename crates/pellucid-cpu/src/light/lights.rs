//! Lights as they arrive at samples (5.4, 6.1).

use glam::{DAffine3, Vec3 as GlamVec3};
use pellucid_optics::{Chroma, Incident, ResolvedLight};

use super::gradient::normalized;
use super::unlit::Unlit;
use crate::chroma;
use crate::field::lane_position;
use crate::lanes::*;
use crate::shadow::Shadow;

/// Lights of the world around a volume.
pub struct Lights<'a> {
    /// Lights that are the same everywhere, at most [`MOST_DIRECTIONAL`], with their numbers.
    directional: Vec<(usize, Incident)>,
    /// All others.
    local: Vec<(usize, &'a ResolvedLight)>,
    world_from_index: DAffine3,
}

/// How many directional lights are prepared for a ray; more are treated as lights that are
/// somewhere.
const MOST_DIRECTIONAL: usize = 4;

/// What lights need of rays.
pub struct Aim<S: Lanes> {
    /// Unit vectors to the eye.
    pub to_eye: Vec3<S>,
    /// Unit vectors halfway between the eye and each directional light.
    halfway: [Vec3<S>; MOST_DIRECTIONAL],
    /// What goes to the eye of each, where that is the same along a ray.
    along: Option<[[F32<S>; 3]; MOST_DIRECTIONAL]>,
}

/// What is left of lights where they arrive.
pub enum Arriving<'a, S: Lanes> {
    /// All of them.
    Whole,
    /// What something on their way leaves, of each colour in its own way if they are not held back alike.
    Shadowed(&'a dyn Shadow<S>, Option<&'a Chroma>),
    /// These shares of each colour of the only light there is.
    Share([F32<S>; 3]),
}

/// A light at samples.
pub struct Arrived<S: Lanes> {
    /// Unit vectors to it.
    pub to_light: Vec3<S>,
    /// Unit vectors halfway between it and the eye.
    pub halfway: Vec3<S>,
    /// What is left of it, of each colour.
    pub radiance: [F32<S>; 3],
    /// Whether it makes highlights.
    pub specular: bool,
    /// What of it goes to the eye, where that is the same along rays.
    pub along: Option<[F32<S>; 3]>,
}

/// All lights at samples.
pub struct Arrivals<'a, S: Lanes> {
    /// The lights of the world.
    pub lights: &'a Lights<'a>,
    /// What they need of the eye's rays.
    pub aim: &'a Aim<S>,
    /// What they arrive at.
    pub sample: &'a Unlit<S>,
    /// What is left of them.
    pub arriving: Arriving<'a, S>,
}

impl<S: Lanes> Arriving<'_, S> {
    /// The share of each colour of a light, by its number.
    #[inline(always)]
    fn share(&self, s: S, light: usize, sample: &Unlit<S>) -> [F32<S>; 3] {
        match self {
            Self::Whole => [splat(s, 1.0); 3],
            Self::Shadowed(shadow, chroma) => {
                chroma::each(s, *chroma, shadow.transmittance(s, light, &sample.index, sample.lanes))
            }
            Self::Share(share) => *share,
        }
    }
}

impl<S: Lanes> Arrivals<'_, S> {
    /// Shows all lights, one after the other.
    #[inline(always)]
    pub fn each(&self, s: S, mut show: impl FnMut(&Arrived<S>)) {
        let (Lights { directional, local, .. }, Aim { to_eye, halfway, along }) = (self.lights, self.aim);
        for (place, (number, light)) in directional.iter().enumerate() {
            let share = self.arriving.share(s, *number, self.sample);
            show(&Arrived {
                to_light: xyz!(I => splat(s, light.to_light[I])),
                halfway: halfway[place],
                radiance: xyz!(C => share[C] * light.radiance[C]),
                specular: light.specular,
                along: along.as_ref().map(
                    #[inline(always)]
                    |along| along[place],
                ),
            });
        }
        for (number, light) in local {
            let share = self.arriving.share(s, *number, self.sample);
            let IncidentLanes { to_light, radiance, specular } =
                self.lights.incident(s, light, &self.sample.index, self.sample.lanes);
            show(&Arrived {
                to_light,
                halfway: normalized(s, xyz!(I => to_light[I] + to_eye[I])),
                radiance: xyz!(C => radiance[C] * share[C]),
                specular,
                along: None,
            });
        }
    }
}

/// A light as it reaches every lane, were nothing in between.
struct IncidentLanes<S: Lanes> {
    to_light: Vec3<S>,
    radiance: [F32<S>; 3],
    specular: bool,
}

impl<'a> Lights<'a> {
    /// Lights around a volume, by a map from its index space.
    pub fn new(lights: &'a [ResolvedLight], world_from_index: DAffine3) -> Self {
        let (everywhere, somewhere): (Vec<_>, Vec<_>) =
            lights.iter().enumerate().partition(|(_, light)| light.is_directional());
        let (prepared, more) = everywhere.split_at(everywhere.len().min(MOST_DIRECTIONAL));
        Self {
            directional: prepared.iter().map(|(number, light)| (*number, light.incident(GlamVec3::ZERO))).collect(),
            local: more.iter().copied().chain(somewhere).collect(),
            world_from_index,
        }
    }

    /// What the directional lights need of rays, once for all of their samples. `share` says what of one goes to the eye, by
    /// the cosine between its way before and after, where that is the same along a ray.
    #[inline(always)]
    pub fn aim<S: Lanes>(&self, s: S, to_eye: Vec3<S>, share: impl Fn(F32<S>) -> Option<[F32<S>; 3]>) -> Aim<S> {
        let mut halfway = [[splat(s, 0.0); 3]; MOST_DIRECTIONAL];
        let mut along = None;
        for (place, (_, light)) in self.directional.iter().enumerate() {
            let to_light = xyz!(I => splat(s, light.to_light[I]));
            halfway[place] = normalized(s, xyz!(I => to_light[I] + to_eye[I]));
            if let Some(weight) = share(-dot::<S>(to_light, to_eye)) {
                along.get_or_insert([[splat(s, 0.0); 3]; MOST_DIRECTIONAL])[place] = weight;
            }
        }
        Aim { to_eye, halfway, along }
    }

    /// The radiance of the first light at index positions, were nothing in between.
    #[inline(always)]
    pub fn radiance<S: Lanes>(&self, s: S, index: &Vec3<S>, lanes: Mask<S>) -> [F32<S>; 3] {
        match (self.directional.first(), self.local.first()) {
            (Some((_, light)), _) => xyz!(C => splat(s, light.radiance[C])),
            (None, Some((_, light))) => self.incident(s, light, index, lanes).radiance,
            (None, None) => [splat(s, 0.0); 3],
        }
    }

    /// A local light at every lane, one after the other.
    #[inline(never)]
    fn incident<S: Lanes>(&self, s: S, light: &ResolvedLight, index: &Vec3<S>, lanes: Mask<S>) -> IncidentLanes<S> {
        let zero = splat(s, 0.0);
        let mut found = IncidentLanes::<S> { to_light: [zero; 3], radiance: [zero; 3], specular: false };
        let bits = lanes.to_bitmask();
        for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
            let world = self.world_from_index.transform_point3(lane_position::<S>(index, lane));
            let incident = light.incident(world.as_vec3());
            for (lanes, value) in found.to_light.iter_mut().zip(incident.to_light.to_array()) {
                lanes[lane] = value;
            }
            for (lanes, value) in found.radiance.iter_mut().zip(incident.radiance) {
                lanes[lane] = value;
            }
            found.specular = incident.specular;
        }
        found
    }
}
