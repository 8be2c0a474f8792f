use core::f32::consts::{PI, TAU};
use glam::{Quat, UVec2, Vec2, Vec3};

/// A picture of all directions (equirectangular): its middle is toward −z, its right half toward +x, its top toward +y.
///
/// Between the middles of texels radiance is linear.
#[derive(Clone, PartialEq)]
pub struct EnvironmentMap {
    size: UVec2,
    /// The top row first.
    texels: Vec<Vec3>,
    /// From the world to the picture.
    turn: Quat,
}

/// The fault of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// So many texels do not make a picture of this size.
    Size,
    /// A texel is not a number.
    NotANumber {
        /// Its column.
        x: u32,
        /// Its row, from the top.
        y: u32,
    },
}

impl core::fmt::Display for EnvironmentError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Size => f.write_str("the picture has no pixels, or not as many as it says"),
            Self::NotANumber { x, y } => write!(f, "the pixel at column {x}, row {y} is not a number"),
        }
    }
}

impl core::error::Error for EnvironmentError {}

impl EnvironmentMap {
    /// Brighter texels, infinite ones included, have this radiance: sums over pictures stay far from overflow.
    pub const BRIGHTEST: f32 = 1e12;

    /// Radiance (W·m⁻²·sr⁻¹ per channel) of so many texels across and down, the top row first. Negative values are read as 0, those above
    /// [`BRIGHTEST`](Self::BRIGHTEST) as that.
    ///
    /// # Errors
    /// [`EnvironmentError`] where that is no picture.
    pub fn new(size: UVec2, mut texels: Vec<Vec3>) -> Result<Self, EnvironmentError> {
        let count = size.x as usize * size.y as usize;
        if count == 0 || texels.len() != count {
            return Err(EnvironmentError::Size);
        }
        if let Some(i) = texels.iter().position(|t| t.is_nan()) {
            let i = i as u32;
            return Err(EnvironmentError::NotANumber { x: i % size.x, y: i / size.x });
        }
        texels.iter_mut().for_each(|t| *t = t.clamp(Vec3::ZERO, Vec3::splat(Self::BRIGHTEST)));
        Ok(Self { size, texels, turn: Quat::IDENTITY })
    }

    /// The same radiance from everywhere.
    #[must_use]
    pub fn uniform(radiance: Vec3) -> Self {
        let radiance = radiance.clamp(Vec3::ZERO, Vec3::splat(Self::BRIGHTEST));
        Self { size: UVec2::ONE, texels: vec![radiance], turn: Quat::IDENTITY }
    }

    /// The same picture, turned about its own +y by `degrees` (counter-clockwise seen from above), so that this is then toward `up`.
    #[must_use]
    pub fn turned(self, up: Vec3, degrees: f32) -> Self {
        let own = Quat::from_rotation_y(-degrees.to_radians());
        Self { turn: own * Quat::from_rotation_arc(up.normalize_or(Vec3::Y), Vec3::Y), ..self }
    }

    /// The same picture, so many times as bright.
    #[must_use]
    pub fn scaled(mut self, factor: Vec3) -> Self {
        self.texels.iter_mut().for_each(|t| *t *= factor);
        self
    }

    /// The same picture with so much more radiance from everywhere. Below 0 and above [`BRIGHTEST`](Self::BRIGHTEST) as in [`new`](Self::new).
    #[must_use]
    pub fn brightened(mut self, radiance: Vec3) -> Self {
        self.texels.iter_mut().for_each(|t| *t = (*t + radiance).clamp(Vec3::ZERO, Vec3::splat(Self::BRIGHTEST)));
        self
    }

    /// The same picture with at most so many texels across, each the mean of those that it stands for. Cost: one look at each texel.
    #[must_use]
    pub fn reduced(&self, across: u32) -> Self {
        let factor = self.size.x.div_ceil(across.max(1));
        if factor <= 1 {
            return self.clone();
        }
        let size = (self.size / factor).max(UVec2::ONE);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); size.x as usize * size.y as usize];
        for y in 0..self.size.y {
            let weight = self.solid_angle(y);
            let row = (y * size.y / self.size.y) * size.x;
            for x in 0..self.size.x {
                let (sum, weights) = &mut sums[(row + x * size.x / self.size.x) as usize];
                *sum += self.texel(x, y) * weight;
                *weights += weight;
            }
        }
        let texels = sums.into_iter().map(|(sum, weights)| sum / weights.max(f32::MIN_POSITIVE)).collect();
        Self { size, texels, turn: self.turn }
    }

    /// Texels across and down.
    #[must_use]
    pub const fn size(&self) -> UVec2 {
        self.size
    }

    /// Where a direction of any length is in the picture: parts of its width and height, from the left and from the top.
    #[must_use]
    pub fn place(&self, direction: Vec3) -> Vec2 {
        let d = (self.turn * direction).normalize_or(Vec3::NEG_Z);
        Vec2::new(0.5 + d.x.atan2(-d.z) / TAU, d.y.clamp(-1.0, 1.0).acos() / PI)
    }

    /// Radiance from a direction of any length.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let p = self.place(direction) * self.size.as_vec2() - 0.5;
        let (low, part) = (p.floor(), p - p.floor());
        let row = |y: f32| {
            let y = (y.max(0.0) as u32).min(self.size.y - 1);
            let texel = |x: f32| {
                let x = (x + self.size.x as f32) as u32 % self.size.x;
                self.texels[(y * self.size.x + x) as usize]
            };
            texel(low.x).lerp(texel(low.x + 1.0), part.x)
        };
        row(low.y).lerp(row(low.y + 1.0), part.y)
    }

    /// The texel in a column and a row from the top.
    pub(super) fn texel(&self, x: u32, y: u32) -> Vec3 {
        self.texels[(y * self.size.x + x) as usize]
    }

    pub(super) fn set_texel(&mut self, x: u32, y: u32, radiance: Vec3) {
        self.texels[(y * self.size.x + x) as usize] = radiance;
    }

    /// The direction of a place in texels from the left and from the top.
    #[must_use]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let (sin, cos) = ((x / self.size.x as f32 - 0.5) * TAU).sin_cos();
        let (down, up) = (y / self.size.y as f32 * PI).sin_cos();
        self.turn.inverse() * Vec3::new(sin * down, up, -cos * down)
    }

    /// The solid angle of a texel in a row.
    #[must_use]
    pub fn solid_angle(&self, y: u32) -> f32 {
        let cos = |y: u32| (f64::from(y) / f64::from(self.size.y) * core::f64::consts::PI).cos();
        ((cos(y) - cos(y + 1)) * core::f64::consts::TAU / f64::from(self.size.x)) as f32
    }

    /// All texels, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }
}

/// Its size and a sum over what it shows.
impl core::fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (size, turn) = (self.size, self.turn);
        write!(f, "EnvironmentMap {{ {size}, {turn}, {:016x} }}", lobe_core::fingerprint(self.texels.iter().copied()))
    }
}
