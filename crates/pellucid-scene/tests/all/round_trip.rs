//! Scenes survive both text formats exactly.

use pellucid_field::{Filter, Gradient, SincWindow, VoxelType};
use pellucid_optics::Frame;
use pellucid_optics::*;
use pellucid_scene::*;
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use proptest::sample::select;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, -1e-6..1e-6, -1e18..1e18, Just(0.0), Just(1.0), Just(-1e-300)]
}

fn position() -> impl Strategy<Value = [f64; 3]> {
    [number(), number(), number()]
}

fn heading() -> impl Strategy<Value = [f64; 3]> {
    (position(), 0usize..3).prop_map(|(mut v, axis)| {
        v[axis] += if v[axis] < 0.0 { -1.0 } else { 1.0 };
        v
    })
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![1e-9..1e-3, 1e-3..1e6]
}

fn text() -> impl Strategy<Value = String> {
    let pieces =
        select(vec!["a", "\"", "\\", "\n", "'''", "\r", "\t", "\u{0}", "é𝄞", "#", "[", "{}", " ", "\u{7f}", "="]);
    vec(pieces, 0..8).prop_map(|pieces| pieces.concat())
}

fn color() -> impl Strategy<Value = Color> {
    prop_oneof![
        any::<u32>().prop_map(Color::hex),
        [0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0].prop_map(|c| Color::new(c).unwrap())
    ]
}

fn interpolation() -> impl Strategy<Value = Interpolation> {
    select(vec![Interpolation::Linear, Interpolation::Step, Interpolation::Smooth])
}

fn transfer_function() -> impl Strategy<Value = TransferFunction> {
    let ascending = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let colors =
        (vec(-1e4..1e4, 1..6).prop_map(ascending), vec((color(), interpolation()), 6)).prop_map(|(values, rest)| {
            let point = |(value, (color, interpolation))| ColorPoint { value, color, interpolation };
            values.into_iter().zip(rest).map(point).collect::<Vec<_>>()
        });
    let opacities = (vec(-1e4..1e4, 1..6).prop_map(ascending), vec((0.0f32..=1.0, interpolation()), 6)).prop_map(
        |(values, rest)| {
            let point = |(value, (opacity, interpolation))| OpacityPoint { value, opacity, interpolation };
            values.into_iter().zip(rest).map(point).collect::<Vec<_>>()
        },
    );
    (colors, opacities, select(vec![ColorSpace::Srgb, ColorSpace::Linear]), of(length())).prop_map(
        |(colors, opacities, space, unit)| {
            TransferFunction::new(colors, opacities).unwrap().with_color_space(space).with_unit_distance(unit).unwrap()
        },
    )
}

fn source() -> impl Strategy<Value = Source> {
    let dims = [1usize..=65_536, 1usize..=9, 1usize..=9];
    let voxel_type = select(VoxelType::ALL.to_vec());
    prop_oneof![
        Just(Source::memory()),
        text().prop_map(|path| Source::File(path.into())),
        (text(), dims.clone(), voxel_type.clone(), 1usize..=4, 0..=i64::MAX as u64, any::<bool>()).prop_map(
            |(path, dims, voxel_type, components, skip, big_endian)| Source::Raw {
                path: path.into(),
                dims,
                voxel_type,
                components,
                skip,
                big_endian
            }
        ),
        (any::<u32>(), 1usize..=256, dims.clone()).prop_map(|(seed, ellipsoids, dims)| {
            Source::Model(ModelSource::Clouds(CloudsSource { seed, ellipsoids, dims }))
        }),
        ([-9.0..9.0, -9.0..9.0, -9.0..9.0], dims.clone()).prop_map(|(phases, dims)| {
            Source::Model(ModelSource::Spectral(SpectralSource { phases: [phases; 5], dims }))
        }),
        (text(), any::<u32>(), any::<bool>(), dims.clone()).prop_map(|(path, seed, is_file, dims)| {
            let map = if is_file { HeightSource::File(path.into()) } else { HeightSource::Terrain(seed) };
            let shape =
                HeightFieldSource { relief: 0.5, slab: [-0.1, 0.2], ramp: 0.01, ..HeightFieldSource::default() };
            Source::Model(ModelSource::HeightField(HeightFieldSource { map, dims, ..shape }))
        }),
        (text(), of(dims), of(voxel_type)).prop_map(|(name, dims, voxel_type)| Source::Sample(SampleSource {
            name,
            dims,
            voxel_type
        })),
    ]
}

