//! Cameras: how rays leave the eye.

use glam::{DQuat, DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, direction, finite, positive, require};

/// Where the eye is and how it projects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Position and orientation.
    pub view: View,
    /// What is framed where target, distance or height are left out. Default visible.
    pub frame: Framing,
}

/// What a camera frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Framing {
    /// What can be seen of the volumes, as tightly as it shows from this side: whatever the transfer function,
    /// the isovalues, clips and crops leave.
    #[default]
    Visible,
    /// The whole grids, whatever is seen of them: pictures of a series, or of several isovalues, compare.
    Grid,
}

/// How the image plane relates to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Projection {
    /// Rays leave one point.
    Perspective {
        /// Full vertical angle of view in degrees, between 0 and 180 (exclusive).
        vertical_fov: f64,
    },
    /// Rays are parallel.
    Orthographic {
        /// Height of the picture in world units; left out, the volumes are framed.
        #[serde(default)]
        height: Option<f64>,
    },
}

impl Default for Projection {
    /// Perspective with 30 degrees.
    fn default() -> Self {
        Self::Perspective { vertical_fov: 30.0 }
    }
}

/// Where the eye stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum View {
    /// Around a target, by angles.
    Orbit(Orbit),
    /// From a position to a target.
    LookAt(LookAt),
}

impl Default for View {
    /// [`Orbit::default`].
    fn default() -> Self {
        Self::Orbit(Orbit::default())
    }
}

/// A camera on a sphere around a target.
///
/// At azimuth 0 and elevation 0 the eye looks along the world's +y axis with +z up: the front of a
/// patient whose file states its orientation. A positive azimuth walks the eye to its own right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Orbit {
    /// Degrees around the world's +z. Default 30.
    pub azimuth: f64,
    /// Degrees above the horizon, -90 to 90. Default 20.
    pub elevation: f64,
    /// Degrees the picture is turned clockwise. Default 0.
    pub roll: f64,
    /// Distance of the eye from the target in world units; left out, the volumes are framed.
    pub distance: Option<f64>,
    /// Magnification of the picture, greater than 0, as by a lens: the angle of view or the height of the picture
    /// becomes narrower, and the eye stays where it is. `distance` moves it. Default 1.
    pub zoom: f64,
    /// World position looked at; left out, the middle of what is framed.
    pub target: Option<[f64; 3]>,
}

impl Default for Orbit {
    fn default() -> Self {
        Self { azimuth: 30.0, elevation: 20.0, roll: 0.0, distance: None, zoom: 1.0, target: None }
    }
}

/// A camera given by positions in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookAt {
    /// World position of the eye.
    pub position: [f64; 3],
    /// World position in the middle of the picture.
    pub target: [f64; 3],
    /// Direction that points up in the picture. Default +z.
    #[serde(default = "up_z")]
    pub up: [f64; 3],
}

