use crate::{Object, Proxy};
use lobe_core::Sphere;
use std::collections::HashSet;

/// Finds equal spheres: two that lie in the same place are one surface and one blocker.
///
/// Of equal spheres of objects that are seen and block alike the first one stands for all. Without that rule each would shadow
/// the surface of the other: a receiver lies on its own object's sphere and, but for rounding, inside the other's.
///
/// ```
/// use lobe_core::Sphere;
/// use scene::{Doubles, Object};
/// let ball = Sphere { radius: 1.0, ..Sphere::default() };
/// let object = Object::spheres("ball", vec![ball; 2], 0);
/// let mut doubles = Doubles::default();
/// assert!(doubles.is_first(&object, &ball));
/// assert!(!doubles.is_first(&object, &ball));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Doubles {
    known: HashSet<([u32; 4], bool, bool, Option<crate::Strategy>)>,
}

impl Doubles {
    /// Forgets all spheres.
    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// Remembers a sphere of an object; true when no equal one of an object that is seen and blocks like this one came before.
    pub fn is_first(&mut self, object: &Object, ball: &Sphere) -> bool {
        let bits = [ball.center.x, ball.center.y, ball.center.z, ball.radius].map(|x| (x + 0.0).to_bits());
        self.known.insert((bits, object.visible, object.proxy == Proxy::None, object.strategy))
    }
}
