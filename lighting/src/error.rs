use glam::Vec3;
use lobe_core::Sphere;

/// The fault of a light: one line that says what is wrong and what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightError(String);

impl core::fmt::Display for LightError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for LightError {}

impl LightError {
    /// A fault in a sentence.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }

    /// Refuses a sphere that is not finite, or beyond 1e9, or has no radius.
    pub(crate) fn check_sphere(sphere: Sphere) -> Result<(), Self> {
        sphere.validate().map_err(Self)
    }

    /// Refuses what is no unit vector.
    pub(crate) fn check_direction(name: &str, direction: Vec3) -> Result<(), Self> {
        if (direction.length() - 1.0).abs() <= 1e-3 {
            return Ok(());
        }
        Err(Self(format!("{name} is {direction}: expected a unit vector")))
    }

    /// Refuses bounds that are not finite.
    pub(crate) fn check_bounds(Sphere { center, radius }: Sphere) -> Result<(), Self> {
        if center.is_finite() && radius.is_finite() && radius >= 0.0 {
            return Ok(());
        }
        Err(Self(format!("it lies in a sphere of radius {radius} at {center}: expected finite numbers")))
    }
}
