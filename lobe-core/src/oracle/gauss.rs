use core::f64::consts::PI;

/// A Gauss–Legendre rule on [−1, 1].
#[derive(Clone, Debug)]
pub(super) struct Gauss {
    nodes: Vec<(f64, f64)>,
}

impl Gauss {
    /// The rule of `n` points, exact for polynomials up to degree `2n − 1`: roots of `P_n` by Newton's method.
    pub(super) fn new(n: usize) -> Self {
        let legendre = |x: f64| {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
            }
            (p1, n as f64 * (x * p1 - p0) / (x * x - 1.0))
        };
        let node = |i: usize| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..8 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let slope = legendre(x).1;
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        };
        Self { nodes: (0..n).map(node).collect() }
    }

    /// `∫ f` over [from, to].
    pub(super) fn integrate(&self, from: f64, to: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        half * self.nodes.iter().map(|&(x, w)| w * f(middle + half * x)).sum::<f64>()
    }

    /// `∫ f` over [from, to] cut into equal panels.
    pub(super) fn composite(&self, from: f64, to: f64, panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
        let width = (to - from) / panels as f64;
        (0..panels).map(|i| from + i as f64 * width).map(|start| self.integrate(start, start + width, &mut f)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_polynomials() {
        for n in [2, 5, 8, 16, 24] {
            let gauss = Gauss::new(n);
            let degree = 2 * n as i32 - 2;
            let exact = 2.0 / f64::from(degree + 1);
            assert!((gauss.integrate(-1.0, 1.0, |x| x.powi(degree)) - exact).abs() < 1e-14);
        }
    }
}
