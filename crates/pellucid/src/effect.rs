//! Which settings of a scene its picture depends on: one table of what each of them needs.

use std::fmt;

use pellucid_optics::SurfaceShare;
use pellucid_scene::{
    Classification, Combine, GlobalIllumination, IlluminationMethod, Isosurface, LightPath, Mode, Orbit, Scene, Slice,
    Source, Stage, StageVolume, SurfaceNormals, View, VolumeEntry,
};
use serde_json::Value;

/// A setting that the picture does not depend on as the rest of the scene stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WithoutEffect {
    /// Its place in the document.
    pub setting: String,
    /// What it would need.
    pub reason: &'static str,
}

impl fmt::Display for WithoutEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} has no effect: {}", self.setting, self.reason)
    }
}

/// The settings of a scene that say something other than their defaults to no effect on the picture, of which
/// `stage` is the resolved form; and those of `also`, places in the document, which somebody has set to whatever value.
pub fn without_effect(scene: &Scene, stage: &Stage, also: &[&str]) -> Vec<WithoutEffect> {
    let (Ok(document), Ok(defaults)) = (serde_json::to_value(scene), serde_json::to_value(defaults_of(scene))) else {
        return Vec::new();
    };
    let said = |setting: &str| {
        let pointer = format!("/{}", setting.replace(['.', '['], "/").replace(']', ""));
        let at = |document: &Value| document.pointer(&pointer).cloned().unwrap_or_default();
        let parts =
            |place: &&str| place.strip_prefix(setting).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        at(&document) != at(&defaults) || also.iter().any(parts)
    };
    let mut found = Vec::new();
    for (number, (entry, volume)) in scene.volumes.iter().zip(&stage.volumes).enumerate() {
        let drawn = Drawn { scene, stage, entry, volume };
        for (pattern, needs) in NEEDS {
            let of_volume = pattern.starts_with("volumes[]");
            let setting = pattern.replace("[]", &format!("[{number}]")).replace('*', stage.technique.name());
            if (of_volume || number == 0)
                && let Some(need) = needs.iter().find(|need| !(need.is_met)(&drawn))
                && said(&setting)
            {
                found.push(WithoutEffect { setting, reason: need.otherwise });
            }
        }
    }
    for (own, reason) in stage.technique.idle() {
        let setting = format!("technique.{}.{own}", stage.technique.name());
        if said(&setting) {
            found.push(WithoutEffect { setting, reason });
        }
    }
    found
}

/// A scene of the same kind, everything in it left to its default.
fn defaults_of(scene: &Scene) -> Scene {
    let mut plain = Scene {
        volumes: scene.volumes.iter().map(|_| VolumeEntry::new(Source::memory())).collect(),
        technique: scene.technique.plain(),
        ..Scene::default()
    };
    plain.camera.view = View::Orbit(Orbit::default());
    // What turns off what is off anyway is no mistake.
    if scene.lighting.ambient == 0.0 {
        plain.lighting.ambient = 0.0;
    }
    for (plain, entry) in plain.volumes.iter_mut().zip(&scene.volumes) {
        plain.shading = entry.shading.filter(|lit| !lit);
    }
    plain
}

/// What a need looks at.
struct Drawn<'a> {
    scene: &'a Scene,
    stage: &'a Stage,
    entry: &'a VolumeEntry,
    volume: &'a StageVolume,
}

/// Something that must hold for a setting to have an effect, and what is said where it does not.
struct Need {
    is_met: fn(&Drawn) -> bool,
    otherwise: &'static str,
}

