//! From stored bytes to voxels: mapping, byte order, narrowing of 64-bit types, planar components.

use std::cell::Cell;

use bytemuck::cast_slice_mut;
use half::f16;
use pellucid_field::{Voxel, VoxelType, Voxels, Warning, memory};

use crate::payload::Payload;
use crate::stream::Stream;
use crate::{IoError, ReadOptions, StoredType};

/// Bytes decoded at a time; memory is touched only as data arrive.
const STEP: usize = 1 << 22;

/// The voxels of a payload, and a warning if they had to change type; and what they count from, which has to be
/// added to each.
pub(crate) fn voxels(
    payload: &Payload,
    options: &ReadOptions,
    warnings: &mut Vec<Warning>,
) -> Result<(Voxels, f64), IoError> {
    payload.check(&options.limits)?;
    let voxels = match payload.stored {
        StoredType::Voxel(VoxelType::U8) => kept::<u8>(payload, options, warnings),
        StoredType::Voxel(VoxelType::I8) => kept::<i8>(payload, options, warnings),
        StoredType::Voxel(VoxelType::U16) => kept::<u16>(payload, options, warnings),
        StoredType::Voxel(VoxelType::I16) => kept::<i16>(payload, options, warnings),
        StoredType::Voxel(VoxelType::U32) => kept::<u32>(payload, options, warnings),
        StoredType::Voxel(VoxelType::I32) => kept::<i32>(payload, options, warnings),
        StoredType::Voxel(VoxelType::F16) => kept::<f16>(payload, options, warnings),
        StoredType::Voxel(VoxelType::F32) => kept::<f32>(payload, options, warnings),
        StoredType::F64 => return single_precision(payload, options, warnings),
        StoredType::I64 => {
            return narrowed_integers(payload, options, |bytes| i64::from_ne_bytes(bytes).into(), warnings);
        }
        StoredType::U64 => {
            return narrowed_integers(payload, options, |bytes| u64::from_ne_bytes(bytes).into(), warnings);
        }
    };
    Ok((voxels?, 0.0))
}

/// Values of a type that voxels have: mapped where possible, else decoded straight into their
/// final memory, which grows no faster than the files vouch for.
fn kept<T: Voxel>(payload: &Payload, options: &ReadOptions, warnings: &mut Vec<Warning>) -> Result<Voxels, IoError> {
    let count = payload.count as usize;
    let mut stream = Stream::new(payload, options, warnings);
    if let Some(buffer) = stream.map::<T>()? {
        return Ok(T::wrap(buffer));
    }
    let mut values: Vec<T> = Vec::new();
    while values.len() < count {
        if values.len() == values.capacity() {
            let vouched = stream.vouched()? as usize / size_of::<T>();
            // As much again as has arrived keeps the copies of a growing vector few.
            let room = vouched.max(values.len()).max(1).min(count - values.len());
            memory::reserve(&mut values, room).map_err(|_| out_of_memory(payload))?;
        }
        let start = values.len();
        let end = (start + STEP / size_of::<T>()).min(values.capacity()).min(count);
        values.resize(end, T::zeroed());
        stream.fill(cast_slice_mut(&mut values[start..]))?;
    }
    if payload.is_foreign() {
        swap_bytes(cast_slice_mut(&mut values), size_of::<T>());
    }
    Ok(interleaved(payload, values)?.into())
}

/// Doubles as singles; where these would lose what the values differ by, counted from the smallest of them.
fn single_precision(
    payload: &Payload,
    options: &ReadOptions,
    warnings: &mut Vec<Warning>,
) -> Result<(Voxels, f64), IoError> {
    /// The largest error that is left, as a share of the range: that of singles that fill it.
    const LOST: f64 = 1.0 / (1u32 << 22) as f64;
    let (low, high, most) = (Cell::new(f64::INFINITY), Cell::new(f64::NEG_INFINITY), Cell::new(0f64));
    let from = |base: f64| {
        let (low, high, most) = (&low, &high, &most);
        move |bytes: [u8; 8]| {
            let value = f64::from_ne_bytes(bytes);
            let kept = (value - base) as f32;
            if !value.is_finite() {
                return (kept, 0.0);
            }
            let error = (value - (base + f64::from(kept))).abs();
            low.set(low.get().min(value));
            high.set(high.get().max(value));
            most.set(most.get().max(error));
            (kept, error)
        }
    };
    let so_far = warnings.len();
    let voxels = narrowed(payload, options, warnings, from(0.0))?;
    let (base, high) = (low.get(), high.get());
    // A single value differs from nothing.
    if high <= base || most.get() <= (high - base) * LOST {
        return Ok((voxels, 0.0));
    }
    drop(voxels);
    warnings.truncate(so_far);
    Ok((narrowed(payload, options, warnings, from(base))?, base))
}

