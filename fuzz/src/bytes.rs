//! Values from bytes; zeros when they are used up.

use glam::Vec3;

pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(data: &'a [u8]) -> Self {
        Self { rest: data }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        let count = N.min(self.rest.len());
        out[..count].copy_from_slice(&self.rest[..count]);
        self.rest = &self.rest[count..];
        out
    }

    pub(crate) fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    /// Less than `count`.
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        u32::from_le_bytes(self.take()) % count.max(1)
    }

    /// Any finite number.
    pub(crate) fn any(&mut self) -> f32 {
        let x = f32::from_le_bytes(self.take());
        if x.is_finite() { x } else { f32::from_bits(x.to_bits() & 0x7f7f_ffff) }
    }

    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.below(1 << 24) as f32 / ((1 << 24) - 1) as f32
    }

    /// From 0 to 1, in half of all cases very near to an end.
    pub(crate) fn edge(&mut self) -> f32 {
        let (kind, x) = (self.byte() % 8, self.unit());
        match kind {
            0 => 0.0,
            1 => 1.0,
            2 => 10.0_f32.powf(-20.0 * x),
            3 => 1.0 - 10.0_f32.powf(-7.0 * x),
            _ => x,
        }
    }

    /// A positive number of any size between two powers of ten.
    pub(crate) fn size(&mut self, from: f32, to: f32) -> f32 {
        10.0_f32.powf(from + (to - from) * self.unit())
    }

    /// A unit vector, often along an axis.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let kind = self.byte();
        if kind < 64 {
            return Vec3::AXES[usize::from(kind) % 3] * if kind < 32 { 1.0 } else { -1.0 };
        }
        let v = Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5);
        v.try_normalize().unwrap_or(Vec3::Z)
    }

    pub(crate) fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * (2.0 * size)
    }
}
