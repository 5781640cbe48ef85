//! Transfer functions: the response of the handles to forces and of one side to the other.

use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};

use super::open_loop::{OpenLoop, check_frequency};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};

/// The diagonal of the transfer matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Convention {
    /// X₁/F₁ = P₂/χ and X₂/F₂ = P₁/χ, from the equations of motion.
    #[default]
    Exact,
    /// Eq. 2 as printed by Du, Kulkarni, Kager and Campolo, with the diagonal swapped; for comparison.
    Paper,
}

/// A frequency response from one input to one output.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseCurve {
    /// Angular frequencies as given, rad/s.
    pub frequency: Vec<f64>,
    /// The complex response at each frequency.
    pub value: Vec<Complex64>,
    /// The magnitude.
    pub magnitude: Vec<f64>,
    /// The phase, rad, continuous from ω → 0⁺.
    pub phase: Vec<f64>,
}

/// The transfer matrix over frequency; entry `[output][input]` is Xₒᵤₜₚᵤₜ/Fᵢₙₚᵤₜ in m/N, robot 1 first.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// Angular frequencies as given, rad/s.
    pub frequency: Vec<f64>,
    /// The matrix at each frequency, m/N.
    pub value: Vec<[[Complex64; 2]; 2]>,
    /// The magnitudes, m/N.
    pub magnitude: Vec<[[f64; 2]; 2]>,
    /// The phases, rad, continuous from ω → 0⁺: from 0 there, or from −π/2 for free handles.
    pub phase: Vec<[[f64; 2]; 2]>,
    /// Frequencies up to the largest requested one at which a characteristic root lies on the imaginary
    /// axis within rounding. The phase falls by π there, as for a root just to the left.
    pub poles_on_axis: Vec<f64>,
}

impl FrequencyResponse {
    /// One entry as a curve: the motion of robot `output` (0 or 1) under the force on robot `input`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a robot is neither 0 nor 1.
    pub fn entry(&self, output: usize, input: usize) -> Result<ResponseCurve> {
        check_robot("output", output)?;
        check_robot("input", input)?;
        Ok(ResponseCurve {
            frequency: self.frequency.clone(),
            value: self.value.iter().map(|matrix| matrix[output][input]).collect(),
            magnitude: self.magnitude.iter().map(|matrix| matrix[output][input]).collect(),
            phase: self.phase.iter().map(|matrix| matrix[output][input]).collect(),
        })
    }
}

/// The transfer matrix from the forces (f₁, f₂) to the positions (x₁, x₂) at a complex `s` (1/s).
///
/// Entry `[output][input]` is in m/N, robot 1 first. The diagonal is P₂/χ, P₁/χ; X₁/F₂ is (k + c s)
/// e^(−s·backward)/χ and X₂/F₁ is (k + c s) e^(−s·forward)/χ. This is Eq. 2 of Du, Kulkarni, Kager and
/// Campolo with a corrected diagonal (and transposed there, rows being forces). χ is evaluated without
/// cancellation near s = 0.
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range or `s` is a pole: s = 0 for free handles, where
/// [`mobility_matrix`] is finite.
///
/// # Examples
///
/// ```
/// use num_complex::Complex64;
/// use telespring::response::{Convention, transfer_matrix};
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 4.0, 2.0, 5.0)?;
/// let s = Complex64::new(0.0, 3.0);
/// let matrix = transfer_matrix(&axis, 10.0, &Delay::each_way(0.1)?, s, Convention::Exact)?;
/// // Robot 1's equation of motion, unit force on it: (m₁s² + b₁s + k) X₁ − k e^(−sδ) X₂ = 1.
/// let balance = (s * s + 4.0 * s + 10.0) * matrix[0][0] - 10.0 * (-0.1 * s).exp() * matrix[1][0];
/// assert!((balance - 1.0).norm() < 1e-14);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn transfer_matrix(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    s: Complex64,
    convention: Convention,
) -> Result<[[Complex64; 2]; 2]> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    let rigid_body = open_loop.rigid_body_factor(s);
    check_finite("s", s, deflated_matrix(&open_loop, check_laplace_point(delay, s)?, convention, rigid_body))
}

