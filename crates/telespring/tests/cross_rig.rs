//! The rig with ideal arms against the exact simulation of the continuous dyad and its spectrum.

use telespring::dde::linear::{Force, Trajectory, simulate};
use telespring::rig::{
    Agent, ConnectedMode, Laboratory, Observation, Recording, Schedule, Status, Target, Trial,
};
use telespring::spectrum::spectral_abscissa;
use telespring::verdicts::{Network as VerdictNetwork, sampled_spectral_radius};
use telespring::{Delay, DyadAxis, InvalidInput, hman};

const ARM_STIFFNESS: f64 = 120.0;

fn laboratory(period: f64) -> Laboratory {
    let mut laboratory = Laboratory::paper();
    laboratory.controller.sample_period = period;
    for side in &mut laboratory.stations {
        side.agent = Agent::Skilled { stiffness: ARM_STIFFNESS, damping: 0.0 };
    }
    laboratory
}

fn run(laboratory: &Laboratory, stiffness: f64, delay: Delay, duration: f64, rate: f64) -> Recording {
    laboratory.check().unwrap();
    let schedule = Schedule::new(duration, rate, laboratory.controller.sample_period).unwrap();
    let coupling = Some(ConnectedMode { stiffness, damping: 0.0, delay });
    Trial { laboratory, coupling, seed: 1, schedule }.record::<InvalidInput>([None, None]).unwrap()
}

/// The dyad on one axis; its operators are springs to the ground.
fn grounded(axis: usize, spring: f64) -> DyadAxis {
    let free = hman().axis(axis).unwrap();
    let [one, two] = free.sides;
    DyadAxis::with_operators(one.mass, one.damping, two.mass, two.damping, spring, spring, 0.0).unwrap()
}

/// A target at rest until 0.3 s, longer than any delay here: before the first packet is played the rig has
/// no spring, where the continuous dyad sees a partner at rest.
fn late(axis: usize, time: f64) -> f64 {
    let t = (time - 0.3).max(0.0);
    [0.05 * (5.18 * t).sin(), 0.1 * (1.0 - (2.59 * t).cos())][axis]
}

fn exact(axis: usize, stiffness: f64, delay: &Delay, duration: f64, rate: f64) -> Trajectory {
    let force = || Force::from_function(&mut |t| ARM_STIFFNESS * late(axis, t), &[0.3], duration).unwrap();
    let dyad = grounded(axis, ARM_STIFFNESS);
    simulate(&dyad, stiffness, delay, &[force(), force()], duration, rate, &Default::default()).unwrap()
}

