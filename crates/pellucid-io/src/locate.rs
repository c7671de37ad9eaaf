//! Which files a document may name.

use std::path::{Component, Path, PathBuf, absolute};

use crate::IoError;

/// The file that a document in `folder` (empty for the current one) means by `name`.
///
/// Documents come from elsewhere, and what they name is read and drawn: unless `outside` allows more, they may name
/// what lies in their own folder and below. Absolute names, `..` and symbolic links are followed, and must not leave it.
/// (Whoever can change the folder while it is read can also put there what he likes.)
///
/// # Errors
/// [`IoError::Outside`], which does not tell whether there is such a file, and [`IoError::Io`].
pub fn locate(folder: impl AsRef<Path>, name: impl AsRef<Path>, outside: bool) -> Result<PathBuf, IoError> {
    let (folder, name) = (folder.as_ref(), name.as_ref());
    let path = folder.join(name);
    if outside {
        return Ok(path);
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let home = folder.canonicalize().map_err(IoError::io(folder))?;
    let refused = || IoError::Outside { path: path.clone(), folder: folder.to_owned() };
    match path.canonicalize() {
        Ok(real) if real.starts_with(&home) => Ok(path),
        Err(error) if stays(name) || (is_plain(name) && absolute(folder).is_ok_and(|home| name.starts_with(home))) => {
            Err(IoError::io(&path)(error))
        }
        _ => Err(refused()),
    }
}

/// Whether a name, by its letters alone, leads nowhere but down.
fn stays(name: &Path) -> bool {
    is_plain(name) && name.is_relative()
}

fn is_plain(name: &Path) -> bool {
    name.components().all(|part| !matches!(part, Component::ParentDir))
}