fn up_z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl Camera {
    pub(crate) fn check(&self, path: &str) -> Checked {
        match self.projection {
            Projection::Perspective { vertical_fov: fov } => {
                let key = "projection.perspective.vertical_fov";
                require(fov > 0.0 && fov < 180.0, path, key, fov, "degrees between 0 and 180")?;
            }
            Projection::Orthographic { height: Some(height) } => {
                positive(path, "projection.orthographic.height", height, "a length greater than 0")?;
            }
            Projection::Orthographic { height: None } => {}
        }
        match &self.view {
            View::Orbit(orbit) => orbit.check(&format!("{path}.view.orbit")),
            View::LookAt(look) => look.check(&format!("{path}.view.look_at")),
        }
    }

    /// Whether anything is left to framing: the target, the distance or the height of parallel rays.
    pub fn frames(&self) -> bool {
        let open = match &self.view {
            View::Orbit(orbit) => orbit.target.is_none() || orbit.distance.is_none(),
            View::LookAt(_) => false,
        };
        open || matches!(self.projection, Projection::Orthographic { height: None })
    }

    /// The explicit camera for a picture of `width` x `height` pixels. Where target, distance or
    /// height are left automatic, it frames all of `corners`, see [`Camera::framing`].
    pub fn viewpoint(&self, width: usize, height: usize, corners: &[DVec3]) -> Viewpoint {
        let farthest = |d: DVec3| corners.iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max);
        self.framing(width, height, &|d| if corners.is_empty() { 0.0 } else { farthest(d) })
    }

    /// The explicit camera for a picture of `width` x `height` pixels. Where target, distance or
    /// height are left automatic, it frames a set of points given by its support function, the
    /// largest `p . d` over the points p for a direction d: all of it is in the picture, its
    /// silhouette reaches both sides of the narrower axis up to a small margin, and is centred.
    ///
    /// A point is in the picture of a perspective eye e exactly if `|(p - e) . a| <= s (e - p) . b`, a an
    /// axis of the picture, b the direction back and s the slope of the picture's side: four half-spaces
    /// whose offsets are values of the support function at `b s + a` and `b s - a`.
    pub fn framing(&self, width: usize, height: usize, support: &dyn Fn(DVec3) -> f64) -> Viewpoint {
        let (target, back, up_hint, zoom, distance) = match self.view {
            View::LookAt(look) => {
                let (eye, target) = (DVec3::from_array(look.position), DVec3::from_array(look.target));
                (Some(target), eye - target, DVec3::from_array(look.up), 1.0, Some((eye - target).length()))
            }
            View::Orbit(orbit) => {
                let (back, up) = orbit.frame();
                (orbit.target.map(DVec3::from_array), back, up, orbit.zoom, orbit.distance)
            }
        };
        let back = back.try_normalize().unwrap_or(DVec3::NEG_Y);
        let right = right_of(back, up_hint);
        let up = back.cross(right);
        let aspect = width as f64 / height as f64;
        let tangent = match self.projection {
            Projection::Perspective { vertical_fov } => Some((vertical_fov.to_radians() / 2.0).tan()),
            Projection::Orthographic { .. } => None,
        };
        // Along an axis of the picture: the middle of what is framed, and how far it reaches from there at the
        // eye's depth 0.
        let along = |axis: DVec3, slope: f64| {
            let [ahead, behind] = [axis, -axis].map(|axis| axis + back * slope);
            match target {
                None => ((support(ahead) - support(behind)) / 2.0, (support(ahead) + support(behind)) / 2.0),
                Some(t) => {
                    let reach = (support(ahead) - t.dot(ahead)).max(support(behind) - t.dot(behind));
                    (t.dot(axis), reach + slope * t.dot(back))
                }
            }
        };
        let framed = || {
            let (nearest, farthest) = (support(back), -support(-back));
            let depth = target.map_or((nearest + farthest) / 2.0, |target| target.dot(back));
            let slope = tangent.unwrap_or(0.0) / MARGIN;
            let [(x, across), (y, upward)] = [along(right, slope * aspect), along(up, slope)];
            let target = target.unwrap_or(right * x + up * y + back * depth);
            let reach = (across / aspect).max(upward);
            // Parallel rays begin in front of everything, and an eye does not touch what it looks at.
            let eye = match tangent {
                Some(_) => (reach / slope).max(nearest + 1e-3 * (nearest - farthest)),
                None => nearest + reach,
            };
            Fit { target, distance: (eye - depth).max(0.0), reach: reach * MARGIN }
        };
        // What is given in full asks nothing of the data.
        let framed = if self.frames() { framed() } else { Fit { target: DVec3::ZERO, distance: 0.0, reach: 0.0 } };
        let half_height = match (tangent, self.projection) {
            (Some(tangent), _) => tangent,
            (None, Projection::Orthographic { height: Some(height) }) => height / 2.0,
            (None, _) => framed.reach,
        };
        let target = target.unwrap_or(framed.target);
        Viewpoint {
            eye: target + back * distance.unwrap_or(framed.distance),
            target,
            right,
            up,
            forward: -back,
            half_height: (half_height / zoom).max(f64::MIN_POSITIVE),
            perspective: tangent.is_some(),
            width,
            height,
            shift: DVec2::ZERO,
        }
    }
}

/// What frames a set of points.
struct Fit {
    target: DVec3,
    /// Of the eye from the target.
    distance: f64,
    /// Half the height of a parallel picture.
    reach: f64,
}

/// Unit direction of picture +x for unit `back`. Looking along `up` itself, +y is up instead, as it
/// is for an orbit at its pole, or +x.
fn right_of(back: DVec3, up: DVec3) -> DVec3 {
    let across = |up: DVec3| Some(up.normalize_or_zero().cross(back)).filter(|across| across.length() > 1e-6);
    let across = [up, DVec3::Y, DVec3::X].into_iter().find_map(across).unwrap_or(DVec3::X);
    // What is left of a short product has rounding errors along `back`.
    across.reject_from_normalized(back).normalize()
}

/// Room left around framed volumes.
const MARGIN: f64 = 1.04;

impl Orbit {
    /// The directions from the target to the eye, and up in the picture.
    fn frame(&self) -> (DVec3, DVec3) {
        let (sin_a, cos_a) = self.azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = self.elevation.to_radians().sin_cos();
        let back = DVec3::new(cos_e * sin_a, -cos_e * cos_a, sin_e);
        // The derivative of `back` by elevation: a valid up even at the poles.
        let up = DVec3::new(-sin_e * sin_a, sin_e * cos_a, cos_e);
        let (sin_r, cos_r) = self.roll.to_radians().sin_cos();
        (back, up * cos_r - up.cross(back) * sin_r)
    }

