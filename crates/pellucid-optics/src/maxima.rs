//! Maxima over any run of numbers in constant time.

/// A sparse table of maxima over runs of 1, 2, 4, ... numbers, two of which cover any run.
#[derive(Clone, Debug)]
pub struct Maxima {
    /// `levels[level][i]` is the maximum of the 2^level numbers from i.
    levels: Vec<Vec<f32>>,
}

impl Maxima {
    /// Over these numbers, of which there is at least one.
    pub fn new(numbers: Vec<f32>) -> Self {
        let (count, mut levels, mut run) = (numbers.len(), vec![numbers], 1);
        while 2 * run <= count {
            let shorter = &levels[levels.len() - 1];
            levels.push(shorter.iter().zip(&shorter[run..]).map(|(a, b)| a.max(*b)).collect());
            run *= 2;
        }
        Self { levels }
    }

    /// The largest number from `first` to `last`, both included and in range.
    pub fn over(&self, first: usize, last: usize) -> f32 {
        let level = (last - first + 1).ilog2() as usize;
        let maxima = &self.levels[level];
        maxima[first].max(maxima[last + 1 - (1 << level)])
    }
}
