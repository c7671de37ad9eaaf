//! The bytes of a file: read as they are wanted, in memory, or mapped. The only module with `unsafe` code.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::lookahead::Lookahead;
use crate::{IoError, open_regular};

/// Shared bytes that decoders and mapped volumes keep alive.
pub(crate) type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Leave to map files into memory instead of reading them.
///
/// A mapped volume costs memory only where it is looked at, and takes about a fifth of the time to have (1 GiB that the
/// system has cached: 0.2 instead of 0.9 seconds), but it lives in its file: if another program shortens that file, the
/// system ends the process (SIGBUS), and if it writes into it, numbers change that Rust takes for constant. Files that
/// are replaced by a rename, as [`AtomicFile`](crate::AtomicFile) does, are safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mapping(());

impl Mapping {
    /// Vouches for the files to be read.
    ///
    /// # Safety
    /// No program may shorten or write into a file that is read with this leave as long as a volume made from it
    /// lives.
    pub unsafe fn new() -> Self {
        Self(())
    }

    fn map(self, file: &File) -> io::Result<Bytes> {
        // SAFETY: the map is private and read-only, and only ever viewed as plain bytes and numbers for which every
        // bit pattern is valid. That the file stays as it is was promised to `Mapping::new`.
        Ok(Arc::new(unsafe { memmap2::Mmap::map(file) }?))
    }
}

/// A file's name and content.
#[derive(Clone)]
pub(crate) struct Source {
    pub path: PathBuf,
    /// Bytes there were when it was opened.
    pub length: u64,
    content: Content,
}

#[derive(Clone)]
enum Content {
    File(Arc<File>),
    Memory(Bytes),
}

impl Source {
    /// Opens a regular file, and maps it with leave to do so.
    pub fn open(path: &Path, mapping: Option<Mapping>) -> Result<Self, IoError> {
        let file = open_regular(path)?;
        let length = file.metadata().map_err(IoError::io(path))?.len();
        let content = match mapping {
            Some(mapping) => Content::Memory(mapping.map(&file).map_err(IoError::io(path))?),
            None => Content::File(Arc::new(file)),
        };
        Ok(Self { path: path.to_owned(), length, content })
    }

    /// Bytes that are already in memory, under the name of the file they stand for.
    pub fn memory(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.to_owned(), length: bytes.len() as u64, content: Content::Memory(Arc::new(bytes)) }
    }

    /// The bytes from `start` on. There is one reader of a source at a time.
    pub fn reader(&self, start: u64) -> Result<Lookahead, IoError> {
        Ok(match &self.content {
            Content::File(file) => {
                (&**file).seek(SeekFrom::Start(start)).map_err(IoError::io(&self.path))?;
                Lookahead::new(Shared(Arc::clone(file)))
            }
            Content::Memory(bytes) => {
                let mut cursor = Cursor::new(View(Arc::clone(bytes)));
                cursor.set_position(start);
                Lookahead::new(cursor)
            }
        })
    }

    /// The first bytes, as many as there are up to `most`.
    pub fn head(&self, most: usize) -> Result<Vec<u8>, IoError> {
        let mut head = Vec::new();
        self.reader(0)?.take(most as u64).read_to_end(&mut head).map_err(IoError::io(&self.path))?;
        Ok(head)
    }

    /// All bytes, if they are in memory.
    pub fn shared(&self) -> Option<Bytes> {
        match &self.content {
            Content::File(_) => None,
            Content::Memory(bytes) => Some(Arc::clone(bytes)),
        }
    }
}

/// A file that several sources hold.
struct Shared(Arc<File>);

impl Read for Shared {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        (&*self.0).read(out)
    }
}

/// Bytes that several sources hold.
struct View(Bytes);

impl AsRef<[u8]> for View {
    fn as_ref(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}
