//! Light at samples: local reflection (5.4), scattering, and what is left of lights on their way (6.1).

use glam::{DAffine3, Vec3 as GlamVec3};
use pellucid_optics::{Chroma, GradientWeight, Incident, Material, ResolvedLight};

use crate::chroma;
use crate::field::lane_position;
use crate::lanes::*;
use crate::scatter::Scatter;
use crate::shadow::Shadow;

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

/// The weight of a gradient magnitude: the vectors' form of [`GradientWeight::weight`].
#[inline(always)]
fn ramp<S: Lanes>(s: S, weight: &GradientWeight, magnitude: F32<S>) -> F32<S> {
    let t = (magnitude - weight.low) * (1.0 / (weight.high - weight.low));
    let t = t.max(splat(s, 0.0)).min(splat(s, 1.0));
    t * t * (splat(s, 3.0) - t * 2.0)
}

/// Material and lights of a volume.
pub struct Surface<'a, S> {
    material: Material,
    weight: Option<GradientWeight>,
    /// How samples scatter, if they are not surfaces.
    scatter: Option<Scatter<'a>>,
    ambient: f32,
    /// Lights that are the same everywhere, at most [`MOST_DIRECTIONAL`], with their numbers.
    directional: Vec<(usize, Incident)>,
    /// All others.
    local: Vec<(usize, &'a ResolvedLight)>,
    /// What holds their light back on its way, if anything does.
    shadow: Option<Box<dyn Shadow<S> + 'a>>,
    /// How it holds back each colour, if not all alike.
    chroma: Option<Chroma>,
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
    /// What is scattered of each directional light, where that is the same along a ray.
    weight: [[F32<S>; 3]; MOST_DIRECTIONAL],
}

/// Samples to be lit.
pub struct Unlit<S: Lanes> {
    /// Associated linear RGB and opacity.
    pub rgba: [F32<S>; 4],
    /// Data values.
    pub value: F32<S>,
    /// Index positions.
    pub index: Vec3<S>,
    /// Lanes that have a sample.
    pub lanes: Mask<S>,
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

impl<'a, S: Lanes> Surface<'a, S> {
    /// A material and gradient magnitudes between which unlit turns into lit, lights of the world and
    /// the ambient light among them.
    pub fn new(
        material: Material,
        weight: Option<GradientWeight>,
        lights: &'a [ResolvedLight],
        ambient: f32,
        world_from_index: DAffine3,
    ) -> Self {
        let (everywhere, somewhere): (Vec<_>, Vec<_>) =
            lights.iter().enumerate().partition(|(_, light)| light.is_directional());
        let (prepared, more) = everywhere.split_at(everywhere.len().min(MOST_DIRECTIONAL));
        Self {
            material,
            weight,
            scatter: None,
            ambient,
            directional: prepared.iter().map(|(number, light)| (*number, light.incident(GlamVec3::ZERO))).collect(),
            local: more.iter().copied().chain(somewhere).collect(),
            shadow: None,
            chroma: None,
            world_from_index,
        }
    }

    /// The same, in the shadow of what holds light back, each colour of it in its own way.
    pub fn shadowed(self, shadow: Option<Box<dyn Shadow<S> + 'a>>, chroma: Option<Chroma>) -> Self {
        Self { shadow, chroma, ..self }
    }

    /// The same lights on samples that scatter them.
    pub fn scattering(self, scatter: Scatter<'a>) -> Self {
        Self { scatter: Some(scatter), ..self }
    }

    /// Whether it depends on the length of a gradient, not on its direction alone.
    pub fn weighs_gradients(&self) -> bool {
        self.weight.is_some() || self.scatter.as_ref().is_some_and(|scatter| scatter.by_gradient().is_some())
    }

    /// What the directional lights need of rays, once for all of their samples.
    #[inline(always)]
    pub fn aim(&self, s: S, to_eye: Vec3<S>) -> Aim<S> {
        let mut halfway = [[splat(s, 0.0); 3]; MOST_DIRECTIONAL];
        let mut weight = [[splat(s, 0.0); 3]; MOST_DIRECTIONAL];
        for ((halfway, weight), (_, light)) in halfway.iter_mut().zip(&mut weight).zip(&self.directional) {
            let to_light = xyz!(I => splat(s, light.to_light[I]));
            *halfway = normalized(s, xyz!(I => to_light[I] + to_eye[I]));
            if let Some((scatter, g)) = self.scatter.as_ref().and_then(Scatter::uniform) {
                *weight = scatter.weight(s, splat(s, g), -dot::<S>(to_light, to_eye), all(s, true));
            }
        }
        Aim { to_eye, halfway, weight }
    }

    /// Lights samples by all lights, of which shadows leave their share. The gradient is asked for where
    /// there are surfaces only.
    #[inline(always)]
    pub fn shade(&self, s: S, sample: &Unlit<S>, aim: &Aim<S>, gradient: impl FnOnce() -> Vec3<S>) -> [F32<S>; 4] {
        self.shade_through(
            s,
            sample,
            aim,
            gradient,
            #[inline(always)]
            |light| match &self.shadow {
                Some(shadow) => {
                    chroma::each(s, self.chroma.as_ref(), shadow.transmittance(s, light, &sample.index, sample.lanes))
                }
                None => [splat(s, 1.0); 3],
            },
        )
    }

