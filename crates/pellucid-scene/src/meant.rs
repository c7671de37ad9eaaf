//! What people mean by words that no setting has.

use pellucid_field::nearest;

/// Words of other programs and of papers, and ours.
const SYNONYMS: [(&str, &str); 31] = [
    ("mip", "maximum"),
    ("max", "maximum"),
    ("minip", "minimum"),
    ("min", "minimum"),
    ("mean", "average"),
    ("avg", "average"),
    ("aip", "average"),
    ("dvr", "composite"),
    ("vr", "composite"),
    ("volume", "composite"),
    ("alpha", "composite"),
    ("sum", "additive"),
    ("emission", "additive"),
    ("radiograph", "x-ray"),
    ("drr", "x-ray"),
    ("absorption", "x-ray"),
    ("iso", "isosurface"),
    ("surface", "isosurface"),
    ("mpr", "slice"),
    ("plane", "slice"),
    ("rays", "ray-cast"),
    ("raymarch", "ray-cast"),
    ("slices", "view-aligned"),
    ("slicing", "view-aligned"),
    ("texture", "view-aligned"),
    ("paths", "path-trace"),
    ("cubic", "catmull-rom"),
    ("tricubic", "catmull-rom"),
    ("spline", "b-spline"),
    ("sinc", "lanczos"),
    ("transverse", "axial"),
];

/// The one of the known words that an unknown one most likely stands for: by another name, or misspelt.
pub fn meant<'a>(found: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> Option<&'a str> {
    let letters = |word: &str| word.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase();
    let plain = letters(found);
    let ours = SYNONYMS.iter().filter(|(theirs, _)| *theirs == plain).map(|(_, ours)| letters(ours));
    let of_synonym = ours.into_iter().find_map(|ours| known.clone().into_iter().find(|word| letters(word) == ours));
    of_synonym.or_else(|| nearest(found, known))
}

/// A message about a word that is not known, as serde phrases it, with what was meant.
pub fn pointed(message: &str) -> String {
    let word = |text: &str| text.split('`').nth(1).map(str::to_owned);
    let Some((head, list)) = message.split_once(", expected ") else { return message.to_owned() };
    if !head.starts_with("unknown ") {
        return message.to_owned();
    }
    let known: Vec<&str> = list.split('`').skip(1).step_by(2).collect();
    let meant = word(head).and_then(|found| meant(&found, known.iter().copied()));
    meant.map_or_else(|| message.to_owned(), |meant| format!("{head} (did you mean `{meant}`?), expected {list}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_others_lead_to_ours() {
        let modes = ["composite", "maximum", "minimum", "average", "additive", "x_ray", "isosurface", "slice"];
        for (found, ours) in [
            ("mip", "maximum"),
            ("MinIP", "minimum"),
            ("xray", "x_ray"),
            ("DRR", "x_ray"),
            ("iso", "isosurface"),
            ("isosurfaces", "isosurface"),
            ("MPR", "slice"),
            ("compsite", "composite"),
        ] {
            assert_eq!(meant(found, modes), Some(ours), "{found}");
        }
        assert_eq!(meant("wobble", modes), None);
    }

    #[test]
    fn messages_of_serde_are_pointed() {
        assert_eq!(
            pointed("unknown variant `mip`, expected one of `composite`, `maximum`"),
            "unknown variant `mip` (did you mean `maximum`?), expected one of `composite`, `maximum`"
        );
        assert_eq!(
            pointed("unknown field `stepp`, expected `step` or `filter`"),
            "unknown field `stepp` (did you mean `step`?), expected `step` or `filter`"
        );
        let other = "invalid type: string \"a\", expected f64";
        assert_eq!(pointed(other), other);
    }
}
