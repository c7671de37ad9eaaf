//! Texts of the schema without the numbers by which comments point to the literature.

use serde_json::Value;

/// Takes citations in brackets, as `(9.1-4)` or `(chapter 7)`, out of all descriptions: the scene guide names the
/// books once.
pub fn leave_out(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::String(text)) = object.get_mut("description") {
                *text = without(text);
            }
            object.values_mut().for_each(leave_out);
        }
        Value::Array(items) => items.iter_mut().for_each(leave_out),
        _ => {}
    }
}

fn without(text: &str) -> String {
    let mut parts = text.split('(');
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(')') {
            Some((inside, after)) if is_citation(inside) => {
                // With the space, or the line break, before it.
                kept.truncate(kept.trim_end().len());
                kept.push_str(after);
            }
            _ => kept.extend(["(", part]),
        }
    }
    kept
}

/// `9.1-4`, `4.5, 4.6`, `6.3-7 b, Eq. 6.8`, `K-06b`, `MOD-11`, `chapter 7`, `section 6.3`, `Kniss et al. 2003`.
fn is_citation(text: &str) -> bool {
    let numbered = |text: &str| {
        let mut parts = text.split('.');
        let digits = |part: Option<&str>| part.is_some_and(|part| part.starts_with(|c: char| c.is_ascii_digit()));
        digits(parts.next()) && digits(parts.next())
    };
    let named = ["K-", "MOD-", "Eq. ", "chapter ", "section ", "Kniss "];
    let first = text.split(',').next().unwrap_or_default();
    named.iter().any(|name| first.starts_with(name)) || (numbered(first) && !first.contains("degrees"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn citations_go_and_other_brackets_stay() {
        for (text, plain) in [
            ("At a value (9.1-4).", "At a value."),
            ("Both (6.3-7 b, Eq. 6.8). Means", "Both. Means"),
            ("depth\n(K-22, MOD-11)", "depth"),
            ("slices (chapter 3), or (section 6.3)", "slices, or"),
            ("x (fastest), y (0 to 100), (not 0 to 255)", "x (fastest), y (0 to 100), (not 0 to 255)"),
            ("the edge (the sun's is 0.27): (x, y)", "the edge (the sun's is 0.27): (x, y)"),
            ("an open ( bracket", "an open ( bracket"),
        ] {
            assert_eq!(without(text), plain);
        }
    }
}
