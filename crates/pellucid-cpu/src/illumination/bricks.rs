//! Light at the places of a lattice, in bricks that are there where a place was asked for (G-08, G-B2).

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering, fence};

use half::f16;
use pellucid_field::memory::{self, OutOfMemory};

/// Places per axis of a brick.
const SIDE: usize = 8;

/// What is known of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Nothing yet.
    Nothing,
    /// That no surface goes through it.
    Absent,
    /// The light that arrives there, linear RGB: all that its paths have found.
    Light([f32; 3]),
}

/// Red, green and blue, and what they are.
type LightOf = [AtomicU32; 4];

/// Coefficients of red, green and blue, one after the other.
type Numbers = Box<[f16]>;

/// Places of a brick.
const PLACES: usize = SIDE * SIDE * SIDE;

/// A brick's places, and how light far away becomes light there, of those of which that is known.
struct Brick {
    places: [LightOf; PLACES],
    transfers: Option<Box<[OnceLock<Numbers>; PLACES]>>,
}

impl Brick {
    fn new(transfers: bool) -> Box<Self> {
        let transfers = transfers.then(|| Box::new([const { OnceLock::new() }; PLACES]));
        Box::new(Self { places: [const { [const { AtomicU32::new(0) }; 4] }; PLACES], transfers })
    }
}

const NOTHING: u32 = 0;
const ABSENT: u32 = 1;
/// The first state of places whose light is known: further ones are those of other lights.
const LIGHT: u32 = 2;

/// The places of a lattice.
pub struct Bricks {
    /// Per axis.
    counts: [usize; 3],
    each: Vec<OnceLock<Box<Brick>>>,
    transfers: bool,
}

impl Bricks {
    /// Of a lattice with so many places per axis, nothing known of any; with what light far away becomes there, or without.
    ///
    /// # Errors
    /// [`OutOfMemory`] if there is no memory for the list of bricks.
    pub fn new(places: [usize; 3], transfers: bool) -> Result<Self, OutOfMemory> {
        let counts = places.map(|n| n.div_ceil(SIDE));
        let (mut each, count) = (Vec::new(), counts.iter().product());
        memory::reserve(&mut each, count)?;
        each.resize_with(count, OnceLock::new);
        Ok(Self { counts, each, transfers })
    }

    /// What is known of a place in the light of a number.
    pub fn get(&self, at: [usize; 3], number: u32) -> Known {
        let (brick, place) = self.locate(at);
        let Some(place) = self.each[brick].get().map(|brick| &brick.places[place]) else { return Known::Nothing };
        match place[3].load(Ordering::Acquire) {
            ABSENT => Known::Absent,
            state if state == LIGHT + number => {
                Known::Light([0, 1, 2].map(|c: usize| f32::from_bits(place[c].load(Ordering::Relaxed))))
            }
            _ => Known::Nothing,
        }
    }

    /// What is known of the light of a place, and the number of it; 0 where there is nothing.
    pub fn so_far(&self, at: [usize; 3]) -> (u32, [f32; 3]) {
        let (brick, place) = self.locate(at);
        let Some(place) = self.each[brick].get().map(|brick| &brick.places[place]) else { return (0, [0.0; 3]) };
        let before = place[3].load(Ordering::Acquire);
        let light = [0, 1, 2].map(|c: usize| f32::from_bits(place[c].load(Ordering::Relaxed)));
        // Nobody writes to it meanwhile if it says the same before and after.
        fence(Ordering::Acquire);
        let after = place[3].load(Ordering::Relaxed);
        if before == after && before > LIGHT { (before - LIGHT, light) } else { (0, [0.0; 3]) }
    }

    /// Of the eight places from one on, the light in that of a number, by shares of the way to the further ones, summed, and
    /// the sum of the shares of those where there is any; `None` where one is not known. Most places that are seen are asked
    /// for so.
    #[inline]
    pub fn around(&self, at: [usize; 3], t: [f32; 3], number: u32) -> Option<([f32; 3], f32)> {
        // Most are in one brick.
        let within = at.iter().all(|n| n % SIDE < SIDE - 1);
        let (brick, first) = self.locate(at);
        let places = &self.each[brick].get()?.places;
        let (mut sum, mut shares) = ([0.0; 3], 0.0);
        for corner in 0..8 {
            let further = [corner & 1, corner >> 1 & 1, corner >> 2];
            let share = |axis: usize| if further[axis] == 1 { t[axis] } else { 1.0 - t[axis] };
            let share = share(0) * share(1) * share(2);
            // Places without a share need not be there.
            if share == 0.0 {
                continue;
            }
            let place = match within {
                true => &places[first + further[0] + SIDE * (further[1] + SIDE * further[2])],
                false => {
                    let (brick, place) = self.locate([0, 1, 2].map(|axis: usize| at[axis] + further[axis]));
                    &self.each[brick].get()?.places[place]
                }
            };
            match place[3].load(Ordering::Acquire) {
                state if state == LIGHT + number => {
                    (0..3).for_each(|c| sum[c] += share * f32::from_bits(place[c].load(Ordering::Relaxed)));
                    shares += share;
                }
                ABSENT => {}
                _ => return None,
            }
        }
        Some((sum, shares))
    }