/// The mobility matrix from the forces to the velocities, s times [`transfer_matrix`], in (m/s)/N. It is
/// finite at s = 0 even for free handles, where both robots drift at 1/(b₁ + b₂ + 2δk) under a unit force
/// (δ is the mean one-way delay).
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range or `s` is a pole.
///
/// # Examples
///
/// ```
/// use num_complex::Complex64;
/// use telespring::response::mobility_matrix;
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 4.0, 2.0, 5.0)?;
/// let drift = mobility_matrix(&axis, 10.0, &Delay::each_way(0.1)?, Complex64::ZERO)?;
/// assert!((drift[0][0].re - 1.0 / (4.0 + 5.0 + 0.2 * 10.0)).abs() < 1e-15);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn mobility_matrix(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    s: Complex64,
) -> Result<[[Complex64; 2]; 2]> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    let s = check_laplace_point(delay, s)?;
    let factor = if open_loop.chi.rigid_body { Complex64::ONE } else { s };
    let matrix = deflated_matrix(&open_loop, s, Convention::Exact, Complex64::ONE);
    check_finite("s", s, matrix.map(|row| row.map(|entry| entry * factor)))
}

/// The transfer matrix with magnitude and phase at angular frequencies (rad/s), in any order.
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range or a frequency is a pole (0 for free handles).
///
/// # Examples
///
/// ```
/// use telespring::response::{Convention, frequency_response};
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0)?;
/// let delay = Delay::each_way(0.1)?;
/// let response = frequency_response(&axis, 10.0, &delay, &[1e-6, 5.0], Convention::Exact)?;
/// assert!((response.phase[0][0][0] + std::f64::consts::FRAC_PI_2).abs() < 1e-5);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn frequency_response(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    frequency: &[f64],
    convention: Convention,
) -> Result<FrequencyResponse> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    let mut order = Vec::with_capacity(frequency.len());
    for (i, &w) in frequency.iter().enumerate() {
        check_frequency(&format!("frequency[{i}]"), w)?;
        order.push(i);
    }
    order.sort_by(|&a, &b| frequency[a].total_cmp(&frequency[b]));
    let nodes: Vec<f64> = order.iter().map(|&i| frequency[i]).collect();
    let followed = open_loop.follow_argument(&nodes);
    let at_rest = if open_loop.chi.rigid_body { FRAC_PI_2 } else { 0.0 };
    let mut chi_phase = vec![0.0; frequency.len()];
    for (&i, &argument) in order.iter().zip(&followed.argument) {
        chi_phase[i] = at_rest + argument;
    }
    let mut response = FrequencyResponse {
        frequency: frequency.to_vec(),
        value: Vec::with_capacity(frequency.len()),
        magnitude: Vec::with_capacity(frequency.len()),
        phase: Vec::with_capacity(frequency.len()),
        poles_on_axis: followed.zeros,
    };
    for (i, (&w, chi)) in frequency.iter().zip(chi_phase).enumerate() {
        let s = Complex64::new(0.0, w);
        let rigid_body = open_loop.rigid_body_factor(s);
        let matrix = check_finite(
            &format!("frequency[{i}]"),
            w,
            deflated_matrix(&open_loop, s, convention, rigid_body),
        )?;
        let coupling = (open_loop.chi.coupling_damping * w).atan2(open_loop.chi.stiffness);
        let [own1, own2] = diagonal_sides(convention).map(|side| open_loop.chi.sides[side].phase(w) - chi);
        response.phase.push([
            [own1, coupling - w * delay.backward() - chi],
            [coupling - w * delay.forward() - chi, own2],
        ]);
        response.magnitude.push(matrix.map(|row| row.map(|entry| entry.norm())));
        response.value.push(matrix);
    }
    Ok(response)
}

/// The open-loop response L(jω) = −(k + cjω)² e^(−jωT)/(P₁P₂), with round-trip delay T, at angular
/// frequencies.
///
/// [`nyquist()`](crate::response::nyquist()) draws this locus, and Fig. 3 of Du, Kulkarni, Kager and
/// Campolo means it (its caption lacks a factor k e^(−δs)). The phase starts at +π (L = −1 at rest for free
/// handles) and is critical at −π, the −180° of that figure. −L is the product of both
/// [`partner_response`]s.
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range or a frequency is a pole (an undamped side).
///
/// # Examples
///
/// ```
/// use telespring::response::open_loop;
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0)?;
/// let curve = open_loop(&axis, 10.0, &Delay::each_way(0.1)?, &[0.0, 2.0])?;
/// assert_eq!(curve.value[0].re, -1.0); // free handles: the rigid-body root
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn open_loop(axis: &DyadAxis, stiffness: f64, delay: &Delay, frequency: &[f64]) -> Result<ResponseCurve> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    response_curve(frequency, |w| (open_loop.value(Complex64::new(0.0, w)), PI + open_loop.loop_phase(w)))
}