fn material() -> impl Strategy<Value = Material> {
    (0.0f32..9.0, 0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0, 1.0f32..=1000.0, any::<bool>()).prop_map(
        |(emission, ambient, diffuse, specular, shininess, two_sided)| Material {
            emission,
            ambient,
            diffuse,
            specular,
            shininess,
            two_sided,
        },
    )
}

fn scattering() -> impl Strategy<Value = Scattering> {
    const G: std::ops::RangeInclusive<f32> = -0.99..=0.99;
    let entries = || vec([1e-3f32..9.0, 1e-3f32..9.0, 1e-3f32..9.0], 2..5);
    let angles = || select(vec![TableAngles::Theta, TableAngles::Cosine]);
    // Those first whose anisotropy can vary.
    let phase =
        (0usize..8, [G, G], 0.0f32..=1.0, angles(), entries()).prop_map(|(k, [first, second], share, at, v)| match k {
            0 => Phase::HenyeyGreenstein { g: first },
            1 => Phase::Schlick { g: first },
            2 => Phase::Hybrid { g: first, back: BackLobe::new(at, v).unwrap() },
            3 => Phase::DoubleHenyeyGreenstein { first, second, share },
            4 => Phase::Table(PhaseTable::new(at, v).unwrap()),
            5 => Phase::Rayleigh,
            6 => Phase::Table(PhaseTable::of_file(at, "mie.csv").unwrap()),
            _ => Phase::Isotropic,
        });
    let numbers = |range: std::ops::RangeInclusive<f32>| {
        vec((range, interpolation()), 1..4).prop_map(|points| {
            let point = |(k, (number, interpolation))| NumberPoint { value: k as f64, number, interpolation };
            points.into_iter().enumerate().map(point).collect::<Vec<_>>()
        })
    };
    let colors = || {
        vec((color(), interpolation()), 1..4).prop_map(|points| {
            let point = |(k, (color, interpolation))| ColorPoint { value: k as f64, color, interpolation };
            points.into_iter().enumerate().map(point).collect::<Vec<_>>()
        })
    };
    let anisotropy =
        prop_oneof![Just(Anisotropy::Uniform), Just(Anisotropy::Cloud), numbers(G).prop_map(Anisotropy::Values),];
    let albedo =
        prop_oneof![Just(Albedo::Color), (0.0f32..=1.0).prop_map(Albedo::Constant), colors().prop_map(Albedo::Colors),];
    let surface = prop_oneof![
        Just(SurfaceShare::None),
        numbers(0.0..=1.0).prop_map(SurfaceShare::Values),
        (0.0f32..10.0, 0.5f32..10.0)
            .prop_map(|(low, more)| SurfaceShare::Gradient(GradientWeight { low, high: low + more })),
    ];
    let normalization = select(vec![PhaseNormalization::Physical, PhaseNormalization::Renormalised]);
    (phase, normalization, anisotropy, albedo, of(colors()), of(color()), surface).prop_map(
        |(phase, phase_normalization, anisotropy, albedo, transport, extinction_color, surface)| {
            let anisotropy = if phase.anisotropy().is_some() { anisotropy } else { Anisotropy::Uniform };
            Scattering { phase, phase_normalization, anisotropy, albedo, transport, extinction_color, surface }
        },
    )
}

