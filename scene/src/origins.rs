use glam::{DVec3, Mat3, Mat4};

/// The origins of an object's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origins {
    /// The origin of its own coordinates, in the coordinates that the file means.
    pub own: DVec3,
    /// The origin of the scene, in the world that the file means.
    pub world: DVec3,
}

impl Origins {
    /// For an object that has `place` in its own coordinates: relative to the scene's origin if it is nearer to that.
    pub fn of(world: DVec3, place: DVec3) -> Self {
        let own = if place.distance_squared(world) < place.length_squared() { world } else { DVec3::ZERO };
        Self { own, world }
    }

    /// The offset that is subtracted from a translation from own coordinates to the world.
    pub fn shift(&self) -> DVec3 {
        self.world - self.own
    }

    /// A matrix whose translation is without [`Self::shift`] and that turns and scales about the file's origin, between these origins.
    /// `linear`: its linear part in double precision.
    pub fn place(&self, matrix: Mat4, linear: impl Fn(DVec3) -> DVec3) -> Mat4 {
        if self.own == DVec3::ZERO {
            return matrix;
        }
        let moved = matrix.w_axis.truncate().as_dvec3() + (linear(self.own) - self.own);
        Mat4 { w_axis: moved.as_vec3().extend(1.0), ..matrix }
    }

    /// The same of a matrix whose translation is given in double precision.
    pub fn place_matrix(&self, matrix: Mat4, translation: DVec3) -> Mat4 {
        if *self == Self::default() {
            return matrix;
        }
        let linear = Mat3::from_mat4(matrix).as_dmat3();
        let moved = translation - self.world + linear * self.own;
        Mat4 { w_axis: moved.as_vec3().extend(1.0), ..matrix }
    }
}
