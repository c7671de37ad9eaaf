//! Finds the line on which a path of a document stands, for errors found after parsing.

use crate::document::line_of;

/// Steps of `volumes[0].source.raw`: keys and positions.
fn steps(path: &str) -> impl Iterator<Item = &str> {
    path.split(['.', '[']).map(|step| step.trim_end_matches(']')).filter(|step| !step.is_empty())
}

/// The line in a TOML text of the deepest part of `path` that is written there.
pub(crate) fn toml_line(text: &str, path: &str) -> Option<usize> {
    let table = toml::de::DeTable::parse(text).ok()?;
    let mut here = table.span().start;
    let mut found = false;
    let mut value: Option<&toml::Spanned<toml::de::DeValue<'_>>> = None;
    for step in steps(path) {
        let next = match value.map(|v| v.get_ref()) {
            None => table.get_ref().get(step),
            Some(toml::de::DeValue::Table(table)) => table.get(step),
            Some(toml::de::DeValue::Array(items)) => step.parse().ok().and_then(|k: usize| items.get(k)),
            Some(_) => None,
        };
        let Some(next) = next else { break };
        here = next.span().start;
        found = true;
        value = Some(next);
    }
    found.then(|| line_of(text, here))
}

/// The line in a JSON text of the deepest part of `path` that is written there. The text is known
/// to be valid JSON.
pub(crate) fn json_line(text: &str, path: &str) -> Option<usize> {
    let mut cursor = Json { text: text.as_bytes(), at: 0 };
    let mut found = None;
    for step in steps(path) {
        if !cursor.enter(step) {
            break;
        }
        cursor.space();
        found = Some(line_of(text, cursor.at));
    }
    found
}

/// A position in valid JSON.
struct Json<'t> {
    text: &'t [u8],
    at: usize,
}

impl Json<'_> {
    fn peek(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(0)
    }

    fn space(&mut self) {
        while matches!(self.peek(), b' ' | b'\n' | b'\r' | b'\t' | b',' | b':') {
            self.at += 1;
        }
    }

    /// Moves from a container to the value of a key or position in it.
    fn enter(&mut self, step: &str) -> bool {
        self.space();
        let object = match self.peek() {
            b'{' => true,
            b'[' => false,
            _ => return false,
        };
        self.at += 1;
        for position in 0.. {
            self.space();
            if matches!(self.peek(), b'}' | b']' | 0) {
                return false;
            }
            if object {
                let from = self.at;
                self.skip();
                let key = &self.text[from + 1..self.at - 1];
                if key == step.as_bytes() {
                    return true;
                }
            } else if step.parse() == Ok(position) {
                return true;
            }
            self.space();
            self.skip();
        }
        false
    }

    /// Skips one value (or key).
    fn skip(&mut self) {
        let mut depth = 0usize;
        loop {
            match self.peek() {
                b'"' => {
                    self.at += 1;
                    while !matches!(self.peek(), b'"' | 0) {
                        self.at += if self.peek() == b'\\' { 2 } else { 1 };
                    }
                    self.at += 1;
                }
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.saturating_sub(1);
                    self.at += 1;
                }
                0 => return,
                _ if depth > 0 => {
                    self.at += 1;
                    continue;
                }
                _ => {
                    while !matches!(self.peek(), b',' | b'}' | b']' | b' ' | b'\n' | b'\r' | b'\t' | b':' | 0) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return;
            }
        }
    }
}
