//! Size, background and encoding.

use pellucid::scene::{Background, Encoding, Scene};

use crate::values;

const ENCODINGS: [(&str, Encoding); 2] = [("srgb", Encoding::Srgb), ("linear", Encoding::Linear)];

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct PictureFlags {
    /// Pixels per row and rows, 1 to 32768 each [default: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    size: Option<[u32; 2]>,
    /// What lies behind the volume: one colour (a name of CSS, #rrggbb or rrggbb), 'transparent', the
    /// 'environment' of the path tracer, or the colours of the top and the bottom row [default: black]
    #[arg(long, value_name = "COLOR|transparent|environment|TOP,BOTTOM", value_parser = background)]
    background: Option<Background>,
    /// How light becomes numbers in a PNG: srgb for screens, linear for measuring [default: srgb]
    #[arg(long, value_name = "CURVE", value_parser = values::word(&ENCODINGS))]
    encoding: Option<Encoding>,
    /// Factor on the light before encoding, greater than 0 [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = values::number32, allow_hyphen_values = true)]
    exposure: Option<f32>,
}

impl PictureFlags {
    pub fn apply(&self, scene: &mut Scene) {
        let image = &mut scene.image;
        if let Some([width, height]) = self.size {
            (image.width, image.height) = (width, height);
        }
        if let Some(background) = &self.background {
            image.background = background.clone();
        }
        image.encoding = self.encoding.unwrap_or(image.encoding);
        image.exposure = self.exposure.unwrap_or(image.exposure);
    }
}

fn background(text: &str) -> Result<Background, String> {
    Ok(match text.split_once(',') {
        _ if text == "transparent" => Background::Transparent,
        _ if text == "environment" => Background::Environment,
        None => Background::Color(values::color(text)?),
        Some((top, bottom)) => Background::Gradient { top: values::color(top)?, bottom: values::color(bottom)? },
    })
}