    /// Lights samples, where `through` says what share of each colour of a light, by its number, arrives. Colours are
    /// associated and stay so: light is weighted by the sample's opacity, or transparent samples would glow
    /// (5.4-1). The vectors' form of [`blinn_phong`](pellucid_optics::blinn_phong), which defines it, and
    /// of `C = E ((1 - S) P + S f)` for samples that scatter (K-10, K-11).
    #[inline(always)]
    pub fn shade_through(
        &self,
        s: S,
        sample: &Unlit<S>,
        aim: &Aim<S>,
        gradient: impl FnOnce() -> Vec3<S>,
        transmittance: impl Fn(usize) -> [F32<S>; 3],
    ) -> [F32<S>; 4] {
        let (material, zero, one) = (&self.material, splat(s, 0.0), splat(s, 1.0));
        let Unlit { rgba, value, index, lanes } = *sample;
        let cloud = self.scatter.as_ref().map(
            #[inline(always)]
            |scatter| (scatter, scatter.at(s, value)),
        );
        let has_surface = match &cloud {
            None => true,
            Some((scatter, found)) => {
                scatter.by_gradient().is_some() || (lanes & found.surface.simd_gt(zero)).any_true()
            }
        };
        let (mut normal, mut magnitude) = ([zero; 3], zero);
        if has_surface {
            (normal, magnitude) = normals(s, gradient());
            if material.two_sided {
                let away = dot::<S>(normal, aim.to_eye).simd_lt(zero);
                normal = xyz!(I => away.select(-normal[I], normal[I]));
            }
        }
        let unlit = splat(s, material.emission + material.ambient * self.ambient);
        let mut reflected = Reflected { diffuse: [if cloud.is_some() { zero } else { unlit }; 3], specular: [zero; 3] };
        let mut scattered = [zero; 3];
        for ((number, light), (halfway, weight)) in self.directional.iter().zip(aim.halfway.iter().zip(&aim.weight)) {
            let transmittance = transmittance(*number);
            let to_light = xyz!(I => splat(s, light.to_light[I]));
            let radiance = xyz!(C => transmittance[C] * light.radiance[C]);
            let light = IncidentLanes { to_light, radiance, specular: light.specular };
            if has_surface {
                self.reflect(s, &mut reflected, &light, &normal, halfway);
            }
            if let Some((scatter, found)) = &cloud {
                let weight = match scatter.uniform() {
                    Some(_) => *weight,
                    None => scatter.weight(s, found.g, -dot::<S>(light.to_light, aim.to_eye), lanes),
                };
                scattered = xyz!(C => weight[C].mul_add(light.radiance[C], scattered[C]));
            }
        }
        for (number, light) in &self.local {
            let transmittance = transmittance(*number);
            let IncidentLanes { to_light, radiance, specular } = self.incident(s, light, &index, lanes);
            let light = IncidentLanes::<S> { to_light, radiance: xyz!(C => radiance[C] * transmittance[C]), specular };
            if has_surface {
                let halfway = normalized(s, xyz!(I => light.to_light[I] + aim.to_eye[I]));
                self.reflect(s, &mut reflected, &light, &normal, &halfway);
            }
            if let Some((scatter, found)) = &cloud {
                let weight = scatter.weight(s, found.g, -dot::<S>(light.to_light, aim.to_eye), lanes);
                scattered = xyz!(C => weight[C].mul_add(light.radiance[C], scattered[C]));
            }
        }
        let Reflected { mut diffuse, mut specular } = reflected;
        if let Some((scatter, found)) = &cloud {
            let share = match scatter.by_gradient() {
                Some(weight) => ramp(s, weight, magnitude),
                None => found.surface,
            };
            diffuse = xyz!(C => lerp::<S>(share, scattered[C], diffuse[C]) + unlit);
            specular = xyz!(C => specular[C] * share);
        }
        if let (Some(weight), None) = (&self.weight, &cloud) {
            let t = ramp(s, weight, magnitude);
            diffuse = xyz!(C => lerp::<S>(t, one, diffuse[C]));
            specular = xyz!(C => specular[C] * t);
        }
        let [r, g, b] = xyz!(C => rgba[C].mul_add(diffuse[C], specular[C] * rgba[3]));
        [lanes.select(r, zero), lanes.select(g, zero), lanes.select(b, zero), rgba[3]]
    }

    /// The radiance of the first light at index positions, were nothing in between.
    #[inline(always)]
    pub fn radiance(&self, s: S, index: &Vec3<S>, lanes: Mask<S>) -> [F32<S>; 3] {
        match (self.directional.first(), self.local.first()) {
            (Some((_, light)), _) => xyz!(C => splat(s, light.radiance[C])),
            (None, Some((_, light))) => self.incident(s, light, index, lanes).radiance,
            (None, None) => [splat(s, 0.0); 3],
        }
    }

    /// Adds the light that is reflected from one source.
    #[inline(always)]
    fn reflect(
        &self,
        s: S,
        reflected: &mut Reflected<S>,
        light: &IncidentLanes<S>,
        normal: &Vec3<S>,
        halfway: &Vec3<S>,
    ) {
        let (material, zero) = (&self.material, splat(s, 0.0));
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
    fn incident(&self, s: S, light: &ResolvedLight, index: &Vec3<S>, lanes: Mask<S>) -> IncidentLanes<S> {
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
