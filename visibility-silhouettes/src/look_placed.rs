//! The same for meshes that stand at places.

use crate::look::{LookMemory, Looker, Space, World};
use crate::placed::{Place, SilhouetteInstances};
use fearless_simd::Simd;
use glam::Mat3;
use lobe_core::vec3x8::Vec3x8;

/// A place whose axes are scaled alike.
pub(crate) struct Turn {
    matrix: Mat3,
    is_mirrored: bool,
}

impl Space for Turn {
    #[inline(always)]
    fn vector<S: Simd>(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        product(self.matrix, v)
    }

    #[inline(always)]
    fn half<S: Simd>(&self, half: Vec3x8<S>) -> Vec3x8<S> {
        let [x, y, z] = [self.matrix.x_axis, self.matrix.y_axis, self.matrix.z_axis].map(|axis| axis.abs());
        product(Mat3::from_cols(x, y, z), half)
    }

    fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }
}

#[inline(always)]
fn product<S: Simd>(matrix: Mat3, v: Vec3x8<S>) -> Vec3x8<S> {
    let row = |row: usize| v.dot_one(matrix.row(row));
    Vec3x8::new(row(0), row(1), row(2))
}

impl<'a> Looker<'a, World> {
    /// The receiver as a mesh at a place sees it.
    pub(crate) fn at(&self, place: &Place) -> Looker<'a, Turn> {
        let matrix = Mat3::from_mat4(*place.matrix());
        let turn = Turn { matrix, is_mirrored: matrix.determinant() < 0.0 };
        let origin = place.to_own(self.origin).as_vec3();
        // Of its length nothing depends on.
        let normal = matrix.transpose() * self.normal;
        let Self { horizon, window, meridians, scale, .. } = *self;
        Looker { space: turn, origin, normal: normal.normalize_or(self.normal), horizon, window, meridians, scale }
    }

    /// Lists the places that may have silhouettes above the horizon that cross a meridian.
    #[inline(always)]
    pub(crate) fn places<S: Simd>(&self, simd: S, all: &SilhouetteInstances, memory: &mut LookMemory) {
        let nodes = all.top().nodes();
        let LookMemory { places, stack, .. } = memory;
        places.clear();
        stack.clear();
        stack.extend((!nodes.is_empty()).then_some(0));
        while let Some(number) = stack.pop() {
            let node = &nodes[number as usize];
            let mut met = self.meets(simd, node);
            while met != 0 {
                let k = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                let (first, count) = (node.first[k], u32::from(node.count[k]));
                match count {
                    0 => stack.push(first),
                    _ => places.extend((first..).take(count as usize)),
                }
            }
        }
    }
}
