//! A quick hash for maps of millions of small keys, as meshes have.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::LazyLock;

/// A map whose keys are hashed in a few multiplications. Its order means nothing.
pub type QuickMap<K, V> = HashMap<K, V, QuickHash>;
/// A set whose keys are hashed in a few multiplications. Its order means nothing.
pub type QuickSet<K> = HashSet<K, QuickHash>;

/// Makes hashers of [`QuickMap`] and [`QuickSet`]: multiplications whose halves are folded together, from a start that differs from run to
/// run, so that no file is slow in all of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct QuickHash;

/// The state of a [`QuickHash`].
#[derive(Clone, Copy, Debug)]
pub struct QuickHasher(u64);

const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

#[inline]
fn folded(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    (product >> 64) as u64 ^ product as u64
}

impl BuildHasher for QuickHash {
    type Hasher = QuickHasher;

    #[inline]
    fn build_hasher(&self) -> QuickHasher {
        static SEED: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(ODD));
        QuickHasher(*SEED)
    }
}

impl Hasher for QuickHasher {
    #[inline]
    fn finish(&self) -> u64 {
        folded(self.0, ODD)
    }

    #[inline]
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.write_u64(u64::from_le_bytes(*word)));
        if !rest.is_empty() {
            let mut last = [0; 8];
            last[..rest.len()].copy_from_slice(rest);
            self.write_u64(u64::from_le_bytes(last));
        }
    }

    #[inline]
    fn write_u32(&mut self, number: u32) {
        self.write_u64(u64::from(number));
    }

    #[inline]
    fn write_u64(&mut self, number: u64) {
        self.0 = folded(self.0 ^ number, ODD);
    }

    #[inline]
    fn write_usize(&mut self, number: usize) {
        self.write_u64(number as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a grid, and rising numbers, as files have them: hardly any two share the bits that tables use.
    #[test]
    fn regular_keys_spread() {
        let hash = QuickHash;
        let grid = (0..64_u32 * 64 * 16).map(|k| [k % 64, k / 64 % 64, k / 4096].map(|x| (x as f32 * 0.25).to_bits()));
        let lows: HashSet<u64> = grid.map(|key| hash.hash_one(key) & 0xffff).collect();
        // Of 65 536 places 63.2 % are taken by as many random keys.
        assert!((39_000..44_000).contains(&lows.len()), "{}", lows.len());
        let highs: HashSet<u64> = (0..65_536_u32).map(|k| hash.hash_one([k, k + 1, k + 2]) >> 48).collect();
        assert!((39_000..44_000).contains(&highs.len()), "{}", highs.len());
    }
}
