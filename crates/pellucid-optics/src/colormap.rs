//! Colour maps by the names people know them by.

mod maps;

use crate::control_point::Interpolation;
use crate::error::unknown_name;
use crate::transfer_function::ascending;
use crate::{Color, ColorPoint, OpacityPoint, OpticsError, TransferFunction};

/// A colour map: sRGB colours along an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorMap {
    name: &'static str,
    /// Position of 255, or the number of the category, and `0xrrggbb`.
    nodes: &'static [(u8, u32)],
    categorical: bool,
    reversed: bool,
}

impl ColorMap {
    /// The map of this name; with `_r` behind it, reversed.
    ///
    /// # Errors
    /// [`OpticsError::Name`], with the names there are.
    pub fn by_name(name: &str) -> Result<Self, OpticsError> {
        let (plain, reversed) = name.strip_suffix("_r").map_or((name, false), |plain| (plain, true));
        // Of a map that is also a colour both spellings are the map.
        let plain = if plain == "grey" { "gray" } else { plain };
        let found = maps::MAPS.iter().find(|map| map.name == plain);
        found.map(|map| Self { reversed, ..*map }).ok_or_else(|| unknown_name("colour map", name, Self::names()))
    }

    /// The colours of a name over a window of data values: a map's or, if it is that of a [colour](Color::parse), this
    /// one alone.
    ///
    /// # Errors
    /// [`OpticsError::Name`], with the maps there are, and as [`points`](Self::points).
    pub fn colors(name: &str, window: [f64; 2]) -> Result<Vec<ColorPoint>, OpticsError> {
        match (Self::by_name(name), Color::parse(name)) {
            (Err(_), Ok(color)) => {
                ascending("window of a colour map", window)?;
                Ok(vec![ColorPoint::new(window[0], color)])
            }
            (map, _) => map?.points(window),
        }
    }