fn perturbation() -> impl Strategy<Value = Perturbation> {
    let octave = (0.0625f32..=1024.0, -16.0f32..=16.0, [-9.0..9.0, -9.0..9.0, -9.0..9.0])
        .prop_map(|(frequency, weight, offset)| Octave { frequency, weight, offset });
    let between = (-9.0f32..9.0, 0.5f32..9.0, any::<bool>())
        .prop_map(|(low, more, falls)| if falls { [low + more, low] } else { [low, low + more] });
    let share = || 0.0f32..=1.0;
    let displacement = (share(), vec(octave.clone(), 0..9), of(between))
        .prop_map(|(amplitude, octaves, between)| Displacement { amplitude, octaves, between });
    let optics = (vec(octave, 0..9), share(), share(), share())
        .prop_map(|(octaves, opacity, color, transport)| PropertyNoise { octaves, opacity, color, transport });
    (any::<u32>(), displacement, optics).prop_map(|(seed, displacement, optics)| Perturbation {
        seed,
        displacement,
        optics,
    })
}

fn volume() -> impl Strategy<Value = VolumeEntry> {
    let interval = || {
        (number(), length())
            .prop_map(|(low, more)| [low, low + more + low.abs()])
            .prop_filter("ascends", |w| w[0] < w[1])
    };
    let crop = [interval(), interval(), interval()]
        .prop_map(|c| Crop { from: c.map(|[low, _]| low), to: c.map(|[_, high]| high) });
    let names = (
        of(select(Preset::all().iter().map(|preset| preset.name.clone()).collect::<Vec<_>>())),
        of(select(ColorMap::names().map(|name| format!("{name}_r")).collect::<Vec<_>>())),
        of(select(opacity_shape_names().collect::<Vec<_>>())),
    );
    let weight = (0.0f32..10.0, 0.5f32..10.0).prop_map(|(low, more)| GradientWeight { low, high: low + more });
    let optics = (of(length()), of(transfer_function()), of(any::<bool>()), of(material()), of(weight));
    let light = (scattering(), perturbation());
    (source(), 0usize..4, of([length(), length(), length()]), of(crop), names, of(interval()), optics, light).prop_map(
        |(source, component, spacing, crop, (preset, colormap, opacity), window, optics, light)| {
            let (unit_distance, transfer_function, shading, material, gradient_weight) = optics;
            let (scattering, mut perturbation) = light;
            if scattering.transport.is_none() {
                perturbation.optics.transport = 0.0;
            }
            VolumeEntry {
                colors: Some(Colors::Data).filter(|_| component > 1),
                source,
                component: Some(component).filter(|component| *component > 0),
                spacing,
                crop,
                preset,
                window,
                colormap,
                opacity,
                unit_distance,
                transfer_function,
                shading,
                material,
                gradient_weight,
                scattering,
                perturbation,
            }
        },
    )
}

fn camera() -> impl Strategy<Value = Camera> {
    let projection = prop_oneof![
        (0.1f64..179.0).prop_map(|vertical_fov| Projection::Perspective { vertical_fov }),
        of(length()).prop_map(|height| Projection::Orthographic { height }),
    ];
    let orbit = (number(), -90.0..=90.0, number(), of(length()), length(), of(position())).prop_map(
        |(azimuth, elevation, roll, distance, zoom, target)| {
            View::Orbit(Orbit { azimuth, elevation, roll, distance, zoom, target })
        },
    );
    let look_at = (position(), heading(), heading()).prop_map(|(position, away, up)| {
        let target = std::array::from_fn(|axis| position[axis] * 2.0 + away[axis]);
        View::LookAt(LookAt { position, target, up })
    });
    let look_at = look_at.prop_filter("eye and target apart", |view| {
        let View::LookAt(LookAt { position, target, .. }) = view else { return false };
        // As the check measures it: squares of the smallest numbers vanish.
        position.iter().zip(target).map(|(p, t)| (t - p).powi(2)).sum::<f64>() > 0.0
    });
    let frame = select(vec![Framing::Visible, Framing::Grid]);
    (projection, prop_oneof![orbit, look_at], frame).prop_map(|(projection, view, frame)| Camera {
        projection,
        view,
        frame,
    })
}

