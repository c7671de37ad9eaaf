//! Values of flags as people write them.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use pellucid::field::VoxelType;
use pellucid::optics::Color;

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

/// `N` whole numbers with an x between them, as `1024x768`.
fn product<const N: usize>(text: &str) -> Result<[usize; N], String> {
    let list = text.split(['x', 'X']).map(|n| n.parse().ok()).collect::<Option<Vec<usize>>>();
    list.and_then(|list| list.try_into().ok())
        .ok_or_else(|| format!("expected {N} whole numbers with an x between them, as {}", ["128"; N].join("x")))
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

/// A colour: `#rrggbb`, or without the sign, which shells take for a comment.
pub fn color(text: &str) -> Result<Color, String> {
    match text {
        "black" => Ok(Color::BLACK),
        "white" => Ok(Color::WHITE),
        _ => Color::parse(&format!("#{}", text.trim_start_matches('#')))
            .map_err(|_| format!("'{text}' is not a colour: expected #rrggbb, black or white")),
    }
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

/// One of several words, each with what it stands for.
pub fn word<T>(words: &'static [(&'static str, T)]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(words.iter().map(|(word, _)| *word)).try_map(|found| {
        let meant = words.iter().find(|(word, _)| *word == found).map(|(_, meaning)| meaning.clone());
        meant.ok_or_else(|| format!("'{found}' is not in the list"))
    })
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
    }

    #[test]
    fn colors_need_no_sign() {
        let orange = Color::hex(0xff8000);
        assert_eq!((color("#ff8000"), color("FF8000")), (Ok(orange), Ok(orange)));
        assert!(color("orange").is_err() && color("#ff80").is_err());
    }
}
