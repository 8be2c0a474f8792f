//! Sobol' points with hash-based Owen scrambling (B. Burley, *Practical Hash-based Owen Scrambling*, JCGT 9 (4), 2020;
//! hash constants by N. Vegdahl, 2021).

use lobe_core::Random;

/// Dimensions of the sequence.
pub(crate) const DIMENSIONS: usize = 3;

/// For each dimension after the first and each byte of the index: the bit-reversed xor of the direction numbers.
static TABLES: [[[u32; 256]; 4]; DIMENSIONS - 1] = [table(&second()), table(&third())];

/// Direction numbers of the second dimension: Pascal's triangle modulo 2.
const fn second() -> [u32; 32] {
    let mut v = [0; 32];
    v[0] = 1 << 31;
    let mut i = 1;
    while i < 32 {
        v[i] = v[i - 1] ^ (v[i - 1] >> 1);
        i += 1;
    }
    v
}

/// Direction numbers of the third dimension: primitive polynomial x² + x + 1 with m = 1, 3.
const fn third() -> [u32; 32] {
    let mut v = [0; 32];
    v[0] = 1 << 31;
    v[1] = 3 << 30;
    let mut i = 2;
    while i < 32 {
        v[i] = v[i - 1] ^ v[i - 2] ^ (v[i - 2] >> 2);
        i += 1;
    }
    v
}

const fn table(directions: &[u32; 32]) -> [[u32; 256]; 4] {
    let mut t = [[0; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 0;
        while value < 256 {
            let mut bit = 0;
            while bit < 8 {
                if value >> bit & 1 == 1 {
                    t[byte][value] ^= directions[byte * 8 + bit].reverse_bits();
                }
                bit += 1;
            }
            value += 1;
        }
        byte += 1;
    }
    t
}

/// A permutation of 32-bit words in which every bit depends on the bits below it only, that is a random tree of
/// exchanges on bit-reversed numbers.
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Mixes a key into a hash.
pub(crate) fn mix(hash: u64, key: u64) -> u64 {
    Random::new(hash ^ key).bits()
}

/// One randomisation of the sequence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sequence {
    seeds: [u32; DIMENSIONS],
}

impl Sequence {
    pub(crate) fn new(key: u64) -> Self {
        Self { seeds: core::array::from_fn(|d| (mix(key, d as u64) >> 32) as u32) }
    }

    /// Coordinate `dimension` of point `index`, in (0, 1).
    #[inline]
    pub(crate) fn get(&self, index: u32, dimension: usize) -> f64 {
        let reversed = if dimension == 0 {
            index
        } else {
            let t = &TABLES[dimension - 1];
            let byte = |k: usize| t[k][(index >> (8 * k)) as usize & 255];
            byte(0) ^ byte(1) ^ byte(2) ^ byte(3)
        };
        let bits = scramble_reversed(reversed, self.seeds[dimension]).reverse_bits();
        (f64::from(bits) + 0.5) * (1.0 / 4_294_967_296.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The defining property: of the first 2^m points, each elementary interval of area 2^−m holds exactly one, in the
    /// first two dimensions and after scrambling.
    #[test]
    fn first_two_dimensions_are_a_net() {
        for key in 0..20 {
            let s = Sequence::new(mix(key, 7));
            for m in [4u32, 8] {
                for columns in 0..=m {
                    let mut seen = vec![false; 1 << m];
                    for i in 0..1 << m {
                        let x = (s.get(i, 0) * f64::from(1 << columns)) as usize;
                        let y = (s.get(i, 1) * f64::from(1 << (m - columns))) as usize;
                        let cell = &mut seen[(x << (m - columns)) + y];
                        assert!(!*cell, "two points in one interval");
                        *cell = true;
                    }
                }
            }
        }
    }

    #[test]
    fn each_dimension_is_stratified_and_unbiased() {
        let mut first = [0.0; DIMENSIONS];
        for key in 0..4000 {
            let s = Sequence::new(mix(key, 3));
            for (d, sum) in first.iter_mut().enumerate() {
                *sum += s.get(0, d) / 4000.0;
                if key < 10 {
                    let mut cells: Vec<_> = (0..64).map(|i| (s.get(i, d) * 64.0) as usize).collect();
                    cells.sort_unstable();
                    assert!(cells.into_iter().eq(0..64));
                }
            }
        }
        // Uniform: standard deviation of the mean is 0.289/√4000 = 0.0046.
        assert!(first.iter().all(|m| (m - 0.5).abs() < 0.02), "{first:?}");
    }
}