fn lighting() -> impl Strategy<Value = Lighting> {
    let falloff = prop_oneof![Just(Falloff::None), length().prop_map(|reference| Falloff::InverseSquare { reference })];
    let kind = prop_oneof![
        heading().prop_map(|direction| LightKind::Directional { direction }),
        (position(), falloff.clone()).prop_map(|(position, falloff)| LightKind::Point { position, falloff }),
        (position(), heading(), 0.0f64..90.0, 90.0f64..180.0, falloff.clone()).prop_map(
            |(position, direction, inner_angle, outer_angle, falloff)| {
                LightKind::Spot { position, direction, inner_angle, outer_angle, falloff }
            }
        ),
        (position(), length(), any::<bool>(), falloff).prop_map(|(center, side, two_sided, falloff)| {
            let edges = [[side, 0.0, 0.0], [0.3, 0.0, 1.0]];
            LightKind::Rectangle { center, edges, two_sided, falloff }
        }),
    ];
    let frame = select(vec![Frame::World, Frame::Camera]);
    let light = (kind, color(), 0.0f32..100.0, frame, any::<bool>(), 0.0..90.0f64).prop_map(
        |(kind, color, intensity, frame, specular, radius)| {
            // Rectangles have edges instead.
            let radius = if matches!(kind, LightKind::Rectangle { .. }) { 0.0 } else { radius };
            Light { kind, color, intensity, frame, specular, radius }
        },
    );
    let shadows = prop_oneof![
        Just(Shadows::None),
        (0.01..100.0f64).prop_map(|step| Shadows::Rays(ShadowRays { step })),
        (0.05..4.0f64).prop_map(|resolution| Shadows::Volume(ShadowVolume { resolution })),
    ];
    let model = select(vec![LightModel::Surface, LightModel::Scattering]);
    (vec(light, 0..4), 0.0f32..3.0, shadows, model).prop_map(|(lights, ambient, shadows, model)| Lighting {
        lights,
        ambient,
        shadows,
        model,
    })
}

fn half_angle() -> impl Strategy<Value = HalfAngle> {
    let factor = || 0.0f32..=10.0;
    let jitter = (select(vec![BlurJitter::Fixed, BlurJitter::PerSlice]), any::<u32>());
    let in_scatter = vec![InScatter::Direct, InScatter::DirectFromMatter, InScatter::BothFromMatter];
    let choices = (select(vec![LightCorrection::HalfSlab, LightCorrection::None]), select(in_scatter), any::<bool>());
    let scaling = select(vec![BlurScaling::PerSlice, BlurScaling::PerDistance]);
    let blur = (0.0..=90.0f64, 1u32..=16, jitter, scaling);
    (of(0usize..9), 16u32..=4096, choices, [factor(), factor(), factor()], blur).prop_map(
        |(light, resolution, (correction, in_scatter, ambient), [direct, indirect, initial_indirect], blur)| {
            let (blur_angle, taps, (jitter, seed), blur_scaling) = blur;
            HalfAngle {
                light,
                resolution,
                correction,
                direct,
                indirect,
                initial_indirect,
                blur_angle,
                taps,
                jitter,
                seed,
                blur_scaling,
                in_scatter,
                ambient,
            }
        },
    )
}

fn technique() -> impl Strategy<Value = Technique> {
    let isovalue = (number(), of(color()), 0.0f32..=1.0).prop_map(|(value, color, opacity)| Isovalue {
        value,
        color,
        opacity,
        volume: None,
    });
    let combine = select(vec![Combine::Maximum, Combine::Minimum, Combine::Average]);
    let slice = (of(position()), of(heading()), 0.0..1e9, combine)
        .prop_map(|(point, normal, thickness, combine)| Slice { point, normal, thickness, combine });
    let plain = vec![Mode::Composite, Mode::Maximum, Mode::Minimum, Mode::Average, Mode::Additive, Mode::XRay];
    let mode = prop_oneof![
        select(plain),
        vec(isovalue, 1..4).prop_map(|isovalues| Mode::Isosurface(Isosurface::new(isovalues))),
        slice.prop_map(Mode::Slice),
    ];
    prop_oneof![
        3 => mode.clone().prop_map(|mode| Technique::RayCast(RayCast { mode })),
        1 => slicing(mode).prop_map(Technique::Slicing),
        1 => half_angle().prop_map(Technique::HalfAngle),
        1 => path_trace().prop_map(Technique::PathTrace),
    ]
}

