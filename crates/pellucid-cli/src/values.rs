//! Values of flags as people write them.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use pellucid::field::VoxelType;
use pellucid::optics::Color;
use pellucid::scene::meant;

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| format!("'{text}' is not a number"))
}

/// A finite number in single precision.
pub fn number32(text: &str) -> Result<f32, String> {
    let value = number(text)? as f32;
    if value.is_finite() { Ok(value) } else { Err(format!("{text} is beyond the range of single precision")) }
}

/// `N` numbers with commas between them.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let list = text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    let found = list.len();
    list.try_into().map_err(|_| format!("expected {N} numbers with commas between them, found {found}"))
}

/// `N` whole numbers with an x or a comma between them, as `1024x768`.
fn product<const N: usize>(text: &str) -> Result<[usize; N], String> {
    let list = text.split(SEPARATORS).map(|n| n.trim().parse().ok()).collect::<Option<Vec<usize>>>();
    list.and_then(|list| list.try_into().ok())
        .ok_or_else(|| format!("expected {N} whole numbers with an x between them, as {}", ["128"; N].join("x")))
}

/// What stands between sizes along axes.
const SEPARATORS: [char; 3] = ['x', 'X', ','];

/// Lengths along the axes: `1x1x2.5` or `1,1,2.5`.
pub fn lengths(text: &str) -> Result<[f64; 3], String> {
    numbers(&text.replace(SEPARATORS, ","))
}

/// Voxels per axis: `256x256x113`.
pub fn dims(text: &str) -> Result<[usize; 3], String> {
    product(text)
}

/// Width and height: `1024x768`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let too_large = |_| "a picture has at most 32768 pixels per side".to_owned();
    let [width, height] = product::<2>(text)?;
    Ok([u32::try_from(width).map_err(too_large)?, u32::try_from(height).map_err(too_large)?])
}

/// A number of bytes, with K, M, G or T for powers of 1024: `300M`.
pub fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(['K', 'M', 'G', 'T']);
    let unit = match &text[digits.len()..] {
        "" => Some(1),
        "K" => Some(1 << 10),
        "M" => Some(1 << 20),
        "G" => Some(1 << 30),
        "T" => Some(1 << 40),
        _ => None,
    };
    let bytes = digits.parse::<u64>().ok().zip(unit).and_then(|(number, unit)| number.checked_mul(unit));
    bytes.ok_or_else(|| format!("'{text}' is not a number of bytes, such as 4000000, 300M or 8G"))
}

/// `on` or `off`.
pub fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("expected on or off".into()),
    }
}

/// A colour by its name, or as `#rrggbb`, also without the sign, which shells take for a comment.
pub fn color(text: &str) -> Result<Color, String> {
    let text = text.trim();
    Color::parse(text).or_else(|error| Color::parse(&format!("#{text}")).map_err(|_| error.to_string()))
}

/// A voxel type by its short name.
pub fn voxel_type() -> impl TypedValueParser<Value = VoxelType> {
    const TYPES: [(&str, VoxelType); 8] = [
        ("u8", VoxelType::U8),
        ("i8", VoxelType::I8),
        ("u16", VoxelType::U16),
        ("i16", VoxelType::I16),
        ("u32", VoxelType::U32),
        ("i32", VoxelType::I32),
        ("f16", VoxelType::F16),
        ("f32", VoxelType::F32),
    ];
    word(&TYPES)
}

/// What was expected, with the one of the words that was probably meant.
pub fn with_pointer(expected: &str, found: &str, words: &[&str]) -> String {
    let pointer = meant(found, words.iter().copied()).map(|word| format!(" (did you mean {word}?)"));
    format!("{expected}{}", pointer.unwrap_or_default())
}

/// One of several words, each with what it stands for.
pub fn word<T>(words: &'static [(&'static str, T)]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    word_or(words, &[])
}

/// [`word`], with words that are looked for there and meant elsewhere, each with where.
pub fn word_or<T>(
    words: &'static [(&'static str, T)],
    elsewhere: &'static [(&'static str, &'static str)],
) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    Words { words, elsewhere }
}

/// Parses words; unlike clap's own list it knows what others call them.
#[derive(Clone)]
struct Words<T: 'static> {
    words: &'static [(&'static str, T)],
    elsewhere: &'static [(&'static str, &'static str)],
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for Words<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        let found = value.to_string_lossy();
        if let Some((_, meaning)) = self.words.iter().find(|(word, _)| *word == found) {
            return Ok(meaning.clone());
        }
        let known = || self.words.iter().map(|(word, _)| *word);
        let mut error = clap::Error::new(ErrorKind::InvalidValue).with_cmd(command);
        if let Some(arg) = arg {
            error.insert(ContextKind::InvalidArg, ContextValue::String(arg.to_string()));
        }
        error.insert(ContextKind::InvalidValue, ContextValue::String(found.to_string()));
        error.insert(ContextKind::ValidValue, ContextValue::Strings(known().map(str::to_owned).collect()));
        // What others call a thing of elsewhere leads there, too.
        let names = self.elsewhere.iter().map(|(word, _)| *word);
        let all: Vec<&str> = known().chain(names).collect();
        if let Some(meant) = meant(&found, all) {
            match self.elsewhere.iter().find(|(name, _)| *name == meant) {
                Some((_, place)) => {
                    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![(*place).into()]))
                }
                None => error.insert(ContextKind::SuggestedValue, ContextValue::String(meant.to_owned())),
            };
        }
        Err(error)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.words.iter().map(|(word, _)| PossibleValue::new(*word))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_counted() {
        assert_eq!(numbers("-1, 2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for bad in ["1,2", "1,2,3,4", "1,,2", "", "nan,0,0", "inf,0,0", "1e999,0,0"] {
            assert!(numbers::<3>(bad).is_err(), "{bad}");
        }
        assert!(number32("1e39").is_err());
    }

    #[test]
    fn products_have_their_number_of_factors() {
        assert_eq!(dims("1x22x333"), Ok([1, 22, 333]));
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in ["1x2", "1x2x3x4", "1x2x", "-1x2x3", "axbxc", "99999999999999999999x1x1"] {
            assert!(dims(bad).is_err(), "{bad}");
        }
        assert!(size("4294967296x1").is_err());
        // Both marks everywhere where sizes along axes are meant.
        assert_eq!((dims("8,8,32"), size("640,480")), (Ok([8, 8, 32]), Ok([640, 480])));
        assert_eq!((lengths("1x1x2.5"), lengths("1, 1, 2.5e0")), (Ok([1.0, 1.0, 2.5]), Ok([1.0, 1.0, 2.5])));
        assert!(lengths("1x1").is_err() && lengths("1xx1").is_err());
    }

    #[test]
    fn colors_need_no_sign() {
        let orange = Color::hex(0xff8000);
        assert_eq!((color("#ff8000"), color("FF8000")), (Ok(orange), Ok(orange)));
        assert_eq!((color("Orange"), color("f80")), (Ok(Color::hex(0xffa500)), Ok(Color::hex(0xff8800))));
        assert!(color("ornage").unwrap_err().contains("did you mean orange?") && color("#ff80").is_err());
    }
}
