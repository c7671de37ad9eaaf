//! Writes the three central slices of a closed-form field, and its maximum along y, side by side
//! as a PGM picture for a person to look at:
//!
//! ```text
//! cargo run --release -p pellucid-field --example slices -- head head.pgm [LOW HIGH]
//! ```
//!
//! Black is LOW, white is HIGH (by default the range of the values). Seen from -y with +z up; the
//! z slice is seen from below with -y up, as radiologists do.

use std::error::Error;
use std::{env, fs};

use pellucid_field::closed_form::{by_name, names, sample_field};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let (name, path, window) = match &arguments[..] {
        [name, path] => (name, path, None),
        [name, path, low, high] => (name, path, Some((low.parse()?, high.parse()?))),
        _ => return Err("usage: slices FIELD FILE.pgm [LOW HIGH]".into()),
    };
    let field = by_name(name).ok_or_else(|| format!("no field {name}: {}", names().collect::<Vec<_>>().join(", ")))?;
    let about = field.about();
    let volume = sample_field(&*field, about.dims, about.voxel_type)?;
    let (low, high) = window.unwrap_or((volume.statistics().min, volume.statistics().max));
    let [nx, ny, nz] = about.dims;
    let value = |x: usize, y: usize, z: usize| volume.value([x, y, z], 0);
    let deepest = |x: usize, z: usize| (0..ny).map(|y| value(x, y, z)).fold(f64::NEG_INFINITY, f64::max);

    let (width, height) = (nx + ny + nx + nx, nz.max(ny));
    let mut picture = format!("P5 {width} {height} 255\n").into_bytes();
    for row in 0..height {
        let z = nz.checked_sub(row + 1);
        let coronal = (0..nx).map(|x| z.map(|z| value(x, ny / 2, z)));
        let sagittal = (0..ny).map(|y| z.map(|z| value(nx / 2, y, z)));
        let axial = (0..nx).map(|x| (row < ny).then(|| value(x, row, nz / 2)));
        let maximum = (0..nx).map(|x| z.map(|z| deepest(x, z)));
        picture.extend(
            coronal
                .chain(sagittal)
                .chain(axial)
                .chain(maximum)
                .map(|value| value.map_or(0, |value| ((value - low) / (high - low) * 255.0).clamp(0.0, 255.0) as u8)),
        );
    }
    fs::write(path, picture)?;
    println!("{name}: {} | {:?} {} | {:?}", about.description, about.dims, about.voxel_type, volume.statistics());
    Ok(())
}