fn slicing(mode: impl Strategy<Value = Mode>) -> impl Strategy<Value = Slicing> {
    use SliceGeometry::*;
    let mode = mode.prop_filter("a plane is not drawn in slices", |mode| match mode {
        Mode::Slice(slice) => slice.thickness > 0.0,
        _ => true,
    });
    let geometry = select(vec![ViewAligned, ObjectAligned, MultiTexture, Shells]);
    let order = select(vec![BlendOrder::FrontToBack, BlendOrder::BackToFront]);
    let target = select(vec![SliceTarget::U8, SliceTarget::F16, SliceTarget::F32]);
    let colors = select(vec![ColorWeight::Associated, ColorWeight::NonAssociated]);
    let correction = select(vec![Correction::PerSample, Correction::PerFrame, Correction::Off]);
    let proxy = select(vec![Proxy::VertexStage, Proxy::Processor]);
    let looks = (1u32..=16, 0u32..=1000, any::<bool>());
    (mode, geometry, order, target, colors, correction, proxy, looks).prop_map(
        |(mode, geometry, order, target, colors, correction, proxy, looks)| {
            let (samples, termination_interval, occlusion_culling) = looks;
            Slicing {
                mode,
                geometry,
                order,
                target,
                colors,
                correction,
                proxy,
                samples,
                termination_interval,
                occlusion_culling,
            }
        },
    )
}

fn path_trace() -> impl Strategy<Value = PathTrace> {
    let environment = prop_oneof![
        Just(Environment::Dark),
        (color(), 0.0f32..9.0).prop_map(|(color, intensity)| Environment::Constant { color, intensity }),
        (color(), color(), 0.0f32..9.0).prop_map(|(top, bottom, intensity)| Environment::Gradient {
            top,
            bottom,
            intensity
        }),
        (text(), any::<bool>(), -360.0..360.0f64, 0.0f32..9.0).prop_map(|(path, day, rotation, intensity)| {
            let source = if day { SkySource::Day } else { SkySource::File(path.into()) };
            Environment::Image(SkyImage { source, rotation, intensity, map: None })
        }),
    ];
    let majorants = select(vec![Majorants::Local, Majorants::Global]);
    let lens = (prop_oneof![Just(0.0), length()], of(length()), 0.0f32..=100.0, any::<bool>(), 0.0f32..=1e9);
    (1u32..=1 << 20, 0u32..=100_000, 0.0f32..=1.0, environment, lens, any::<u32>(), 0u32..=100_000, majorants).prop_map(
        |(
            samples,
            bounces,
            noise,
            environment,
            (aperture, focus, surface_depth, denoise, firefly_clamp),
            seed,
            roulette,
            majorants,
        )| {
            PathTrace {
                samples,
                bounces,
                noise,
                environment,
                aperture,
                focus,
                seed,
                roulette,
                surface_depth,
                denoise,
                firefly_clamp,
                majorants,
            }
        },
    )
}

