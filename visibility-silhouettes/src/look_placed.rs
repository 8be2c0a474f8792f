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

    /// Lists the places that may have silhouettes above the horizon that cross a meridian.
    #[inline(always)]
    pub(crate) fn places<S: Simd>(&self, simd: S, all: &SilhouetteInstances, memory: &mut LookMemory) {
        memory.begin(all);
        while let Some((node, stack, places)) = memory.next(all) {
            add(node, self.meets(simd, node), stack, places);
        }
    }
}

impl Sift<'_, World> {
    /// The same for all receivers of a part.
    #[inline(always)]
    pub(crate) fn places<S: Simd>(&self, simd: S, all: &SilhouetteInstances, memory: &mut LookMemory) {
        memory.begin(all);
        while let Some((node, stack, places)) = memory.next(all) {
            add(node, self.meets(simd, node), stack, places);
        }
    }
}

impl LookMemory {
    fn begin(&mut self, all: &SilhouetteInstances) {
        self.places.clear();
        self.stack.clear();
        self.stack.extend((!all.top().nodes().is_empty()).then_some(0));
    }

    /// The next node, and where what is met of it goes.
    #[inline(always)]
    fn next<'n>(&mut self, all: &'n SilhouetteInstances) -> Option<(&'n Node, &mut Vec<u32>, &mut Vec<u32>)> {
        let number = self.stack.pop()?;
        Some((&all.top().nodes()[number as usize], &mut self.stack, &mut self.places))
    }
}

/// Adds the children of a node that are met: nodes to the first list, places to the second.
#[inline(always)]
fn add(node: &Node, mut met: u32, stack: &mut Vec<u32>, places: &mut Vec<u32>) {
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