    /// What light far away becomes at a place: coefficients of red, green and blue, one after the other.
    pub fn transfer(&self, at: [usize; 3]) -> Option<&[f16]> {
        let (brick, place) = self.locate(at);
        self.each[brick].get()?.transfers.as_ref()?[place].get().map(|transfer| &**transfer)
    }

    /// Writes that down.
    pub fn set_transfer(&self, at: [usize; 3], transfer: impl Iterator<Item = f16>) {
        let (brick, place) = self.locate(at);
        if let Some(transfers) = &self.each[brick].get_or_init(|| Brick::new(self.transfers)).transfers {
            transfers[place].get_or_init(|| transfer.collect());
        }
    }

    /// Whether anything is known of any place.
    pub fn are_touched(&self) -> bool {
        self.each.iter().any(|brick| brick.get().is_some())
    }

    /// Writes down what is known of a place in the light of a number, 1 or more. Whoever finds out about a place finds the same, so that it does not matter who
    /// comes first.
    pub fn set(&self, at: [usize; 3], number: u32, known: Known) {
        let (brick, place) = self.locate(at);
        let place = &self.each[brick].get_or_init(|| Brick::new(self.transfers)).places[place];
        let state = match known {
            Known::Nothing => NOTHING,
            Known::Absent => ABSENT,
            Known::Light(light) => {
                // What was known is not any more, until all of it is written.
                place[3].store(NOTHING, Ordering::Relaxed);
                fence(Ordering::Release);
                light.iter().zip(place).for_each(|(v, to)| to.store(v.to_bits(), Ordering::Relaxed));
                LIGHT + number
            }
        };
        place[3].store(state, Ordering::Release);
    }

    /// The brick of a place, and its number there.
    fn locate(&self, at: [usize; 3]) -> (usize, usize) {
        let number = |parts: [usize; 3], counts: [usize; 3]| parts[0] + counts[0] * (parts[1] + counts[1] * parts[2]);
        (number(at.map(|n| n / SIDE), self.counts), number(at.map(|n| n % SIDE), [SIDE; 3]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_keeps_what_is_its_own() {
        let bricks = Bricks::new([9, 17, 3], true).unwrap();
        let each = || (0..9 * 17 * 3).map(|k| ([k % 9, k / 9 % 17, k / (9 * 17)], k));
        let known = |k: usize| if k.is_multiple_of(5) { Known::Absent } else { Known::Light([k as f32, 0.5, -0.0]) };
        each().for_each(|(at, _)| assert_eq!(bricks.get(at, 7), Known::Nothing));
        each().filter(|(at, _)| at[1] > 7).for_each(|(at, k)| {
            bricks.set(at, 7, known(k));
            bricks.set_transfer(at, [k as f32, 0.5].into_iter().map(f16::from_f32));
        });
        for (at, k) in each() {
            let there = at[1] > 7;
            assert_eq!(bricks.get(at, 7), if there { known(k) } else { Known::Nothing }, "{at:?}");
            // In other light it is not known yet, but for what is nowhere.
            let elsewhere = if k.is_multiple_of(5) && there { Known::Absent } else { Known::Nothing };
            assert_eq!(bricks.get(at, 8), elsewhere, "{at:?}");
            let transfer = bricks.transfer(at).map(|numbers| numbers[0].to_f32());
            assert_eq!(transfer, there.then_some(k as f32), "{at:?}");
        }
        let there = bricks.each.iter().filter(|brick| brick.get().is_some()).count();
        assert_eq!((there, bricks.each.len()), (4, 6));
    }

    #[test]
    fn eight_places_at_once_are_what_they_are_one_by_one() {
        let bricks = Bricks::new([12, 12, 12], false).unwrap();
        let light = |at: [usize; 3]| [at[0] as f32, 10.0 * at[1] as f32, -(at[2] as f32)];
        let there = |at: [usize; 3]| !(at[0] + at[1] + at[2]).is_multiple_of(3);
        for at in (0..12 * 12 * 12).map(|k| [k % 12, k / 12 % 12, k / 144]) {
            bricks.set(at, 0, if there(at) { Known::Light(light(at)) } else { Known::Absent });
        }
        let t = [0.25, 0.5, 0.125];
        for at in [[0, 0, 0], [6, 3, 5], [7, 3, 7], [8, 9, 10]] {
            let (mut sum, mut shares) = ([0.0; 3], 0.0);
            for corner in 0..8 {
                let near = [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1));
                let share = [0, 1, 2].map(|axis| if near[axis] > at[axis] { t[axis] } else { 1.0 - t[axis] });
                let share = if there(near) { share.iter().product::<f32>() } else { 0.0 };
                (0..3).for_each(|c| sum[c] += share * light(near)[c]);
                shares += share;
            }
            let (found, of) = bricks.around(at, t, 0).unwrap();
            assert!((of - shares).abs() < 1e-6 && (0..3).all(|c| (found[c] - sum[c]).abs() < 1e-4), "{at:?}");
            assert_eq!(bricks.around(at, t, 1), None);
        }
        // At the end there are no further ones, nor are they asked for.
        assert!(bricks.around([11, 11, 11], [0.0; 3], 0).is_some());
    }
}
