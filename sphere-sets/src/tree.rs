use core::f32::consts::PI;

use glam::Vec3;

/// Triangles in a leaf.
const LEAF: usize = 6;

/// A node is replaced by its dipole from this many of its radii away. The error of the winding number of a closed mesh
/// stays below a few hundredths there; the threshold is 0.5.
const FAR: f32 = 2.5;

/// A bounding-volume tree over triangles that answers how far away they are and how often they wind around a point.
pub(crate) struct TriangleTree {
    triangles: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

struct Node {
    lo: Vec3,
    hi: Vec3,
    /// Leaf: first triangle. Inner node: number of the right child; the left one follows its parent.
    first: u32,
    /// Triangles of a leaf, 0 for an inner node.
    count: u32,
    /// Vector area ∫ n dA, about `pole`.
    dipole: Vec3,
    pole: Vec3,
    /// Bounds the triangles around `pole`.
    radius: f32,
}

impl TriangleTree {
    pub(crate) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut tree = Self { triangles: triangles.to_vec(), nodes: Vec::with_capacity(triangles.len() / 2) };
        tree.split(0, triangles.len());
        tree
    }

    fn split(&mut self, start: usize, end: usize) {
        let own = self.nodes.len();
        self.nodes.push(Node::around(&self.triangles[start..end]));
        if end - start <= LEAF {
            self.nodes[own].first = start as u32;
            self.nodes[own].count = (end - start) as u32;
            return;
        }
        let size = self.nodes[own].hi - self.nodes[own].lo;
        let axis = size.max_position();
        let middle = (end - start) / 2;
        self.triangles[start..end].select_nth_unstable_by(middle, |a, b| {
            let key = |t: &[Vec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            key(a).total_cmp(&key(b))
        });
        self.split(start, start + middle);
        self.nodes[own].first = self.nodes.len() as u32;
        self.split(start + middle, end);
    }

    /// Distance from `p` to the nearest triangle, or `at_most` if that is less. O(log n) typically.
    pub(crate) fn distance(&self, p: Vec3, at_most: f32) -> f32 {
        let mut best = at_most * at_most;
        let mut stack = [(0.0_f32, 0_u32); 64];
        let mut depth = 0;
        let mut current = Some((self.nodes[0].distance_sq(p), 0_u32));
        while let Some((lower, number)) = current.take() {
            if lower < best {
                let node = &self.nodes[number as usize];
                if node.count > 0 {
                    for triangle in &self.triangles[node.first as usize..(node.first + node.count) as usize] {
                        best = best.min(distance_sq(p, triangle));
                    }
                } else {
                    let (left, right) = (number + 1, node.first);
                    let (dl, dr) =
                        (self.nodes[left as usize].distance_sq(p), self.nodes[right as usize].distance_sq(p));
                    let (near, far) = if dl <= dr { ((dl, left), (dr, right)) } else { ((dr, right), (dl, left)) };
                    // The tree halves its triangles, so 64 levels hold more than 2⁶⁴ of them.
                    stack[depth] = far;
                    depth += 1;
                    current = Some(near);
                    continue;
                }
            }
            if depth > 0 {
                depth -= 1;
                current = Some(stack[depth]);
            }
        }
        best.sqrt()
    }

    /// Whether a ray meets a triangle; a ray in the plane of a node's face may miss it. O(log n) typically.
    pub(crate) fn blocks(&self, from: Vec3, toward: Vec3) -> bool {
        let inverse = toward.recip();
        let mut stack = [0_u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let number = stack[depth];
            let node = &self.nodes[number as usize];
            let (a, b) = ((node.lo - from) * inverse, (node.hi - from) * inverse);
            let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element() * 1.000_01);
            if enter > leave {
                continue;
            }
            if node.count > 0 {
                let triangles = &self.triangles[node.first as usize..(node.first + node.count) as usize];
                if triangles.iter().any(|t| ray_meets(from, toward, t)) {
                    return true;
                }
            } else {
                stack[depth] = node.first;
                stack[depth + 1] = number + 1;
                depth += 2;
            }
        }
        false
    }

    /// Generalised winding number of the triangles around `p`: 1 inside a closed mesh, 0 outside, fractions near the
    /// holes of an open one.
    ///
    /// Sum of solid angles / 4π (A. Jacobson et al., *Robust Inside-Outside Segmentation using Generalized Winding
    /// Numbers*, SIGGRAPH 2013), distant groups of triangles as dipoles (G. Barill et al., *Fast Winding Numbers for
    /// Soups and Clouds*, SIGGRAPH 2018). O(log n).
    pub(crate) fn winding(&self, p: Vec3) -> f32 {
        let mut stack = [0_u32; 64];
        let mut depth = 1;
        let mut angle = 0.0;
        while depth > 0 {
            depth -= 1;
            let number = stack[depth];
            let node = &self.nodes[number as usize];
            let to = node.pole - p;
            let distance_sq = to.length_squared();
            if distance_sq > (FAR * node.radius) * (FAR * node.radius) {
                angle += node.dipole.dot(to) / (distance_sq * distance_sq.sqrt());
            } else if node.count > 0 {
                for triangle in &self.triangles[node.first as usize..(node.first + node.count) as usize] {
                    angle += solid_angle(p, triangle);
                }
            } else {
                stack[depth] = node.first;
                stack[depth + 1] = number + 1;
                depth += 2;
            }
        }
        angle / (4.0 * PI)
    }

