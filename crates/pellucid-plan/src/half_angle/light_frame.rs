//! The light's picture of the volume: texels on a plane across the light (6.1-5).

use glam::{DVec2, DVec3};
use pellucid_field::Grid;
use pellucid_optics::{LightShape, ResolvedLight};
use pellucid_scene::Ray;

/// How world positions are projected along the rays of a light. Texel `(x, y)` is the square from there to
/// `(x + 1, y + 1)`.
#[derive(Clone, Debug)]
pub struct LightFrame {
    /// Where the light is, or a point from which the volume lies ahead.
    pub origin: DVec3,
    /// One of the two ways across, unit vectors.
    pub right: DVec3,
    /// The other way across.
    pub up: DVec3,
    /// The middle direction in which light travels.
    pub forward: DVec3,
    /// Whether its rays are parallel.
    pub is_directional: bool,
    /// Coordinates on the plane of the corner of texel (0, 0): in world units, or as tangents.
    pub low: DVec2,
    /// Sides of a texel, likewise.
    pub texel: DVec2,
    /// Texels that the box covers: the middles of the outer ones are on its outline, or light would leak in
    /// from beside it.
    pub size: [usize; 2],
    /// From index positions to texels, or to texels times depth, and depth.
    pub rows: [[f32; 4]; 3],
}

impl LightFrame {
    /// Around a grid's box, with so many texels along its longer side; `None` if the light stands in the box
    /// or so near that it would have to look all around.
    pub fn new(light: &ResolvedLight, grid: &Grid, resolution: u32) -> Option<Self> {
        /// Tangent of the widest angle from the middle direction.
        const WIDEST: f64 = 4.0;
        let center = grid.center();
        let corners = grid.world_corners();
        let (origin, forward, is_directional) = match light.shape() {
            LightShape::Directional { to_light } => {
                let to_light = to_light.as_dvec3().normalize();
                let far = corners.map(|corner| corner.distance(center)).into_iter().fold(0.0, f64::max);
                (center + to_light * (2.0 * far), -to_light, true)
            }
            LightShape::Local { position, .. } => {
                let position = position.as_dvec3();
                (position, (center - position).try_normalize()?, false)
            }
        };
        // Along the box's side that the light sees longest: the picture of a long box would else be a square, nearly
        // empty where the box lies across it.
        let across = [1, 2, 4].map(|corner| (corners[corner] - corners[0]).reject_from_normalized(forward));
        let longest = across.into_iter().fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
        let right = longest.try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = forward.cross(right);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            let way = corner - origin;
            let depth = if is_directional { 1.0 } else { way.dot(forward) };
            let place = DVec2::new(way.dot(right), way.dot(up)) / depth;
            let ahead = is_directional || (depth > 0.0 && place.abs().max_element() <= WIDEST);
            if !ahead || !place.is_finite() {
                return None;
            }
            (low, high) = (low.min(place), high.max(place));
        }
        // Rays along faces of the box would miss it by a rounding.
        let inset = (high - low) * 1e-6;
        let (low, extent) = (low + inset, high - low - 2.0 * inset);
        let side = extent.max_element() / f64::from(resolution - 1);
        let size = [extent.x, extent.y].map(|length| ((length / side - 1e-6).ceil() as usize).max(1) + 1);
        let texel = extent / DVec2::from_array(size.map(|n| (n - 1) as f64));
        let texel = texel.max(DVec2::splat(f64::MIN_POSITIVE));
        let low = low - texel / 2.0;
        let frame = Self { origin, right, up, forward, is_directional, low, texel, size, rows: [[0.0; 4]; 3] };
        Some(frame.on(grid))
    }

    /// The same picture for index positions of another grid.
    pub fn on(&self, grid: &Grid) -> Self {
        Self { rows: self.rows_of(grid), ..self.clone() }
    }

    /// Affine functions of the index position.
    fn rows_of(&self, grid: &Grid) -> [[f32; 4]; 3] {
        let world = grid.world_from_index();
        let row = |direction: DVec3| {
            let slope = world.matrix3.transpose() * direction;
            [slope.x, slope.y, slope.z, direction.dot(world.translation - self.origin)]
        };
        let depth = if self.is_directional { [0.0, 0.0, 0.0, 1.0] } else { row(self.forward) };
        let [x, y] = [(self.right, 0), (self.up, 1)].map(|(side, axis)| {
            let row = row(side);
            std::array::from_fn(|column| (row[column] - self.low[axis] * depth[column]) / self.texel[axis])
        });
        [x, y, depth].map(|row| row.map(|number| number as f32))
    }

    /// The ray of light through a place of the picture, in texels. Distances along rays of a light that is
    /// somewhere count from it.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let place = self.low + DVec2::new(x, y) * self.texel;
        let side = self.right * place.x + self.up * place.y;
        if self.is_directional {
            Ray { origin: self.origin + side, direction: self.forward }
        } else {
            Ray { origin: self.origin, direction: (self.forward + side).normalize() }
        }
    }

    /// Directions of the rays at the picture's corners: all others lie between them.
    pub fn corner_rays(&self) -> [DVec3; 4] {
        let [width, height] = self.size.map(|n| n as f64);
        [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)].map(|(x, y)| self.ray(x, y).direction)
    }

    /// Where a world position is in the picture, in texels.
    pub fn project(&self, position: DVec3) -> DVec2 {
        let way = position - self.origin;
        let depth = if self.is_directional { 1.0 } else { way.dot(self.forward) };
        (DVec2::new(way.dot(self.right), way.dot(self.up)) / depth - self.low) / self.texel
    }

    /// The most texels per world unit across the light, over a grid's box.
    pub fn finest(&self, grid: &Grid) -> f64 {
        let depth = |corner: DVec3| if self.is_directional { 1.0 } else { (corner - self.origin).dot(self.forward) };
        let nearest = grid.world_corners().map(depth).into_iter().fold(f64::INFINITY, f64::min);
        (nearest * self.texel.min_element()).recip()
    }

    /// A length across a directional light, in texels to the right and up.
    pub fn across(&self, length: f64) -> [f32; 2] {
        (DVec2::splat(length) / self.texel).as_vec2().to_array()
    }

    /// The light's position, if it is somewhere.
    pub fn position(&self) -> Option<DVec3> {
        (!self.is_directional).then_some(self.origin)
    }
}
