//! The same for meshes that stand at places.

use crate::look::{LookMemory, Looker, Space, World};
use crate::placed::{Place, SilhouetteInstances};
use crate::sift::Sift;
use crate::tree::Node;
use fearless_simd::Simd;
use glam::{Mat3, Vec3};
use lobe_core::vec3x8::Vec3x8;

/// A place whose axes are scaled alike.
#[derive(Clone, Copy)]
pub(crate) struct Turn {
    matrix: Mat3,
    abs: Mat3,
    is_mirrored: bool,
}

impl Space for Turn {
    #[inline(always)]
    fn vector<S: Simd>(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        product(self.matrix, v)
    }

    #[inline(always)]
    fn half<S: Simd>(&self, half: Vec3x8<S>) -> Vec3x8<S> {
        product(self.abs, half)
    }

    fn half_of(&self, half: Vec3) -> Vec3 {
        self.abs * half
    }

    fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }
}

#[inline(always)]
fn product<S: Simd>(matrix: Mat3, v: Vec3x8<S>) -> Vec3x8<S> {
    Vec3x8::new(v.dot_one(matrix.row(0)), v.dot_one(matrix.row(1)), v.dot_one(matrix.row(2)))
}

impl Place {
    /// How the mesh lies here.
    pub(crate) fn turn(&self) -> Turn {
        let matrix = Mat3::from_mat4(*self.matrix());
        let abs = Mat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs());
        Turn { matrix, abs, is_mirrored: matrix.determinant() < 0.0 }
    }

    /// A receiver and its normal in the mesh's own coordinates.
    pub(crate) fn own(&self, origin: Vec3, normal: Vec3) -> [Vec3; 2] {
        let own = Mat3::from_mat4(*self.matrix()).transpose() * normal;
        [self.to_own(origin).as_vec3(), own.normalize_or(normal)]
    }
}

impl<'a> Looker<'a, World> {
    /// The receiver as a mesh at a place sees it.
    pub(crate) fn at(&self, place: &Place) -> Looker<'a, Turn> {
        let [origin, normal] = place.own(self.origin, self.normal);
        let Self { horizon, window, meridians, scale, .. } = *self;
        Looker { space: place.turn(), origin, normal, horizon, window, meridians, scale }
    }
}

/// Who looks for shared meshes: one receiver, or those of a part.
pub(crate) trait Search {
    /// The children of a node that may have silhouettes which cross a meridian above a horizon, as bits.
    fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32;

    /// Lists the places that may have such silhouettes.
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, all: &SilhouetteInstances, LookMemory { places, stack, .. }: &mut LookMemory) {
        let nodes = all.top().nodes();
        places.clear();
        stack.clear();
        stack.extend((!nodes.is_empty()).then_some(0));
        while let Some(number) = stack.pop() {
            let node = &nodes[number as usize];
            let mut met = self.meets(simd, node);
            while met != 0 {
                let k = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                let (first, count) = (node.first[k], usize::from(node.count[k]));
                match count {
                    0 => stack.push(first),
                    _ => places.extend((first..).take(count)),
                }
            }
        }
    }
}

impl Search for Looker<'_, World> {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        Looker::meets(self, simd, node)
    }
}

impl Search for Sift<'_, World> {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        Sift::meets(self, simd, node)
    }
}
