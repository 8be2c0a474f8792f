use glam::{DMat3, DVec3};

/// Eigenvectors, as columns, and eigenvalues of a symmetric matrix, by Jacobi's rotations. Those of a diagonal matrix
/// are the axes.
pub(crate) fn eigen(mut a: DMat3) -> (DMat3, DVec3) {
    let mut vectors = DMat3::IDENTITY;
    // Converges quadratically: 4 or 5 sweeps for f64.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a.col(q)[p];
            if off == 0.0 {
                continue;
            }
            let half_cot = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let tan = half_cot.signum() / (half_cot.abs() + (half_cot * half_cot + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let mut turn = DMat3::IDENTITY;
            (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (cos, cos);
            (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (tan * cos, -tan * cos);
            a = turn.transpose() * a * turn;
            vectors *= turn;
        }
    }
    (vectors, DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_and_values_make_the_matrix() {
        let matrices = [
            [2.0, 1.0, 0.5, 1.0, -3.0, 0.25, 0.5, 0.25, 1e-7],
            [1e12, 1e12, 1e12, 1e12, 1e12, 1e12, 1e12, 1e12, 1e12],
            [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [1e-20, 1.0, 1e-9, 1.0, 1e-20, 1e-9, 1e-9, 1e-9, 1.0],
            [0.0; 9],
        ];
        for m in matrices.map(|m| DMat3::from_cols_array(&m)) {
            let (vectors, values) = eigen(m);
            let scale = m.to_cols_array().iter().fold(1.0_f64, |s, x| s.max(x.abs()));
            let again = vectors * DMat3::from_diagonal(values) * vectors.transpose();
            assert!(again.abs_diff_eq(m, 1e-14 * scale), "{m}\n{again}");
            assert!((vectors.transpose() * vectors).abs_diff_eq(DMat3::IDENTITY, 1e-14));
        }
        let diagonal = DVec3::new(-0.3, 0.0, 7.0);
        assert_eq!(eigen(DMat3::from_diagonal(diagonal)), (DMat3::IDENTITY, diagonal));
    }
}
