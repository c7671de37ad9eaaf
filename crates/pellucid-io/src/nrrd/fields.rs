//! The header as it stands: fields, key/value pairs and where the data are.

use std::collections::HashMap;

use pellucid_field::Warning;

use crate::IoError;
use crate::file_names::FileNames;
use crate::header::{Field, Lines};
use crate::payload::Parts;
use crate::source::Source;

/// Every field of the format; other spellings only leave out spaces.
const FIELDS: [&str; 30] = [
    "dimension",
    "type",
    "block size",
    "encoding",
    "endian",
    "content",
    "min",
    "max",
    "old min",
    "old max",
    "data file",
    "line skip",
    "byte skip",
    "number",
    "sample units",
    "sizes",
    "spacings",
    "thicknesses",
    "axis mins",
    "axis maxs",
    "centers",
    "labels",
    "units",
    "kinds",
    "space",
    "space dimension",
    "space units",
    "space origin",
    "space directions",
    "measurement frame",
];

/// A parsed header.
pub(super) struct NrrdHeader<'a> {
    pub source: &'a Source,
    fields: HashMap<&'static str, String>,
    keys: HashMap<String, String>,
    /// Files named line by line after `data file: LIST`.
    list: Option<FileNames>,
    /// Where attached data begin, if the header ends before the file does.
    data: Option<u64>,
}

impl<'a> NrrdHeader<'a> {
    pub fn parse(source: &'a Source, head: &[u8], warnings: &mut Vec<Warning>) -> Result<Self, IoError> {
        let path = &source.path;
        let mut lines = Lines::new(source, head);
        let magic = lines.next_line()?.unwrap_or_default();
        let version = magic.trim_end().strip_prefix("NRRD").unwrap_or_default();
        if !matches!(version, "0001" | "0002" | "0003" | "0004" | "0005" | "00.01") {
            return Err(IoError::malformed(path, "magic", &magic, "NRRD0001 to NRRD0005"));
        }
        let mut header = Self { source, fields: HashMap::new(), keys: HashMap::new(), list: None, data: None };
        while let Some(line) = lines.next_line()? {
            if line.is_empty() {
                header.data = Some(lines.position() as u64);
                break;
            }
            if line.starts_with('#') {
                continue;
            }
            let Some((name, value)) = line.split_once(':') else {
                return Err(IoError::malformed(path, "header line", &line, "'field: value' or 'key:=value'"));
            };
            if let Some(value) = value.strip_prefix('=') {
                header.keys.insert(name.trim().to_owned(), value.to_owned());
                continue;
            }
            let value = value.trim();
            match canonical(name) {
                Some("data file") if value.split_whitespace().next() == Some("LIST") => {
                    let mut files = Vec::new();
                    while let Some(name) = lines.next_line()? {
                        if !name.trim().is_empty() {
                            files.push(name.trim().to_owned());
                        }
                    }
                    header.list = Some(FileNames::listed(path, files)?);
                    break;
                }
                Some(field) => {
                    if header.fields.insert(field, value.to_owned()).is_some() {
                        return Err(IoError::malformed(path, field, value, "only once"));
                    }
                }
                None => warnings.push(Warning::File(format!("the unknown field '{}' is ignored", name.trim()))),
            }
        }
        Ok(header)
    }

    /// A field, if it is there.
    pub fn get(&self, name: &'static str) -> Option<Field<'_>> {
        self.fields.get(name).map(|text| Field { path: &self.source.path, name, text })
    }

    /// A field that must be there.
    pub fn require(&self, name: &'static str, expected: &'static str) -> Result<Field<'_>, IoError> {
        self.get(name).ok_or_else(|| IoError::Missing { path: self.source.path.clone(), field: name, expected })
    }

    /// The value of a key.
    pub fn key(&self, key: &'static str) -> Option<Field<'_>> {
        self.keys.get(key).map(|text| Field { path: &self.source.path, name: key, text })
    }

    /// Where the data are.
    pub fn take_parts(&mut self) -> Result<Parts, IoError> {
        if let Some(list) = self.list.take() {
            return Ok(Parts::Files(list));
        }
        if let Some(field) = self.get("data file") {
            return FileNames::parse(&field).map(Parts::Files);
        }
        match self.data {
            Some(offset) => Ok(Parts::Attached(self.source.clone(), offset)),
            None => Err(IoError::Missing {
                path: self.source.path.clone(),
                field: "data file",
                expected: "the name of a file, or an empty line and the data after the header",
            }),
        }
    }
}

/// The official spelling of a field's name.
fn canonical(name: &str) -> Option<&'static str> {
    let plain = |name: &str| name.replace(' ', "").to_lowercase();
    let name = plain(name);
    let name = if name == "centerings" { "centers" } else { &name };
    FIELDS.into_iter().find(|field| plain(field) == name)
}
