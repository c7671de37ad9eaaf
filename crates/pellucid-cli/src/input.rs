//! What a picture is made of: a volume file, a scene, or a built-in field.

use std::convert::Infallible;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use pellucid::field::{Volume, VoxelType, Warning, closed_form, nearest};
use pellucid::io::{Format as VolumeFormat, Limits, Mapping, ReadOptions, read_text};
use pellucid::scene::{Format, SampleSource, Scene, Source};
use pellucid::{LoadError, LoadOptions, load_optics_with, load_with};

use super::failure::Failure;
use super::values;

/// The INPUT argument.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// `sample:NAME` or `sample:NAME@DIMS`: the text after the colon.
    Sample(String),
    /// A scene document.
    Scene(PathBuf, Format),
    /// A volume file.
    Volume(PathBuf),
}

impl FromStr for Input {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        if let Some(name) = text.strip_prefix("sample:") {
            return Ok(Self::Sample(name.to_owned()));
        }
        let path = PathBuf::from(text);
        Ok(Format::of(&path).map_or_else(|| Self::Volume(path.clone()), |format| Self::Scene(path.clone(), format)))
    }
}

/// As it was written on the command line.
impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sample(text) => write!(f, "sample:{text}"),
            Self::Scene(path, _) | Self::Volume(path) => path.display().fmt(f),
        }
    }
}

/// How a file without a header is laid out; `--dims` and `--type` also choose those of a sample.
#[derive(clap::Args, Debug, Default)]
#[command(next_help_heading = "Raw input")]
pub struct RawFlags {
    /// Voxels per axis, x (fastest in memory), y, z; also the resolution of a sample
    #[arg(long, value_name = "XxYxZ", value_parser = values::dims)]
    dims: Option<[usize; 3]>,
    /// Type of the values; also that of a sample
    #[arg(long = "type", value_name = "TYPE", value_parser = values::voxel_type())]
    voxel_type: Option<VoxelType>,
    /// Byte order of the values [default: little]
    #[arg(long, value_name = "ORDER", value_parser = ["little", "big"])]
    endian: Option<String>,
    /// Bytes before the first value. Without it the file must hold the values and nothing else
    #[arg(long, value_name = "BYTES")]
    skip: Option<u64>,
    /// Interleaved values per voxel, 1 to 4 [default: 1]
    #[arg(long, value_name = "N")]
    components: Option<usize>,
    #[command(flatten)]
    reading: ReadingFlags,
}

/// What files may name and cost, whatever they say.
#[derive(clap::Args, Debug, Default)]
#[command(next_help_heading = "Reading")]
struct ReadingFlags {
    /// Let scenes and headers name files outside of their own folder
    ///
    /// A scene, or the header of a volume, names files in its own folder and below; for one that you
    /// trust this lifts the limit. Files that the command line names may lie anywhere.
    #[arg(long)]
    allow_outside: bool,
    /// Most bytes that the values of a volume, or a picture, may unpack to; as 4000000, 300M or 8G
    /// [default: 512M, or 256 times what is stored]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    max_bytes: Option<u64>,
    /// Map plain files into memory instead of reading them
    ///
    /// That is quicker, and files may be larger than memory, but if another program shortens such a
    /// file meanwhile, the system ends this one.
    #[arg(long)]
    map: bool,
}

impl ReadingFlags {
    fn options(&self) -> ReadOptions {
        ReadOptions {
            outside: self.allow_outside,
            limits: Limits { bytes: self.max_bytes, ..Limits::default() },
            // SAFETY: that is what the user vouches for.
            map: self.map.then(|| unsafe { Mapping::new() }),
            ..ReadOptions::default()
        }
    }
}

/// A scene to begin with, and how the files are read that it names.
pub struct Base {
    /// The scene as it was given, or one of a single volume.
    pub scene: Scene,
    /// The folder of the scene's file, where relative paths start; empty for the current one.
    pub folder: PathBuf,
    read: ReadOptions,
    /// Whether the scene is a file, rather than what the command line says.
    is_document: bool,
}

impl Base {
    /// The volumes of this scene, or of what flags made of it.
    pub fn load(&self, scene: &Scene) -> Result<(Vec<Arc<Volume>>, Vec<Warning>), LoadError> {
        load_with(scene, &self.folder, &self.options(scene))
    }

    /// Reads what the optics of this scene, or of what flags made of it, name.
    pub fn load_optics(&self, scene: &mut Scene) -> Result<(), LoadError> {
        let options = self.options(scene);
        load_optics_with(scene, &self.folder, &options)
    }

    /// What the document does not name, the command line does.
    fn options(&self, scene: &Scene) -> LoadOptions {
        let files = |scene: &Scene| scene.clone().files_mut().into_iter().map(|file| file.clone()).collect();
        let (mut trusted, documents): (Vec<PathBuf>, Vec<PathBuf>) = (files(scene), files(&self.scene));
        trusted.retain(|file| !self.is_document || !documents.contains(file));
        LoadOptions { outside: self.read.outside, trusted, read: self.read.clone() }
    }
}