    fn check(&self, path: &str) -> Checked {
        for (key, angle) in [("azimuth", self.azimuth), ("roll", self.roll)] {
            require(angle.is_finite(), path, key, angle, "finite degrees")?;
        }
        let elevation = self.elevation;
        require((-90.0..=90.0).contains(&elevation), path, "elevation", elevation, "degrees from -90 to 90")?;
        positive(path, "zoom", self.zoom, "a factor greater than 0")?;
        if let Some(distance) = self.distance {
            positive(path, "distance", distance, "a length greater than 0")?;
        }
        self.target.map_or(Ok(()), |target| finite(path, "target", target))
    }
}

impl LookAt {
    fn check(&self, path: &str) -> Checked {
        finite(path, "position", self.position)?;
        finite(path, "target", self.target)?;
        direction(path, "up", self.up)?;
        let away: [f64; 3] = std::array::from_fn(|axis| self.target[axis] - self.position[axis]);
        let apart = away.iter().any(|d| d.abs() > 1e-12);
        require(apart, path, "target", format!("{:?}", self.target), "a position apart from the camera's")
    }
}

/// A ray with a unit direction: `origin + t * direction`, t in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t = 0.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance t.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// A camera with nothing left to choose: an orthonormal frame and the size of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// World position of the eye (of the middle of the image plane, if orthographic).
    pub eye: DVec3,
    /// World position in the middle of the picture, which the eye turns about.
    pub target: DVec3,
    /// Unit direction of picture +x.
    pub right: DVec3,
    /// Unit direction of picture up.
    pub up: DVec3,
    /// Unit direction of view.
    pub forward: DVec3,
    /// Half the picture's height: at distance 1 (perspective) or in world units (orthographic).
    pub half_height: f64,
    /// Whether rays leave one point.
    pub perspective: bool,
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Added to every picture position, in pixels to the right and down: zero, unless frames with
    /// their rays elsewhere in the pixels are to be averaged.
    pub shift: DVec2,
}

impl Viewpoint {
    /// The ray through picture position (x, y) in pixels: (0, 0) is the top left corner of the
    /// picture, (0.5, 0.5) the middle of its first pixel. Pixels are square.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let scale = 2.0 * self.half_height / self.height as f64;
        let across = self.right * ((x + self.shift.x - self.width as f64 / 2.0) * scale);
        let upward = self.up * ((self.height as f64 / 2.0 - y - self.shift.y) * scale);
        if self.perspective {
            Ray { origin: self.eye, direction: (self.forward + across + upward).normalize() }
        } else {
            Ray { origin: self.eye + across + upward, direction: self.forward }
        }
    }

    /// The view whose ray through (x, y) is this one's through (x + dx, y + dy).
    pub fn shifted(&self, dx: f64, dy: f64) -> Self {
        Self { shift: self.shift + DVec2::new(dx, dy), ..*self }
    }

    /// The same view in `rows` rows (at least 1) and as many columns as cover the picture. Positions
    /// relative to the middle of the picture scale by `rows / height`, across as well: a last column
    /// may reach beyond.
    pub fn with_rows(&self, rows: usize) -> Self {
        let (rows, height) = (rows.max(1), self.height.max(1));
        let shift = self.shift * (rows as f64 / height as f64);
        Self { width: (self.width * rows).div_ceil(height), height: rows, shift, ..*self }
    }

    /// The view after a walk of `degrees` around the target on a turntable: about the world's +z, which is towards
    /// the head of a patient whose file states the orientation, so that what is upright stays upright.
    /// Positive degrees walk the eye to its own right, as a larger azimuth does.
    pub fn turntable(&self, degrees: f64) -> Self {
        self.turned(DVec3::Z, degrees)
    }

    /// The view after a walk of `degrees` around the target: the eye and its directions are turned
    /// together about `axis`, by the right hand rule. No degrees, or an axis without a direction, leave
    /// the view as it is, to the bit. (About `up`, which leans with the eye's elevation, what is upright wobbles:
    /// [`Viewpoint::turntable`] is what shows a thing from all sides.)
    pub fn turned(&self, axis: DVec3, degrees: f64) -> Self {
        let Some(axis) = axis.try_normalize().filter(|_| degrees != 0.0) else { return *self };
        let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
        Self {
            eye: self.target + turn * (self.eye - self.target),
            right: turn * self.right,
            up: turn * self.up,
            forward: turn * self.forward,
            ..*self
        }
    }

    /// Unit vector from a point towards the eye.
    pub fn to_eye(&self, point: DVec3) -> DVec3 {
        if self.perspective { (self.eye - point).try_normalize().unwrap_or(-self.forward) } else { -self.forward }
    }
}
