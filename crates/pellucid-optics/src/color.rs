//! Colours as people write them, and the linear light the renderer computes with.

use std::fmt;

use schemars::JsonSchema;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use pellucid_field::nearest;

use crate::OpticsError;
use crate::color_names::COLOR_NAMES;
use crate::sequence::exactly;

/// The space colours are given and interpolated in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ColorSpace {
    /// The numbers are sRGB-encoded, as in colour pickers, colour maps and web pages (default).
    #[default]
    Srgb,
    /// The numbers are linear light.
    Linear,
}

/// The linear value of an sRGB-encoded one (IEC 61966-2-1, exact piecewise form).
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB-encoded value of a linear one; the inverse of [`srgb_decode`].
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The 8-bit sRGB code values of a linear colour, clamped to the displayable range; NaN is black.
pub fn srgb8(linear: [f32; 3]) -> [u8; 3] {
    linear.map(|v| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Relative luminance of a linear colour with the primaries of sRGB (ITU-R BT.709).
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// A colour as written in a document: `"#rrggbb"`, a name of CSS, or `[r, g, b]` with numbers from 0 to 1.
///
/// Which space the numbers are in is said by what holds the colour (a transfer function's
/// [`ColorSpace`]); where nothing says otherwise they are sRGB-encoded.
#[derive(Clone, Copy, PartialEq)]
pub struct Color([f32; 3]);

impl Color {
    /// Black.
    pub const BLACK: Self = Self([0.0; 3]);
    /// White.
    pub const WHITE: Self = Self([1.0; 3]);

    /// A colour from red, green and blue in 0..=1.
    ///
    /// # Errors
    /// [`OpticsError::Color`] if a number is out of range or NaN.
    pub fn new(rgb: [f32; 3]) -> Result<Self, OpticsError> {
        if rgb.iter().all(|v| (0.0..=1.0).contains(v)) {
            return Ok(Self(rgb));
        }
        Err(OpticsError::Color { found: format!("{rgb:?}"), meant: None })
    }

    /// A colour from its code as hexadecimal number, `0xrrggbb`; higher bits are ignored.
    pub const fn hex(code: u32) -> Self {
        let [_, r, g, b] = code.to_be_bytes();
        Self([r as f32 / 255.0, g as f32 / 255.0, b as f32 / 255.0])
    }

    /// A colour from text: `#rrggbb`, `#rgb`, or a name of CSS in letters of any case.
    ///
    /// # Errors
    /// [`OpticsError::Color`] if it is anything else.
    pub fn parse(text: &str) -> Result<Self, OpticsError> {
        let code = match text.strip_prefix('#') {
            Some(digits) if digits.bytes().all(|digit| digit.is_ascii_hexdigit()) => {
                let number = u32::from_str_radix(digits, 16).ok();
                match digits.len() {
                    6 => number,
                    // Every digit stands for two of them.
                    3 => number.map(|n| 0x11 * ((n & 0xf00) << 8 | (n & 0xf0) << 4 | n & 0xf)),
                    _ => None,
                }
            }
            Some(_) => None,
            None => {
                let name = text.to_ascii_lowercase();
                COLOR_NAMES.binary_search_by_key(&name.as_str(), |(name, _)| name).ok().map(|k| COLOR_NAMES[k].1)
            }
        };
        code.map(Self::hex).ok_or_else(|| OpticsError::Color {
            found: format!("{text:?}"),
            meant: nearest(text, COLOR_NAMES.iter().map(|(name, _)| *name)),
        })
    }

    /// Red, green and blue as written.
    pub fn rgb(self) -> [f32; 3] {
        self.0
    }

    /// The nearest `#rrggbb`.
    pub fn to_hex(self) -> String {
        let [r, g, b] = self.0.map(|v| (v * 255.0).round() as u8);
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// The linear colour, the numbers read in `space`.
    pub fn to_linear(self, space: ColorSpace) -> [f32; 3] {
        match space {
            ColorSpace::Srgb => self.0.map(srgb_decode),
            ColorSpace::Linear => self.0,
        }
    }

    /// The sRGB-encoded colour, the numbers read in `space`.
    pub(crate) fn to_srgb(self, space: ColorSpace) -> Self {
        match space {
            ColorSpace::Srgb => self,
            ColorSpace::Linear => Self(self.0.map(|v| srgb_encode(v).min(1.0))),
        }
    }

    /// Linear interpolation of the numbers, whatever space they are in.
    pub(crate) fn lerp(self, to: Self, t: f32) -> Self {
        Self(std::array::from_fn(|channel| self.0[channel] + (to.0[channel] - self.0[channel]) * t))
    }
}

impl fmt::Debug for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Color({:?})", self.0)
    }
}

/// The two forms of a colour in documents.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Form {
    Text(#[schemars(regex(pattern = "^(#[0-9a-fA-F]{6}|#[0-9a-fA-F]{3}|[a-zA-Z]+)$"))] String),
    Rgb(#[schemars(inner(range(min = 0.0, max = 1.0)))] [f32; 3]),
}

impl JsonSchema for Color {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Color".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let mut schema = Form::json_schema(generator);
        schema.insert(
            "description".into(),
            "\"#rrggbb\", a name of CSS such as \"orange\", or [r, g, b] with numbers from 0 to 1.".into(),
        );
        schema
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // The short form only where it says the same.
        let hex = self.to_hex();
        let form = if Self::parse(&hex) == Ok(*self) { Form::Text(hex) } else { Form::Rgb(self.0) };
        form.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Forms;
        impl<'de> Visitor<'de> for Forms {
            type Value = Color;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a colour: \"#rrggbb\", a name of CSS, or [r, g, b] with numbers from 0 to 1")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
                Color::parse(text).map_err(E::custom)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Color, A::Error> {
                let rgb = exactly(seq, 3, &self)?;
                Color::new(rgb).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(Forms)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn transfer_curve_has_the_published_values() {
        // IEC 61966-2-1 code values, computed with 50 digits elsewhere: 0.5 -> 0.214041140..., 8-bit 10 -> 0.00303526983...
        for (encoded, linear) in
            [(0.0, 0.0), (1.0, 1.0), (0.5, 0.214_041_14), (10.0 / 255.0, 0.003_035_27), (0.04045, 0.003_130_8)]
        {
            assert!((srgb_decode(encoded) - linear).abs() < 1e-7, "{encoded}");
            assert!((srgb_encode(linear) - encoded).abs() < 1e-5, "{linear}");
        }
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn every_code_value_survives_the_linear_round_trip() {
        for code in 0..=255u8 {
            let color = Color::hex(u32::from_be_bytes([0, code, 255 - code, code]));
            assert_eq!(srgb8(color.to_linear(ColorSpace::Srgb)), [code, 255 - code, code]);
        }
        assert_eq!(srgb8([f32::NAN, -1.0, 7.0]), [0, 0, 255]);
    }

    #[test]
    fn documents_take_both_forms_and_reject_the_rest_with_a_reason() {
        assert_eq!(serde_json::from_str::<Color>("\"#ff8000\"").unwrap(), Color::hex(0xff8000));
        assert_eq!(serde_json::from_str::<Color>("[1, 0.25, 0]").unwrap().rgb(), [1.0, 0.25, 0.0]);
        assert_eq!(serde_json::to_string(&Color::hex(0x0a0b0c)).unwrap(), "\"#0a0b0c\"");
        for bad in
            ["\"#ff80\"", "\"ff8000\"", "\"#gg0000\"", "\"#+f0000\"", "[0, 0, 1.5]", "[0, 0]", "[0, 0, 0, 0]", "3"]
        {
            let message = serde_json::from_str::<Color>(bad).unwrap_err().to_string();
            assert!(message.contains("#rrggbb") || message.contains("invalid length 2"), "{bad}: {message}");
        }
        assert!(Color::new([f32::NAN, 0.0, 0.0]).is_err());
    }

    #[test]
    fn colours_have_the_names_of_css() {
        // Names with the code values of the standard, as people write them; `gray` has two spellings.
        for (name, code) in [
            ("orange", 0xffa500),
            ("SteelBlue", 0x4682b4),
            ("grey", 0x808080),
            ("gray", 0x808080),
            ("rebeccapurple", 0x663399),
            ("white", 0xffffff),
            ("#f80", 0xff8800),
        ] {
            assert_eq!(Color::parse(name), Ok(Color::hex(code)), "{name}");
            assert_eq!(serde_json::from_value::<Color>(name.into()).unwrap(), Color::hex(code));
        }
        assert!(COLOR_NAMES.is_sorted_by(|a, b| a.0 < b.0));
        let message = Color::parse("ornage").unwrap_err().to_string();
        assert!(message.contains("did you mean orange?"), "{message}");
    }

    proptest! {
        #[test]
        fn documents_round_trip(rgb in [0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0]) {
            let color = Color::new(rgb).unwrap();
            prop_assert_eq!(serde_json::from_str::<Color>(&serde_json::to_string(&color).unwrap()).unwrap(), color);
        }
    }
}