/// Settings and their needs; the first that is not met is told. Settings of speed alone are not here: the picture never
/// depends on them.
const NEEDS: &[(&str, &[Need])] = &[
    ("overlap", &[LAYERED, NOT_OF_SURFACES]),
    ("camera.frame", &[FREE]),
    ("camera.view.orbit.distance", &[FROM_A_POINT]),
    ("volumes[].window", &[CLASSIFIED_OR_PRESET, SPREAD]),
    ("volumes[].preset", &[NO_TRANSFER_FUNCTION_OR_SURFACE, CLASSIFIED_OR_SHADED]),
    ("volumes[].colormap", &[NO_TRANSFER_FUNCTION, CLASSIFIED_OR_PRESET, COLORED]),
    ("volumes[].colors", &[MAY_BE_OF_DATA]),
    ("volumes[].opacity", &[NO_TRANSFER_FUNCTION, OPACITY_IS_USED]),
    ("volumes[].transfer_function", &[CLASSIFIED_OR_PRESET]),
    ("volumes[].unit_distance", &[MEDIUM]),
    ("volumes[].shading", &[SURFACES_OR_AMBIENT]),
    ("volumes[].material", &[SURFACES_OR_AMBIENT, SHADED, NOT_MATTE]),
    ("volumes[].gradient_weight", &[MADE_OF_SURFACES, SHADED, NOT_SCATTERED, NOT_MATTE]),
    ("volumes[].scattering.phase", &[LIT_BY_SCATTERING]),
    ("volumes[].scattering.albedo", &[LIT_BY_SCATTERING]),
    ("volumes[].scattering.anisotropy", &[LIT_BY_SCATTERING]),
    ("volumes[].scattering.surface", &[LIT_BY_SCATTERING]),
    ("volumes[].scattering.transport", &[BY_HALF_ANGLES]),
    ("volumes[].perturbation.optics", &[COMPOSITED]),
    ("lighting.lights", &[LIT]),
    ("lighting.ambient", &[LIT_FROM_EVERYWHERE]),
    ("lighting.shadows", &[LIT, NOT_MATTE, SHADOWED]),
    ("lighting.model", &[SAMPLES_OF_RAYS_OR_SLICES, COMPOSITED]),
    ("technique.*.mode.slice.combine", &[THICK]),
    ("technique.*.mode.isosurface.search", &[TRILINEAR, SEARCHED_ALONG_RAYS]),
    ("technique.*.mode.isosurface.illumination", &[SHADED]),
    ("technique.*.mode.isosurface.illumination.global.resolution", &[IN_A_LATTICE]),
    ("technique.*.mode.isosurface.illumination.global.interpolation", &[IN_A_LATTICE]),
    ("technique.*.mode.isosurface.illumination.global.basis", &[IN_A_LATTICE]),
    ("technique.*.mode.isosurface.illumination.global.file", &[IN_A_LATTICE]),
    ("technique.*.mode.isosurface.illumination.global.surfaces", &[IN_A_LATTICE]),
    ("technique.*.mode.isosurface.illumination.global.bounces", &[HELD_BACK]),
    ("technique.*.mode.isosurface.illumination.global.distance", &[HELD_BACK]),
    ("technique.path_trace.surface_depth", &[MADE_OF_SURFACES]),
    ("quality.step", &[NOT_BY_PATHS, NOT_A_PLANE, NOT_AN_EXTREME, NOT_EVERY_SURFACE]),
    ("quality.gradient", &[MADE_OF_SURFACES, SHADED, NORMALS_OF_DATA]),
    ("quality.classification", &[SAMPLES_OF_RAYS_OR_SLICES, COMPOSITED]),
    ("quality.jitter", &[NOT_A_PLANE, NOT_AN_EXTREME, NOT_EVERY_SURFACE, NOT_THE_VOLUMES_PLANES]),
    ("quality.early_termination", &[NOT_BY_PATHS, BECOMES_OPAQUE, NEAREST_FIRST]),
    ("quality.adaptive_tolerance", &[ADAPTIVE, COMPOSITED, POST_CLASSIFIED]),
    ("quality.supersampling", &[NOT_BY_PATHS]),
];

const LAYERED: Need = Need { is_met: |drawn| drawn.stage.has_layers(), otherwise: "there is one volume" };

const NOT_OF_SURFACES: Need =
    Need { is_met: |drawn| drawn.stage.technique.needs().overlap, otherwise: "surfaces and paths meet all volumes" };

const FROM_A_POINT: Need = Need {
    // Rays that begin within the volume miss what lies behind the eye.
    is_met: |drawn| {
        let view = &drawn.stage.viewpoint;
        let behind = |v: &StageVolume| {
            v.volume.grid().world_corners().into_iter().any(|corner| (corner - view.eye).dot(view.forward) < 0.0)
        };
        view.perspective || drawn.stage.volumes.iter().any(behind)
    },
    otherwise: "parallel rays show the same from any distance in front of the volume; only depths count from the eye",
};

const FREE: Need = Need { is_met: |drawn| drawn.scene.camera.frames(), otherwise: "the camera is given in full" };

const CLASSIFIED: Need = Need {
    is_met: |drawn| match drawn.stage.mode() {
        Mode::Isosurface(Isosurface { isovalues, .. }) => isovalues.iter().any(|iso| iso.color.is_none()),
        _ => true,
    },
    otherwise: "every isosurface has a colour of its own",
};

const CLASSIFIED_OR_PRESET: Need =
    Need { is_met: |drawn| (CLASSIFIED.is_met)(drawn) || replaces_preset(drawn), otherwise: CLASSIFIED.otherwise };

