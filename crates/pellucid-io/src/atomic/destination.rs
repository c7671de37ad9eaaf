//! What a new file takes the place of.

use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Where a file is to appear.
#[derive(Debug)]
pub struct Destination {
    /// As the caller names it.
    pub named: PathBuf,
    /// Where symbolic links lead from there.
    pub target: PathBuf,
    /// The regular file that is there now.
    existing: Option<Metadata>,
}

impl Destination {
    /// Follows a name to the place where a file would be.
    pub fn of(named: &Path) -> io::Result<Self> {
        /// As many as Linux follows.
        const MOST_LINKS: usize = 40;
        let mut target = named.to_owned();
        for _ in 0..=MOST_LINKS {
            let found = match fs::symlink_metadata(&target) {
                Err(error) if error.kind() == ErrorKind::NotFound => None,
                Err(error) => return Err(error),
                Ok(found) if found.is_symlink() => {
                    let to = fs::read_link(&target)?;
                    target = target.parent().unwrap_or(Path::new("")).join(to);
                    continue;
                }
                Ok(found) if found.is_dir() => return Err(refused("a folder has this name")),
                Ok(found) if !found.is_file() => return Err(refused("not a regular file")),
                Ok(found) => Some(found),
            };
            if target.file_name().is_none() {
                return Err(refused("not the name of a file"));
            }
            return Ok(Self { named: named.to_owned(), target, existing: found });
        }
        Err(refused("too many symbolic links"))
    }

    /// What a temporary file may not exceed while it is written: whoever cannot read the old content
    /// cannot read the new one.
    #[cfg(unix)]
    pub fn mode(&self) -> u32 {
        use std::os::unix::fs::PermissionsExt;
        // Less what the user's mask takes away.
        self.existing.as_ref().map_or(0o666, |existing| existing.permissions().mode() & 0o700)
    }

    /// Gives a file the owner and the permissions of the one that it replaces.
    #[cfg(unix)]
    pub fn dress(&self, file: &File) -> io::Result<()> {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
        let Some(existing) = &self.existing else { return Ok(()) };
        let mut mode = existing.permissions().mode() & 0o777;
        // Nobody but an administrator gives files away.
        let _ = fchown(file, Some(existing.uid()), None);
        if fchown(file, None, Some(existing.gid())).is_err() {
            // What a group was allowed is not for another one, which gets what all others have.
            mode = (mode & !0o070) | ((mode & 0o007) << 3);
        }
        file.set_permissions(fs::Permissions::from_mode(mode))
    }

    /// Gives a file the permissions of the one that it replaces.
    #[cfg(not(unix))]
    pub fn dress(&self, file: &File) -> io::Result<()> {
        self.existing.as_ref().map_or(Ok(()), |existing| file.set_permissions(existing.permissions()))
    }
}

fn refused(why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, why)
}
