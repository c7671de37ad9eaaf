//! Modules that the linker writes for as many layers as there are: functions that ask one of them by its number, or all.

/// How many layers there are.
pub fn count(layers: usize) -> String {
    format!("#define_import_path pellucid::count\nconst COUNT: u32 = {layers}u;\n")
}

/// What asks one of so many layers for what lies on rays, by its number.
pub fn each(layers: usize) -> String {
    let functions = [
        ("way_of", "at: vec2<f32>", "Way"),
        ("clear", "way: Way, distance: f32", "f32"),
        ("element", "way: Way, ends: vec2<f32>, jitter: f32, front: f32", "vec4<f32>"),
        ("normal", "way: Way, distance: f32", "vec3<f32>"),
    ];
    "#define_import_path pellucid::each\n#import pellucid::way::Way\n".to_owned()
        + &choices(layers, "layer", &functions)
}

/// What asks one of so many layers for its surfaces, by its number.
pub fn each_hit(layers: usize) -> String {
    let functions = [
        ("first_hit", "pixel: vec2<u32>, sub: u32, reach: vec2<f32>", "Cursor"),
        ("next_hit", "pixel: vec2<u32>, sub: u32, last: Cursor", "Cursor"),
        ("hit", "pixel: vec2<u32>, sub: u32, cursor: Cursor, front: f32", "Hit"),
    ];
    "#define_import_path pellucid::each_hit\n#import pellucid::cursor::{Cursor, Hit}\n".to_owned()
        + &choices(layers, "hits", &functions)
}

/// What asks one of so many layers what becomes of paths, by its number; of no layers, the volume that has none.
pub fn each_path(layers: usize) -> String {
    let at_vertices = [
        ("vertex_of", "p: vec3<f32>, value: f32, color: vec3<f32>, forward: vec3<f32>", "Vertex"),
        ("vertex_value", "vertex: Vertex, direction: vec3<f32>", "vec3<f32>"),
        ("vertex_density", "vertex: Vertex, direction: vec3<f32>", "f32"),
        ("vertex_sample", "vertex: Vertex", "vec3<f32>"),
        ("vertex_light", "vertex: Vertex, to_light: vec3<f32>, radiance: vec3<f32>, has_highlight: bool", "vec3<f32>"),
        ("emission", "", "f32"),
    ];
    let at_places = [
        ("in_first", "p: vec3<f32>", "vec3<f32>"),
        ("in_front", "p: vec3<f32>, normal: vec3<f32>, extinction: f32", "vec3<f32>"),
    ];
    let load = |k: usize| format!("    paths_of{k}::load_paths({k}u);\n");
    let load: String = (0..layers.max(1)).map(load).collect();
    "#define_import_path pellucid::each_path\n#import pellucid::flight::Vertex\n".to_owned()
        + &choices(layers, "paths", &at_places)
        + &choices(layers, "vertex", &at_vertices)
        + &format!("fn load() {{\n{load}}}\n")
}

/// What all of so many layers make of ways of paths: each its part, or one after the other more of what there was.
pub fn every(layers: usize) -> String {
    let gathered = [
        ("parts_ahead", "aim: Aim", "part_ahead(aim)"),
        ("parts_from", "first: vec3<f32>, forward: vec3<f32>", "part_from(first, forward)"),
    ];
    // The number of a layer stands where `#` is.
    let folded = [
        ("nearest", "parts: array<Part, COUNT>", "Encounter", "nearer(all, #u, parts[#])"),
        (
            "transmittance_through",
            "first: vec3<f32>, forward: vec3<f32>, most: f32",
            "vec4<f32>",
            "lessened(all, first, forward, most)",
        ),
        ("thickness", "parts: array<Part, COUNT>, ends: vec2<f32>", "f32", "thicker(all, parts[#], ends)"),
        ("densest_of", "parts: array<Part, COUNT>, distance: f32", "vec4<f32>", "denser(all, parts[#], distance)"),
    ];
    let of = |call: &str, module: &str, k: usize| format!("{module}_of{k}::{}", call.replace('#', &k.to_string()));
    let gather = |(name, parameters, call): (&str, &str, &str)| {
        let each: Vec<_> = (0..layers).map(|k| of(call, "paths", k)).collect();
        let made = format!("array<Part, COUNT>({})", each.join(", "));
        format!("fn {name}({parameters}) -> array<Part, COUNT> {{\n    return {made};\n}}\n")
    };
    let fold = |(name, parameters, gives, call): (&str, &str, &str, &str)| {
        let turns: String = (0..layers).map(|k| format!("    all = {};\n", of(call, "part", k))).collect();
        let body = format!("    var all = before;\n{turns}    return all;\n");
        format!("fn {name}(before: {gives}, {parameters}) -> {gives} {{\n{body}}}\n")
    };
    let import = |k: usize| {
        format!("#import pellucid::of{k}::part as part_of{k}\n#import pellucid::of{k}::paths as paths_of{k}\n")
    };
    let imports: String = (0..layers).map(import).collect();
    let functions: String = gathered.map(gather).into_iter().chain(folded.map(fold)).collect();
    format!(
        "#define_import_path pellucid::every\n#import pellucid::count::COUNT\n\
         #import pellucid::flight::{{Aim, Encounter, Part}}\n{imports}{functions}"
    )
}

