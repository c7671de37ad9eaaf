//! Why a picture is empty: the cause by its name, with what was found and what there is.

use std::fmt::Display;

use glam::DVec3;
use pellucid_field::{Grid, Short};
use pellucid_optics::{DataRange, Table, Visibility};

use crate::{Crop, Frame, Mode, RenderWarning, Slice, Stage, StageVolume};

impl RenderWarning {
    /// The picture of a stage is empty although this many rays met the volume.
    pub fn empty(stage: &Stage, rays_hit: u64) -> Self {
        Self::Empty { reason: stage.why_empty(rays_hit) }
    }
}

impl Stage {
    /// Whether nothing of a frame reaches half a step of 8 bits.
    pub fn is_too_faint(&self, frame: &Frame) -> bool {
        const FAINT: f32 = 0.5 / 255.0;
        !frame.color.iter().any(|pixel| pixel.iter().any(|channel| *channel >= FAINT))
    }

    /// Why nothing is in the picture, although this many rays met the volume.
    pub fn why_empty(&self, rays_hit: u64) -> String {
        let causes = self.volumes.iter().enumerate().find_map(|(k, volume)| self.cause(k, volume, rays_hit));
        causes.unwrap_or_else(|| "no sample that a ray meets has opacity; look at the transfer function".to_owned())
    }

    fn cause(&self, k: usize, volume: &StageVolume, rays_hit: u64) -> Option<String> {
        let (grid, statistics) = (volume.volume.grid(), volume.volume.statistics());
        if statistics.finite == 0 {
            let absent = statistics.nan + statistics.infinite;
            return Some(format!("the volume holds no value: all {absent} are NaN or infinite"));
        }
        let left = volume.region.corners_in(grid);
        if left.is_empty() {
            return Some(nothing_left(volume, grid));
        }
        if let Mode::Slice(slice) = self.mode()
            && let Some(cause) = self.slice_outside(volume, slice, &left)
        {
            return Some(cause);
        }
        if rays_hit == 0 {
            return Some(self.looks_elsewhere(&left));
        }
        let unit = volume.volume.value_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        // What users see counts from 0.
        let told = |value: f64| Short(value + volume.origin);
        let range = format!("{} to {}{unit}", told(statistics.min), told(statistics.max));
        if let Mode::Isosurface(surfaces) = self.mode() {
            let within = |value: f64| (statistics.min..=statistics.max).contains(&value);
            if !surfaces.isovalues.iter().any(|iso| within(iso.value)) {
                let values = list(surfaces.isovalues.iter().map(|iso| told(iso.value)));
                return Some(format!("the isovalue {values} is not in the data's range, {range}"));
            }
            if surfaces.isovalues.iter().all(|iso| iso.opacity == 0.0 || !within(iso.value)) {
                return Some("no isovalue in the data's range has an opacity above 0".to_owned());
            }
            return Some("the surfaces of the isovalues lie where no ray looks, or in what is clipped away".to_owned());
        }
        let table = Table::for_data(&volume.transfer_function, &DataRange::of(&volume.volume)).ok()?;
        let most = Visibility::of_table(&table).max_opacity(statistics.min as f32, statistics.max as f32);
        if most == 0.0 {
            let seen = volume.transfer_function.opacities().iter().filter(|point| point.opacity > 0.0);
            let seen: Vec<f64> = seen.map(|point| point.value).collect();
            let has = match (seen.first(), seen.last()) {
                (Some(first), Some(last)) => format!("it has some around {} to {}", told(*first), told(*last)),
                _ => "it has none anywhere".to_owned(),
            };
            return Some(format!(
                "the transfer function has no opacity over the data's range, {range}: {has}; volumes[{k}].window, preset \
                 or opacity change that"
            ));
        }
        let (low, high) = grid.world_bounds();
        let (unit, length) = (volume.unit_distance(), (high - low).length());
        let total = 1.0 - (1.0 - f64::from(most)).powf(length / unit);
        (total < 0.05).then(|| {
            format!(
                "opacities hold for a unit distance of {}, and no ray is longer than {} in the volume, which makes an \
                 opacity of {} at most: volumes[{k}].unit_distance sets a smaller one",
                Short(unit),
                Short(length),
                Short(total)
            )
        })
    }

    fn slice_outside(&self, volume: &StageVolume, slice: &Slice, left: &[DVec3]) -> Option<String> {
        let (point, normal) = self.slice_plane(volume, slice);
        let (low, high) = extent(left, normal);
        let (at, half) = (point.dot(normal), slice.thickness / 2.0);
        let outside = at + half < low || at - half > high;
        outside.then(|| {
            format!(
                "the slice passes outside of the volume: it is at {} along its normal ({}), and what is left of the \
                 volume spans {} to {}",
                Short(at),
                list(normal.to_array().map(Short)),
                Short(low),
                Short(high)
            )
        })
    }

    fn looks_elsewhere(&self, left: &[DVec3]) -> String {
        let view = &self.viewpoint;
        let middle = left.iter().sum::<DVec3>() / left.len() as f64;
        let where_it_is = match extent(left, view.forward).1 < view.eye.dot(view.forward) {
            true => "behind the eye",
            false => "beside the picture",
        };
        format!(
            "the camera points elsewhere: the volume, around ({}), lies {where_it_is}, which looks from ({}) at ({})",
            list(middle.to_array().map(Short)),
            list(view.eye.to_array().map(Short)),
            list(view.target.to_array().map(Short))
        )
    }
}

/// What cuts all of the volume away.
fn nothing_left(volume: &StageVolume, grid: &Grid) -> String {
    let outside = |crop: &Crop| {
        let (low, high) = grid.index_bounds();
        (0..3).any(|axis| crop.to[axis] <= low[axis] || crop.from[axis] >= high[axis])
    };
    if let Some(crop) = volume.crop.filter(|crop| outside(crop)) {
        return format!(
            "the crop, voxels ({}) to ({}), lies outside of the volume, whose voxels are (0, 0, 0) to ({})",
            list(crop.from.map(Short)),
            list(crop.to.map(Short)),
            list(grid.dims().map(|n| n - 1))
        );
    }
    let (low, high) = grid.world_bounds();
    format!(
        "the clips{} leave nothing of the volume, which spans ({}) to ({})",
        if volume.crop.is_some() { " and the crop" } else { "" },
        list(low.to_array().map(Short)),
        list(high.to_array().map(Short))
    )
}

/// The least and the largest coordinate of points along a direction.
fn extent(points: &[DVec3], direction: DVec3) -> (f64, f64) {
    let along = points.iter().map(|point| point.dot(direction));
    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)))
}

fn list(items: impl IntoIterator<Item = impl Display>) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<_>>().join(", ")
}
