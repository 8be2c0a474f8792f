//! Random triangles.

use super::{Soup, cuboid, globe, turn};
use glam::Vec3;
use lobe_core::oracle::Random;

/// A point in a sphere.
pub(crate) fn vec(random: &mut Random, size: f64) -> Vec3 {
    (random.axis() * (size * random.between(0.0, 1.0).cbrt())).as_vec3()
}

/// Triangles of a kind: the composition differs by kind, the arrangement is random.
pub(crate) fn soup(kind: usize, random: &mut Random) -> Soup {
    let mut soup = Soup::default();
    match kind {
        // Triangles without neighbours.
        0 => {
            for _ in 0..random.between(1.0, 60.0) as usize {
                let (center, size) = (vec(random, 1.5), random.log_uniform(0.01, 2.0));
                soup.add(core::array::from_fn(|_| center + vec(random, size)));
            }
        }
        // Boxes through each other.
        1 => {
            for _ in 0..random.between(1.0, 8.0) as usize {
                let center = vec(random, 1.2);
                soup.append(&cuboid(random, center, 0.8));
            }
        }
        // Spheres, some with holes, some with triangles wound the other way.
        2 => {
            for _ in 0..random.between(1.0, 5.0) as usize {
                let (center, radius) = (vec(random, 1.2), random.log_uniform(0.05, 0.9) as f32);
                let rings = random.between(3.0, 12.0) as u32;
                let mut one = globe(center, radius, rings);
                let (holes, turned) = (random.between(-0.3, 0.3), random.between(-0.5, 0.5));
                one.triangles.retain(|_| random.between(0.0, 1.0) > holes);
                for t in &mut one.triangles {
                    if random.between(0.0, 1.0) < turned {
                        t.swap(0, 1);
                    }
                }
                soup.append(&one);
            }
        }
        // Strips and fans with common corners: more than two triangles at some edges, one at others.
        3 => {
            let corners = random.between(4.0, 14.0) as usize;
            soup.positions = (0..corners).map(|_| vec(random, 1.5)).collect();
            for _ in 0..random.between(1.0, 40.0) as usize {
                let t: [u32; 3] = core::array::from_fn(|_| random.between(0.0, corners as f64) as u32);
                if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                    soup.triangles.push(t);
                }
            }
        }
        // Cards: many quadrilaterals of two triangles.
        4 => {
            for _ in 0..random.between(5.0, 120.0) as usize {
                let (c, q, s) = (vec(random, 1.5), turn(random), random.log_uniform(0.02, 0.4) as f32);
                let p = [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, y)| c + q * Vec3::new(x, y, 0.0));
                let first = soup.positions.len() as u32;
                soup.positions.extend(p);
                soup.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        // Needles: as thin as rounding.
        _ => {
            for _ in 0..random.between(1.0, 30.0) as usize {
                let (a, b) = (vec(random, 1.5), vec(random, 1.5));
                let aside = vec(random, 1.0).normalize() * random.log_uniform(1e-7, 1e-2) as f32;
                soup.add([a, b, 0.5 * (a + b) + aside]);
            }
        }
    }
    soup
}
