//! How volumes scatter: what a sample gets, and what a document may say.

use pellucid_optics::{
    Albedo, Anisotropy, Color, ColorPoint, GradientWeight, NumberPoint, Phase, Scattering, SurfaceShare, srgb_decode,
};

fn lobe() -> Scattering {
    Scattering { phase: Phase::HenyeyGreenstein { g: 0.6 }, ..Scattering::default() }
}

#[test]
fn left_out_the_colour_is_the_albedo_and_the_phase_function_has_its_anisotropy() {
    let scatterer = lobe().at(7.0, [0.9, 0.5, 0.1, 0.3]);
    assert_eq!((scatterer.albedo, scatterer.g), ([0.9, 0.5, 0.1], 0.6));
    assert_eq!(Scattering::default().at(7.0, [1.0, 1.0, 1.0, 0.3]).g, 0.0);
    assert_eq!(lobe().transport_at(7.0), None);
    assert_eq!(lobe().surface_at(7.0, 1e9), 0.0);
}

#[test]
fn curves_over_data_values_replace_them() {
    let scattering = Scattering {
        anisotropy: Anisotropy::Values(vec![NumberPoint::new(0.0, -0.5), NumberPoint::new(10.0, 0.5)]),
        albedo: Albedo::Colors(vec![ColorPoint::new(0.0, Color::BLACK), ColorPoint::new(10.0, Color::WHITE)]),
        transport: Some(vec![ColorPoint::new(0.0, Color::hex(0xff8000))]),
        surface: SurfaceShare::Values(vec![NumberPoint::new(0.0, 0.0), NumberPoint::new(10.0, 1.0)]),
        ..lobe()
    };
    scattering.validate().unwrap();
    let scatterer = scattering.at(7.5, [0.9, 0.5, 0.1, 0.3]);
    assert_eq!(scatterer.g, 0.25);
    // Colours of documents are encoded, as everywhere else.
    assert_eq!(scatterer.albedo, [srgb_decode(0.75); 3]);
    assert_eq!(scattering.transport_at(-3.0), Some([1.0, srgb_decode(128.0 / 255.0), 0.0]));
    assert_eq!(scattering.surface_at(7.5, 0.0), 0.75);
    let constant = Scattering { albedo: Albedo::Constant(0.5), ..lobe() };
    assert_eq!(constant.at(f64::NAN, [0.9; 4]).albedo, [0.5; 3]);
    let ramp = Scattering { surface: SurfaceShare::Gradient(GradientWeight { low: 1.0, high: 3.0 }), ..lobe() };
    assert_eq!([1.0, 2.0, 3.0].map(|gradient| ramp.surface_at(0.0, gradient)), [0.0, 0.5, 1.0]);
}

#[test]
fn thin_cloud_throws_light_on_and_dense_cloud_all_around() {
    // 6.2-6
    let cloud = Scattering { anisotropy: Anisotropy::Cloud, ..lobe() };
    let g = |opacity| cloud.at(0.0, [1.0, 1.0, 1.0, opacity]).g;
    assert_eq!([0.0, 0.25, 1.0].map(g), [0.99, 0.75, 0.0]);
}

#[test]
fn what_cannot_be_used_is_named() {
    let point = |number| vec![NumberPoint::new(0.0, 0.0), NumberPoint::new(1.0, number)];
    let weight = GradientWeight { low: 2.0, high: 1.0 };
    let cases = [
        (Scattering { phase: Phase::Schlick { g: 2.0 }, ..lobe() }, "phase", "g is 2: expected -0.99 to 0.99"),
        (
            Scattering { phase: Phase::Rayleigh, anisotropy: Anisotropy::Cloud, ..lobe() },
            "anisotropy",
            "phase function rayleigh has no single anisotropy that could vary",
        ),
        (
            Scattering { anisotropy: Anisotropy::Values(point(1.5)), ..lobe() },
            "anisotropy.values",
            "values, point 1 (value 1): number is 1.5: expected -0.99 to 0.99",
        ),
        (Scattering { albedo: Albedo::Constant(1.5), ..lobe() }, "albedo.constant", "albedo is 1.5: expected 0 to 1"),
        (Scattering { albedo: Albedo::Colors(vec![]), ..lobe() }, "albedo.colors", "colors has no points"),
        (Scattering { transport: Some(vec![]), ..lobe() }, "transport", "colors has no points"),
        (
            Scattering { surface: SurfaceShare::Values(point(f32::NAN)), ..lobe() },
            "surface.values",
            "number is NaN: expected a finite one",
        ),
        (
            Scattering { surface: SurfaceShare::Values(point(-0.5)), ..lobe() },
            "surface.values",
            "number is -0.5: expected 0 to 1",
        ),
        (
            Scattering { surface: SurfaceShare::Gradient(weight), ..lobe() },
            "surface.gradient",
            "gradient weight [2, 1]",
        ),
    ];
    for (scattering, key, message) in cases {
        let (found, error) = scattering.validate().unwrap_err();
        assert_eq!(found, key);
        assert!(error.to_string().contains(message), "{error}");
    }
}
