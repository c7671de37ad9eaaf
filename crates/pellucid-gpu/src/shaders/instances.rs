//! Files of which each of several layers has its own: the same text, with names, flags and bindings of the layer.

use std::borrow::Cow;

/// Modules that all layers share; of every other one each layer has its own, as `pellucid::of0::field`.
const SHARED: &[&str] = &[
    "lists",
    "way",
    "cursor",
    "passage",
    "across",
    "points",
    "count",
    "each",
    "each_hit",
    "every_line",
    "every_slab",
    "every_slab_light",
    "merge",
    "ways",
    "slice_nodes",
    "ahead",
    "constants",
    "slabs",
    "slab_pieces",
    "line",
    "look",
    "random",
    "flight",
    "each_path",
    "every",
    "surroundings",
    "sight",
];

/// Flags that say the same of all layers.
const COMMON: [&str; 5] = ["LAYERED", "APART", "STORED_CONSTANTS", "LOADED_CONSTANTS", "WAVEFRONT"];

/// Numbers of bindings that a layer has for itself, in every group.
pub const BINDINGS: u32 = 32;

/// Whether layers share a module.
pub fn is_shared(module: &str) -> bool {
    SHARED.contains(&module)
}

/// Whether a flag says the same of all layers.
pub fn is_common(flag: &str) -> bool {
    COMMON.contains(&flag)
}

/// What a flag of a layer is called.
pub fn flag_of(flag: &str, layer: usize) -> String {
    if is_common(flag) { flag.to_owned() } else { format!("{flag}_OF_{layer}") }
}

/// The text of a module of a layer.
pub fn text_of(text: &str, layer: usize) -> String {
    text.lines().map(|line| line_of(line, layer) + "\n").collect()
}

fn line_of(line: &str, layer: usize) -> String {
    let mut line = Cow::Borrowed(line);
    let words: Vec<&str> = line.split_whitespace().collect();
    if let [.., "#ifdef" | "#ifndef" | "ifdef" | "ifndef", flag] = words[..] {
        let own = flag_of(flag, layer);
        line = Cow::Owned(line.replace(flag, &own));
    }
    bound(&moved(&line, layer), layer)
}

/// A line whose modules are those of a layer.
fn moved(line: &str, layer: usize) -> String {
    const ROOT: &str = "pellucid::";
    let mut parts = line.split(ROOT);
    let mut moved = parts.next().unwrap_or_default().to_owned();
    for rest in parts {
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        moved += ROOT;
        if !is_shared(&rest[..end]) {
            moved += &format!("of{layer}::");
        }
        moved += rest;
    }
    moved
}

/// A line whose bindings are those of a layer.
fn bound(line: &str, layer: usize) -> String {
    let Some((before, rest)) = line.split_once("@binding(") else { return line.to_owned() };
    let Some((number, after)) = rest.split_once(')') else { return line.to_owned() };
    let number = number.parse::<u32>().unwrap_or_default() + layer as u32 * BINDINGS;
    format!("{before}@binding({number}){after}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_flags_and_bindings_are_those_of_a_layer() {
        let text = "#define_import_path pellucid::field\n#import pellucid::frame::{frame, bounds}\n\
                    #import pellucid::way::Way\n#ifdef HOLES\n#else ifndef LAYERED\n#endif\n\
                    @group(1) @binding(2) var x: f32;\n";
        let own = "#define_import_path pellucid::of1::field\n#import pellucid::of1::frame::{frame, bounds}\n\
                   #import pellucid::way::Way\n#ifdef HOLES_OF_1\n#else ifndef LAYERED\n#endif\n\
                   @group(1) @binding(34) var x: f32;\n";
        assert_eq!(text_of(text, 1), own);
    }
}