    /// Whether `p` counts as inside: |winding number| > ½.
    pub(crate) fn contains(&self, p: Vec3) -> bool {
        let node = &self.nodes[0];
        p.cmpge(node.lo).all() && p.cmple(node.hi).all() && self.winding(p).abs() > 0.5
    }
}

impl Node {
    fn around(triangles: &[[Vec3; 3]]) -> Self {
        let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (mut dipole, mut weighted, mut area) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for [a, b, c] in triangles {
            lo = lo.min(*a).min(*b).min(*c);
            hi = hi.max(*a).max(*b).max(*c);
            let normal = (b - a).cross(c - a) * 0.5;
            dipole += normal;
            area += normal.length();
            weighted += (a + b + c) * (normal.length() / 3.0);
        }
        let pole = if area > 0.0 { weighted / area } else { (lo + hi) * 0.5 };
        let radius = triangles.iter().flatten().map(|v| v.distance(pole)).fold(0.0, f32::max);
        Self { lo, hi, first: 0, count: 0, dipole, pole, radius }
    }

    fn distance_sq(&self, p: Vec3) -> f32 {
        (p - p.clamp(self.lo, self.hi)).length_squared()
    }
}

/// By Cramer's rule (T. Möller, B. Trumbore, *Fast, Minimum Storage Ray-Triangle Intersection*, 1997).
fn ray_meets(from: Vec3, toward: Vec3, &[a, b, c]: &[Vec3; 3]) -> bool {
    let (e1, e2) = (b - a, c - a);
    let p = toward.cross(e2);
    let scale = 1.0 / e1.dot(p);
    let s = from - a;
    let u = s.dot(p) * scale;
    let q = s.cross(e1);
    let v = toward.dot(q) * scale;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(q) * scale > 0.0
}

/// Signed solid angle of a triangle seen from `p`, in (−2π, 2π) (A. van Oosterom, J. Strackee, *The Solid Angle of a
/// Plane Triangle*, IEEE Trans. Biomed. Eng. 30 (2), 1983).
fn solid_angle(p: Vec3, triangle: &[Vec3; 3]) -> f32 {
    let [a, b, c] = triangle.map(|v| v - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let determinant = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * determinant.atan2(denominator)
}

/// Squared distance from `p` to a triangle: to its plane if the foot is inside, else to the nearest edge.
fn distance_sq(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> f32 {
    let normal = (b - a).cross(c - a);
    let beside = |from: Vec3, to: Vec3| normal.cross(to - from).dot(p - from);
    if beside(a, b) >= 0.0 && beside(b, c) >= 0.0 && beside(c, a) >= 0.0 {
        let height = normal.dot(p - a);
        return height * height / normal.length_squared();
    }
    let edge = |from: Vec3, to: Vec3| {
        let along = to - from;
        let t = (along.dot(p - from) / along.length_squared()).clamp(0.0, 1.0);
        (from + along * t - p).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn rays_agree_with_brute_force() {
        let mesh = shapes::bumpy_sphere(12);
        let tree = TriangleTree::new(&mesh);
        let mut blocked = 0;
        for i in 0..2000 {
            let (from, mut toward) = (shapes::scattered(i) * 1.6, shapes::scattered(i + 5000));
            if i % 4 == 0 {
                toward.y = 0.0;
            }
            let want = mesh.iter().any(|t| ray_meets(from, toward, t));
            assert_eq!(tree.blocks(from, toward), want);
            blocked += usize::from(want);
        }
        assert!((200..1800).contains(&blocked), "{blocked}");
    }

    #[test]
    fn distance_agrees_with_brute_force() {
        let mesh = shapes::bumpy_sphere(12);
        let tree = TriangleTree::new(&mesh);
        for i in 0..200 {
            let p = shapes::scattered(i) * 1.5;
            // Brute force: dense barycentric samples, spacing ≤ 1/64 of an edge of ≈ 0.3, hence an error ≤ 0.003.
            let sampled = mesh
                .iter()
                .flat_map(|&[a, b, c]| {
                    (0..=64).flat_map(move |i| {
                        (0..=64 - i).map(move |j| a + (b - a) * (i as f32 / 64.0) + (c - a) * (j as f32 / 64.0))
                    })
                })
                .map(|q| q.distance(p))
                .fold(f32::INFINITY, f32::min);
            let found = tree.distance(p, f32::INFINITY);
            assert!(found <= sampled + 1e-6 && found > sampled - 0.01, "{p}: {found} against {sampled}");
        }
    }

    #[test]
    fn winding_is_one_inside_and_zero_outside() {
        let mesh = shapes::bumpy_sphere(12);
        let tree = TriangleTree::new(&mesh);
        for i in 0..500 {
            let p = shapes::scattered(i) * 1.6;
            let exact: f64 =
                mesh.iter().map(|t| f64::from(solid_angle(p, t))).sum::<f64>() / (4.0 * std::f64::consts::PI);
            let fast = tree.winding(p);
            assert!((f64::from(fast) - exact).abs() < 0.03, "{p}: {fast} against {exact}");
            assert!((exact - exact.round()).abs() < 1e-3);
        }
    }

    #[test]
    fn point_on_the_surface_is_finite() {
        let mesh = shapes::bumpy_sphere(6);
        let tree = TriangleTree::new(&mesh);
        for triangle in &mesh {
            for p in [triangle[0], (triangle[0] + triangle[1]) * 0.5, (triangle[0] + triangle[1] + triangle[2]) / 3.0] {
                assert!(tree.distance(p, f32::INFINITY) < 1e-6);
                assert!(tree.winding(p).is_finite());
            }
        }
    }
}
