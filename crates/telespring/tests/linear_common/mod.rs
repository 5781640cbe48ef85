//! An independent solver for the tests of the linear simulation.
#![allow(dead_code)]

use nalgebra::{DMatrix, DVector};
use telespring::DyadAxis;

/// Stages; the order is twice as many.
const STAGES: usize = 10;

/// Gauss-Legendre collocation of the dyad with steps that divide both delays.
pub struct Collocation {
    axis: DyadAxis,
    stiffness: f64,
    /// Delays in steps: forward, backward.
    delays: [usize; 2],
    step: f64,
    nodes: Vec<f64>,
    weights: Vec<f64>,
    integrals: DMatrix<f64>,
}

/// Values at the ends of the steps.
pub struct Reference {
    pub position: [Vec<f64>; 2],
    pub velocity: [Vec<f64>; 2],
}

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
fn gauss(count: usize) -> (Vec<f64>, Vec<f64>) {
    let legendre = |x: f64| {
        let (mut p0, mut p1) = (1.0, x);
        for n in 1..count {
            let n = n as f64;
            (p0, p1) = (p1, ((2.0 * n + 1.0) * x * p1 - n * p0) / (n + 1.0));
        }
        (p1, count as f64 * (x * p1 - p0) / (x * x - 1.0))
    };
    let mut nodes = Vec::new();
    let mut weights = Vec::new();
    for i in 0..count {
        let mut x = (std::f64::consts::PI * (count as f64 - i as f64 - 0.25) / (count as f64 + 0.5)).cos();
        for _ in 0..20 {
            let (p, slope) = legendre(x);
            x -= p / slope;
        }
        let slope = legendre(x).1;
        nodes.push(0.5 * (1.0 + x));
        weights.push(1.0 / ((1.0 - x * x) * slope * slope));
    }
    (nodes, weights)
}

impl Collocation {
    pub fn new(axis: &DyadAxis, stiffness: f64, delays: [usize; 2], step: f64) -> Self {
        let (nodes, weights) = gauss(STAGES);
        let lagrange = |j: usize, t: f64| {
            (0..STAGES).filter(|&l| l != j).map(|l| (t - nodes[l]) / (nodes[j] - nodes[l])).product::<f64>()
        };
        let integrals = DMatrix::from_fn(STAGES, STAGES, |i, j| {
            nodes[i] * (0..STAGES).map(|q| weights[q] * lagrange(j, nodes[i] * nodes[q])).sum::<f64>()
        });
        Self { axis: *axis, stiffness, delays, step, nodes, weights, integrals }
    }

    /// `past` gives position and velocity before 0 and the start at 0.
    pub fn run(
        &self,
        force: [&dyn Fn(f64) -> f64; 2],
        past: [&dyn Fn(f64) -> (f64, f64); 2],
        steps: usize,
    ) -> Reference {
        let (h, c) = (self.step, self.axis.coupling_damping);
        // what robot i receives comes with this many steps of delay
        let lag = [self.delays[1], self.delays[0]];
        let side = |i: usize| self.axis.sides[i];
        let p = [0, 1].map(|i| (side(i).damping + c) / side(i).mass);
        let q = [0, 1].map(|i| (side(i).ground_stiffness + self.stiffness) / side(i).mass);
        let (a, eye) = (&self.integrals, DMatrix::<f64>::identity(STAGES, STAGES));
        let square = a * a;
        let mut x: [Vec<f64>; 2] = [0, 1].map(|i| vec![past[i](0.0).0]);
        let mut v: [Vec<f64>; 2] = [0, 1].map(|i| vec![past[i](0.0).1]);
        let mut stages: [Vec<(DVector<f64>, DVector<f64>)>; 2] = [vec![], vec![]];
        // both robots at once where a delay of zero couples them within a step
        let mut matrix = DMatrix::<f64>::zeros(2 * STAGES, 2 * STAGES);
        for i in 0..2 {
            let block = &eye + a * (p[i] * h) + &square * (q[i] * h * h);
            matrix.view_mut((i * STAGES, i * STAGES), (STAGES, STAGES)).copy_from(&block);
            if lag[i] == 0 {
                let block = -(a * (c * h) + &square * (self.stiffness * h * h)) / side(i).mass;
                matrix.view_mut((i * STAGES, (1 - i) * STAGES), (STAGES, STAGES)).copy_from(&block);
            }
        }
        let solver = matrix.lu();
        for n in 0..steps {
            let mut right = DVector::<f64>::zeros(2 * STAGES);
            for i in 0..2 {
                for s in 0..STAGES {
                    let (x0, v0) = (x[i][n], v[i][n]);
                    let node = self.nodes[s];
                    let (dx, dv) = if lag[i] == 0 {
                        (x[1 - i][n] + node * h * v[1 - i][n], v[1 - i][n])
                    } else if n >= lag[i] {
                        let (dx, dv) = &stages[1 - i][n - lag[i]];
                        (dx[s], dv[s])
                    } else {
                        past[1 - i]((n as f64 - lag[i] as f64 + node) * h)
                    };
                    let drive = self.stiffness * dx + c * dv + force[i]((n as f64 + node) * h);
                    right[i * STAGES + s] = drive / side(i).mass - p[i] * v0 - q[i] * (x0 + node * h * v0);
                }
            }
            let solution = solver.solve(&right).expect("the collocation matrix is regular");
            for i in 0..2 {
                let w = solution.rows(i * STAGES, STAGES).into_owned();
                let (x0, v0) = (x[i][n], v[i][n]);
                let speed = a * &w * h + DVector::from_element(STAGES, v0);
                let place = a * &speed * h + DVector::from_element(STAGES, x0);
                let weights = DVector::from_row_slice(&self.weights);
                x[i].push(x0 + h * weights.dot(&speed));
                v[i].push(v0 + h * weights.dot(&w));
                stages[i].push((place, speed));
            }
        }
        Reference { position: x, velocity: v }
    }
}

/// Every `stride`-th value.
pub fn sampled_at(values: &[f64], stride: usize) -> Vec<f64> {
    values.iter().copied().step_by(stride).collect()
}

/// The largest difference, relative to the largest expected value.
pub fn difference(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let size = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = got.iter().zip(expected).fold(0.0_f64, |m, (a, b)| {
        assert!(a.is_finite());
        m.max((a - b).abs())
    });
    if worst == 0.0 { 0.0 } else { worst / size }
}

#[track_caller]
#[expect(clippy::disallowed_methods, clippy::disallowed_macros, reason = "shows the errors on request")]
pub fn close(got: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    let error = difference(got, expected);
    if std::env::var_os("TELESPRING_SHOW").is_some() {
        println!("{what}: {error:.1e}");
    }
    assert!(error <= tolerance, "{what}: relative difference {error:e} above {tolerance:e}");
}