/// Functions, by names, parameters and types, that call those of a module of one of so many layers, by its number; of no
/// layers, those of the volume that has none.
fn choices(layers: usize, module: &str, functions: &[(&str, &str, &str)]) -> String {
    let layer = |k: usize| if layers == 0 { String::new() } else { format!("of{k}::") };
    let import = |k: usize| format!("#import pellucid::{}{module} as {module}_of{k}\n", layer(k));
    let function = |(name, parameters, gives): &(&str, &str, &str)| {
        let passed: Vec<_> = parameters.split(", ").filter_map(|one| one.split(':').next()).collect();
        let call = |k: usize| format!("return {module}_of{k}::{name}({});", passed.join(", "));
        let cases: String = (1..layers).map(|k| format!("        case {k}u: {{ {} }}\n", call(k))).collect();
        let choice = match layers {
            0 => call(0),
            _ => format!("switch layer {{\n{cases}        default: {{ {} }}\n    }}", call(0)),
        };
        format!("fn {name}(layer: u32, {parameters}) -> {gives} {{\n    {choice}\n}}\n")
    };
    (0..layers.max(1)).map(import).chain(functions.iter().map(function)).collect()
}

/// What tells of the eye's rays in all of so many layers.
pub fn every_line(layers: usize) -> String {
    let functions = [
        ("layer", "way_of", "all_ways", "at: vec2<f32>", "Way"),
        ("eye", "line_along", "all_lines", "each way: Way, each length: f32, jitter: f32", "Line"),
        ("eye", "clear_slabs", "all_clear", "each line: Line, slab: f32", "f32"),
    ];
    let imports = "#import pellucid::passage::Line\n#import pellucid::way::Way\n";
    format!("#define_import_path pellucid::every_line\n{imports}{}", all(layers, &functions))
}

/// What tells of rays of light, and of what lies in slabs, in all of so many layers.
pub fn every_slab(layers: usize) -> String {
    let functions = [
        ("sweep", "light_ray", "all_rays", "texel: vec2<u32>", "Crossing"),
        ("slab", "matter_of", "all_matter", "each passage: Passage", "Matter"),
        ("slab", "held_by", "all_held", "each passage: Passage, each matter: Matter", "Shares"),
    ];
    let imports = "#import pellucid::passage::{Crossing, Matter, Passage, Shares}\n";
    format!("#define_import_path pellucid::every_slab\n{imports}{}", all(layers, &functions))
}

/// What tells of the light that all of so many layers send to the eye from a slab.
pub fn every_slab_light(layers: usize) -> String {
    let sample = "each way: Way, each passage: Passage, each matter: Matter";
    let seen = format!("{sample}, each lost: vec4<f32>, each left: Shares");
    let functions = [
        ("slab_light", "texel_of", "all_texels", "each passage: Passage", "vec2<f32>"),
        ("slab_light", "steps_inside", "all_steps_inside", "each passage: Passage, slab: f32", "f32"),
        ("slab_light", "passing", "all_passing", "each passage: Passage, each matter: Matter, steps: f32", "Shares"),
        ("slab_light", "seen", "all_seen", &seen, "vec4<f32>"),
    ];
    let imports = "#import pellucid::passage::{Matter, Passage, Shares}\n#import pellucid::way::Way\n";
    format!("#define_import_path pellucid::every_slab_light\n{imports}{}", all(layers, &functions))
}

