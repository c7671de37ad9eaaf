//! A text that is not a scene is answered with the key, what was found, what was expected, and
//! the line it stands on.

use pellucid_scene::{Format, Scene};

/// Parses `marked` without its one `@`, which stands on the line that the error must point at.
fn check(format: Format, marked: &str, fragments: &[&str]) {
    let line = marked[..marked.find('@').expect("one line is marked")].matches('\n').count() + 1;
    let text = marked.replacen('@', "", 1);
    let error = Scene::parse(&text, format).expect_err(&text);
    assert_eq!(error.line, Some(line), "line of {:?} in\n{text}", error.message);
    for fragment in fragments {
        assert!(error.message.contains(fragment), "{fragment:?} is not in {:?} of\n{text}", error.message);
    }
    assert!(error.to_string().starts_with(&format!("line {line}: ")));
}

#[test]
fn toml_errors_point_at_their_line() {
    let cases: &[(&str, &[&str])] = &[
        // Keys.
        ("\n\n@colour = 3\n", &["colour", "unknown field `colour`", "expected one of", "`camera`"]),
        ("title = 'a'\n[camera]\n@vew = 'orbit'\n", &["camera.vew: unknown field `vew`", "`view`"]),
        ("[camera.view.orbit]\nzoom = 2\n\n@azimut = 3\n", &["camera.view.orbit.azimut", "`azimuth`"]),
        ("title = 'x'\n[camera.view]\norbit = { zoom = 1, @elevatio = 3 }\n", &["camera.view.orbit.elevatio"]),
        ("[quality]\nstep = 1\n@\"a.b[0]\" = 1\n", &["unknown field `a.b[0]`"]),
        ("[[volumes]]\nsource = 'memory'\n[[volumes]]\n@sorce = 1\nsource = 'memory'\n", &["volumes[1].sorce"]),
        ("# none\n\n@[[volumes]]\npreset = 'ct-bone'\n", &["volumes[0]: missing field `source`"]),
        (
            "clips = [\n  { plane = { point = [0, 0, 0], normal = [1, 0, 0] } },\n  @{ box = { min = [0, 0, 0] } },\n]\n",
            &["clips[1].box: missing field `max`"],
        ),
        ("title = 'a'\nversion = 1\n@title = 'b'\n", &["duplicate key"]),
        // Types.
        ("\n@title = 3\n", &["title: invalid type: integer `3`, expected a string"]),
        ("[image]\nheight = 7\n@width = \"wide\"\n", &["image.width: invalid type: string \"wide\", expected u32"]),
        ("[image]\n@width = -1\n", &["image.width: invalid value: integer `-1`, expected u32"]),
        ("[image]\n@width = 1.5\n", &["image.width", "floating point `1.5`", "expected u32"]),
        ("[camera]\n\n@view = 3\n", &["camera.view: invalid type: integer `3`, expected string or map"]),
        (
            "[camera.view.orbit]\nazimuth = 1\ntarget = [\n 1,\n @'two',\n 3]\n",
            &["camera.view.orbit.target[1]", "\"two\""],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n@spacing = [1, 2]\n",
            &["volumes[0].spacing", "invalid length 2", "length 3"],
        ),
        ("[[volumes]]\nsource = 'memory'\n@spacing = [\n1, 2, 3, 4]\n", &["volumes[0].spacing", "invalid length 4"]),
        ("[[volumes]]\n@source = 1979-05-27\n", &["volumes[0].source: found a date"]),
        ("@clips = 'none'\n", &["clips: invalid type: string \"none\", expected a sequence"]),
        // Variants.
        (
            "[camera]\n\n@projection = 'wide'\n",
            &["camera.projection: unknown variant `wide`", "`perspective`", "`orthographic`"],
        ),
        ("[camera.projection]\n@perspectiv = 3\n", &["camera.projection.perspectiv: unknown variant `perspectiv`"]),
        (
            "[technique.ray_cast]\n@mode = 'composit'\n",
            &["technique.ray_cast.mode: unknown variant `composit`", "`composite`"],
        ),
        ("[camera.@view]\norbit = {}\nlook_at = {}\n", &["camera.view", "expected map with a single key"]),
        (
            "[[volumes]]\n[volumes.source.raw]\npath = 'a'\ndims = [1, 1, 1]\n@voxel_type = 'u7'\n",
            &["volumes[0].source.raw.voxel_type: unknown variant `u7`", "`u8`"],
        ),
        ("[quality]\nstep = 1\njitter.@blue_noise.seed = -2\n", &["quality.jitter.blue_noise.seed", "`-2`"]),
        (
            "[quality]\nfilter = { sinc = { window = 'lanczos', @half_width = 300 } }\n",
            &["quality.filter.sinc.half_width", "300"],
        ),
        // Ranges.
        ("title = ''\n@version = 2\n", &["version: found 2, expected 1"]),
        ("[quality]\n\n@step = 0\n", &["quality.step: found 0, expected 0.01 to 100"]),
        ("[quality]\n@early_termination = 1.5\n", &["quality.early_termination: found 1.5"]),
        ("[quality]\n@adaptive_tolerance = -0.1\n", &["quality.adaptive_tolerance: found -0.1", "0 to 1"]),
        ("[quality]\n@supersampling = 17\n", &["found 17, expected 1 to 16"]),
        (
            "[quality]\nstep = 1\n[quality.gradient.gaussian]\n\n@sigma = 9\n",
            &["quality.gradient.gaussian.sigma", "9", "0.25 to 3"],
        ),
        (
            "[quality.filter.sinc]\nwindow = 'hann'\n@half_width = 9\n",
            &["quality.filter.sinc.half_width", "9", "2 to 8"],
        ),
        ("[image]\n@width = 0\n", &["image.width: found 0, expected 1 to 32768"]),
        ("[image]\n@exposure = 0\n", &["image.exposure: found 0"]),
        (
            "[camera.view.orbit]\nroll = 3\n@elevation = 91\n",
            &["camera.view.orbit.elevation: found 91, expected degrees from -90 to 90"],
        ),
        ("[camera.view.orbit]\n@azimuth = nan\n", &["camera.view.orbit.azimuth", "not finite"]),
        ("[camera.view.orbit]\n@zoom = inf\n", &["camera.view.orbit.zoom", "not finite"]),
        ("[camera.view.orbit]\n@distance = 0\n", &["camera.view.orbit.distance: found 0"]),
        (
            "[camera.projection]\nperspective = {@vertical_fov = 180}\n",
            &["camera.projection.perspective.vertical_fov: found 180"],
        ),
        ("[camera.projection]\northographic = {@height = -3}\n", &["camera.projection.orthographic.height: found -3"]),
        (
            "[camera.view.look_at]\nposition = [1, 2, 3]\n@target = [1, 2, 3]\n",
            &["camera.view.look_at.target: found [1.0, 2.0, 3.0]"],
        ),
        ("[camera.view.look_at]\nposition = [1, 2, 3]\ntarget = [0, 0, 0]\n@up = [0, 0, 0]\n", &["up", "not zero"]),
        (
            "[[clips]]\nplane = { point = [0, 0, 0], normal = [1, 0, 0] }\n[[clips]]\n[clips.plane]\npoint = [0, 0, 0]\n@normal = [0, 0, 0]\n",
            &["clips[1].plane.normal: found [0.0, 0.0, 0.0]"],
        ),
        ("[[clips]]\n[clips.box]\nmin = [0, 0, 0]\n@max = [1, 0, 1]\n", &["clips[0].box.max", "more than min"]),
        (
            "[[volumes]]\nsource = 'memory'\n[[volumes]]\nsource = 'memory'\n@window = [3, 3]\n",
            &["volumes[1].window: found [3, 3]"],
        ),
        ("[[volumes]]\nsource = 'memory'\n@component = 4\n", &["volumes[0].component: found 4, expected 0 to 3"]),
        ("[[volumes]]\nsource = 'memory'\nspacing = [\n1,\n1,\n@0]\n", &["volumes[0].spacing[2]: found 0"]),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.crop]\nfrom = [0, 0, 0]\n@to = [1, 1, 0]\n",
            &["volumes[0].crop.to", "more than from"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n@preset = 'ct-bones'\n",
            &["volumes[0].preset", "\"ct-bones\" is unknown", "ct-bone,"],
        ),
        ("[[volumes]]\nsource = 'memory'\n@colormap = 'jetty'\n", &["volumes[0].colormap", "\"jetty\"", "viridis"]),
        (
            "[[volumes]]\nsource = 'memory'\n@opacity = 'sigmoid_99'\n",
            &["volumes[0].opacity", "\"sigmoid_99\"", "foreground"],
        ),
        ("[[volumes]]\nsource = 'memory'\n@unit_distance = 0\n", &["volumes[0].unit_distance: found 0"]),
        (
            "[[volumes]]\n[volumes.source.raw]\npath = 'a'\n@dims = [1, 0, 1]\nvoxel_type = 'u8'\n",
            &["source.raw.dims: found [1, 0, 1]"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.material]\ndiffuse = 0.5\n@shininess = 0\n",
            &["volumes[0].material.shininess", "1 to 1000"],
        ),
        ("[technique.half_angle]\n@taps = 17\n", &["technique.half_angle.taps: found 17, expected 1 to 16"]),
        (
            "[technique.half_angle]\ntaps = 3\n@blur_angle = 100\n",
            &["technique.half_angle.blur_angle: found 100, expected 0 to 90 degrees"],
        ),
        (
            "[technique.half_angle]\n@resolution = 8\n",
            &["technique.half_angle.resolution: found 8, expected 16 to 4096 texels"],
        ),
        ("[lighting.shadows.rays]\n@step = 0\n", &["lighting.shadows.rays.step", "0.01 to 100 voxel spacings"]),
        (
            "[lighting.shadows.volume]\n@resolution = 9\n",
            &["lighting.shadows.volume.resolution", "0.05 to 4 points for each voxel"],
        ),
        ("[technique.path_trace]\n@samples = 0\n", &["technique.path_trace.samples: found 0, expected 1 to 1048576"]),
        (
            "[technique.path_trace]\nsamples = 1\n@noise = 2\n",
            &["technique.path_trace.noise: found 2, expected 0 to 1"],
        ),
        (
            "[technique.path_trace]\n@aperture = -1\n",
            &["technique.path_trace.aperture: found -1, expected 0 or a length"],
        ),
        (
            "[technique.path_trace.environment.image]\nsource = 'day'\n@rotation = 1e9\n",
            &["technique.path_trace.environment.image.rotation", "degrees"],
        ),
        (
            "[technique.path_trace.environment.constant]\ncolor = '#ffffff'\n@intensity = -1\n",
            &["technique.path_trace.environment.constant.intensity", "-1", "0 or more"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.scattering.phase.henyey_greenstein]\n@g = 1\n",
            &["volumes[0].scattering.phase.henyey_greenstein.g", "1", "-0.99 to 0.99"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.scattering]\nphase = 'rayleigh'\n@anisotropy = 'cloud'\n",
            &["volumes[0].scattering.anisotropy", "rayleigh", "henyey_greenstein, schlick or hybrid"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.scattering.phase.@table]\nvalues = [[1, 1, 1]]\n",
            &["volumes[0].scattering.phase.table", "entries is 1: expected 2 to 65,536"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.scattering]\n@surface = { values = [[0, 0.5], [1, 2]] }\n",
            &["volumes[0].scattering.surface.values", "point 1", "2: expected 0 to 1"],
        ),
        (
            "[[volumes]]\n[volumes.source.model.clouds]\nseed = 1\n@ellipsoids = 257\n",
            &["volumes[0].source.model.clouds.ellipsoids", "found 257", "1 to 256"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.perturbation.displacement]\n@amplitude = 2\n",
            &["volumes[0].perturbation.displacement.amplitude", "2", "0 to 1"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.perturbation.displacement]\namplitude = 0.1\noctaves = [\n{ frequency = 1 },\n{ @frequency = 0 }]\n",
            &["volumes[0].perturbation.displacement.octaves[1].frequency", "0", "1/16 to 1024"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.perturbation.displacement]\n@between = [3, 3]\n",
            &["volumes[0].perturbation.displacement.between", "[3, 3]", "other than"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.perturbation.optics]\n@transport = 0.5\n",
            &["volumes[0].perturbation.optics.transport", "0.5", "scattering.transport"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.perturbation.optics]\n@opacity = -0.5\n",
            &["volumes[0].perturbation.optics.opacity", "-0.5", "0 to 1"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.gradient_weight]\nlow = 3\n@high = 2\n",
            &["volumes[0].gradient_weight.high", "[3, 2]"],
        ),
        ("[lighting]\n@ambient = -1\n", &["lighting.ambient: found -1, expected 0 or more"]),
        (
            "[lighting]\n[[lighting.lights]]\nintensity = 1\n[lighting.lights.kind.spot]\nposition = [0, 0, 0]\ndirection = [1, 0, 0]\ninner_angle = 20\n@outer_angle = 10\n",
            &["lighting.lights[0].kind.spot.outer_angle", "is 10", "180"],
        ),
        (
            "[[lighting.lights]]\n@intensity = -1\nkind = { directional = { direction = [1, 0, 0] } }\n",
            &["lighting.lights[0].intensity", "-1"],
        ),
        (
            "[[lighting.lights]]\n@radius = 120\nkind = { directional = { direction = [1, 0, 0] } }\n",
            &["lighting.lights[0].radius", "120", "0 to 90 degrees"],
        ),
        (
            "[[lighting.lights]]\nintensity = 1\n[lighting.lights.kind.rectangle]\ncenter = [0, 0, 0]\n@edges = [[1, 0, 0], [2, 0, 0]]\n",
            &["lighting.lights[0].kind.rectangle.edges", "not parallel"],
        ),
        (
            "[[lighting.lights]]\nintensity = 1\nkind = { directional = { @direction = [0, 0, 0] } }\n",
            &["kind.directional.direction"],
        ),
        (
            "[[lighting.lights]]\nkind = { point = { position = [0, 0, 0], falloff = { inverse_square = { @reference = 0 } } } }\n",
            &["falloff.inverse_square.reference"],
        ),
        (
            "[technique.ray_cast.mode.isosurface]\n@isovalues = []\n",
            &["technique.ray_cast.mode.isosurface.isovalues: found none"],
        ),
        (
            "[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 1\n[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 2\n@opacity = 1.5\n",
            &["technique.ray_cast.mode.isosurface.isovalues[1].opacity: found 1.5, expected 0 to 1"],
        ),
        (
            "[technique.slicing.mode.slice]\n@thickness = 0\n",
            &["technique.slicing.mode.slice.thickness: found 0", "a plane is for the ray caster"],
        ),
        ("[technique.slicing]\n@samples = 17\n", &["technique.slicing.samples: found 17, expected 1 to 16"]),
        ("[technique.ray_cast.mode.slice]\n@thickness = -1\n", &["technique.ray_cast.mode.slice.thickness: found -1"]),
        // Colours and transfer functions.
        ("[image.background]\n@color = '#ff80'\n", &["image.background.color", "#ff80", "#rrggbb"]),
        ("[image.background]\n@color = [0, 0, 1.5]\n", &["image.background.color", "1.5"]),
        (
            "[image.background.gradient]\ntop = '#000000'\n@bottom = 3\n",
            &["image.background.gradient.bottom", "integer `3`", "#rrggbb"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [[0, '#000000']]\nopacities = [\n  [0, 0],\n  [50, 0.5],\n  @[40, 1],\n]\n",
            &["volumes[0].transfer_function.opacities[2]", "value 40", "must ascend", "50"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [[0, '#000000']]\nopacities = [\n  [0, 0],\n  @[50, 80],\n  [60, 1],\n]\n",
            &["volumes[0].transfer_function.opacities[1]", "opacity is 80", "0 to 1"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [\n [0, '#000000'],\n [1, @'blakc']]\nopacities = [[0, 0]]\n",
            &["volumes[0].transfer_function.colors[1]", "blakc", "did you mean black?"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\n@colors = []\nopacities = [[0, 0]]\n",
            &["transfer_function.colors", "no points"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [[0, '#000000']]\nopacities = [\n@{ value = 0 }]\n",
            &["opacities[0]", "missing field `opacity`"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [[0, '#000000']]\nopacities = [\n[0, 0], [1, 1], @[1, 1, 2]]\n",
            &["opacities[2]", "length"],
        ),
        (
            "[[volumes]]\nsource = 'memory'\n[volumes.transfer_function]\ncolors = [[0, '#000000']]\nopacities = [[0, 0]]\n@unit_distance = 0\n",
            &["volumes[0].transfer_function.unit_distance", "is 0"],
        ),
        // Not TOML at all.
        ("title = 'a'\n@[camera\n", &[]),
        ("title = 'a'\n\n@title 3\n", &[]),
    ];
    for (marked, fragments) in cases {
        check(Format::Toml, marked, fragments);
    }
}

#[test]
fn json_errors_point_at_their_line() {
    let cases: &[(&str, &[&str])] = &[
        ("{\n\"title\": \"a\",\n@\"colour\": 3\n}", &["colour: unknown field `colour`", "`camera`"]),
        ("{\"title\": \"{ [ \\\" ] \\\\\",\n\"camera\": {\n@\"vew\":\n 3}}", &["camera.vew: unknown field `vew`"]),
        ("{\"camera\": {\"view\": {\"orbit\": {\n\"zoom\": 1,\n@\"azimut\": 3}}}}", &["camera.view.orbit.azimut"]),
        // Braces, quotes and keys within strings, and keys written with escapes.
        (
            "{\n\"title\": \"\\\"image\\\": {\\\"width\\\": 0}, }\\u007b\",\n\"image\": {\n@\"width\": 0}}",
            &["image.width: found 0"],
        ),
        (
            "{\"im\\u0061ge\": {\n\"height\": 3,\n@\"w\\u0069dth\":\n\n0}}",
            &["image.width: found 0, expected 1 to 32768"],
        ),
        (
            "{\"volumes\": [\n{\"source\": {\"file\": \"a}]\\\"\"}},\n{\"source\": \"memory\",\n@\"window\":\n[3,\n3]}]}",
            &["volumes[1].window: found [3, 3]"],
        ),
        (
            "{\"volumes\": [\n{\"source\": \"memory\"},\n@{\n\"preset\": \"ct-bone\"\n}]}",
            &["volumes[1]: missing field `source`"],
        ),
        (
            "{\"volumes\": [{\"source\": \"memory\",\n@\"spacing\": [1,\n2,\n3,\n4]}]}",
            &["volumes[0].spacing", "invalid length 4"],
        ),
        (
            "{\"volumes\": [{\"source\": \"memory\",\n\"spacing\": [1,\n@-2,\n3]}]}",
            &["volumes[0].spacing[1]: found -2"],
        ),
        ("{\"camera\":\n{\n@\"projection\": \"wide\"}}", &["camera.projection: unknown variant `wide`"]),
        ("{\"camera\": {\n@\"view\":\n{\n\"orbit\": {}, \"look_at\": {}}}}", &["camera.view", "single key"]),
        ("{\n@\"title\": 3}", &["title: invalid type: integer `3`, expected a string"]),
        ("{\n@\"title\": null}", &["title: invalid type: null, expected a string"]),
        (
            "{\"quality\": {\"filter\": {\"sinc\": {\"window\": \"hann\",\n@\"half_width\": 9}}}}",
            &["quality.filter.sinc.half_width"],
        ),
        (
            "{\"volumes\": [{\"source\": \"memory\", \"transfer_function\": {\n\"colors\": [[0, \"#000000\"]],\n\"opacities\": [[0, 0],\n[5, 0.5],\n@[4, 1]]\n}\n}\n]\n}",
            &["volumes[0].transfer_function.opacities[2]", "must ascend"],
        ),
        (
            "{\"volumes\": [{\"source\": \"memory\", \"transfer_function\": {\n\"colors\": [[0, \"#000000\"]],\n\"opacities\": [[0, 0],\n@{\"value\": 5,\n\"opacity\":\n 1.5},\n[6, 1]]\n}\n}\n]\n}",
            &["volumes[0].transfer_function.opacities[1]", "opacity is 1.5"],
        ),
        (
            "{\"technique\": {\"ray_cast\": {\"mode\": {\"isosurface\": {\"isovalues\": [\n{\"value\": 1},\n{\"value\": 2,\n@\"opacity\": -1}]}}}}}",
            &["technique.ray_cast.mode.isosurface.isovalues[1].opacity: found -1"],
        ),
        // A key twice, which would lose one of them.
        ("{\"title\": \"a\",\n\"version\": 1,\n@\"title\": \"b\"\n}", &["duplicate field `title`"]),
        ("{\"image\": {\n\"width\": 3,\n@\"width\": 4\n}\n}", &["duplicate field `width`"]),
        // Not JSON at all.
        ("{\n\"title\": \"a\"\n@\"version\": 1}", &["expected `,` or `}`"]),
        ("{\n\"title\": \"a\",\n@\"version\": 1e999}", &["number out of range"]),
        ("{}\n\n@{}", &["trailing characters"]),
        ("@", &["EOF"]),
    ];
    for (marked, fragments) in cases {
        check(Format::Json, marked, fragments);
    }
}

#[test]
fn a_scene_that_no_format_can_hold_is_an_error() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let path = std::path::PathBuf::from(OsStr::from_bytes(b"\xff.nrrd"));
    let mut nan = Scene::default();
    nan.quality.step = f64::NAN;
    for scene in [Scene::of(pellucid_scene::Source::File(path)), nan] {
        for format in [Format::Toml, Format::Json] {
            assert!(scene.to_text(format).is_err());
        }
    }
}
