//! Distances between the surfaces of a map.

use crate::face::Face;
use crate::layer::EMPTY;

/// The light's width in texels at the edge of a blocker that shadows another surface of the map, which is also the width of the
/// penumbra there; the mean over these penumbrae, weighted by their widths. Infinite if no surface is behind another one.
///
/// With q = z₀/z − 1 the shaft from depth d to a light of radius r has the width `2r(d − z)/(d z t) = 2r(q − q')/(z₀ t)`
/// at depth z, in texels t.
pub(crate) fn shaft_texels(faces: &[Face], radius: f64) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for face in faces {
        let [first, _, third, ..] = face.layers.as_slice() else { continue };
        let scale = 2.0 * radius / (face.z0 * face.texel);
        for (near, far) in first.q().iter().zip(third.q()).filter(|(_, far)| **far != EMPTY) {
            let width = scale * f64::from(near - far);
            sum += width;
            squares += width * width;
        }
    }
    if sum > 0.0 { squares / sum } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use crate::options::MapOptions;
    use crate::{ShadowMap, contacts::shaft_texels};
    use glam::Vec3;
    use lobe_core::Sphere;

    /// Slabs under a light at the origin, each from one depth to another.
    fn slabs(depths: &[[f32; 2]]) -> ShadowMap {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (depth, turned) in depths.iter().flat_map(|[top, bottom]| [(*top, false), (*bottom, true)]) {
            let first = positions.len() as u32;
            // The width is proportional to the depth, so that all slabs cover the same part of the face.
            positions.extend(
                [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                    .map(|(x, z)| Vec3::new(x, -8.0, z) * (depth / 8.0)),
            );
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
            triangles.extend(if turned { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
        }
        let light = Sphere { center: Vec3::ZERO, radius: 0.5 };
        ShadowMap::build(&positions, &triangles, light, &MapOptions { resolution: 64, ..MapOptions::default() })
            .expect("good slabs")
    }

    #[test]
    fn width_between_slabs_is_the_closed_form() {
        let map = slabs(&[[4.0, 4.1], [5.0, 5.5]]);
        let expected = 2.0 * 0.5 * (5.0 - 4.0) / (5.0 * 4.0 * map.faces[0].texel);
        let width = shaft_texels(&map.faces, 0.5);
        assert!((width / expected - 1.0).abs() < 1e-4, "{width} {expected}");
    }

    #[test]
    fn one_slab_shadows_nothing_of_itself() {
        assert_eq!(shaft_texels(&slabs(&[[4.0, 5.0]]).faces, 0.5), f64::INFINITY);
        assert_eq!(shaft_texels(&[], 0.5), f64::INFINITY);
    }
}
