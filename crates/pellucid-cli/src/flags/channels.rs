//! Components of a file as layers of one picture, as microscopes write them.

use pellucid::optics::{Color, ColorMap};
use pellucid::scene::{Scene, VolumeEntry};

use super::first_volume;
use crate::failure::Failure;

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Look")]
pub struct ChannelFlags {
    /// Components of the voxels, from 0, that are drawn together, each in a colour or colour map and over a window of
    /// its own, as in 0:green,1:magenta
    #[arg(long, value_name = "COMPONENT:COLOR,..", value_parser = channel, value_delimiter = ',',
        conflicts_with_all = ["component", "preset", "colormap", "transfer_function"])]
    channels: Vec<Channel>,
}

/// A component and the name of its colours.
#[derive(Clone, Debug)]
struct Channel {
    component: usize,
    color: String,
}

impl ChannelFlags {
    /// Makes a layer of every channel, in the place of the first volume and otherwise as that.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if self.channels.is_empty() {
            return Ok(());
        }
        let volume = first_volume(scene, "--channels")?.clone();
        let layer = |Channel { component, color }: &Channel| VolumeEntry {
            component: Some(*component),
            colormap: Some(color.clone()),
            opacity: volume.opacity.clone().or(Some("linear".to_owned())),
            preset: None,
            transfer_function: None,
            ..volume.clone()
        };
        scene.volumes.splice(..1, self.channels.iter().map(layer));
        Ok(())
    }
}

fn channel(text: &str) -> Result<Channel, String> {
    let parts = text.split_once(':').and_then(|(component, color)| Some((component.trim().parse().ok()?, color)));
    let (component, color) = parts.ok_or("a component's number and a colour are expected, as in 0:green")?;
    // Most are meant to be colours: of what is neither, that error tells more.
    if let (Err(_), Err(error)) = (ColorMap::colors(color, [0.0, 1.0]), Color::parse(color)) {
        return Err(error.to_string());
    }
    Ok(Channel { component, color: color.to_owned() })
}