/// Whether a look stands for a preset that would have been chosen, with its material, if nothing were said.
fn replaces_preset(drawn: &Drawn) -> bool {
    let by_preset =
        matches!(drawn.stage.mode(), Mode::Isosurface(_)) && drawn.entry.preset.is_none() && global(drawn).is_none();
    by_preset && drawn.entry.material.is_none() && drawn.volume.material.is_some()
}

const SPREAD: Need = Need {
    is_met: |drawn| drawn.scene.heeds_window(drawn.entry, &drawn.volume.volume),
    otherwise: "the look has data values of its own and is not spread over a window; a colour map or an opacity shape is",
};

const NO_TRANSFER_FUNCTION: Need = Need {
    is_met: |drawn| drawn.entry.transfer_function.is_none(),
    otherwise: "the transfer function is given in full",
};

const NO_TRANSFER_FUNCTION_OR_SURFACE: Need = Need {
    is_met: |drawn| drawn.entry.transfer_function.is_none() || (SHADED.is_met)(drawn),
    otherwise: "the transfer function is given in full, and no surface is lit by the preset's material",
};

const COLORED: Need = Need {
    is_met: |drawn| *drawn.stage.mode() != Mode::XRay,
    otherwise: "a radiograph shows the share of light that is held back, which has no colour",
};

const MAY_BE_OF_DATA: Need = Need {
    is_met: |drawn| drawn.stage.technique.needs().data_colors,
    otherwise: "colours of data are composited along rays and by half-angle light, and this is drawn otherwise",
};

const OPACITY_IS_USED: Need = Need {
    is_met: |drawn| !matches!(drawn.stage.mode(), Mode::Isosurface(_) | Mode::Slice(_)) || replaces_preset(drawn),
    otherwise: "isosurfaces have opacities of their own, and slices are opaque",
};

const MEDIUM: Need = Need {
    is_met: |drawn| matches!(drawn.stage.mode(), Mode::Composite | Mode::Additive | Mode::XRay),
    otherwise: "opacities hold for a length only where light passes through; projections, slices and isosurfaces show values",
};

const MADE_OF_SURFACES: Need = Need {
    is_met: |drawn| {
        let lit = matches!(drawn.stage.mode(), Mode::Composite | Mode::Isosurface(_));
        lit && (!drawn.stage.scatters() || drawn.volume.scattering.surface != SurfaceShare::None)
    },
    otherwise: "nothing is drawn as a surface: composited volumes and isosurfaces are, and with light that scatters what \
                scattering.surface says",
};

const SHADED: Need = Need { is_met: |drawn| drawn.volume.material.is_some(), otherwise: "shading is off" };

const LIT: Need = Need {
    is_met: |drawn| {
        drawn.stage.scatters() || ((MADE_OF_SURFACES.is_met)(drawn) && drawn.stage.volumes.iter().any(is_shaded))
    },
    otherwise: "nothing is lit: composited volumes and isosurfaces are, with shading, or a volume with light that scatters",
};

fn is_shaded(volume: &StageVolume) -> bool {
    volume.material.is_some()
}

const SURFACES_OR_AMBIENT: Need = Need {
    // A cloud still reflects ambient light by its material.
    is_met: |drawn| {
        let reflects = drawn.stage.technique.needs().ambient && *drawn.stage.mode() == Mode::Composite;
        (MADE_OF_SURFACES.is_met)(drawn) || reflects
    },
    otherwise: MADE_OF_SURFACES.otherwise,
};

const LIT_FROM_EVERYWHERE: Need = Need {
    is_met: |drawn| {
        // What scatters reflects it as the default material does where there is none.
        let answers = drawn.stage.scatters() || drawn.stage.volumes.iter().any(is_shaded);
        drawn.stage.technique.needs().ambient && (SURFACES_OR_AMBIENT.is_met)(drawn) && answers
    },
    otherwise: "only what is shaded reflects ambient light; half-angle slicing if its own 'ambient' is on, and paths find \
                their environment instead",
};

const NOT_SCATTERED: Need = Need {
    is_met: |drawn| !drawn.stage.scatters(),
    otherwise: "how much of a sample is a surface is said by scattering.surface where light scatters",
};

const CLASSIFIED_OR_SHADED: Need = Need {
    is_met: |drawn| (CLASSIFIED.is_met)(drawn) || (SHADED.is_met)(drawn) && global(drawn).is_none(),
    otherwise: "every isosurface has a colour of its own, and none is lit by a material",
};

const LIT_BY_SCATTERING: Need = Need {
    is_met: |drawn| drawn.stage.scatters(),
    otherwise: "light is not scattered: it is by path_trace and half_angle, and with lighting.model = \"scattering\"",
};

const BY_HALF_ANGLES: Need = Need {
    is_met: |drawn| drawn.stage.technique.needs().light == LightPath::Spreads,
    otherwise: "indirect light travels through slices of half_angle only",
};

