//! What every record of a site must keep to, whatever the network and the partner did.

#![allow(dead_code, reason = "every test uses its part")]

use telespring::session::{LocalTime, Span, WatchdogState};
use telespring_link::site::{Limits, Moment, Phase, Safety};

/// What a record is judged by: the limits of the site and the stiffness of its spring, N/m.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    pub safety: Safety,
    pub stiffness: f64,
    /// The highest speed of the partner's handle, m/s; `None` if it says what it likes: any step that the account can pay.
    pub speed: Option<f64>,
}

/// From full force to none after a silence: 8 of 15 parts of 148 ms, s.
const RAMP_OUT: f64 = 0.0789;
/// From no force to full, s.
const RAMP_IN: f64 = 0.5;
/// The sample period, s.
const PERIOD: f64 = 0.001;
/// Of a force, N.
const ROUNDING: f64 = 1e-9;
/// How far back the largest force counts for the slope of a ramp.
const RECENT: Span = Span(250_000_000);

/// What a record showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Findings {
    /// Ticks.
    pub ticks: usize,
    /// The largest force, N.
    pub largest_force: f64,
    /// The largest change of the force from tick to tick, N, and as a share of what is allowed there.
    pub largest_step: (f64, f64),
    /// The least energy in the account, J.
    pub least_balance: f64,
    /// How long after the partner's last packet the force was zero, for each silence that took it: the longest.
    pub zero_after: Option<Span>,
    /// Silences that took the force.
    pub silences: usize,
}

/// The highest speed that the motions of a record show, m/s.
pub fn largest_speed(moments: &[Moment]) -> f64 {
    let speeds = moments.windows(2).filter_map(|pair| {
        let seconds = (pair[1].time - pair[0].time).seconds();
        Some(moved(&pair[0], &pair[1])? / seconds)
    });
    speeds.fold(0.0, f64::max)
}

/// How far the handle moved between two ticks, m; `None` if nobody knows.
fn moved(before: &Moment, after: &Moment) -> Option<f64> {
    let [from, to] = [before.motion?.position, after.motion?.position];
    Some((to[0] - from[0]).hypot(to[1] - from[1])).filter(|moved| moved.is_finite())
}

