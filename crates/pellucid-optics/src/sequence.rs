//! Sequences of documents that have a fixed length.

use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, Expected, IgnoredAny, SeqAccess};

/// Reads a fixed number of elements and makes sure that they are all: some formats drop the rest
/// of a sequence without a word.
pub(crate) fn exactly<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(
    mut seq: A,
    length: usize,
    expected: &dyn Expected,
) -> Result<T, A::Error> {
    let elements = T::deserialize(SeqAccessDeserializer::new(&mut seq))?;
    match seq.next_element::<IgnoredAny>()? {
        None => Ok(elements),
        Some(_) => Err(A::Error::invalid_length(length + 1, expected)),
    }
}
