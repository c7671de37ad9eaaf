//! Opening files: regular ones only, without waiting for anybody.

use std::fs::{File, FileType, OpenOptions};
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

use crate::{IoError, Limits};

/// Opens a regular file for reading. Folders, pipes, sockets and devices are refused untouched: to open a pipe is to
/// wait for whoever writes into it, some devices act on being opened, and many never end.
///
/// # Errors
/// [`IoError::Io`].
pub fn open_regular(path: impl AsRef<Path>) -> Result<File, IoError> {
    let path = path.as_ref();
    open(path).map_err(IoError::io(path))
}

fn open(path: &Path) -> Result<File, Error> {
    check(std::fs::metadata(path)?.file_type())?;
    let mut options = OpenOptions::new();
    options.read(true);
    // By now the name may mean a pipe: it must not be waited for.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path)?;
    check(file.metadata()?.file_type())?;
    Ok(file)
}

fn check(kind: FileType) -> Result<(), Error> {
    if kind.is_file() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::InvalidInput, format!("{}, expected a regular file", name(kind))))
}

fn name(kind: FileType) -> &'static str {
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    "neither file nor folder"
}

/// Reads a text of at most `limits.text` bytes from a regular file.
///
/// # Errors
/// [`IoError::Io`], [`IoError::Limit`], and [`IoError::Damaged`] if it is not UTF-8.
pub fn read_text(path: impl AsRef<Path>, limits: &Limits) -> Result<String, IoError> {
    let path = path.as_ref();
    let file = open_regular(path)?;
    let stated = file.metadata().map_err(IoError::io(path))?.len();
    limits.check_text(path, stated)?;
    let mut bytes = Vec::new();
    // What a file says of its size need not hold: that of /proc/self/maps is 0.
    file.take(limits.text.saturating_add(1)).read_to_end(&mut bytes).map_err(IoError::io(path))?;
    limits.check_text(path, bytes.len() as u64)?;
    String::from_utf8(bytes).map_err(|error| {
        let reason = format!("byte {} is not UTF-8", error.utf8_error().valid_up_to());
        IoError::Damaged { path: path.to_owned(), encoding: "text", reason }
    })
}