/// 64-bit integers as the first of `i32`, `u32`, `u32` counted from their smallest, and `f32` that holds them all;
/// decoded twice, once for their range, so that they never lie in memory at full width.
fn narrowed_integers(
    payload: &Payload,
    options: &ReadOptions,
    integer: fn([u8; 8]) -> i128,
    warnings: &mut Vec<Warning>,
) -> Result<(Voxels, f64), IoError> {
    let (mut low, mut high) = (i128::MAX, i128::MIN);
    for_each_chunk(payload, options, &mut Vec::new(), |chunk| {
        for &bytes in chunk {
            low = low.min(integer(bytes));
            high = high.max(integer(bytes));
        }
        Ok(())
    })?;
    if low >= i32::MIN.into() && high <= i32::MAX.into() {
        return Ok((narrowed(payload, options, warnings, |bytes| (integer(bytes) as i32, 0.0))?, 0.0));
    }
    if low >= 0 && high <= u32::MAX.into() {
        return Ok((narrowed(payload, options, warnings, |bytes| (integer(bytes) as u32, 0.0))?, 0.0));
    }
    // A number that data values, which are `f64`, can have.
    let mut base = low as f64;
    if base as i128 > low {
        base = base.next_down();
    }
    let from = base as i128;
    if high - from <= u32::MAX.into() {
        let voxels = narrowed(payload, options, warnings, |bytes| {
            let kept = (integer(bytes) - from) as u32;
            let value = (base + f64::from(kept)) as i128;
            (kept, (value - integer(bytes)).abs() as f64)
        })?;
        return Ok((voxels, base));
    }
    let voxels = narrowed(payload, options, warnings, |bytes| {
        let value = integer(bytes);
        let kept = value as f32;
        (kept, (value - kept as i128).abs() as f64)
    })?;
    Ok((voxels, 0.0))
}

/// 64-bit values in a smaller type; `narrow` tells the new value and how far it is off.
fn narrowed<T: Voxel>(
    payload: &Payload,
    options: &ReadOptions,
    warnings: &mut Vec<Warning>,
    narrow: impl Fn([u8; 8]) -> (T, f64),
) -> Result<Voxels, IoError> {
    let mut values: Vec<T> = Vec::new();
    let mut largest_error = 0f64;
    for_each_chunk(payload, options, warnings, |chunk| {
        if values.capacity() - values.len() < chunk.len() {
            // As much again, as vectors grow by themselves.
            let more = values.len().max(chunk.len());
            memory::reserve(&mut values, more).map_err(|_| out_of_memory(payload))?;
        }
        for &bytes in chunk {
            let (value, error) = narrow(bytes);
            largest_error = largest_error.max(error);
            values.push(value);
        }
        Ok(())
    })?;
    warnings.push(Warning::Converted { from: payload.stored.name().to_owned(), to: T::TYPE, largest_error });
    Ok(interleaved(payload, values)?.into())
}

/// Decodes 64-bit values, a few thousand at a time, in native order.
fn for_each_chunk(
    payload: &Payload,
    options: &ReadOptions,
    warnings: &mut Vec<Warning>,
    mut visit: impl FnMut(&[[u8; 8]]) -> Result<(), IoError>,
) -> Result<(), IoError> {
    let mut buffer = vec![[0; 8]; 1 << 13];
    let mut stream = Stream::new(payload, options, warnings);
    loop {
        let bytes: &mut [u8] = cast_slice_mut(&mut buffer);
        let n = stream.fill(bytes)?;
        if n == 0 {
            return Ok(());
        }
        if payload.is_foreign() {
            swap_bytes(&mut bytes[..n], 8);
        }
        visit(&buffer[..n / 8])?;
    }
}

fn swap_bytes(bytes: &mut [u8], size: usize) {
    match size {
        2 => cast_slice_mut::<u8, [u8; 2]>(bytes).iter_mut().for_each(|value| value.reverse()),
        4 => cast_slice_mut::<u8, [u8; 4]>(bytes).iter_mut().for_each(|value| value.reverse()),
        8 => cast_slice_mut::<u8, [u8; 8]>(bytes).iter_mut().for_each(|value| value.reverse()),
        _ => {}
    }
}

/// Brings components that lie one whole grid after the other together at each voxel.
fn interleaved<T: Voxel>(payload: &Payload, planar: Vec<T>) -> Result<Vec<T>, IoError> {
    if payload.planes == 1 {
        return Ok(planar);
    }
    let mut values = Vec::new();
    memory::reserve(&mut values, planar.len()).map_err(|_| out_of_memory(payload))?;
    let voxels = planar.len() / payload.planes;
    values.extend((0..voxels).flat_map(|voxel| planar[voxel..].iter().step_by(voxels).copied()));
    Ok(values)
}

fn out_of_memory(payload: &Payload) -> IoError {
    IoError::Memory { path: payload.header.clone(), bytes: payload.frame_bytes() }
}
