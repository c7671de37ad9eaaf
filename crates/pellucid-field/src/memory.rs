//! Memory that may be refused.
//!
//! Large memory is asked for here, so that its lack is an error and no abort. [`is_attempt`] tells an allocator that
//! the caller of a request copes with a refusal; one that ends the program in good order where nobody does is a few
//! lines (the `pellucid` command has it).

use std::cell::Cell;

/// There is not so much memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{bytes} bytes do not fit into memory")]
pub struct OutOfMemory {
    /// Bytes asked for.
    pub bytes: u64,
}

thread_local! {
    // Without a destructor, it can be read where memory is allocated.
    static IS_ATTEMPT: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is asking for memory in this module.
pub fn is_attempt() -> bool {
    IS_ATTEMPT.get()
}

/// Makes room for `more` further values, and for no others.
///
/// # Errors
/// [`OutOfMemory`]; the values are what they were.
pub fn reserve<T>(values: &mut Vec<T>, more: usize) -> Result<(), OutOfMemory> {
    IS_ATTEMPT.set(true);
    let done = values.try_reserve_exact(more);
    IS_ATTEMPT.set(false);
    done.map_err(|_| OutOfMemory { bytes: (more as u64).saturating_mul(size_of::<T>() as u64) })
}

/// Copies values.
///
/// # Errors
/// [`OutOfMemory`].
pub fn copied<T: Copy>(values: &[T]) -> Result<Vec<T>, OutOfMemory> {
    let mut copy = Vec::new();
    reserve(&mut copy, values.len())?;
    copy.extend_from_slice(values);
    Ok(copy)
}

/// Asks for memory and gives it back: for work that takes so much in several pieces, or in code of others.
///
/// # Errors
/// [`OutOfMemory`].
pub fn afford(bytes: usize) -> Result<(), OutOfMemory> {
    reserve(&mut Vec::<u8>::new(), bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused() {
        let most = isize::MAX as usize;
        assert_eq!(afford(most), Err(OutOfMemory { bytes: most as u64 }));
        let mut values = vec![1u64];
        assert!(reserve(&mut values, usize::MAX).is_err() && values == [1]);
        reserve(&mut values, 1000).unwrap();
        assert!(values.capacity() > 1000);
        assert_eq!(copied(&[1, 2, 3]).unwrap(), [1, 2, 3]);
        assert!(!is_attempt());
    }
}