fn quality() -> impl Strategy<Value = Quality> {
    use SincWindow::*;
    let filter = prop_oneof![
        select(vec![Filter::Nearest, Filter::Linear]),
        any::<bool>().prop_map(|prefilter| Filter::BSpline { prefilter }),
        (-2.0..2.0, -2.0..2.0).prop_map(|(b, c)| Filter::Bc { b, c }),
        (select(vec![Lanczos, Hann, Blackman, Kaiser]), 2u8..=8)
            .prop_map(|(window, half_width)| Filter::Sinc { window, half_width }),
    ];
    let gradient = prop_oneof![
        select(vec![Gradient::Forward, Gradient::Sobel, Gradient::SobelIsotropic, Gradient::BSpline]),
        (0.25..=3.0).prop_map(|sigma| Gradient::Gaussian { sigma }),
    ];
    let classification = select(vec![Classification::Post, Classification::Pre, Classification::PreIntegrated]);
    let jitter = prop_oneof![Just(Jitter::Centered), any::<u32>().prop_map(|seed| Jitter::BlueNoise { seed })];
    let thresholds = (1e-3f32..=1.0, 0.0f32..=1.0);
    (0.01..=100.0, filter, gradient, classification, jitter, thresholds, any::<bool>(), 1u32..=16).prop_map(
        |(step, filter, gradient, classification, jitter, thresholds, empty_space_skipping, supersampling)| {
            let (early_termination, adaptive_tolerance) = thresholds;
            Quality {
                step,
                filter,
                gradient,
                classification,
                jitter,
                early_termination,
                adaptive_tolerance,
                empty_space_skipping,
                supersampling,
            }
        },
    )
}

fn image() -> impl Strategy<Value = ImageSettings> {
    let background = prop_oneof![
        Just(Background::Transparent),
        Just(Background::Environment),
        color().prop_map(Background::Color),
        (color(), color()).prop_map(|(top, bottom)| Background::Gradient { top, bottom }),
    ];
    let encoding = select(vec![Encoding::Srgb, Encoding::Linear]);
    (1u32..=32768, 1u32..=32768, background, encoding, 1e-3f32..1e3).prop_map(
        |(width, height, background, encoding, exposure)| ImageSettings {
            width,
            height,
            background,
            encoding,
            exposure,
        },
    )
}

fn scene() -> impl Strategy<Value = Scene> {
    let plane = (position(), heading()).prop_map(|(point, normal)| Clip::Plane { point, normal });
    let cube = (position(), [length(), length(), length()]).prop_map(|(min, size)| Clip::Box {
        min,
        max: std::array::from_fn(|axis| min[axis] + size[axis] + min[axis].abs()),
    });
    let cube = cube.prop_filter(
        "ascends",
        |cube| matches!(cube, Clip::Box { min, max } if (0..3).all(|axis| min[axis] < max[axis])),
    );
    let clips = vec(prop_oneof![plane, cube], 0..4);
    let overlap = prop_oneof![Just(Overlap::Add), Just(Overlap::Maximum), Just(Overlap::Priority)];
    let drawn = (technique(), quality(), image());
    (text(), vec(volume(), 0..3), overlap, camera(), lighting(), clips, drawn).prop_map(
        |(title, volumes, overlap, camera, lighting, clips, (technique, quality, image))| Scene {
            version: 1,
            title,
            volumes,
            overlap,
            camera,
            lighting,
            clips,
            technique,
            quality,
            image,
        },
    )
}

fn survives(scene: &Scene) {
    for format in [Format::Toml, Format::Json] {
        let text = scene.to_text(format).unwrap();
        let back = Scene::parse(&text, format).unwrap_or_else(|error| panic!("{error} in\n{text}"));
        assert_eq!(&back, scene, "{format:?}\n{text}");
    }
}

proptest! {
    #[test]
    fn any_scene_survives(scene in scene()) {
        survives(&scene);
    }
}

#[test]
fn the_default_survives_and_is_what_an_empty_document_means() {
    survives(&Scene::default());
    assert_eq!(Scene::parse("", Format::Toml).unwrap(), Scene::default());
    assert_eq!(Scene::parse("{}", Format::Json).unwrap(), Scene::default());
    let short = "[[volumes]]\nsource.file = 'a.nrrd'\n";
    assert_eq!(Scene::parse(short, Format::Toml).unwrap(), Scene::of(Source::File("a.nrrd".into())));
}

#[test]
fn formats_are_told_by_extension() {
    let format = |name: &str| Format::of(std::path::Path::new(name));
    assert_eq!(format("a/b.toml"), Some(Format::Toml));
    assert_eq!(format("b.JSON"), Some(Format::Json));
    assert_eq!((format("toml"), format("a.txt")), (None, None));
}
