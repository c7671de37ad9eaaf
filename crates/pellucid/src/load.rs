//! What a scene needs from elsewhere: its volumes and the pictures that light it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pellucid_field::closed_form::ScalarField;
use pellucid_field::{Grid, Volume, VoxelType, Warning, closed_form, memory};
use pellucid_io::{Endian, IoError, Limits, RawLayout, ReadOptions, Transfer, locate, read_picture};
use pellucid_model::{Clouds, HeightField, HeightMap, Ramp, Spectral};
use pellucid_optics::{Environment, SkyMap, SkySource, srgb_decode};
use pellucid_scene::{HeightFieldSource, HeightSource, Held, Mode, ModelSource, SampleSource, Scene, Source};

use crate::{LoadError, phase_file};

/// What a scene may name, and what that may cost.
///
/// A scene is a document that may come from anywhere. By default it names files in its own folder and below, see
/// [`locate`](pellucid_io::locate), and so do the headers of volumes in theirs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Whether the scene may name files anywhere.
    pub outside: bool,
    /// Names in the scene that are not the document's but the caller's own: they may lie anywhere.
    pub trusted: Vec<PathBuf>,
    /// How files of volumes are read; the limits are those of pictures and tables, too.
    pub read: ReadOptions,
}

/// The folder of a scene.
struct Folder<'a> {
    path: &'a Path,
    options: &'a LoadOptions,
}

impl Folder<'_> {
    /// The file that the scene means by a name.
    fn locate(&self, name: &Path) -> Result<PathBuf, IoError> {
        let outside = self.options.outside || self.options.trusted.iter().any(|trusted| trusted == name);
        locate(self.path, name, outside)
    }
}

/// Loads the volumes of a scene, one per entry, in order. Relative paths start at `base`, usually
/// the folder of the scene's file, which the scene must not leave ([`load_with`] lets it). The warnings tell
/// what was converted, guessed or ignored, and how many values are absent.
///
/// # Errors
/// [`LoadError`] for the first volume that cannot be had.
pub fn load(scene: &Scene, base: impl AsRef<Path>) -> Result<(Vec<Arc<Volume>>, Vec<Warning>), LoadError> {
    load_with(scene, base, &LoadOptions::default())
}

/// Loads the volumes of a scene, as [`load`] does, with other limits.
///
/// # Errors
/// [`LoadError`] for the first volume that cannot be had.
pub fn load_with(
    scene: &Scene,
    base: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<(Vec<Arc<Volume>>, Vec<Warning>), LoadError> {
    let folder = Folder { path: base.as_ref(), options };
    // What cannot be had is known before any file is read.
    for (k, entry) in scene.volumes.iter().enumerate() {
        match &entry.source {
            Source::Sample(sample) => drop(field_of(k, sample)?),
            Source::Memory(Held(None)) => return Err(LoadError::Absent { volume: k }),
            _ => {}
        }
    }
    let mut warnings = Vec::new();
    let mut volumes = Vec::with_capacity(scene.volumes.len());
    for (k, entry) in scene.volumes.iter().enumerate() {
        // Channels of a file are layers of the same voxels.
        if let Some(same) = scene.volumes[..k].iter().position(|other| other.source == entry.source) {
            let same: Arc<Volume> = Arc::clone(&volumes[same]);
            volumes.push(same);
            continue;
        }
        let volume = match &entry.source {
            Source::File(path) => read(&folder.locate(path)?, &options.read, &mut warnings)?,
            Source::Raw { path, dims, voxel_type, components, skip, big_endian } => {
                let layout = RawLayout {
                    components: *components,
                    endian: if *big_endian { Endian::Big } else { Endian::Little },
                    // With no bytes to skip the file must hold the values and nothing else.
                    skip: Some(*skip).filter(|skip| *skip > 0),
                    ..RawLayout::new(*dims, *voxel_type)
                };
                let options = ReadOptions { raw: Some(layout), ..options.read.clone() };
                read(&folder.locate(path)?, &options, &mut warnings)?
            }
            Source::Sample(sample) => sampled(k, sample)?,
            Source::Model(model) => modelled(k, model, &folder)?,
            Source::Memory(Held(None)) => return Err(LoadError::Absent { volume: k }),
            Source::Memory(Held(Some(volume))) => {
                volumes.push(volume.clone());
                continue;
            }
        };
        volumes.push(Arc::new(volume));
    }
    Ok((volumes, warnings))
}

/// Reads the files that the optics of a scene name, pictures of an environment, phase functions and saved light, into the
/// scene, where they stay: changes of the scene need no second reading. Relative paths start at `base`, which the scene must
/// not leave ([`load_optics_with`] lets it). PNG pictures are as bright as a screen shows them, white being a radiance
/// of 1.
///
/// # Errors
/// [`LoadError::Io`] if a file cannot be read, [`LoadError::Line`] and [`LoadError::Optics`] if it cannot be used.
pub fn load_optics(scene: &mut Scene, base: impl AsRef<Path>) -> Result<(), LoadError> {
    load_optics_with(scene, base, &LoadOptions::default())
}

/// Reads the files that the optics of a scene name, as [`load_optics`] does, with other limits.
///
/// # Errors
/// As [`load_optics`].
pub fn load_optics_with(scene: &mut Scene, base: impl AsRef<Path>, options: &LoadOptions) -> Result<(), LoadError> {
    let folder = Folder { path: base.as_ref(), options };
    let limits = &options.read.limits;
    if let Some(Environment::Image(image)) = scene.technique.environment_mut()
        && let SkySource::File(path) = &image.source
    {
        image.map = Some(Arc::new(sky(&folder.locate(path)?, limits)?));
    }
    if let Some(global) = scene.technique.mode_mut().and_then(Mode::global_illumination_mut)
        && let Some(file) = &global.file
    {
        // What is not as it was written is no light, and is refused for that.
        global.baked = Held(Some(Arc::new(read(&folder.locate(file)?, &options.read, &mut Vec::new())?)));
    }
    for entry in &mut scene.volumes {
        let phase = &mut entry.scattering.phase;
        if let Some(file) = phase.file() {
            let path = folder.locate(file)?;
            let entries = phase_file::read(&path, limits)?;
            phase.fill(&entries).map_err(|error| LoadError::Optics { path, error })?;
        }
    }
    Ok(())
}

fn sky(path: &Path, limits: &Limits) -> Result<SkyMap, LoadError> {
    let picture = read_picture(path, limits)?;
    let linear = |v: f32| if picture.transfer == Transfer::Srgb { srgb_decode(v) } else { v };
    let texels = picture.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b].map(linear)).collect();
    SkyMap::new(picture.width as usize, picture.height as usize, texels)
        .map_err(|error| LoadError::Optics { path: path.to_owned(), error })
}

