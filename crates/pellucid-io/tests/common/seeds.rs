//! Small valid files of every format and encoding, and ways to spoil them.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::gzip;
use super::nifti::Header;

/// A file to begin with.
pub struct Seed {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

/// Seeds whose names lie in `folder`, where the files that detached headers name are written.
pub fn seeds(folder: &Path) -> Vec<Seed> {
    let data: Vec<u8> = (0..48).collect();
    std::fs::write(folder.join("data.raw"), &data).unwrap();
    std::fs::write(folder.join("s0.raw"), &data[..24]).unwrap();
    std::fs::write(folder.join("s1.raw"), &data[24..]).unwrap();
    let attached = |header: &str, data: &[u8]| [header.as_bytes(), data].concat();
    let numbers: String = (0..24).rev().map(|value| format!("{value} ")).collect();
    let hex: String = data.iter().map(|byte| format!("{byte:02x}")).collect();
    let mut bzip2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    bzip2.write_all(&data).unwrap();
    let bzip2 = bzip2.finish().unwrap();
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    zlib.write_all(&data).unwrap();
    let zlib = zlib.finish().unwrap();

    let nrrd = |encoding: &str, data: &[u8]| {
        let header = format!(
            "NRRD0005\n# seed\ntype: short\ndimension: 3\nspace: RAS\nsizes: 4 3 2\n\
             space directions: (1,0,0) (0,1.5,0) (0,0,-2)\nkinds: domain domain domain\nendian: big\n\
             encoding: {encoding}\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\nvalue scale:=2\n\n"
        );
        attached(&header, data)
    };
    let series = "NRRD0004\ntype: double\ndimension: 4\nsizes: 1 2 1 3\nspacings: nan 1 2 3\naxis mins: nan 0 0 nan\n\
                  kinds: vector space space time\nencoding: raw\nendian: little\nold min: 0\nlabels: \"a\" \"b\" \"c\" \"d\"\n\n";
    let detached = "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\n";
    let meta = |tags: &str, data: &[u8]| {
        let header = format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n\
             DistanceUnits = mm\nElementSpacing = 1 2 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n{tags}"
        );
        attached(&header, data)
    };
    let rows = [[1.0, 0.0, 0.0, 5.0], [0.0, 2.0, 0.0, 6.0], [0.0, 0.0, 3.0, 7.0]];
    let nifti = |version, big| Header::new(version, big).dim(&[3, 4, 3, 2]).slope(2.0, 1.0);
    let wide = nifti(2, true).dim(&[5, 2, 1, 1, 1, 3]).datatype(1024, 64).qform(1, [0.5; 3], [1.0; 3]);
    [
        ("raw.nrrd", nrrd("raw", &data)),
        ("gzip.nrrd", nrrd("gzip", &gzip(&data))),
        ("bzip2.nrrd", nrrd("bzip2", &bzip2)),
        ("hex.nrrd", nrrd("hex", hex.as_bytes())),
        ("text.nrrd", nrrd("ascii", numbers.as_bytes())),
        ("series.nrrd", attached(series, &data)),
        ("single.nhdr", attached(detached, b"data file: data.raw\n")),
        ("list.nhdr", attached(detached, b"data file: LIST\ns0.raw\ns1.raw\n")),
        ("numbered.nhdr", attached(detached, b"data file: s%d.raw 0 1 1\n")),
        ("raw.mha", meta("ElementDataFile = LOCAL\n", &data)),
        ("zlib.mha", meta("CompressedData = True\nElementDataFile = LOCAL\n", &zlib)),
        ("list.mhd", meta("ElementDataFile = LIST\ns0.raw\ns1.raw\n", b"")),
        ("numbered.mhd", meta("HeaderSize = -1\nElementDataFile = s%01d.raw 0 1 1\n", b"")),
        ("one.nii", nifti(1, false).sform(1, rows).with(&data)),
        ("one.nii.gz", gzip(&nifti(1, true).qform(1, [0.1, 0.2, 0.3], [1.0; 3]).with(&data))),
        ("two.nii", wide.with(&data)),
    ]
    .into_iter()
    .map(|(name, bytes)| Seed { path: folder.join(name), bytes })
    .collect()
}

/// Small, fast and repeatable (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
}

/// Words that have broken readers before.
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "2",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-320",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "-9223372036854775808",
    "LIST",
    "LOCAL",
    "%d",
    "none",
    "(",
    ")",
    "\"",
    "\n\n",
    "=",
];

/// Spoils a file in one to four places.
pub fn mutate(bytes: &mut Vec<u8>, others: &[Seed], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(9) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            1 if !bytes.is_empty() => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b' ', b'\n'][random.below(7)],
            2 => bytes.truncate(at),
            3 => {
                let end = (at + random.below(32)).min(bytes.len());
                bytes.drain(at..end);
            }
            4 => {
                let end = (at + random.below(64)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            5 => {
                // A field of four bytes, as binary headers have them.
                let value = [0, 1, -1, i32::MAX, i32::MIN, 0x7f80_0000, 0x7fff][random.below(7)];
                let order = if random.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
                bytes.iter_mut().skip(at).zip(order).for_each(|(byte, new)| *byte = new);
            }
            6 => {
                let other = &others[random.below(others.len())].bytes;
                let from = random.below(other.len());
                let to = (from + random.below(64)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            _ => {
                // The word around the place becomes another.
                let is_edge = |byte: &u8| byte.is_ascii_whitespace() || b",()".contains(byte);
                let start = bytes[..at].iter().rposition(is_edge).map_or(0, |edge| edge + 1);
                let end = bytes[at..].iter().position(is_edge).map_or(bytes.len(), |edge| at + edge);
                bytes.splice(start..end, WORDS[random.below(WORDS.len())].bytes());
            }
        }
    }
}