/// Functions that call those of modules of all of so many layers: by modules, names there, names, parameters and types.
/// A parameter that is `each` layer's is a list, and so is what they give.
fn all(layers: usize, functions: &[(&str, &str, &str, &str, &str)]) -> String {
    let mut modules: Vec<&str> = functions.iter().map(|(module, ..)| *module).collect();
    modules.dedup();
    let import = |(module, k): (&str, usize)| format!("#import pellucid::of{k}::{module} as {module}_of{k}\n");
    let imports: String =
        modules.into_iter().flat_map(|module| (0..layers).map(move |k| (module, k))).map(import).collect();
    let function = |(module, of_layer, name, parameters, gives): &(&str, &str, &str, &str, &str)| {
        let parameters: Vec<_> = parameters.split(", ").filter_map(|one| one.split_once(": ")).collect();
        let taken = |(parameter, ty): &(&str, &str)| match parameter.strip_prefix("each ") {
            Some(own) => format!("{own}: array<{ty}, COUNT>"),
            None => format!("{parameter}: {ty}"),
        };
        let passed = |parameter: &str, k: usize| match parameter.strip_prefix("each ") {
            Some(own) => format!("{own}[{k}]"),
            None => parameter.to_owned(),
        };
        let call = |k: usize| {
            let passed: Vec<_> = parameters.iter().map(|(parameter, _)| passed(parameter, k)).collect();
            format!("{module}_of{k}::{of_layer}({})", passed.join(", "))
        };
        let taken = parameters.iter().map(taken).collect::<Vec<_>>().join(", ");
        let calls = (0..layers).map(call).collect::<Vec<_>>().join(", ");
        format!("fn {name}({taken}) -> array<{gives}, COUNT> {{\n    return array<{gives}, COUNT>({calls});\n}}\n")
    };
    format!("#import pellucid::count::COUNT\n{imports}{}", functions.iter().map(function).collect::<String>())
}

/// What loads the constants of passes through slabs; `roots` are the modules' own of all layers.
pub fn constants(roots: &[String]) -> String {
    let import = |(k, root): (usize, &String)| format!("#import {root}::sweep as sweep_of{k}\n");
    let imports: String = roots.iter().enumerate().map(import).collect();
    let loads: String = (0..roots.len()).map(|k| format!("    sweep_of{k}::load_sweep();\n")).collect();
    format!(
        "#define_import_path pellucid::constants\n#import {}::frame as frame_of0\n{imports}\
         fn load_constants() {{\n    frame_of0::load_bounds();\n{loads}}}\n",
        roots[0]
    )
}

/// What so many layers leave of a light on its way to a position of the world.
pub fn across(layers: usize) -> String {
    let imports = |k: usize| {
        format!("#import pellucid::of{k}::shadow as shadow_of{k}\n#import pellucid::of{k}::frame as frame_of{k}\n")
    };
    let factor =
        |k: usize| format!("    left *= shadow_of{k}::transmittance_to(place, frame_of{k}::index_of(world));\n");
    let (imports, factors): (String, String) = ((0..layers).map(imports).collect(), (0..layers).map(factor).collect());
    format!(
        "#define_import_path pellucid::across\n{imports}fn transmittance_across(place: vec4<f32>, world: vec3<f32>) -> f32 {{\n    \
         var left = 1.0;\n{factors}    return left;\n}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_over_all_layers_ask_each_for_its_own() {
        let text = "#import pellucid::count::COUNT\n\
                    #import pellucid::of0::eye as eye_of0\n#import pellucid::of1::eye as eye_of1\n\
                    fn all_clear(line: array<Line, COUNT>, slab: f32) -> array<f32, COUNT> {\n    \
                    return array<f32, COUNT>(eye_of0::clear(line[0], slab), eye_of1::clear(line[1], slab));\n}\n";
        assert_eq!(all(2, &[("eye", "clear", "all_clear", "each line: Line, slab: f32", "f32")]), text);
    }
}
