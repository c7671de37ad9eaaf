//! Files that the optics of a scene name.

use pellucid::io::{IoError, PngPixels, Transfer, write_exr, write_png};
use pellucid::optics::{BackLobe, Environment, Phase, PhaseTable, SkyImage, SkySource, TableAngles, srgb_decode};
use pellucid::scene::{Format, PathTrace, SampleSource, Scene, Source, Technique};
use pellucid::{LoadError, load, load_optics};

fn scene(file: &str) -> Scene {
    let image = SkyImage { source: SkySource::File(file.into()), rotation: 0.0, intensity: 1.0, map: None };
    let ball = SampleSource { name: "ball".into(), dims: Some([8; 3]), voxel_type: None };
    let settings = PathTrace { environment: Environment::Image(image), ..PathTrace::default() };
    Scene { technique: Technique::PathTrace(settings), ..Scene::of(Source::Sample(ball)) }
}

/// Radiance from straight above and from straight below.
fn ends(scene: &Scene) -> [[f32; 3]; 2] {
    let Technique::PathTrace(settings) = &scene.technique else { panic!("{:?}", scene.technique) };
    let sky = settings.environment.resolve().unwrap().unwrap();
    [1.0, -1.0].map(|z| sky.radiance([0.0, 0.0, z].into()))
}

#[test]
fn pictures_of_the_sky_are_read_as_light() {
    let folder = tempfile::tempdir().unwrap();
    let channels = [("R", [7.0f32, 0.5]), ("G", [3.0, 0.25]), ("B", [1.0, 0.125])];
    let channels: Vec<(&str, &[f32])> = channels.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    write_exr(folder.path().join("sky.exr"), 1, 2, &channels).unwrap();
    let mut lit = scene("sky.exr");
    load_optics(&mut lit, folder.path()).unwrap();
    assert_eq!(ends(&lit), [[7.0, 3.0, 1.0], [0.5, 0.25, 0.125]]);

    let pixels = PngPixels::U8(&[255, 128, 0, 10, 20, 30]);
    write_png(folder.path().join("sky.png"), 1, 2, pixels, Transfer::Srgb).unwrap();
    let mut lit = scene("sky.png");
    load_optics(&mut lit, folder.path()).unwrap();
    let decoded = |bytes: [u8; 3]| bytes.map(|v| srgb_decode(f32::from(v) / 255.0));
    assert_eq!(ends(&lit), [decoded([255, 128, 0]), decoded([10, 20, 30])]);
}

#[test]
fn what_cannot_be_read_or_used_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = |file: &str| load_optics(&mut scene(file), folder.path()).unwrap_err();
    assert!(matches!(error("none.exr"), LoadError::Io(IoError::Io { .. })));
    write_exr(folder.path().join("dark.exr"), 1, 1, &[("R", &[-1.0]), ("G", &[0.0]), ("B", &[0.0])]).unwrap();
    let negative = error("dark.exr").to_string();
    assert!(negative.contains("dark.exr") && negative.contains("texel 0, 0"), "{negative}");
}

#[test]
fn phase_functions_are_read_into_tables_and_lobes() {
    let folder = tempfile::tempdir().unwrap();
    let scattering = |phase| {
        let mut scene = scene("unused.exr");
        scene.technique = Technique::default();
        scene.volumes[0].scattering.phase = phase;
        scene
    };
    let table = |file: &str| Phase::Table(PhaseTable::of_file(TableAngles::Theta, file).unwrap());
    // What grows with the cosine, (1 + mu) / 2, integrates to 2 pi: physical it is over that.
    std::fs::write(folder.path().join("mie.csv"), "cosine, intensity\n-1, 0\n0.2, 0.6\n1, 1\n").unwrap();
    let mut lit = scattering(table("mie.csv"));
    let unread = lit.resolve(&load(&lit, "").unwrap().0).unwrap_err().to_string();
    assert!(unread.contains("volumes[0].scattering.phase") && unread.contains("mie.csv"), "{unread}");
    load_optics(&mut lit, folder.path()).unwrap();
    assert!(lit.resolve(&load(&lit, "").unwrap().0).is_ok());
    for mu in [-0.9f32, -0.1, 0.3, 1.0] {
        let found = lit.volumes[0].scattering.phase.eval(0.0, mu);
        assert!(found.iter().all(|v| (v - (1.0 + mu) / 4.0 / std::f32::consts::PI).abs() < 1e-6), "{mu}: {found:?}");
    }
    // The document still names the file.
    let text = lit.to_text(Format::Toml).unwrap();
    assert!(text.contains("mie.csv") && !text.contains("values"), "{text}");

    // A row of a picture, linear, is a table of so many angles; a lobe takes those behind.
    let row: Vec<u16> = (0..7).flat_map(|k| [9000 * k + 1000, 30_000, 65_535 - 9000 * k]).collect();
    write_png(folder.path().join("row.png"), 7, 1, PngPixels::U16(&row), Transfer::Linear).unwrap();
    let values: Vec<[f32; 3]> = row.chunks(3).map(|v| [0, 1, 2].map(|c| f32::from(v[c]) / 65_535.0)).collect();
    let back = |lobe: Result<BackLobe, _>| Phase::Hybrid { g: 0.7, back: lobe.unwrap() };
    for (unread, given) in [
        (table("row.png"), Phase::Table(PhaseTable::new(TableAngles::Theta, values.clone()).unwrap())),
        (
            back(BackLobe::of_file(TableAngles::Cosine, "row.png")),
            back(BackLobe::new(TableAngles::Cosine, values.clone())),
        ),
    ] {
        let mut lit = scattering(unread);
        load_optics(&mut lit, folder.path()).unwrap();
        let read = &lit.volumes[0].scattering.phase;
        for k in 0..=40 {
            let mu = k as f32 / 20.0 - 1.0;
            assert_eq!(read.eval(0.7, mu), given.eval(0.7, mu));
        }
    }
    // Half of the angles are no table.
    std::fs::write(folder.path().join("half.csv"), "0,1\n90,1\n").unwrap();
    let error = load_optics(&mut scattering(table("half.csv")), folder.path()).unwrap_err().to_string();
    assert!(error.contains("half.csv") && error.contains("expected from 1 to -1"), "{error}");
    std::fs::write(folder.path().join("bad.csv"), "0,1\n180,one\n").unwrap();
    let error = load_optics(&mut scattering(table("bad.csv")), folder.path()).unwrap_err().to_string();
    assert!(error.contains("bad.csv, line 2: word 2 is not a number"), "{error}");
    assert!(matches!(
        load_optics(&mut scattering(table("no.csv")), folder.path()),
        Err(LoadError::Io(IoError::Io { .. }))
    ));
}
