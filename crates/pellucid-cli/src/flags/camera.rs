//! Where the eye stands and how it projects.

use pellucid::scene::{Framing, LookAt, Orbit, Projection, Scene, View};

use crate::failure::Failure;
use crate::values;

const FRAMINGS: [(&str, Framing); 2] = [("visible", Framing::Visible), ("grid", Framing::Grid)];

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Camera")]
pub struct CameraFlags {
    /// Degrees around the up axis; 0 looks at a patient's face, positive walks to the viewer's
    /// right [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = values::number, allow_hyphen_values = true)]
    azimuth: Option<f64>,
    /// Degrees above the horizon, -90 to 90 [default: 20]
    #[arg(long, value_name = "DEGREES", value_parser = values::number, allow_hyphen_values = true)]
    elevation: Option<f64>,
    /// Degrees the picture is turned clockwise [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = values::number, allow_hyphen_values = true)]
    roll: Option<f64>,
    /// Magnification of the picture, greater than 0, as by a lens: the eye stays where it is, and a
    /// distance is what moves it [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = values::number, allow_hyphen_values = true)]
    zoom: Option<f64>,
    /// What is framed where target, distance or height are left out: what is visible of the volume, or
    /// the whole grid, so that pictures of a series or of several isovalues compare [default: visible]
    #[arg(long, value_name = "WHAT", value_parser = values::word(&FRAMINGS))]
    frame: Option<Framing>,
    /// Distance of the eye from the target in world units [default: the volume is framed]
    #[arg(long, value_name = "LENGTH", value_parser = values::number, allow_hyphen_values = true)]
    distance: Option<f64>,
    /// World position in the middle of the picture [default: the middle of what is framed]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::numbers::<3>, allow_hyphen_values = true)]
    target: Option<[f64; 3]>,
    /// World position of the eye, instead of angles; needs --target
    #[arg(long, value_name = "X,Y,Z", value_parser = values::numbers::<3>, allow_hyphen_values = true,
        conflicts_with_all = ["azimuth", "elevation", "roll", "zoom", "distance"])]
    eye: Option<[f64; 3]>,
    /// Direction that points up in the picture, with --eye [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::numbers::<3>, allow_hyphen_values = true,
        conflicts_with_all = ["azimuth", "elevation", "roll", "zoom", "distance"])]
    up: Option<[f64; 3]>,
    /// Full vertical angle of view in degrees, between 0 and 180 [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = values::number, allow_hyphen_values = true,
        conflicts_with = "orthographic")]
    fov: Option<f64>,
    /// Parallel rays; HEIGHT of the picture in world units [default: perspective; the volume is
    /// framed]
    #[arg(long, value_name = "HEIGHT", value_parser = values::number, num_args = 0..=1, require_equals = true)]
    #[allow(clippy::option_option)] // Not given, given alone, given with a height.
    orthographic: Option<Option<f64>>,
}

impl CameraFlags {
    /// Whether any of them decides where the eye stands or how it projects; a zoom magnifies what it sees.
    pub fn is_given(&self) -> bool {
        self.stands() || self.looks() || self.target.is_some() || self.fov.is_some() || self.orthographic.is_some()
    }

    fn stands(&self) -> bool {
        [self.azimuth, self.elevation, self.roll, self.distance].iter().any(Option::is_some)
    }

    fn orbits(&self) -> bool {
        self.stands() || self.zoom.is_some()
    }

    fn looks(&self) -> bool {
        self.eye.is_some() || self.up.is_some()
    }

    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let camera = &mut scene.camera;
        camera.frame = self.frame.unwrap_or(camera.frame);
        if let Some(vertical_fov) = self.fov {
            camera.projection = Projection::Perspective { vertical_fov };
        }
        if let Some(height) = self.orthographic {
            camera.projection = Projection::Orthographic { height };
        }
        camera.view = match camera.view {
            View::LookAt(look) if !self.orbits() => View::LookAt(LookAt {
                position: self.eye.unwrap_or(look.position),
                target: self.target.unwrap_or(look.target),
                up: self.up.unwrap_or(look.up),
            }),
            View::Orbit(_) if self.looks() => View::LookAt(self.look_at()?),
            View::Orbit(orbit) => View::Orbit(self.orbit(orbit)),
            // Angles replace a camera given by positions.
            View::LookAt(_) => View::Orbit(self.orbit(Orbit::default())),
        };
        Ok(())
    }

    fn look_at(&self) -> Result<LookAt, Failure> {
        let (Some(position), Some(target)) = (self.eye, self.target) else {
            return Err(Failure::input("a camera by position needs both --eye and --target"));
        };
        Ok(LookAt { position, target, up: self.up.unwrap_or([0.0, 0.0, 1.0]) })
    }

    fn orbit(&self, orbit: Orbit) -> Orbit {
        Orbit {
            azimuth: self.azimuth.unwrap_or(orbit.azimuth),
            elevation: self.elevation.unwrap_or(orbit.elevation),
            roll: self.roll.unwrap_or(orbit.roll),
            distance: self.distance.or(orbit.distance),
            zoom: self.zoom.unwrap_or(orbit.zoom),
            target: self.target.or(orbit.target),
        }
    }
}
