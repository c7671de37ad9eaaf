//! Local light at samples (5.4).

use glam::{DAffine3, Vec3 as GlamVec3};
use pellucid_optics::{GradientWeight, Incident, Material, ResolvedLight};

use crate::field::lane_position;
use crate::lanes::*;

/// Unit normals out of the surface, towards lower values, and the lengths of the gradients. Zero
/// where there is no gradient, so that lighting vanishes there instead of turning into NaN (5.3-1).
#[inline(always)]
pub fn normals<S: Lanes>(s: S, gradient: Vec3<S>) -> (Vec3<S>, F32<S>) {
    // Scaled first, so that squares of very long or short gradients stay in range.
    let largest = gradient[0].abs().max(gradient[1].abs()).max(gradient[2].abs());
    let usable = largest.simd_ge(splat(s, f32::MIN_POSITIVE)) & largest.is_finite();
    let scale = splat(s, 1.0) / usable.select(largest, splat(s, 1.0));
    let scaled = xyz!(I => gradient[I] * scale);
    let length = dot::<S>(scaled, scaled).sqrt();
    let usable = usable & length.is_finite();
    let inverse = splat(s, 1.0) / usable.select(length, splat(s, 1.0));
    let normal = xyz!(I => usable.select(-scaled[I] * inverse, splat(s, 0.0)));
    (normal, usable.select(length * largest, splat(s, 0.0)))
}

/// A vector of the same direction and length 1; zero if it has none.
#[inline(always)]
fn normalized<S: Lanes>(s: S, v: Vec3<S>) -> Vec3<S> {
    let squared = dot::<S>(v, v);
    let usable = squared.simd_gt(splat(s, 1e-24));
    let inverse = splat(s, 1.0) / usable.select(squared, splat(s, 1.0)).sqrt();
    xyz!(I => usable.select(v[I] * inverse, splat(s, 0.0)))
}

/// Material and lights of a volume.
pub struct Surface<'a> {
    material: &'a Material,
    weight: Option<GradientWeight>,
    ambient: f32,
    /// Lights that are the same everywhere.
    directional: Vec<Incident>,
    /// Lights that are somewhere.
    local: Vec<&'a ResolvedLight>,
    world_from_index: DAffine3,
}

/// A light as it reaches every lane.
struct IncidentLanes<S: Lanes> {
    to_light: Vec3<S>,
    radiance: [F32<S>; 3],
    specular: bool,
}

impl<'a> Surface<'a> {
    /// The material of a volume, gradient magnitudes between which unlit turns into lit, lights
    /// of the world and the ambient light among them.
    pub fn new(
        material: &'a Material,
        weight: Option<GradientWeight>,
        lights: &'a [ResolvedLight],
        ambient: f32,
        world_from_index: DAffine3,
    ) -> Self {
        let everywhere = |light: &&ResolvedLight| light.is_directional();
        Self {
            material,
            weight,
            ambient,
            directional: lights.iter().filter(everywhere).map(|light| light.incident(GlamVec3::ZERO)).collect(),
            local: lights.iter().filter(|light| !everywhere(light)).collect(),
            world_from_index,
        }
    }

    /// The lit colours (not associated) of samples at index positions: the vectors' form of
    /// [`blinn_phong`](pellucid_optics::blinn_phong), which defines it.
    #[inline(always)]
    pub fn shade<S: Lanes>(
        &self,
        s: S,
        base: [F32<S>; 3],
        index: Vec3<S>,
        gradient: Vec3<S>,
        to_eye: &Vec3<S>,
        lanes: Mask<S>,
    ) -> [F32<S>; 3] {
        let material = self.material;
        let (mut normal, magnitude) = normals(s, gradient);
        if material.two_sided {
            let away = dot::<S>(normal, *to_eye).simd_lt(splat(s, 0.0));
            normal = xyz!(I => away.select(-normal[I], normal[I]));
        }
        let unlit = material.emission + material.ambient * self.ambient;
        let mut lit = xyz!(C => base[C] * unlit);
        for light in &self.directional {
            let to_light = xyz!(I => splat(s, light.to_light[I]));
            let radiance = xyz!(I => splat(s, light.radiance[I]));
            let light = IncidentLanes { to_light, radiance, specular: light.specular };
            self.add(s, &mut lit, &base, &light, &normal, to_eye);
        }
        for light in &self.local {
            let light = self.incident(s, light, &index, lanes);
            self.add(s, &mut lit, &base, &light, &normal, to_eye);
        }
        match &self.weight {
            None => lit,
            Some(weight) => {
                let t = (magnitude - weight.low) * (1.0 / (weight.high - weight.low));
                let t = t.max(splat(s, 0.0)).min(splat(s, 1.0));
                let t = t * t * (splat(s, 3.0) - t * 2.0);
                xyz!(C => lerp::<S>(t, base[C], lit[C]))
            }
        }
    }

    /// Adds the light that is reflected from one source.
    #[inline(always)]
    fn add<S: Lanes>(
        &self,
        s: S,
        lit: &mut [F32<S>; 3],
        base: &[F32<S>; 3],
        light: &IncidentLanes<S>,
        normal: &Vec3<S>,
        to_eye: &Vec3<S>,
    ) {
        let (material, zero) = (self.material, splat(s, 0.0));
        // Also 0 for the normal 0: light is reflected at boundaries only.
        let facing = dot::<S>(*normal, light.to_light).max(zero);
        let diffuse = facing * material.diffuse;
        let specular = if light.specular && material.specular > 0.0 {
            let halfway = normalized(s, xyz!(I => light.to_light[I] + to_eye[I]));
            let tilt = dot::<S>(*normal, halfway).max(zero).min(splat(s, 1.0));
            let highlight = power(s, tilt, splat(s, material.shininess)) * material.specular;
            // No highlight on the side away from the light.
            facing.simd_gt(zero).select(highlight, zero)
        } else {
            zero
        };
        for channel in 0..3 {
            lit[channel] += base[channel].mul_add(diffuse, specular) * light.radiance[channel];
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