    /// The names of all maps, without the reversed ones.
    pub fn names() -> impl Iterator<Item = &'static str> {
        maps::MAPS.iter().map(|map| map.name)
    }

    /// The map as control points over a window of data values. A map of categories divides the
    /// window into equal steps.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] unless the window ascends and is finite.
    pub fn points(&self, window: [f64; 2]) -> Result<Vec<ColorPoint>, OpticsError> {
        ascending("window of a colour map", window)?;
        let last = self.nodes.len() - 1;
        let point = |i: usize| {
            let (position, code) = self.nodes[if self.reversed { last - i } else { i }];
            let fraction = if self.categorical {
                i as f64 / self.nodes.len() as f64
            } else if self.reversed {
                1.0 - position as f64 / 255.0
            } else {
                position as f64 / 255.0
            };
            let interpolation = if self.categorical { Interpolation::Step } else { Interpolation::Linear };
            let value = window[0] * (1.0 - fraction) + window[1] * fraction;
            ColorPoint { value, color: Color::hex(code), interpolation }
        };
        Ok((0..=last).map(point).collect())
    }

    /// A transfer function with this map over a window of data values.
    ///
    /// # Errors
    /// As [`ColorMap::points`] and [`TransferFunction::new`].
    pub fn transfer_function(
        &self,
        window: [f64; 2],
        opacities: Vec<OpacityPoint>,
    ) -> Result<TransferFunction, OpticsError> {
        TransferFunction::new(self.points(window)?, opacities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ColorSpace, srgb8};

    /// Every 16th of the 256 colours of matplotlib 3.11, from the 8th on.
    #[rustfmt::skip]
    const PUBLISHED: [(&str, [u32; 16]); 10] = [
        ("viridis", [
            0x460b5e, 0x482173, 0x453581, 0x3f4889, 0x375a8c, 0x306a8e, 0x29798e, 0x23888e,
            0x1f978b, 0x21a685, 0x31b57b, 0x4cc26c, 0x6ece58, 0x95d840, 0xc0df25, 0xeae51a,
        ]),
        ("plasma", [
            0x20068f, 0x3e049c, 0x5801a4, 0x7100a8, 0x8808a6, 0x9e199d, 0xb22b8f, 0xc33d80,
            0xd24f71, 0xdf6263, 0xeb7556, 0xf48948, 0xfb9f3a, 0xfeb72d, 0xfcd025, 0xf5eb27,
        ]),
        ("inferno", [
            0x030210, 0x140b34, 0x2d0b59, 0x490b6a, 0x62146e, 0x7c1d6d, 0x952667, 0xae305c,
            0xc63d4d, 0xda4e3c, 0xeb6429, 0xf67e14, 0xfb9b06, 0xfbba1f, 0xf5d949, 0xf3f586,
        ]),
        ("magma", [
            0x03030f, 0x120d31, 0x271258, 0x420f75, 0x5c167f, 0x752181, 0x8e2a81, 0xa8327d,
            0xc23b75, 0xdb476a, 0xee5b5e, 0xf9785d, 0xfd9668, 0xfeb47b, 0xfed194, 0xfceeb0,
        ]),
        ("cividis", [
            0x002859, 0x013271, 0x263d6e, 0x3a486c, 0x4a536c, 0x595e6e, 0x676a71, 0x757575,
            0x838179, 0x928d78, 0xa29975, 0xb3a670, 0xc3b369, 0xd4c15f, 0xe6d051, 0xf8df3c,
        ]),
        ("turbo", [
            0x38276d, 0x4454c3, 0x467df4, 0x38a5fb, 0x1ecbda, 0x1de7b2, 0x4af880, 0x88ff4e,
            0xb7f735, 0xdde037, 0xf7c13a, 0xfe992c, 0xf56918, 0xe14109, 0xc12302, 0x950d01,
        ]),
        ("coolwarm", [
            0x4358cb, 0x5673e0, 0x6b8df0, 0x81a4fb, 0x97b8ff, 0xadc9fd, 0xc1d4f4, 0xd4dbe6,
            0xe4d9d2, 0xf1cdba, 0xf7bca1, 0xf7a688, 0xf18d6f, 0xe57058, 0xd55042, 0xc0282f,
        ]),
        ("gray", [
            0x070707, 0x171717, 0x272727, 0x373737, 0x474747, 0x575757, 0x676767, 0x777777,
            0x878787, 0x979797, 0xa7a7a7, 0xb7b7b7, 0xc7c7c7, 0xd7d7d7, 0xe7e7e7, 0xf7f7f7,
        ]),
        ("bone", [
            0x060609, 0x14141c, 0x22222f, 0x303043, 0x3e3e56, 0x4c4c6a, 0x5a5d7a, 0x687188,
            0x768496, 0x8497a4, 0x92aab2, 0xa0bec0, 0xb2cece, 0xc8dcdc, 0xdeeaea, 0xf4f8f8,
        ]),
        ("hot", [
            0x1d0000, 0x470000, 0x710000, 0x9b0000, 0xc50000, 0xef0000, 0xff1a00, 0xff4400,
            0xff6e00, 0xff9800, 0xffc200, 0xffec00, 0xffff22, 0xffff61, 0xffffa0, 0xffffdf,
        ]),
    ];

    fn at(name: &str, fraction: f64) -> [u8; 3] {
        let map = ColorMap::by_name(name).unwrap();
        let tf = map.transfer_function([-100.0, 155.0], vec![OpacityPoint::new(0.0, 1.0)]).unwrap();
        assert_eq!(tf.color_space(), ColorSpace::Srgb);
        srgb8(tf.color(-100.0 + 255.0 * fraction))
    }

    #[test]
    fn maps_are_the_published_ones() {
        for (name, colors) in PUBLISHED {
            for (i, code) in colors.into_iter().enumerate() {
                let fraction = (7 + 16 * i) as f64 / 255.0;
                let expected: [u8; 3] = code.to_be_bytes()[1..].try_into().unwrap();
                let found = [at(name, fraction), at(&format!("{name}_r"), 1.0 - fraction)];
                for (a, b) in found.iter().flat_map(|rgb| rgb.iter().zip(&expected)) {
                    assert!(a.abs_diff(*b) <= 2, "{name} at {fraction}: {found:?}, expected {expected:?}");
                }
            }
        }
    }

    #[test]
    fn categories_are_equal_steps() {
        assert_eq!(at("tab10", 0.0), [0x1f, 0x77, 0xb4]);
        assert_eq!(at("tab10", 0.0999), [0x1f, 0x77, 0xb4]);
        assert_eq!(at("tab10", 0.1001), [0xff, 0x7f, 0x0e]);
        assert_eq!(at("tab10", 1.0), [0x17, 0xbe, 0xcf]);
        assert_eq!(at("tab10_r", 0.0), [0x17, 0xbe, 0xcf]);
        assert_eq!(at("tab10_r", 0.95), [0x1f, 0x77, 0xb4]);
    }

    #[test]
    fn every_name_works_both_ways_and_others_are_answered_with_the_list() {
        for name in ColorMap::names() {
            for name in [name.to_owned(), format!("{name}_r")] {
                let points = ColorMap::by_name(&name).unwrap().points([0.0, 1.0]).unwrap();
                assert!(points.windows(2).all(|pair| pair[0].value < pair[1].value), "{name}");
                assert_eq!(points[0].value, 0.0);
            }
        }
        let message = ColorMap::by_name("jet").unwrap_err().to_string();
        assert!(message.contains("\"jet\"") && message.contains("viridis, plasma"), "{message}");
        assert!(ColorMap::by_name("viridis").unwrap().points([1.0, 1.0]).is_err());
    }

    #[test]
    fn a_color_is_a_map_of_itself_unless_a_map_has_its_name() {
        let window = [10.0, 30.0];
        assert_eq!(ColorMap::colors("magenta", window).unwrap(), [ColorPoint::new(10.0, Color::hex(0xff00ff))]);
        let gray = ColorMap::by_name("gray").unwrap().points(window).unwrap();
        for name in ["gray", "grey"] {
            assert_eq!(ColorMap::colors(name, window).unwrap(), gray, "{name}");
        }
        assert_eq!(ColorMap::colors("grey_r", window).unwrap().len(), gray.len());
        assert!(ColorMap::colors("magneta", window).is_err());
        assert!(ColorMap::colors("magenta", [1.0, 1.0]).is_err());
    }
}
