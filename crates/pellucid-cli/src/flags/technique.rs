//! What becomes of the samples along a ray.

use pellucid::scene::{
    Camera, Combine, Isosurface, Isovalue, Likeness, Mode, Orbit, Projection, Scene, Slice, StageVolume, TECHNIQUES,
    View,
};

use crate::failure::Failure;
use crate::values;

const MODES: [(&str, Mode); 6] = [
    ("composite", Mode::Composite),
    ("maximum", Mode::Maximum),
    ("minimum", Mode::Minimum),
    ("average", Mode::Average),
    ("additive", Mode::Additive),
    ("x-ray", Mode::XRay),
];

/// What is drawn by flags of its own.
const NOT_MODES: [(&str, &str); 2] = [
    ("isosurface", "--iso VALUE draws the surface of a data value"),
    ("slice", "--slice axial, coronal, sagittal or a normal draws a plane"),
];

/// What is looked for among techniques, and where it is.
const NOT_TECHNIQUES: [(&str, &str); 8] = [
    ("composite", "--mode composite, of ray-cast and the slices, is the default"),
    ("maximum", "maximum projections are drawn with --mode maximum"),
    ("minimum", "minimum projections are drawn with --mode minimum"),
    ("average", "averages are drawn with --mode average"),
    ("additive", "emission without absorption is drawn with --mode additive"),
    ("x-ray", "absorption without emission is drawn with --mode x-ray"),
    ("isosurface", "surfaces are drawn with --iso VALUE"),
    ("slice", "planes are drawn with --slice axial|coronal|sagittal|NX,NY,NZ"),
];

const COMBINES: [(&str, Combine); 3] =
    [("maximum", Combine::Maximum), ("minimum", Combine::Minimum), ("average", Combine::Average)];

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Technique")]
pub struct TechniqueFlags {
    /// What draws: rays, slices blended by a graphics adapter, slices that light and view share, or random paths of
    /// light [default: ray-cast]
    ///
    /// Slices lie across the view (view-aligned), on the volume's own planes (object-aligned), between those
    /// (multi-texture), or on spheres around the eye (shells). They keep no depth and no normals.
    #[arg(long, value_name = "TECHNIQUE", value_parser = values::word_or(TECHNIQUES, &NOT_TECHNIQUES))]
    technique: Option<Likeness>,
    /// What becomes of the samples along a ray [default: composite]
    #[arg(long, value_name = "MODE", value_parser = values::word_or(&MODES, &NOT_MODES), conflicts_with_all = ["iso", "slice"])]
    mode: Option<Mode>,
    /// Draw the surface of a data value, in the transfer function's colour unless one is given,
    /// with an opacity of 0 to 1. Repeatable
    #[arg(long, value_name = "VALUE[,COLOR[,OPACITY]]", value_parser = isovalue, allow_hyphen_values = true,
        conflicts_with = "slice")]
    iso: Vec<Isovalue>,
    /// Draw a plane through the volume, by name or by its normal
    ///
    /// If no camera is given, parallel rays meet the plane head on, in the radiological
    /// convention: axial from the feet with the patient's front up, coronal from the front and
    /// sagittal from the patient's left, both with the head up. In axial and coronal pictures the
    /// patient's right is on the left. (World axes are left, posterior, superior.) A plane by its
    /// normal is seen from the side the normal points to.
    #[arg(long, value_name = "axial|coronal|sagittal|NX,NY,NZ", value_parser = plane, allow_hyphen_values = true)]
    slice: Option<Plane>,
    /// Where the slice is: a world position, or percent of the way through the volume along the
    /// normal (from feet to head, front to back, right to left) [default: the middle, of the crop if there is one]
    #[arg(long, value_name = "X,Y,Z|PERCENT%", value_parser = position, allow_hyphen_values = true)]
    at: Option<Position>,
    /// Thickness of the slice in world units; 0 is a plane [default: 0]
    #[arg(long, value_name = "LENGTH", value_parser = values::number, allow_hyphen_values = true)]
    thickness: Option<f64>,
    /// What becomes of the values within a thick slice [default: maximum]
    #[arg(long, value_name = "RULE", value_parser = values::word(&COMBINES))]
    combine: Option<Combine>,
}

/// A plane, and the camera that faces it.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: [f64; 3],
    azimuth: f64,
    elevation: f64,
}

#[derive(Clone, Copy, Debug)]
enum Position {
    World([f64; 3]),
    Percent(f64),
}

