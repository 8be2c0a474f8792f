//! Random inputs, the same for the same seed.

use cosine_lobes::lobe_core::oracle::Random;

/// The kind of a target's inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text with words and numbers.
    Text,
    /// Binary, or binary after text.
    Mixed,
    /// Bytes that numbers are taken from.
    Numbers,
}

/// Words that break parsers.
const WORDS: [&[u8]; 36] = [
    b"0",
    b"-0",
    b"-1",
    b"1",
    b"2",
    b"4",
    b"255",
    b"65535",
    b"65536",
    b"2147483647",
    b"4294967295",
    b"4294967296",
    b"-9223372036854775808",
    b"18446744073709551616",
    b"1e38",
    b"3.5e38",
    b"1e39",
    b"1e-45",
    b"1e-300",
    b"1e400",
    b"nan",
    b"inf",
    b"-inf",
    b"null",
    b"true",
    b"\"\"",
    b"[]",
    b"{}",
    b"[[[[",
    b"]",
    b"}",
    b"\n",
    b"\r",
    b"\0",
    b"\xff\xfe",
    b"\xe2\x80\xa8",
];

/// Makes inputs for one target.
pub struct Source {
    random: Random,
    kind: Kind,
    seeds: Vec<Vec<u8>>,
}

impl Source {
    /// Inputs like these seeds, of which there is one at least.
    #[must_use]
    pub fn new(seed: u64, kind: Kind, seeds: Vec<Vec<u8>>) -> Self {
        Self { random: Random::new(seed), kind, seeds }
    }

    fn below(&mut self, count: usize) -> usize {
        (self.random.bits() % count.max(1) as u64) as usize
    }

    /// The next input.
    pub fn input(&mut self) -> Vec<u8> {
        if self.kind == Kind::Numbers {
            let count = 1 + self.below(1500);
            return (0..count).map(|_| self.random.bits() as u8).collect();
        }
        let seed = self.below(self.seeds.len());
        let mut data = self.seeds[seed].clone();
        for _ in 0..1 + self.below(6) {
            self.change(&mut data);
        }
        data.truncate(1 << 20);
        data
    }

    fn change(&mut self, data: &mut Vec<u8>) {
        let at = self.below(data.len() + 1);
        match self.below(9) {
            // A bit, or a byte.
            0 if at < data.len() => data[at] ^= 1 << self.below(8),
            1 if at < data.len() => data[at] = self.random.bits() as u8,
            // An end.
            2 => data.truncate(at),
            // A part out, twice, or of another seed.
            3 => {
                let end = (at + self.below(64)).min(data.len());
                data.drain(at..end);
            }
            4 => {
                let end = (at + self.below(200)).min(data.len());
                let part = data[at..end].to_vec();
                data.splice(at..at, part);
            }
            5 => {
                let other = self.below(self.seeds.len());
                let (from, length) = (self.below(self.seeds[other].len() + 1), self.below(200));
                let part: Vec<u8> = self.seeds[other].iter().skip(from).take(length).copied().collect();
                data.splice(at..at, part);
            }
            // A word in place of a number or a name.
            6 | 7 if self.kind == Kind::Text => {
                let is_word = |b: &u8| b.is_ascii_alphanumeric() || b".+-_".contains(b);
                let start = data[..at].iter().rposition(|b| !is_word(b)).map_or(0, |k| k + 1);
                let end = data[at..].iter().position(|b| !is_word(b)).map_or(data.len(), |k| at + k);
                let word = WORDS[self.below(WORDS.len())];
                data.splice(start..end, word.iter().copied());
            }
            // Four bytes that mean a length or a float.
            _ if data.len() >= 4 => {
                const NUMBERS: [u32; 10] = [0, 1, 2, 3, 255, 65536, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0001];
                let at = self.below(data.len() - 3);
                let number = NUMBERS[self.below(NUMBERS.len())];
                data[at..at + 4].copy_from_slice(&number.to_le_bytes());
            }
            _ => data.push(self.random.bits() as u8),
        }
    }
}
