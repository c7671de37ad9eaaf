//! Lights, as they stand in a document and as they reach a point (5.2).

use glam::{DAffine3, DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::checked;
use crate::extent::{Extent, Face};
use crate::{Color, ColorSpace, OpticsError};

/// What a light's position and direction are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The world: the light stays where it is (default).
    #[default]
    World,
    /// The camera, which looks along -z with y up: the light moves with the eye.
    Camera,
}

/// How a light weakens with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Falloff {
    /// Not at all (default).
    #[default]
    None,
    /// As light does, with the square of the distance. `reference` is the distance in world units
    /// at which the light has its intensity.
    InverseSquare {
        /// Positive, in world units.
        reference: f64,
    },
}

/// Where a light shines from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LightKind {
    /// From infinitely far away (5.2-3).
    Directional {
        /// The way the light travels, towards the scene; any length but zero.
        direction: [f64; 3],
    },
    /// From a point, all around (5.2-1).
    Point {
        /// In world units.
        position: [f64; 3],
        /// Default none.
        #[serde(default)]
        falloff: Falloff,
    },
    /// From a point, into a cone with a soft edge (5.2-2).
    Spot {
        /// In world units.
        position: [f64; 3],
        /// The axis of the cone, away from the light; any length but zero.
        direction: [f64; 3],
        /// Full intensity up to this angle from the axis, in degrees, 0 to 180.
        inner_angle: f64,
        /// Nothing from this angle on, in degrees, from the inner angle to 180.
        outer_angle: f64,
        /// Default none.
        #[serde(default)]
        falloff: Falloff,
    },
    /// From a flat face, most straight ahead and nothing along it.
    Rectangle {
        /// Its middle, in world units.
        center: [f64; 3],
        /// Its edges, in world units; it shines to the side where the first turns into the second
        /// counterclockwise. At another angle than a right one they make a parallelogram.
        edges: [[f64; 3]; 2],
        /// Whether it shines to both sides; default false.
        #[serde(default)]
        two_sided: bool,
        /// Default none.
        #[serde(default)]
        falloff: Falloff,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Where it shines from.
    pub kind: LightKind,
    /// Its colour, sRGB-encoded; default white.
    #[serde(default = "white")]
    pub color: Color,
    /// Factor of the colour; default 1, not negative.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0))]
    pub intensity: f32,
    /// What position and direction are relative to; default the world.
    #[serde(default)]
    pub frame: Frame,
    /// Whether it makes highlights; default true. Fill lights do not.
    #[serde(default = "yes")]
    pub specular: bool,
    /// The size of what shines: of a directional light the angle from the middle of its disc to the edge, in
    /// degrees, 0 to 90 (the sun's is 0.27); of a point or spot light the radius of a ball, in world units; a
    /// rectangle has none. Default 0, a point. Techniques other than path tracing draw the middle alone.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub radius: f64,
}

fn white() -> Color {
    Color::WHITE
}

fn one() -> f32 {
    1.0
}

fn yes() -> bool {
    true
}

impl Light {
    /// A white light of intensity 1 in the world.
    pub fn new(kind: LightKind) -> Self {
        Self { kind, color: white(), intensity: one(), frame: Frame::default(), specular: yes(), radius: 0.0 }
    }

    /// The light ready for use, in world coordinates; `world_from_camera` places the camera.
    ///
    /// # Errors
    /// [`OpticsError::Direction`] and [`OpticsError::Parameter`] name the first setting that is
    /// out of range or not finite.
    pub fn resolve(&self, world_from_camera: DAffine3) -> Result<ResolvedLight, OpticsError> {
        checked("light intensity", self.intensity as f64, 0.0..=f32::MAX as f64, "0 or more")?;
        let world = match self.frame {
            Frame::World => DAffine3::IDENTITY,
            Frame::Camera => world_from_camera,
        };
        let direction = |found: [f64; 3]| {
            // Normalised first, so that no length is too short or too long to be transformed.
            let own = DVec3::from_array(found).try_normalize();
            let direction = own.and_then(|own| world.transform_vector3(own).try_normalize());
            direction
                .map(|direction| direction.as_vec3())
                .ok_or(OpticsError::Direction { name: "light direction", found })
        };
        let position = |found: [f64; 3]| {
            found.iter().try_for_each(|&v| {
                checked("light position", v, -f32::MAX as f64..=f32::MAX as f64, "finite coordinates")
            })?;
            Ok(world.transform_point3(DVec3::from_array(found)).as_vec3())
        };
        let reference = |falloff| match falloff {
            Falloff::None => Ok(None),
            Falloff::InverseSquare { reference } => {
                checked("light reference distance", reference, 1e-12..=1e12, "a length in world units")?;
                Ok(Some(reference as f32))
            }
        };
        let shape = match self.kind {
            LightKind::Directional { direction: d } => LightShape::Directional { to_light: -direction(d)? },
            LightKind::Point { position: p, falloff } => {
                LightShape::Local { position: position(p)?, reference: reference(falloff)?, cone: None }
            }
            LightKind::Spot { position: p, direction: d, inner_angle, outer_angle, falloff } => {
                checked("inner angle of a spot light", inner_angle, 0.0..=180.0, "0 to 180 degrees")?;
                checked(
                    "outer angle of a spot light",
                    outer_angle,
                    inner_angle..=180.0,
                    "the inner angle to 180 degrees",
                )?;
                let [inner, outer] = [inner_angle, outer_angle].map(|angle| angle.to_radians().cos() as f32);
                let cone = LightCone { axis: direction(d)?, inner, outer };
                LightShape::Local { position: position(p)?, reference: reference(falloff)?, cone: Some(cone) }
            }
            LightKind::Rectangle { center, falloff, .. } => {
                LightShape::Local { position: position(center)?, reference: reference(falloff)?, cone: None }
            }
        };
        let radiance = self.color.to_linear(ColorSpace::Srgb).map(|v| v * self.intensity);
        Ok(ResolvedLight { shape, extent: self.extent(world)?, radiance, specular: self.specular })
    }

