use core::fmt::Write;
use core::ops::Range;

/// How the words of a [`GpuBuffer`](crate::gpu::GpuBuffer) in pages are bound: as one buffer, or, where that is more than a binding may be, as
/// pages of it, each a binding of its own.
///
/// ```
/// use shading::gpu::GpuPages;
/// let bytes = 181_930_368;
/// let pages = GpuPages::of(bytes, 128 << 20);
/// assert_eq!(pages.count(), 2);
/// assert_eq!(pages.range(1, bytes), 128 << 20..bytes);
/// assert_eq!(GpuPages::of(bytes, 1 << 30), GpuPages::ONE);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuPages {
    count: u32,
    /// A page has `2^bits` words, the last one fewer.
    bits: u32,
}

impl GpuPages {
    /// All in one.
    pub const ONE: Self = Self { count: 1, bits: 32 };

    /// For so many bytes, where a binding may have at most `most`.
    ///
    /// # Panics
    /// When a binding may not have 4 bytes.
    #[must_use]
    pub fn of(bytes: u64, most: u64) -> Self {
        if bytes <= most {
            return Self::ONE;
        }
        let bits = Self::bits(most);
        Self { count: bytes.div_ceil(4 << bits) as u32, bits }
    }

    /// The most bytes that so many pages hold, where a binding may have at most `most`.
    ///
    /// # Panics
    /// When a binding may not have 4 bytes.
    #[must_use]
    pub fn room(count: u32, most: u64) -> u64 {
        if count <= 1 { most } else { most.max(u64::from(count) * (4 << Self::bits(most))) }
    }

    /// Of the largest page in a binding.
    fn bits(most: u64) -> u32 {
        assert!(most >= 4, "a binding of {most} bytes");
        (most / 4).ilog2().min(31)
    }

    /// How many.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.count
    }

    /// The bytes of a page, of so many in all.
    #[must_use]
    pub fn range(self, page: u32, bytes: u64) -> Range<u64> {
        let size = 4 << self.bits;
        let from = u64::from(page) * size;
        from.min(bytes)..(from + size).min(bytes)
    }

    /// The bindings in WGSL, from this number on, and `fn NAME_word(k: u32) -> u32`, which reads a word.
    #[must_use]
    pub fn wgsl(self, name: &str, binding: u32) -> String {
        let mut text = String::new();
        for page in 0..self.count {
            let binding = binding + page;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "@group(0) @binding({binding}) var<storage, read> {name}{page}: array<u32>;");
        }
        let _ = writeln!(text, "fn {name}_word(k: u32) -> u32 {{");
        let rest = match self.bits {
            32.. => "k".to_owned(),
            bits => format!("k & {}u", (1_u64 << bits) - 1),
        };
        for page in 0..self.count - 1 {
            let end = u64::from(page + 1) << self.bits;
            let _ = writeln!(text, "if k < {end}u {{ return {name}{page}[{rest}]; }}");
        }
        let _ = writeln!(text, "return {name}{}[{rest}];\n}}", self.count - 1);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_hold_every_byte_once() {
        for (bytes, most, count) in [
            (16, 16, 1),
            (20, 16, 2),
            (100, 48, 4),
            (155 << 20, 128 << 20, 2),
            (2047 << 20, 128 << 20, 16),
            (155 << 20, (1 << 31) - 1, 1),
            (3 << 30, (1 << 31) - 1, 3),
        ] {
            let pages = GpuPages::of(bytes, most);
            assert_eq!(pages.count(), count, "{bytes} {most}");
            let mut end = 0;
            for page in 0..count {
                let range = pages.range(page, bytes);
                assert!(range.start == end && range.end > end && range.end - end <= most, "{bytes} {most}: {range:?}");
                end = range.end;
            }
            assert_eq!(end, bytes);
            assert!(GpuPages::room(count, most) >= bytes && (count == 1 || GpuPages::room(count - 1, most) < bytes));
        }
        assert_eq!(GpuPages::room(0, 100), 100);
    }
}
