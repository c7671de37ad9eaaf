//! Pictures: what is written is what other decoders and this one read.

use std::path::{Path, PathBuf};

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use pellucid_io::{IoError, PngPixels, Transfer, read_exr, read_png, write_exr, write_png};

/// The chunks of a PNG by the letter of its specification: length, name, data, checksum.
fn chunks(path: &Path) -> Vec<(String, Vec<u8>)> {
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let (mut rest, mut chunks) = (&bytes[8..], Vec::new());
    while !rest.is_empty() {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        chunks.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + length].to_vec()));
        rest = &rest[12 + length..];
    }
    chunks
}

fn in_folder(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

#[test]
fn every_depth_and_channel_count_returns() {
    let (_folder, path) = in_folder("a.png");
    let (width, height) = (5, 7);
    for channels in [3, 4] {
        let bytes: Vec<u8> = (0..width * height * channels).map(|k| (k * 37 % 256) as u8).collect();
        let words: Vec<u16> = (0..width * height * channels).map(|k| (k * 7919 % 65536) as u16).collect();
        let with_alpha = |pixel: &[f32]| [pixel[0], pixel[1], pixel[2], pixel.get(3).copied().unwrap_or(1.0)];
        for (pixels, depth) in [(PngPixels::U8(&bytes), 8), (PngPixels::U16(&words), 16)] {
            for transfer in [Transfer::Srgb, Transfer::Linear] {
                write_png(&path, width, height, pixels, transfer).unwrap();
                let values: Vec<f32> = match pixels {
                    PngPixels::U8(values) => values.iter().map(|&value| f32::from(value) / 255.0).collect(),
                    PngPixels::U16(values) => values.iter().map(|&value| f32::from(value) / 65535.0).collect(),
                };
                let expected: Vec<[f32; 4]> = values.chunks(channels as usize).map(with_alpha).collect();
                let picture = read_png(&path).unwrap();
                assert_eq!((picture.width, picture.height, picture.transfer), (width, height, transfer));
                assert_eq!(picture.pixels, expected);

                let chunks = chunks(&path);
                let (name, header) = &chunks[0];
                assert_eq!(name, "IHDR");
                assert_eq!(header[..8], [0, 0, 0, 5, 0, 0, 0, 7]);
                assert_eq!(header[8..10], [depth, if channels == 3 { 2 } else { 6 }]);
                let find = |name: &str| chunks.iter().find(|chunk| chunk.0 == name).map(|chunk| chunk.1.clone());
                match transfer {
                    Transfer::Srgb => assert_eq!(find("sRGB"), Some(vec![1])),
                    // 1.0 in units of 1/100000.
                    Transfer::Linear => assert_eq!((find("sRGB"), find("gAMA")), (None, Some(vec![0, 1, 0x86, 0xa0]))),
                }
            }
        }
    }
}

#[test]
fn grey_palettes_and_small_depths_become_rgba() {
    use png::{BitDepth, ColorType};
    let (_folder, path) = in_folder("a.png");
    let read = |color, depth, data: &[u8]| {
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette(vec![10, 20, 30, 255, 0, 51]);
            encoder.set_trns(vec![102]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        read_png(&path).unwrap().pixels
    };
    assert_eq!(read(ColorType::Grayscale, BitDepth::One, &[0b0100_0000]), [[0.0, 0.0, 0.0, 1.0], [1.0; 4]]);
    assert_eq!(
        read(ColorType::GrayscaleAlpha, BitDepth::Sixteen, &[0, 0, 255, 255, 255, 255, 0, 0]),
        [[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 0.0]]
    );
    let of = |value: u8| f32::from(value) / 255.0;
    assert_eq!(
        read(ColorType::Indexed, BitDepth::Two, &[0b0001_0000]),
        [[of(10), of(20), of(30), of(102)], [1.0, 0.0, of(51), 1.0]]
    );
}

#[test]
fn wrong_sizes_and_hostile_files_are_errors() {
    let (folder, path) = in_folder("a.png");
    let error = write_png(&path, 3, 3, PngPixels::U8(&[0; 26]), Transfer::Srgb).unwrap_err();
    assert!(error.to_string().contains("26 values for a picture that needs 36 (3 x 3 x 4)"), "{error}");
    assert!(write_png(&path, 0, 3, PngPixels::U8(&[]), Transfer::Srgb).is_err());
    assert!(write_exr(&path, 2, 2, &[("R", &[0.0; 3])]).is_err());
    assert!(write_exr(&path, 2, 2, &[("R", &[0.0; 4]), ("R", &[0.0; 4])]).is_err());
    assert!(write_exr(&path, 2, 2, &[]).is_err());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "nothing is left");

    write_png(&path, 9, 5, PngPixels::U8(&[77; 9 * 5 * 3]), Transfer::Srgb).unwrap();
    let good = std::fs::read(&path).unwrap();
    for length in 0..good.len() - 12 {
        std::fs::write(&path, &good[..length]).unwrap();
        assert!(read_png(&path).is_err(), "cut to {length} of {}", good.len());
    }
    for at in 0..good.len() {
        let mut bad = good.clone();
        bad[at] ^= 0x55;
        std::fs::write(&path, &bad).unwrap();
        let _ = read_png(&path);
    }
    // 2^31 - 1 squared pixels, with the checksum made right by the decoder's own encoder.
    let mut lying = Vec::new();
    let mut encoder = png::Encoder::new(&mut lying, 60_000, 60_000);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, &[0x78, 1, 3, 0, 0, 0, 0, 1]).unwrap();
    drop(writer);
    std::fs::write(&path, &lying).unwrap();
    let error = read_png(&path).unwrap_err();
    assert!(matches!(error, IoError::Truncated { expected: 14_400_000_000, .. }), "{error}");
}

