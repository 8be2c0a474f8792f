use crate::Light;
use glam::{Mat4, Vec3};
use lobe_core::{Cone, LightImage, LightLobes, LightTerm, LobesFull, LobesMut, Outline, Receiver, Sphere};

/// A light inside an object whose surface it stands for: it does not light that object.
///
/// A ball in place of a faceted mesh is above its surface here and below it there; what that surface got of it would be noise.
///
/// ```
/// use glam::Vec3;
/// use lighting::{InsideLight, SphereLight};
/// use lobe_core::{LightLobes, Receiver, Sphere};
/// let ball = SphereLight::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, Vec3::ONE);
/// let light = InsideLight { light: Box::new(ball.into()), object: 3 };
/// let at = Receiver { position: Vec3::Z * 0.99, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: 3 };
/// assert_eq!(light.radiance(&at), Vec3::ZERO);
/// assert_eq!(light.radiance(&Receiver { object: 2, ..at }), Vec3::ONE);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct InsideLight {
    /// The light.
    pub light: Box<Light>,
    /// The number of the object, as receivers have it.
    pub object: u32,
}

impl InsideLight {
    /// The same light somewhere else. Turns and shifts only.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        Self { light: Box::new(self.light.moved(placement)), ..*self }
    }
}

impl LightLobes for InsideLight {
    fn bounds(&self) -> Sphere {
        self.light.bounds()
    }

    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        self.light.bounds_from(receivers)
    }

    fn cone(&self, at: &Receiver) -> Cone {
        self.light.cone(at)
    }

    fn radiance(&self, at: &Receiver) -> Vec3 {
        if at.object == self.object { Vec3::ZERO } else { self.light.radiance(at) }
    }

    fn outline(&self, at: &Receiver) -> Option<Outline> {
        self.light.outline(at)
    }

    fn image(&self) -> Option<&LightImage> {
        self.light.image()
    }

    fn term(&self, at: &Receiver) -> LightTerm {
        LightTerm { radiance: self.radiance(at), ..self.light.term(at) }
    }

    fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        if at.object == self.object { Ok(()) } else { self.light.light_lobes(at, out) }
    }
}
