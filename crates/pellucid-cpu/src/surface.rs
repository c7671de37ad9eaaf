//! Local light at samples (5.4).

use glam::{DAffine3, Vec3 as GlamVec3};
use pellucid_optics::{GradientWeight, Incident, Material, ResolvedLight};

use crate::field::lane_position;
use crate::lanes::*;

/// Unit normals out of the surface, towards lower values, and the lengths of the gradients. Zero
/// where there is no gradient, so that lighting vanishes there instead of turning into NaN (5.3-1).
#[inline(always)]
pub fn normals<S: Lanes>(s: S, gradient: Vec3<S>) -> (Vec3<S>, F32<S>) {
    let squared = dot::<S>(gradient, gradient);
    // Squares of very short and very long gradients leave the range of numbers.
    let plain = squared.simd_gt(splat(s, 1e-30)) & squared.simd_lt(splat(s, 1e30));
    let length = plain.select(squared, splat(s, 1.0)).sqrt();
    let inverse = splat(s, -1.0) / length;
    let normal = xyz!(I => plain.select(gradient[I] * inverse, splat(s, 0.0)));
    if plain.all_true() {
        return (normal, length);
    }
    let largest = gradient[0].abs().max(gradient[1].abs()).max(gradient[2].abs());
    let usable = !plain & largest.simd_ge(splat(s, f32::MIN_POSITIVE)) & largest.is_finite();
    let scale = usable.select(largest, splat(s, 1.0));
    let scaled = xyz!(I => gradient[I] / scale);
    let scaled_length = usable.select(dot::<S>(scaled, scaled), splat(s, 1.0)).sqrt();
    let normal = xyz!(I => usable.select(-scaled[I] / scaled_length, normal[I]));
    let zero = splat(s, 0.0);
    (normal, plain.select(length, usable.select(scaled_length * largest, zero)))
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
    /// Lights that are the same everywhere, at most [`MOST_DIRECTIONAL`].
    directional: Vec<Incident>,
    /// All others.
    local: Vec<&'a ResolvedLight>,
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
}

/// The light that leaves a surface: factors of its own colour, and highlights.
struct Reflected<S: Lanes> {
    diffuse: [F32<S>; 3],
    specular: [F32<S>; 3],
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
        let (everywhere, somewhere): (Vec<&ResolvedLight>, Vec<&ResolvedLight>) =
            lights.iter().partition(|light| light.is_directional());
        let (prepared, more) = everywhere.split_at(everywhere.len().min(MOST_DIRECTIONAL));
        Self {
            material,
            weight,
            ambient,
            directional: prepared.iter().map(|light| light.incident(GlamVec3::ZERO)).collect(),
            local: more.iter().copied().chain(somewhere).collect(),
            world_from_index,
        }
    }

    /// What the directional lights need of rays, once for all of their samples.
    #[inline(always)]
    pub fn aim<S: Lanes>(&self, s: S, to_eye: Vec3<S>) -> Aim<S> {
        let mut halfway = [[splat(s, 0.0); 3]; MOST_DIRECTIONAL];
        for (halfway, light) in halfway.iter_mut().zip(&self.directional) {
            *halfway = normalized(s, xyz!(I => splat(s, light.to_light[I]) + to_eye[I]));
        }
        Aim { to_eye, halfway }
    }

    /// Lights samples at index positions. `rgba` is associated and stays so: light is weighted by
    /// the sample's opacity, or transparent samples would glow (5.4-1). The vectors' form of
    /// [`blinn_phong`](pellucid_optics::blinn_phong), which defines it.
    #[inline(always)]
    pub fn shade<S: Lanes>(
        &self,
        s: S,
        rgba: [F32<S>; 4],
        index: Vec3<S>,
        gradient: Vec3<S>,
        aim: &Aim<S>,
        lanes: Mask<S>,
    ) -> [F32<S>; 4] {
        let (material, zero) = (self.material, splat(s, 0.0));
        let (mut normal, magnitude) = normals(s, gradient);
        if material.two_sided {
            let away = dot::<S>(normal, aim.to_eye).simd_lt(zero);
            normal = xyz!(I => away.select(-normal[I], normal[I]));
        }
        let unlit = splat(s, material.emission + material.ambient * self.ambient);
        let mut reflected = Reflected { diffuse: [unlit; 3], specular: [zero; 3] };
        for (light, halfway) in self.directional.iter().zip(&aim.halfway) {
            let to_light = xyz!(I => splat(s, light.to_light[I]));
            let radiance = xyz!(I => splat(s, light.radiance[I]));
            let light = IncidentLanes { to_light, radiance, specular: light.specular };
            self.reflect(s, &mut reflected, &light, &normal, halfway);
        }
        for light in &self.local {
            let light = self.incident(s, light, &index, lanes);
            let halfway = normalized(s, xyz!(I => light.to_light[I] + aim.to_eye[I]));
            self.reflect(s, &mut reflected, &light, &normal, &halfway);
        }
        let Reflected { mut diffuse, mut specular } = reflected;
        if let Some(weight) = &self.weight {
            let t = (magnitude - weight.low) * (1.0 / (weight.high - weight.low));
            let t = t.max(zero).min(splat(s, 1.0));
            let t = t * t * (splat(s, 3.0) - t * 2.0);
            diffuse = xyz!(C => lerp::<S>(t, splat(s, 1.0), diffuse[C]));
            specular = xyz!(C => specular[C] * t);
        }
        let [r, g, b] = xyz!(C => rgba[C].mul_add(diffuse[C], specular[C] * rgba[3]));
        [lanes.select(r, zero), lanes.select(g, zero), lanes.select(b, zero), rgba[3]]
    }

    /// Adds the light that is reflected from one source.
    #[inline(always)]
    fn reflect<S: Lanes>(
        &self,
        s: S,
        reflected: &mut Reflected<S>,
        light: &IncidentLanes<S>,
        normal: &Vec3<S>,
        halfway: &Vec3<S>,
    ) {
        let (material, zero) = (self.material, splat(s, 0.0));
        // Also 0 for the normal 0: light is reflected at boundaries only.
        let facing = dot::<S>(*normal, light.to_light).max(zero);
        let diffuse = facing * material.diffuse;
        reflected.diffuse = xyz!(C => diffuse.mul_add(light.radiance[C], reflected.diffuse[C]));
        if light.specular && material.specular > 0.0 {
            let tilt = dot::<S>(*normal, *halfway).max(zero).min(splat(s, 1.0));
            let highlight = power(s, tilt, splat(s, material.shininess)) * material.specular;
            // No highlight on the side away from the light.
            let highlight = facing.simd_gt(zero).select(highlight, zero);
            reflected.specular = xyz!(C => highlight.mul_add(light.radiance[C], reflected.specular[C]));
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
