//! What a header says of a volume.

use std::path::Path;

use glam::DAffine3;
use pellucid_field::{ValueMap, Warning};

use crate::payload::Payload;
use crate::{IoError, ReadOptions};

/// What a header says.
pub(crate) struct Description {
    pub dims: [usize; 3],
    pub world_from_index: DAffine3,
    pub components: usize,
    pub text: Option<String>,
    pub value_map: ValueMap,
    pub value_unit: Option<String>,
    pub length_unit: Option<String>,
    pub is_anatomical: bool,
    pub payload: Payload,
    pub warnings: Vec<Warning>,
}

/// Checks the time point a caller asks for, and warns of those that are not read.
pub(crate) fn choose_time(
    path: &Path,
    frames: u64,
    options: &ReadOptions,
    warnings: &mut Vec<Warning>,
) -> Result<u64, IoError> {
    let time = options.time as u64;
    if time >= frames {
        let advice = format!("the file has {frames}, counted from 0");
        return Err(IoError::unsupported(path, "time point", time, advice));
    }
    if frames > 1 {
        warnings.push(Warning::File(format!("{frames} time points: only number {time}, counted from 0, is read")));
    }
    Ok(time)
}