impl Input {
    /// Reads a scene, or makes one around a volume.
    pub fn open(&self, raw: &RawFlags) -> Result<Base, Failure> {
        let read = raw.reading.options();
        let here =
            |source| Base { scene: Scene::of(source), folder: PathBuf::new(), read: read.clone(), is_document: false };
        match self {
            Self::Sample(text) => {
                raw.only_for_files()?;
                let mut sample = parse_sample(text)?;
                sample.dims = raw.dims.or(sample.dims);
                sample.voxel_type = raw.voxel_type;
                Ok(here(Source::Sample(sample)))
            }
            Self::Volume(path) => {
                is_file(path)?;
                Ok(here(raw.source(path)?))
            }
            Self::Scene(path, format) => {
                raw.not_for_scenes()?;
                is_file(path)?;
                let text = read_text(path, &read.limits).map_err(LoadError::from)?;
                let scene = Scene::parse(&text, *format)
                    .map_err(|error| Failure::input(format_args!("{}: {error}", path.display())))
                    .map_err(|failure| failure.hint("'pellucid schema' prints every key a scene can have"))?;
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                Ok(Base { scene, folder, read, is_document: true })
            }
        }
    }
}

/// Refuses a name that is no file's, with what may be meant.
fn is_file(path: &Path) -> Result<(), Failure> {
    let named = path.display();
    if path.is_dir() {
        let mut files: Vec<String> = std::fs::read_dir(path)
            .map_err(Failure::reading(path))?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|file| VolumeFormat::from_extension(file).is_some() || Format::of(file).is_some())
            .map(|file| file.display().to_string())
            .collect();
        files.sort();
        let hint = match files.as_slice() {
            [] => {
                "name a volume file or a scene; slices of a series are read once another program has put them into one"
                    .to_owned()
            }
            [file] => format!("the file to draw in it is {file}"),
            [first, ..] => format!("name one of the {} files to draw in it, as {first}", files.len()),
        };
        return Err(Failure::input(format_args!("{named}: this is a folder, and a file is expected")).hint(hint));
    }
    match std::fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let name = path.to_string_lossy();
            let failure = Failure::reading(path)(error);
            Err(match nearest(&name, closed_form::names()) {
                Some(sample) => failure.hint(format!("'sample:{sample}' draws the built-in field of that name")),
                None => failure.hint("'sample:NAME' draws a built-in field; 'pellucid sample --list' lists them"),
            })
        }
        _ => Ok(()),
    }
}

/// `NAME` or `NAME@DIMS`.
fn parse_sample(text: &str) -> Result<SampleSource, Failure> {
    let (name, dims) = match text.split_once('@') {
        None => (text, None),
        Some((name, dims)) => {
            let dims = values::dims(dims).map_err(|error| Failure::input(format_args!("sample:{text}: {error}")))?;
            (name, Some(dims))
        }
    };
    Ok(SampleSource { name: name.to_owned(), dims, voxel_type: None })
}

impl RawFlags {
    fn source(&self, path: &Path) -> Result<Source, Failure> {
        match (self.dims, self.voxel_type) {
            (Some(dims), Some(voxel_type)) => Ok(Source::Raw {
                path: path.to_owned(),
                dims,
                voxel_type,
                components: self.components.unwrap_or(1),
                skip: self.skip.unwrap_or(0),
                big_endian: self.endian.as_deref() == Some("big"),
            }),
            (None, None) if self.layout_flag().is_none() => Ok(Source::File(path.to_owned())),
            _ => Err(Failure::input("a headerless file needs both --dims and --type")
                .hint("as in --dims 256x256x113 --type u16")),
        }
    }

    /// A flag that describes how values lie in a file.
    fn layout_flag(&self) -> Option<&'static str> {
        let given = [
            (self.endian.is_some(), "--endian"),
            (self.skip.is_some(), "--skip"),
            (self.components.is_some(), "--components"),
        ];
        given.into_iter().find_map(|(given, flag)| given.then_some(flag))
    }

    fn only_for_files(&self) -> Result<(), Failure> {
        match self.layout_flag() {
            Some(flag) => Err(Failure::input(format_args!("{flag} describes a headerless file, not a sample"))),
            None => Ok(()),
        }
    }

    fn not_for_scenes(&self) -> Result<(), Failure> {
        let dims = self.dims.map(|_| "--dims");
        match dims.or(self.voxel_type.map(|_| "--type")).or(self.layout_flag()) {
            Some(flag) => Err(Failure::input(format_args!("{flag} describes a volume, and the input is a scene"))
                .hint("--set volumes[0].source... changes the source of a scene's volume")),
            None => Ok(()),
        }
    }
}