#[test]
fn exr_channels_return_bit_by_bit_under_their_names() {
    let (_folder, path) = in_folder("a.exr");
    let (width, height) = (7, 5);
    let channel = |seed: u32| -> Vec<f32> {
        let specials = [f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MAX, f32::MIN_POSITIVE / 4.0, 1e-3];
        (0..width * height).map(|k| specials.get(k as usize).copied().unwrap_or((k * seed) as f32 * 0.37)).collect()
    };
    let names = ["R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z"];
    let data: Vec<Vec<f32>> = (0..names.len() as u32).map(|k| channel(k + 1)).collect();
    let channels: Vec<(&str, &[f32])> = names.iter().copied().zip(data.iter().map(Vec::as_slice)).collect();
    write_exr(&path, width, height, &channels).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01]);
    let image = read_first_flat_layer_from_file(&path).unwrap();
    assert_eq!((image.layer_data.size.0, image.layer_data.size.1), (7, 5));
    for (name, expected) in channels {
        let found = image.layer_data.channel_data.list.iter().find(|channel| channel.name == *name).unwrap();
        let FlatSamples::F32(found) = &found.sample_data else { panic!("{name} is not 32-bit") };
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found), bits(expected), "{name}");
    }
}

#[test]
fn exr_colours_return_as_light() {
    let (_folder, path) = in_folder("a.exr");
    let channel = |factor: f32| (0..6).map(|k| k as f32 * factor).collect::<Vec<_>>();
    let [red, green, blue, alpha] = [1.0, 100.0, 0.01, 0.1].map(channel);
    write_exr(&path, 3, 2, &[("B", &blue), ("R", &red), ("G", &green), ("A", &alpha), ("Z", &red)]).unwrap();
    let picture = read_exr(&path).unwrap();
    assert_eq!((picture.width, picture.height, picture.transfer), (3, 2, Transfer::Linear));
    for (k, pixel) in picture.pixels.iter().enumerate() {
        assert_eq!(*pixel, [red[k], green[k], blue[k], alpha[k]]);
    }
    write_exr(&path, 3, 2, &[("R", &red), ("G", &green), ("B", &blue)]).unwrap();
    assert!(read_exr(&path).unwrap().pixels.iter().all(|pixel| pixel[3] == 1.0));
}

#[test]
fn broken_exrs_are_errors() {
    let (_folder, path) = in_folder("a.exr");
    let values = vec![0.5; 64 * 64];
    write_exr(&path, 64, 64, &[("Y", &values)]).unwrap();
    assert!(matches!(read_exr(&path), Err(IoError::Damaged { encoding: "EXR", .. })), "no colours");
    write_exr(&path, 64, 64, &[("R", &values), ("G", &values), ("B", &values)]).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in [0, 3, 8, 100, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(matches!(read_exr(&path), Err(IoError::Damaged { .. })), "{length} of {} bytes", whole.len());
    }
    // A header that claims more than can be: the data window's far corner.
    let window = whole.windows(10).position(|bytes| bytes == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
    let mut lying = whole.clone();
    lying[window + 8..window + 16].copy_from_slice(&[0xff, 0xff, 0x0f, 0, 0xff, 0xff, 0x0f, 0]);
    std::fs::write(&path, lying).unwrap();
    assert!(matches!(read_exr(&path), Err(IoError::Limit { setting: "bytes", .. })));
    assert!(matches!(read_exr(path.with_extension("none")), Err(IoError::Io { .. })));
}