fn size([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Judges a record.
///
/// No tick without an agreed session has a force; no force is above the limit, or above what the account can pay; none acts
/// 150 ms after the last packet; the account is overdrawn by no more than what a held force can give out in one tick; no step is
/// above what ramps, the own motion, the partner's and the account allow between two ticks.
///
/// # Panics
///
/// If a tick does not keep to that.
pub fn judge(moments: &[Moment], rules: &Rules) -> Findings {
    let Rules { safety, stiffness, .. } = rules;
    let mut findings = Findings {
        ticks: moments.len(),
        largest_force: 0.0,
        largest_step: (0.0, 0.0),
        least_balance: f64::INFINITY,
        zero_after: None,
        silences: 0,
    };
    let mut silence: Option<LocalTime> = None;
    for moment in moments {
        let force = size(moment.force);
        assert!(force.is_finite() && force <= Limits::default().force + ROUNDING, "{force} N: {moment:?}");
        assert!(moment.phase.is_coupled() || force == 0.0, "a force without an agreement: {moment:?}");
        assert!(force <= payable(moment, *stiffness) + ROUNDING, "more than the account can pay: {moment:?}");
        findings.largest_force = findings.largest_force.max(force);
        findings.least_balance = findings.least_balance.min(moment.balance.unwrap_or(f64::INFINITY));
        let Some(heard) = moment.heard else {
            assert_eq!(force, 0.0, "a force without a partner: {moment:?}");
            continue;
        };
        let silent = moment.time - heard;
        assert!(
            silent < safety.silence || force == 0.0,
            "{} s after the last packet: {moment:?}",
            silent.seconds()
        );
        if force == 0.0 && silence != Some(heard) && silent > safety.silence.scaled(0.5) {
            silence = Some(heard);
            findings.silences += 1;
            findings.zero_after = findings.zero_after.max(Some(silent));
        }
    }
    // a held force, over the longest way between two ticks
    let longest = moments.windows(2).filter_map(|pair| moved(&pair[0], &pair[1])).fold(0.0, f64::max);
    let overdraft = 0.5 * stiffness * longest * longest;
    assert!(findings.least_balance >= -overdraft, "overdrawn: {findings:?}, {overdraft} J allowed");
    for at in 0..moments.len().saturating_sub(2) {
        let [before, after] = [&moments[at], &moments[at + 1]];
        let step = size([0, 1].map(|axis| after.force[axis] - before.force[axis]));
        let allowed = match rules.speed {
            Some(speed) => largest_step(moments, at, rules, speed),
            None => payable(before, *stiffness) + payable(after, *stiffness),
        };
        let growth = growth(before.force, after.force);
        // a tick that is late counts for two periods at most
        let rise = Limits::default().rise * 2.0 * PERIOD;
        assert!(growth <= rise + ROUNDING, "it grew by {growth} N in a tick: {before:?} {after:?}");
        assert!(step <= allowed + ROUNDING, "a step of {step} N, above {allowed} N: {before:?} {after:?}");
        let (largest, share) = findings.largest_step;
        findings.largest_step = (largest.max(step), share.max(step / (allowed + ROUNDING)));
    }
    findings
}

/// The largest force that the account of a tick can pay, N.
fn payable(moment: &Moment, stiffness: f64) -> f64 {
    moment.balance.map_or(f64::INFINITY, |balance| (2.0 * stiffness * balance.max(0.0)).sqrt())
}

/// By how much a force is longer than what the one before was along its direction, N.
fn growth(before: [f64; 2], after: [f64; 2]) -> f64 {
    let along = (before[0] * after[0] + before[1] * after[1]) / size(after).max(f64::MIN_POSITIVE);
    size(after) - along.max(0.0)
}

/// The largest step of the force from this tick to the next, N.
///
/// A force is a share of the spring's, or what the account can pay, if that is less. The share is 1 or follows a ramp. The
/// spring's follows both handles, and the part of the partner's motion that is played; what `limits.rise` held back comes after.
/// When in a tick the force was computed is not on record: before the next tick.
fn largest_step(moments: &[Moment], at: usize, rules: &Rules, speed: f64) -> f64 {
    let Rules { safety, stiffness, .. } = rules;
    let [before, after, next] = [moments[at], moments[at + 1], moments[at + 2]];
    let (tick, elapsed) = ((after.time - before.time).seconds(), (next.time - before.time).seconds());
    let since = moments[..=at].iter().rev().take_while(|earlier| before.time - earlier.time <= RECENT);
    let recent = since.map(|earlier| size(earlier.force)).fold(0.0, f64::max);
    let slopes = [before, after].map(|moment| match (moment.phase, moment.state) {
        (Phase::RampingOut, _) => recent / safety.ramp_out.seconds() + recent / RAMP_OUT,
        (_, WatchdogState::RampingOut { .. } | WatchdogState::Disengaged { .. }) => recent / RAMP_OUT,
        (_, WatchdogState::RampingIn) => Limits::default().force / RAMP_IN,
        (_, WatchdogState::Engaged | WatchdogState::Holding { .. }) => 0.0,
    });
    let ramp = slopes.iter().fold(0.0_f64, |steepest, slope| steepest.max(*slope)) * elapsed;
    let own = moved(&before, &after).unwrap_or(0.0);
    // By how much the played instant moved on the partner's clock. Between two samples that are no neighbours it moves on, while
    // the age is that of the earlier one.
    let played = match (before.age, after.age) {
        (Some(old), Some(new)) => (tick - (new - old)).abs().max(tick) + (elapsed - tick),
        // a partner is found, or has been lost: the force is at the foot of its ramp
        _ => elapsed,
    };
    let account = match (before.balance, after.balance) {
        (Some(_), Some(_)) => (payable(&after, *stiffness) - payable(&before, *stiffness)).abs(),
        _ => 0.0,
    };
    // what the limit of the growth held back in the tick before, it may let follow now
    let [wanted, force] = [before.forces.wanted.unwrap_or(before.force), before.force];
    let held_back = if before.is_cut { size([0, 1].map(|axis| wanted[axis] - force[axis])) } else { 0.0 };
    ramp + stiffness * (own + speed * played) + account + held_back
}