    /// What shines around its middle.
    fn extent(&self, world: DAffine3) -> Result<Extent, OpticsError> {
        let (most, expected) = match self.kind {
            LightKind::Directional { .. } => (90.0, "0 to 90 degrees"),
            LightKind::Point { .. } | LightKind::Spot { .. } => (1e12, "0 or a length in world units"),
            LightKind::Rectangle { .. } => (0.0, "0, as a rectangle has edges"),
        };
        checked("light radius", self.radius, 0.0..=most, expected)?;
        if let LightKind::Rectangle { edges, two_sided, .. } = self.kind {
            let placed = edges.map(|edge| world.transform_vector3(DVec3::from_array(edge)).as_vec3());
            let face = Face::new(placed, two_sided);
            return face.map(Extent::Face).ok_or(OpticsError::Edges { found: edges });
        }
        Ok(match self.kind {
            _ if self.radius == 0.0 => Extent::Point,
            LightKind::Directional { .. } => {
                Extent::Disc { sine_squared: self.radius.to_radians().sin().powi(2) as f32 }
            }
            _ => Extent::Ball { radius: self.radius as f32 },
        })
    }
}

/// A light in world coordinates and linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolvedLight {
    /// Of its middle.
    pub(crate) shape: LightShape,
    pub(crate) extent: Extent,
    radiance: [f32; 3],
    specular: bool,
}

/// Where a light is and where it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// From the same side everywhere.
    Directional {
        /// Unit vector.
        to_light: Vec3,
    },
    /// From a point.
    Local {
        /// In the world.
        position: Vec3,
        /// The distance at which the radiance holds, if it falls off.
        reference: Option<f32>,
        /// Into a cone instead of everywhere.
        cone: Option<LightCone>,
    },
}

/// The cone of a spot light, by cosines, so that no angle has to be computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCone {
    /// Unit vector along its middle.
    pub axis: Vec3,
    /// Cosine of the angle up to which it has its full strength.
    pub inner: f32,
    /// Cosine of the angle from which on it has none.
    pub outer: f32,
}

/// A light as it reaches a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit vector from the point to the light; zero where the point is the light.
    pub to_light: Vec3,
    /// Linear RGB, nothing where the light does not reach.
    pub radiance: [f32; 3],
    /// Whether it makes highlights.
    pub specular: bool,
}

impl ResolvedLight {
    /// Whether the light is the same everywhere.
    pub fn is_directional(&self) -> bool {
        matches!(self.shape, LightShape::Directional { .. })
    }

    /// Where it is and where it shines; its middle, if it has a size.
    pub fn shape(&self) -> LightShape {
        self.shape
    }

    /// What shines around its middle.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Whether it has a size; otherwise it is met by choice alone, never by chance.
    pub fn has_extent(&self) -> bool {
        self.extent != Extent::Point
    }

    /// Whether it is a flat face, which shines less to its sides.
    pub fn is_face(&self) -> bool {
        matches!(self.extent, Extent::Face(_))
    }

    /// Its linear RGB radiance, where it is not weakened.
    pub fn radiance(&self) -> [f32; 3] {
        self.radiance
    }

    /// Whether it makes highlights.
    pub fn is_specular(&self) -> bool {
        self.specular
    }

    /// The light at a point of the world, if nothing is in between. All of a light that has a size comes from
    /// its middle.
    pub fn incident(&self, at: Vec3) -> Incident {
        let (to_light, strength) = self.towards(at);
        let seen = if let Extent::Face(face) = self.extent { face.cosine(to_light) } else { 1.0 };
        self.arriving(to_light, strength * seen)
    }

    /// This light, from somewhere and by a factor weaker.
    pub(crate) fn arriving(&self, to_light: Vec3, strength: f32) -> Incident {
        Incident { to_light, radiance: self.radiance.map(|v| v * strength), specular: self.specular }
    }

    /// The unit vector to its middle, and how much of its strength is left from there, straight ahead.
    pub(crate) fn towards(&self, at: Vec3) -> (Vec3, f32) {
        match self.shape {
            LightShape::Directional { to_light } => (to_light, 1.0),
            LightShape::Local { position, reference, cone } => {
                let path = position - at;
                let distance = path.length();
                // At the light itself there is no direction it could come from.
                if !(distance.is_finite() && distance > 1e-12) {
                    (Vec3::ZERO, 0.0)
                } else {
                    let to_light = path / distance;
                    // Bounded, as overflow next to the light would become NaN.
                    let falloff = reference.map_or(1.0, |r| (r / distance).powi(2).min(1e12));
                    (to_light, falloff * cone.map_or(1.0, |cone| cone.strength(-to_light)))
                }
            }
        }
    }
}

impl LightCone {
    /// 1 within the inner angle, 0 outside the outer one, smooth in between.
    fn strength(&self, direction: Vec3) -> f32 {
        let cosine = self.axis.dot(direction);
        if cosine >= self.inner {
            return 1.0;
        }
        if cosine <= self.outer {
            return 0.0;
        }
        let t = (cosine - self.outer) / (self.inner - self.outer);
        t * t * (3.0 - 2.0 * t)
    }
}
