//! Small valid files of every format and encoding.

use std::io::{Read, Write};
use std::path::Path;

use pellucid_io::{PngPixels, Transfer, write_exr, write_png};

use super::gzip;
use super::mutate::{Random, Seed, mutate};
use super::nifti::Header;

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

/// Pictures of every kind, in `folder`.
pub fn pictures(folder: &Path) -> Vec<Seed> {
    use png::{BitDepth, ColorType};
    let path = |name: &str| folder.join(name);
    let bytes: Vec<u8> = (0..192).collect();
    let words: Vec<u16> = (0..256).map(|k| k * 257).collect();
    let light: Vec<f32> = (0..64).map(|k| k as f32 / 7.0).collect();
    write_png(path("rgb.png"), 8, 8, PngPixels::U8(&bytes), Transfer::Srgb).unwrap();
    write_png(path("rgba.png"), 8, 8, PngPixels::U16(&words), Transfer::Linear).unwrap();
    for (name, color, depth) in [
        ("grey1.png", ColorType::Grayscale, BitDepth::One),
        ("alpha.png", ColorType::GrayscaleAlpha, BitDepth::Eight),
        ("palette2.png", ColorType::Indexed, BitDepth::Two),
        ("palette8.png", ColorType::Indexed, BitDepth::Eight),
    ] {
        let mut encoder = png::Encoder::new(std::fs::File::create(path(name)).unwrap(), 8, 8);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette((0..12).map(|k| k * 20).collect::<Vec<u8>>());
            encoder.set_trns(vec![102, 7]);
        }
        let data = vec![0; 8 * color.samples() * depth as usize];
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
    }
    write_exr(path("rgb.exr"), 8, 8, &[("R", &light), ("G", &light), ("B", &light)]).unwrap();
    write_exr(path("more.exr"), 8, 8, &[("A", &light), ("B", &light), ("G", &light), ("R", &light), ("Z", &light)])
        .unwrap();
    let names =
        ["rgb.png", "rgba.png", "grey1.png", "alpha.png", "palette2.png", "palette8.png", "rgb.exr", "more.exr"];
    let mut seeds: Vec<Seed> =
        names.into_iter().map(|name| Seed { path: path(name), bytes: std::fs::read(path(name)).unwrap() }).collect();
    for compression in ["rle", "zip1", "piz", "pxr24", "b44", "tiles"] {
        let name = path(&format!("{compression}.exr"));
        compressed_exr(&name, compression);
        seeds.push(Seed { bytes: std::fs::read(&name).unwrap(), path: name });
    }
    seeds
}

fn compressed_exr(path: &Path, compression: &str) {
    use exr::prelude::{Blocks, Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage, f16};
    let pixel = |at: Vec2<usize>| (f16::from_f32(at.x() as f32), at.y() as f32, 0.5f32, f16::ONE);
    let mut image = Image::from_channels((8, 8), SpecificChannels::rgba(pixel));
    image.layer_data.encoding = Encoding {
        compression: match compression {
            "rle" => Compression::RLE,
            "piz" => Compression::PIZ,
            "pxr24" => Compression::PXR24,
            "b44" => Compression::B44,
            _ => Compression::ZIP1,
        },
        blocks: if compression == "tiles" { Blocks::Tiles(Vec2(4, 4)) } else { Blocks::ScanLines },
        line_order: LineOrder::Increasing,
    };
    image.write().to_file(path).unwrap();
}

/// Spoils a file, mostly behind the checks that would refuse it at once: what is inside if it is packed as a whole, and
/// the chunks of a PNG, whose checksums are made right.
pub fn spoil(seed: &Seed, others: &[Seed], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.bytes.clone();
    if random.below(4) == 0 {
        mutate(&mut bytes, others, random);
        return bytes;
    }
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut inner = Vec::new();
        flate2::read::GzDecoder::new(bytes.as_slice()).read_to_end(&mut inner).expect("a valid seed");
        mutate(&mut inner, others, random);
        return gzip(&inner);
    }
    if bytes.starts_with(b"\x89PNG") {
        return spoil_png(&bytes, others, random);
    }
    mutate(&mut bytes, others, random);
    bytes
}

fn spoil_png(bytes: &[u8], others: &[Seed], random: &mut Random) -> Vec<u8> {
    let mut chunks: Vec<([u8; 4], Vec<u8>)> = Vec::new();
    let mut rest = &bytes[8..];
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        chunks.push((after[..4].try_into().unwrap(), after[4..4 + length].to_vec()));
        rest = &after[8 + length..];
    }
    for _ in 0..=random.below(3) {
        let at = random.below(chunks.len());
        match random.below(8) {
            0 => drop(chunks.remove(at)),
            1 => chunks.insert(at, chunks[random.below(chunks.len())].clone()),
            2 => {
                const NAMES: [&[u8; 4]; 8] = [b"PLTE", b"tRNS", b"gAMA", b"IDAT", b"acTL", b"fcTL", b"fdAT", b"iCCP"];
                chunks[at].0 = *NAMES[random.below(NAMES.len())];
            }
            3 if chunks[at].0 == *b"IHDR" => {
                let (byte, value) = (random.below(13), [0, 1, 2, 3, 4, 6, 8, 16, 0x7f, 0xff][random.below(10)]);
                chunks[at].1.iter_mut().skip(byte).take(1).for_each(|old| *old = value);
            }
            4 if chunks[at].0 == *b"IDAT" => {
                let mut inner = Vec::new();
                let _ = flate2::read::ZlibDecoder::new(chunks[at].1.as_slice()).read_to_end(&mut inner);
                mutate(&mut inner, others, random);
                let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
                zlib.write_all(&inner).unwrap();
                chunks[at].1 = zlib.finish().unwrap();
            }
            _ => mutate(&mut chunks[at].1, others, random),
        }
        if chunks.is_empty() {
            break;
        }
    }
    let mut spoilt = bytes[..8].to_vec();
    for (name, body) in chunks {
        let mut checksum = flate2::Crc::new();
        checksum.update(&name);
        checksum.update(&body);
        spoilt.extend((body.len() as u32).to_be_bytes());
        spoilt.extend(name);
        spoilt.extend(body);
        spoilt.extend(checksum.sum().to_be_bytes());
    }
    spoilt
}
