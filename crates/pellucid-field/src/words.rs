//! Numbers and names as people read and write them.

use std::borrow::Cow;
use std::fmt;

/// A number in no more digits than tell it: exactly where that is short, otherwise with six significant digits, and
/// by a power of ten where zeros would hide it.
///
/// ```
/// use pellucid_field::Short;
///
/// assert_eq!(Short(2.5).to_string(), "2.5");
/// assert_eq!(Short(1.0 / 3.0).to_string(), "0.333333");
/// assert_eq!(Short(3.402_823_466e38).to_string(), "3.40282e38");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Short(pub f64);

impl Short {
    /// Both ends of a range, with all digits where fewer would not tell how wide it is.
    ///
    /// ```
    /// use pellucid_field::Short;
    ///
    /// assert_eq!(Short::ends(0.0, 1.0 / 3.0), ["0", "0.333333"]);
    /// assert_eq!(Short::ends(1e9 + 0.25, 1e9 + 0.75), ["1000000000.25", "1000000000.75"]);
    /// ```
    pub fn ends(low: f64, high: f64) -> [String; 2] {
        let short = [low, high].map(|end| Self(end).to_string());
        let told = short.each_ref().map(|text| text.parse().unwrap_or(f64::NAN));
        let error = ((told[1] - told[0]) - (high - low)).abs();
        let shows = |v: f64| if v.abs() < 1e17 { v.to_string() } else { format!("{v:e}") };
        if error > 0.01 * (high - low).abs() { [low, high].map(shows) } else { short }
    }
}

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Longer numbers are rounded: nobody compares them digit by digit.
        const READABLE: usize = 12;
        let v = self.0;
        if v == 0.0 || !v.is_finite() {
            // Without the sign of a zero.
            return f.pad(&if v == 0.0 { 0.0 } else { v }.to_string());
        }
        let plainly = |v: f64, largest: f64| {
            if (1e-3..largest).contains(&v.abs()) { v.to_string() } else { format!("{v:e}") }
        };
        // So far whole numbers are counts, labels, sums: all their digits mean something.
        const WHOLE: f64 = (1u64 << 53) as f64;
        let exact = plainly(v, WHOLE);
        if exact.len() <= READABLE || (v.fract() == 0.0 && v.abs() < WHOLE) {
            return f.pad(&exact);
        }
        let rounded = format!("{v:.5e}").parse().unwrap_or(v);
        f.pad(&plainly(rounded, 1e6))
    }
}

/// A text from outside as a terminal may show it: control characters, and those that turn the direction of writing,
/// become `?`.
pub fn printable(text: &str) -> Cow<'_, str> {
    if text.contains(is_hidden) { Cow::Owned(text.replace(is_hidden, "?")) } else { Cow::Borrowed(text) }
}

/// Whether a character steers a terminal instead of being shown.
fn is_hidden(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The name among those known that a misspelt one most likely means, if any is near enough.
pub fn nearest<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = |name: &str| name.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase();
    let found = letters(found);
    let length = found.chars().count();
    let far = |name: &str| {
        let name = letters(name);
        let typos = distance(&found, &name);
        // A part of a name means it, but less surely than a typing error.
        let part = length > 2 && (name.contains(&found) || (name.len() > 2 && found.contains(&name)));
        if typos <= (length / 3).max(1) && typos < length {
            Some(typos)
        } else {
            part.then(|| length + name.chars().count().abs_diff(length))
        }
    };
    known.into_iter().filter_map(|name| Some((far(name)?, name))).min_by_key(|(far, _)| *far).map(|(_, name)| name)
}

/// Letters to insert, leave out, replace or swap with their neighbour on the way from one word to the other (optimal
/// string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(rows[i - 2][j - 2] + 1);
            }
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_have_the_digits_that_tell_them() {
        for (v, said) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (5e-5, "5e-5"),
            (1.2e-4, "1.2e-4"),
            (0.001, "0.001"),
            (220e-6 / 3.0, "7.33333e-5"),
            (f64::from(3e-27f32), "3e-27"),
            (f64::from(0.1f32), "0.1"),
            (f64::from(f32::MAX), "3.40282e38"),
            (0.488_281_25, "0.48828125"),
            (100_000_001.5, "100000001.5"),
            (18_446_744_073.0, "18446744073"),
            (123_456_789_012_345.0, "123456789012345"),
            (12_345_678.123_456_7, "1.23457e7"),
            (999_999.999_999_9, "1e6"),
            (1e22, "1e22"),
            (-1e300, "-1e300"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Short(v).to_string(), said);
        }
        assert_eq!(format!("{:>6}|{:<6}|", Short(2.5), Short(1e9 / 7.0)), "   2.5|1.42857e8|");
    }

    #[test]
    fn terminals_are_not_steered() {
        assert_eq!(printable("\u{1b}[2J\u{1b}]0;pwned\u{7}evil\n"), "?[2J?]0;pwned?evil?");
        assert_eq!(printable("\u{9b}31m\u{202e}txt\u{7f}"), "?31m?txt?");
        assert!(matches!(printable("Blätter, 12 µm"), Cow::Borrowed("Blätter, 12 µm")));
    }

    #[test]
    fn misspelt_names_lead_to_what_is_meant() {
        let presets = ["ct-air", "ct-bone", "ct-skin", "mr-brain", "micro-ct", "simulation"];
        for (found, meant) in [
            ("ct-bonne", Some("ct-bone")),
            ("CT_Bone", Some("ct-bone")),
            ("ct-boen", Some("ct-bone")),
            ("bone", Some("ct-bone")),
            ("brain", Some("mr-brain")),
            ("simulations", Some("simulation")),
            ("x", None),
            ("", None),
            ("tartan", None),
        ] {
            assert_eq!(nearest(found, presets), meant, "{found}");
        }
        assert_eq!(nearest("x_ray", ["composite", "x-ray"]), Some("x-ray"));
    }

    proptest! {
        /// What is said is the number, to half a unit in its sixth digit.
        #[test]
        fn numbers_are_said_to_six_digits(v in proptest::num::f64::NORMAL | proptest::num::f64::ZERO) {
            let text = Short(v).to_string();
            prop_assert!(text.len() <= 16, "{text}");
            let said: f64 = text.parse().unwrap();
            prop_assert!((said - v).abs() <= v.abs() * 5.1e-6, "{v} {text}");
        }

        #[test]
        fn typing_errors_are_counted_both_ways(a in "[a-d]{0,6}", b in "[a-d]{0,6}") {
            prop_assert_eq!(distance(&a, &b), distance(&b, &a));
            prop_assert_eq!(distance(&a, &b) == 0, a == b);
        }
    }
}