/// The response of robot `robot` (0 or 1) to its partner, Xᵢ/Xⱼ = (k + cjω) e^(−jωδ)/Pᵢ, at angular
/// frequencies; δ is the delay towards it. Magnitude ratio and phase shift as in Fig. 4 of Du, Kulkarni,
/// Kager and Campolo.
///
/// Why this response: the caption says that delay moves the phase "without affecting the magnitude ratio",
/// which rules out every closed-loop response (χ contains the delay), and it measures phase "relative to
/// the input", after a paper on transmission from one joint to the next. For identical robots its square is
/// −L. It therefore exceeds 1 exactly if the stiffness exceeds b²/(2m), and a phase of −180° is critical,
/// both as the caption says.
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range or a frequency is a pole (an undamped side).
///
/// # Examples
///
/// ```
/// use telespring::response::partner_response;
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0)?;
/// // k = b²/m, twice the critical stiffness: at its resonance the partner's motion is amplified.
/// let curve = partner_response(&axis, 16.0, &Delay::each_way(0.1)?, 1, &[0.0, 2.8])?;
/// assert!(curve.magnitude[0] == 1.0 && curve.magnitude[1] > 1.0);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn partner_response(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    robot: usize,
    frequency: &[f64],
) -> Result<ResponseCurve> {
    check_robot("robot", robot)?;
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    let side = open_loop.chi.sides[robot];
    let towards = if robot == 1 { delay.forward() } else { delay.backward() };
    response_curve(frequency, |w| {
        let s = Complex64::new(0.0, w);
        let coupling = open_loop.chi.coupling(s);
        (
            coupling / side.value(s) * (-s * towards).exp(),
            (coupling.im).atan2(coupling.re) - side.phase(w) - w * towards,
        )
    })
}

/// The sides whose factors P stand on the diagonal of the transfer matrix.
fn diagonal_sides(convention: Convention) -> [usize; 2] {
    match convention {
        Convention::Exact => [1, 0],
        Convention::Paper => [0, 1],
    }
}

/// The transfer matrix with numerators divided by `rigid_body` N(s).
fn deflated_matrix(
    open_loop: &OpenLoop,
    s: Complex64,
    convention: Convention,
    rigid_body: Complex64,
) -> [[Complex64; 2]; 2] {
    let [own1, own2] = diagonal_sides(convention).map(|side| open_loop.chi.sides[side].value(s));
    let coupling = open_loop.chi.coupling(s);
    let to_robot1 = coupling * (-s * open_loop.delay.backward()).exp();
    let to_robot2 = coupling * (-s * open_loop.delay.forward()).exp();
    let deflated = open_loop.chi.value(s);
    [[own1, to_robot1], [to_robot2, own2]].map(|row| row.map(|entry| entry / deflated / rigid_body))
}

/// Rejects a transfer matrix that is infinite at a pole.
fn check_finite(
    field: &str,
    place: impl ToString,
    matrix: [[Complex64; 2]; 2],
) -> Result<[[Complex64; 2]; 2]> {
    if matrix.iter().flatten().all(|entry| entry.is_finite()) {
        Ok(matrix)
    } else {
        Err(pole_error(field, place))
    }
}

/// The error for a frequency response at a pole.
fn pole_error(field: &str, place: impl ToString) -> InvalidInput {
    InvalidInput::new(
        field,
        place,
        "the response is infinite there",
        "Choose a nearby point; for free handles the velocities are finite at s = 0.",
    )
}

/// The transfer of a signal as a curve at angular frequencies, from its value and phase at one frequency.
fn response_curve(frequency: &[f64], at: impl Fn(f64) -> (Complex64, f64)) -> Result<ResponseCurve> {
    let mut value = Vec::with_capacity(frequency.len());
    let mut phase = Vec::with_capacity(frequency.len());
    for (i, &w) in frequency.iter().enumerate() {
        let field = || format!("frequency[{i}]");
        check_frequency(&field(), w)?;
        let (response, angle) = at(w);
        if !response.is_finite() {
            return Err(pole_error(&field(), w));
        }
        value.push(response);
        phase.push(angle);
    }
    let magnitude = value.iter().map(|response| response.norm()).collect();
    Ok(ResponseCurve { frequency: frequency.to_vec(), value, magnitude, phase })
}

/// Checks the index of a robot in a transfer matrix.
fn check_robot(field: &str, robot: usize) -> Result<usize> {
    if robot < 2 {
        return Ok(robot);
    }
    Err(InvalidInput::new(field, robot, "a dyad has the robots 0 and 1", "Count from 0."))
}

/// Checks the point s of a transfer matrix: far into the left half-plane e^(−T s) overflows.
fn check_laplace_point(delay: &Delay, s: Complex64) -> Result<Complex64> {
    if s.is_finite() && s.norm() <= 1e12 && s.re * delay.round_trip() >= -600.0 {
        return Ok(s);
    }
    Err(InvalidInput::new(
        "s",
        s,
        "must be a complex number with |s| up to 1e12 1/s and Re(s)·(round trip) at least -600",
        "Use s = jω with ω in rad/s.",
    ))
}