impl TechniqueFlags {
    /// `face`: whether the camera may be turned towards a slice.
    pub fn apply(&self, scene: &mut Scene, face: bool) -> Result<(), Failure> {
        if let Some(technique) = self.technique {
            scene.technique = technique(&scene.technique);
        }
        let technique = scene.technique.name();
        let Some(mode) = scene.technique.mode_mut() else {
            let flags = [
                (self.mode.is_some(), "--mode"),
                (!self.iso.is_empty(), "--iso"),
                (self.slice.is_some(), "--slice"),
                (self.at.is_some(), "--at"),
                (self.thickness.is_some(), "--thickness"),
                (self.combine.is_some(), "--combine"),
            ];
            let given = flags.into_iter().find(|(given, _)| *given);
            return given.map_or(Ok(()), |(_, flag)| {
                let message = format_args!("{flag} has no meaning for {technique}, which the scene asks for");
                Err(Failure::input(message).hint("add --technique ray-cast"))
            });
        };
        if let Some(given) = &self.mode {
            *mode = given.clone();
        }
        if !self.iso.is_empty() {
            *mode = Mode::Isosurface(Isosurface::new(self.iso.clone()));
        }
        if let Some(plane) = self.slice {
            *mode = Mode::Slice(Slice { normal: Some(plane.normal), ..slice_of(mode).cloned().unwrap_or_default() });
            if face {
                scene.camera = plane.faced_by(&scene.camera);
            }
        }
        let flags = [
            (self.at.is_some(), "--at"),
            (self.thickness.is_some(), "--thickness"),
            (self.combine.is_some(), "--combine"),
        ];
        if let Some((_, flag)) = flags.into_iter().find(|(given, _)| *given) {
            let missing = || Failure::input(format_args!("{flag} is about a slice")).hint("add --slice axial");
            let slice = slice_of(mode).ok_or_else(missing)?;
            if let Some(Position::World(point)) = self.at {
                slice.point = Some(point);
            }
            slice.thickness = self.thickness.unwrap_or(slice.thickness);
            slice.combine = self.combine.unwrap_or(slice.combine);
        }
        Ok(())
    }

    /// Moves the slice to its place in percent, if it is given so and there is a slice.
    pub fn place(&self, scene: &mut Scene, volume: &StageVolume) -> bool {
        let slice = scene.technique.mode_mut().and_then(slice_of);
        let (Some(Position::Percent(percent)), Some(slice)) = (self.at, slice) else { return false };
        let Some(normal) = slice.normal else { return false };
        let dot = |p: [f64; 3]| (0..3).map(|axis| p[axis] * normal[axis]).sum::<f64>();
        let grid = volume.volume.grid();
        let heights = grid.world_corners().map(|corner| dot(corner.to_array()));
        let low = heights.into_iter().fold(f64::INFINITY, f64::min);
        let high = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let center = grid.center().to_array();
        let rise = (low + (high - low) * percent / 100.0 - dot(center)) / dot(normal);
        slice.point = Some(std::array::from_fn(|axis| center[axis] + normal[axis] * rise));
        true
    }
}

fn slice_of(mode: &mut Mode) -> Option<&mut Slice> {
    match mode {
        Mode::Slice(slice) => Some(slice),
        _ => None,
    }
}

impl Plane {
    /// A camera that faces the plane and frames and magnifies as this one.
    fn faced_by(self, camera: &Camera) -> Camera {
        let zoom = match camera.view {
            View::Orbit(orbit) => orbit.zoom,
            View::LookAt(_) => 1.0,
        };
        Camera {
            projection: Projection::Orthographic { height: None },
            view: View::Orbit(Orbit { azimuth: self.azimuth, elevation: self.elevation, zoom, ..Orbit::default() }),
            frame: camera.frame,
        }
    }
}

fn plane(text: &str) -> Result<Plane, String> {
    match text {
        "axial" => return Ok(Plane { normal: [0.0, 0.0, 1.0], azimuth: 0.0, elevation: -90.0 }),
        "coronal" => return Ok(Plane { normal: [0.0, 1.0, 0.0], azimuth: 0.0, elevation: 0.0 }),
        "sagittal" => return Ok(Plane { normal: [1.0, 0.0, 0.0], azimuth: 90.0, elevation: 0.0 }),
        _ => {}
    }
    let normal = values::numbers::<3>(text).map_err(|_| {
        let expected = "expected axial, coronal, sagittal or the three numbers of a normal";
        values::with_pointer(expected, text, &["axial", "coronal", "sagittal"])
    })?;
    let [x, y, z] = normal;
    let length = (x * x + y * y + z * z).sqrt();
    if length == 0.0 || !length.is_finite() {
        return Err("the normal has no direction".into());
    }
    // The inverse of the orbit: azimuth 0 is at -y, positive azimuths lead to +x.
    Ok(Plane { normal, azimuth: x.atan2(-y).to_degrees(), elevation: (z / length).asin().to_degrees() })
}

fn position(text: &str) -> Result<Position, String> {
    let Some(percent) = text.strip_suffix('%') else { return values::numbers(text).map(Position::World) };
    let percent = values::number(percent)?;
    if (0.0..=100.0).contains(&percent) { Ok(Position::Percent(percent)) } else { Err("expected 0% to 100%".into()) }
}

fn isovalue(text: &str) -> Result<Isovalue, String> {
    let mut parts = text.split(',');
    let value = values::number(parts.next().unwrap_or_default())?;
    let color = parts.next().map(values::color).transpose()?;
    let opacity = parts.next().map_or(Ok(1.0), values::number32)?;
    match parts.next() {
        None => Ok(Isovalue { value, color, opacity, volume: None }),
        Some(rest) => Err(format!("expected VALUE, COLOR and OPACITY, found '{rest}' as well")),
    }
}