fn read(path: &Path, options: &ReadOptions, warnings: &mut Vec<Warning>) -> Result<Volume, LoadError> {
    let loaded = pellucid_io::read(path, options)?;
    warnings.extend(loaded.warnings);
    Ok(loaded.volume)
}

fn field_of(volume: usize, sample: &SampleSource) -> Result<Box<dyn ScalarField>, LoadError> {
    closed_form::by_name(&sample.name).ok_or_else(|| LoadError::UnknownSample {
        volume,
        found: sample.name.clone(),
        known: closed_form::names().collect::<Vec<_>>().join(", "),
    })
}

fn sampled(volume: usize, sample: &SampleSource) -> Result<Volume, LoadError> {
    let field = field_of(volume, sample)?;
    let about = field.about();
    let dims = sample.dims.unwrap_or(about.dims);
    let voxel_type = sample.voxel_type.unwrap_or(about.voxel_type);
    baked(volume, field.as_ref(), dims, voxel_type)
}

fn modelled(volume: usize, model: &ModelSource, folder: &Folder) -> Result<Volume, LoadError> {
    let (field, dims): (Box<dyn ScalarField>, _) = match model {
        ModelSource::Clouds(clouds) => (Box::new(Clouds::new(clouds.seed.into(), clouds.ellipsoids)), clouds.dims),
        ModelSource::Spectral(spectral) => (Box::new(Spectral { phases: spectral.phases }), spectral.dims),
        ModelSource::HeightField(land) => (Box::new(height_field(volume, land, folder)?), land.dims),
    };
    baked(volume, field.as_ref(), dims, field.about().voxel_type)
}

/// A slab over a map, of the level that its voxels are as fine as.
fn height_field(volume: usize, land: &HeightFieldSource, folder: &Folder) -> Result<HeightField, LoadError> {
    /// Heights along a side of built-in land.
    const POINTS: usize = 1024;
    let failed = |source| LoadError::Sample { volume, source };
    let map = match &land.map {
        HeightSource::Terrain(seed) => HeightMap::terrain(*seed, POINTS),
        HeightSource::File(path) => {
            let picture = read_picture(folder.locate(path)?, &folder.options.read.limits)?;
            let (width, height) = (picture.width as usize, picture.height as usize);
            // Rows of pictures go down, those of a map along y.
            let row = |y: usize| &picture.pixels[(height - 1 - y) * width..][..width];
            let mean = |[r, g, b, _]: &[f32; 4]| (r + g + b) / 3.0;
            let heights = (0..height).flat_map(|y| row(y).iter().map(mean)).collect();
            HeightMap::new([width, height], heights).map_err(failed)?
        }
    };
    let footprint = (0..2).map(|axis| map.dims()[axis] as f64 / land.dims[axis] as f64).fold(f64::INFINITY, f64::min);
    let map = map.for_footprint(footprint).scaled(land.relief as f32);
    HeightField::new(map, land.slab, land.ramp, Ramp::Inside).map_err(failed)
}

fn baked(volume: usize, field: &dyn ScalarField, dims: [usize; 3], voxel_type: VoxelType) -> Result<Volume, LoadError> {
    let failed = |source| LoadError::Sample { volume, source };
    let bytes = Grid::new(dims).map_err(failed)?.len() * voxel_type.size();
    // An allocation that fails within would end the program: ask first.
    memory::afford(bytes).map_err(|_| LoadError::Memory { volume, bytes })?;
    closed_form::sample_field(field, dims, voxel_type).map_err(failed)
}