const SHADOWED: Need =
    Need { is_met: |drawn| drawn.stage.technique.needs().shadows, otherwise: "it is about the ray caster" };

const ADAPTIVE: Need =
    Need { is_met: |drawn| drawn.stage.technique.needs().adaptive, otherwise: "it is about the ray caster" };

const NOT_BY_PATHS: Need = Need {
    is_met: |drawn| drawn.stage.technique.needs().light != LightPath::Scatters,
    otherwise: "paths meet matter at random: their number, technique.path_trace.samples, is their quality",
};

const SAMPLES_OF_RAYS_OR_SLICES: Need = Need {
    is_met: |drawn| !drawn.stage.technique.needs().light.is_followed(),
    otherwise: "the technique classifies every sample by itself and scatters light at it",
};

const COMPOSITED: Need = Need {
    is_met: |drawn| *drawn.stage.mode() == Mode::Composite,
    otherwise: "it is about composited volumes, and the mode is another",
};

const POST_CLASSIFIED: Need = Need {
    is_met: |drawn| drawn.stage.quality.classification == Classification::Post,
    otherwise: "only samples that are classified by themselves are left out",
};

const THICK: Need = Need {
    is_met: |drawn| !matches!(drawn.stage.mode(), Mode::Slice(Slice { thickness, .. }) if *thickness == 0.0),
    otherwise: "a slice without thickness has one value for a pixel",
};

const NOT_A_PLANE: Need =
    Need { is_met: THICK.is_met, otherwise: "a slice without thickness has one sample for a ray" };

const NOT_AN_EXTREME: Need = Need {
    is_met: |drawn| {
        let extreme = |combine| matches!(combine, Combine::Maximum | Combine::Minimum);
        !matches!(drawn.stage.mode(), Mode::Maximum | Mode::Minimum)
            && !matches!(drawn.stage.mode(), Mode::Slice(Slice { combine, .. }) if extreme(*combine))
    },
    otherwise: "the extreme of a ray is found in every cell that it passes, wherever samples are",
};

const NOT_EVERY_SURFACE: Need = Need {
    is_met: |drawn| {
        let stage = drawn.stage;
        stage.slicing().is_some() || !stage.volumes.iter().all(|volume| stage.finds_every_surface(volume))
    },
    otherwise: "every surface is found in the cells that a ray passes, wherever samples are",
};

const TRILINEAR: Need = Need {
    is_met: |drawn| drawn.stage.volumes.iter().any(|volume| drawn.stage.is_trilinear(volume)),
    otherwise: "surfaces are looked for between samples: a ray through cells is a cubic under the linear filter alone",
};

const SEARCHED_ALONG_RAYS: Need = Need {
    is_met: |drawn| drawn.stage.slicing().is_none() || drawn.stage.has_layers(),
    otherwise: "slices look for surfaces between themselves",
};

const NOT_MATTE: Need = Need {
    is_met: |drawn| drawn.stage.global_illumination().is_none(),
    otherwise: "surfaces in global illumination are matte, and hold light back by themselves",
};

const NORMALS_OF_DATA: Need = Need {
    is_met: |drawn| global(drawn).is_none_or(|global| global.normals == SurfaceNormals::Data),
    otherwise: "the normals of surfaces in global illumination are smoothed, unless its 'normals' are those of the data",
};

const IN_A_LATTICE: Need = Need {
    is_met: |drawn| global(drawn).is_none_or(|global| global.method == IlluminationMethod::Lattice),
    otherwise: "paths of light start at every place that is seen, not at those of a lattice",
};

const HELD_BACK: Need = Need {
    is_met: |drawn| global(drawn).is_none_or(|global| global.shadows),
    otherwise: "surfaces do not hold light back, nor send it on",
};

fn global<'a>(drawn: &'a Drawn) -> Option<&'a GlobalIllumination> {
    drawn.stage.global_illumination()
}

const NOT_THE_VOLUMES_PLANES: Need = Need {
    is_met: |drawn| drawn.stage.technique.needs().jitter,
    otherwise: "object-aligned slices lie on the planes of the voxels",
};

const BECOMES_OPAQUE: Need = Need {
    is_met: |drawn| match drawn.stage.mode() {
        Mode::Composite => true,
        Mode::Isosurface(Isosurface { isovalues, .. }) => isovalues.iter().any(|iso| iso.opacity < 1.0),
        _ => false,
    },
    otherwise: "no ray becomes opaque little by little",
};

const NEAREST_FIRST: Need = Need {
    is_met: |drawn| drawn.stage.technique.needs().front_to_back,
    otherwise: "what is farthest is blended first",
};