/// Positions of both robots on one axis.
fn rig(axis: usize, stiffness: f64, delay: &Delay, duration: f64, rate: f64, period: f64) -> [Vec<f64>; 2] {
    let mut laboratory = laboratory(period);
    let ticks = (duration / period).round() as usize;
    let target = (0..=ticks).map(|tick| [0, 1].map(|axis| late(axis, tick as f64 * period))).collect();
    laboratory.target = Target::Sampled(target);
    let recording = run(&laboratory, stiffness, *delay, duration, rate);
    assert_eq!(recording.outcome.status, Status::Completed);
    [0, 1].map(|robot| recording.position.iter().map(|row| row[robot][axis]).collect())
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

#[test]
fn cross_the_rig_tends_to_the_continuous_dyad_at_first_order() {
    let (duration, rate) = (6.0, 50.0);
    let delays = [
        Delay::each_way(0.0).unwrap(),
        Delay::each_way(0.00037).unwrap(),
        Delay::each_way(0.083_595_3).unwrap(),
        Delay::new(0.0512, 0.090_133_7).unwrap(),
        Delay::each_way(0.167_19).unwrap(),
    ];
    for stiffness in [17.8, 71.23] {
        for delay in &delays {
            for axis in 0..2 {
                let truth = exact(axis, stiffness, delay, duration, rate);
                let [coarse, middle, fine] =
                    [1e-3, 5e-4, 2.5e-4].map(|period| rig(axis, stiffness, delay, duration, rate, period));
                for robot in 0..2 {
                    let truth = &truth.position[robot];
                    assert_eq!(truth.len(), fine[robot].len());
                    let error =
                        |got: &dyn Fn(usize) -> f64| largest((0..truth.len()).map(|i| got(i) - truth[i]));
                    let errors = [&coarse, &middle, &fine].map(|rig| error(&|i| rig[robot][i]));
                    let extrapolated = [
                        error(&|i| 2.0 * middle[robot][i] - coarse[robot][i]),
                        error(&|i| 2.0 * fine[robot][i] - middle[robot][i]),
                    ];
                    let size = largest(truth.iter().copied());
                    let case = format!("k {stiffness}, {delay:?}, axis {axis}, robot {robot}");
                    // a held force acts half a period late
                    assert!(errors[0] < 0.01 * size, "{case}: {errors:?}");
                    for pair in errors.windows(2) {
                        assert!((pair[0] / pair[1] - 2.0).abs() < 0.06, "{case}: {errors:?}");
                    }
                    // what first order leaves is of second order: a hundredth here
                    assert!(extrapolated[0] < 0.01 * errors[0], "{case}: {extrapolated:?}");
                    assert!(extrapolated[1] < 0.4 * extrapolated[0], "{case}: {extrapolated:?}");
                }
            }
        }
    }
}

/// Real part of the pair of roots that rules `values`, spaced by `step`: the least-squares fit of
/// x(t + 2h) = a x(t + h) − b x(t), whose b is e^(2αh).
fn growth(values: &[f64], lag: usize, step: f64) -> f64 {
    let (mut m, mut r) = ([[0.0; 2]; 2], [0.0; 2]);
    for i in 0..values.len() - 2 * lag {
        // equal weight for every instant of a growing movement
        let scale = 1.0 / (values[i].powi(2) + values[i + lag].powi(2));
        let (u, v, w) = (values[i + lag], -values[i], values[i + 2 * lag]);
        m[0][0] += u * u * scale;
        m[0][1] += u * v * scale;
        m[1][1] += v * v * scale;
        r[0] += u * w * scale;
        r[1] += v * w * scale;
    }
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[0][1];
    let b = (m[0][0] * r[1] - m[0][1] * r[0]) / determinant;
    b.ln() / (2.0 * lag as f64 * step)
}

#[test]
fn cross_an_unstable_condition_grows_at_the_rate_of_the_rightmost_root() {
    // 4 K_xy and 0.1 s in the ideal arms: x is unstable, y is not
    let (stiffness, delay) = (142.46, Delay::each_way(0.1).unwrap());
    let truth =
        [0, 1].map(|axis| spectral_abscissa(&grounded(axis, ARM_STIFFNESS), stiffness, &delay).unwrap());
    assert!(truth[0].value > 0.0 && truth[1].value < 0.0, "{truth:?}");
    let mut rates = Vec::new();
    for period in [1e-3, 5e-4, 2.5e-4] {
        let mut laboratory = laboratory(period);
        let ticks = (12.0 / period) as usize;
        let kick = |tick| if (tick as f64) * period < 0.2 { [1e-4, 1e-4] } else { [0.0; 2] };
        laboratory.target = Target::Sampled((0..=ticks).map(kick).collect());
        let recording = run(&laboratory, stiffness, delay, 12.0, 100.0);
        assert_eq!(recording.outcome.status, Status::Completed);
        let on = |axis: usize| recording.position.iter().map(|row| row[0][axis]).collect::<Vec<_>>();
        let (x, y) = (on(0), on(1));
        rates.push(growth(&x[800..], 12, 0.01));
        let envelope = |values: &[f64]| largest(values.iter().copied());
        assert!(envelope(&x[1100..]) > envelope(&x[800..900]));
        assert!(envelope(&y[1100..]) < 0.5 * envelope(&y[300..400]));
    }
    let extrapolated = 2.0 * rates[2] - rates[1];
    assert!((extrapolated - truth[0].value).abs() < 1e-3 * truth[0].value, "{rates:?}, {truth:?}");
}

#[test]
fn cross_a_free_dyad_grows_at_the_rate_of_the_sampled_spectrum() {
    // without arms only the springs are held, as the sampled verdict has it; a program pushes at the start
    let (stiffness, delay, period) = (142.46, Delay::each_way(0.1).unwrap(), 1e-3);
    let network = VerdictNetwork::new(delay, 0.0, 0.0, period, 0.0).unwrap();
    let mut laboratory = laboratory(period);
    for side in &mut laboratory.stations {
        side.agent = Agent::External;
    }
    let schedule = Schedule::new(8.0, 1000.0, period).unwrap();
    let coupling = Some(ConnectedMode { stiffness, damping: 0.0, delay });
    let trial = Trial { laboratory: &laboratory, coupling, seed: 1, schedule };
    let mut push = |seen: &Observation| Ok(if seen.time < 0.05 { [1e-6; 2] } else { [0.0; 2] });
    let mut rest = |_: &Observation| Ok([0.0; 2]);
    let recording = trial.record::<InvalidInput>([Some(&mut push), Some(&mut rest)]).unwrap();
    assert_eq!(recording.outcome.status, Status::Completed);
    for axis in 0..2 {
        let sampled = sampled_spectral_radius(&hman().axis(axis).unwrap(), stiffness, &network).unwrap();
        assert!(!sampled.is_stable());
        // the difference leaves out both robots' drift
        let apart: Vec<_> = recording.position.iter().map(|row| row[0][axis] - row[1][axis]).collect();
        let rate = growth(&apart[6000..], 150, period);
        // what is left of the faster decaying roots after 6 s
        assert!((rate / sampled.abscissa_equivalent - 1.0).abs() < 1e-9, "{rate}, {sampled:?}");
    }
}

#[test]
fn ref_the_ideal_arm_gives_the_agents_force_exactly() {
    // F = k_c (p* − p), Eq. 13, bit for bit, and 0 N from the robot in the unconnected mode
    let mut laboratory = laboratory(1e-3);
    laboratory.target = Target::FigureEight { amplitude: [0.05, 0.1], angular_frequency: 2.59 };
    let schedule = Schedule::new(2.0, 100.0, 1e-3).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: None, seed: 1, schedule };
    let recording = trial.record::<InvalidInput>([None, None]).unwrap();
    for row in 0..recording.position.len() {
        let t = row as f64 * 0.01;
        let target = recording.target[row];
        // Eq. 12; rounding of a sine of up to 10 rad
        assert!((target[0] - 0.05 * (2.0 * 2.59 * t).sin()).abs() < 1e-16);
        assert!((target[1] - 0.1 * (2.59 * t).sin()).abs() < 1e-16);
        for robot in 0..2 {
            assert_eq!(recording.coupling_force[row][robot], [0.0; 2]);
            for axis in 0..2 {
                let expected = 120.0 * (target[axis] - recording.position[row][robot][axis]);
                assert_eq!(recording.handle_force[row][robot][axis], expected);
            }
        }
    }
}
