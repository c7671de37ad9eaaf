//! Light at the places of a lattice, in bricks that are there where a place was asked for (G-08, G-B2).

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use half::f16;

/// Places per axis of a brick.
const SIDE: usize = 8;

/// What is known of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Nothing yet.
    Nothing,
    /// That no surface goes through it.
    Absent,
    /// The light that arrives there, as bright as a white surface looks in it, linear RGB.
    Light([f32; 3]),
}

/// Red, green and blue, and what they are.
type Place = [AtomicU32; 4];

/// Places of a brick.
const PLACES: usize = SIDE * SIDE * SIDE;

/// A brick's places, and how light far away becomes light there, of those of which that is known.
struct Brick {
    places: [Place; PLACES],
    transfers: Option<Box<[OnceLock<Box<[f16]>>; PLACES]>>,
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
    pub fn new(places: [usize; 3], transfers: bool) -> Self {
        let counts = places.map(|n| n.div_ceil(SIDE));
        let each = (0..counts.iter().product()).map(|_| OnceLock::new()).collect();
        Self { counts, each, transfers }
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

    /// Writes down what is known of a place in the light of a number. Whoever finds out about a place finds the same, so that it does not matter who
    /// comes first.
    pub fn set(&self, at: [usize; 3], number: u32, known: Known) {
        let (brick, place) = self.locate(at);
        let place = &self.each[brick].get_or_init(|| Brick::new(self.transfers)).places[place];
        let state = match known {
            Known::Nothing => NOTHING,
            Known::Absent => ABSENT,
            Known::Light(light) => {
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
        let bricks = Bricks::new([9, 17, 3], true);
        let each = || (0..9 * 17 * 3).map(|k| ([k % 9, k / 9 % 17, k / (9 * 17)], k));
        let known = |k: usize| if k % 5 == 0 { Known::Absent } else { Known::Light([k as f32, 0.5, -0.0]) };
        each().for_each(|(at, _)| assert_eq!(bricks.get(at, 7), Known::Nothing));
        each().filter(|(at, _)| at[1] > 7).for_each(|(at, k)| {
            bricks.set(at, 7, known(k));
            bricks.set_transfer(at, [k as f32, 0.5].into_iter().map(f16::from_f32));
        });
        for (at, k) in each() {
            let there = at[1] > 7;
            assert_eq!(bricks.get(at, 7), if there { known(k) } else { Known::Nothing }, "{at:?}");
            // In other light it is not known yet, but for what is nowhere.
            let elsewhere = if k % 5 == 0 && there { Known::Absent } else { Known::Nothing };
            assert_eq!(bricks.get(at, 8), elsewhere, "{at:?}");
            let transfer = bricks.transfer(at).map(|numbers| numbers[0].to_f32());
            assert_eq!(transfer, there.then_some(k as f32), "{at:?}");
        }
        let there = bricks.each.iter().filter(|brick| brick.get().is_some()).count();
        assert_eq!((there, bricks.each.len()), (4, 6));
    }
}
