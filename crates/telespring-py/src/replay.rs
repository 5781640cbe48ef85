//! Recorded live sessions through the endpoints once more.

use std::sync::Arc;

use numpy::{IntoPyArray, Ix1, Ix2, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::rig::replay::{
    self, Acted, ForceLimits, RecordedArrival, RecordedTick, ReplaySettings, ReplayedSite as CoreReplayed,
    ReplayedTick,
};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Motion, Span, WatchdogSettings, WatchdogState};

use crate::arguments::{Argument, Number, Truth, rows};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::records::{Array, Value, record};
use crate::study::Study;

/// What the endpoint of one live site was given, in its order; `telespring.replay` takes it from a recording.
///
/// Parameters
/// ----------
/// time : (n,) array of uint64
///     When each tick began, ns on the site's clock: the stamp of its measurement.
/// answered : (n,) array of uint64
///     When the endpoint was asked for the force, ns; 0 where it was not.
/// is_given : (n,) array of bool
///     Whether the endpoint was given a motion at this tick.
/// position, velocity : (n, 2) array_like
///     This motion, m and m/s.
/// acted : (n, 2) array_like
///     The force that the endpoint was told to have acted, N; NaN where it was told none.
/// target_position, target_velocity : (n, 2) array_like
///     The target that it was given, m and m/s; NaN where it was given none.
/// share : (n, 2) array_like
///     The share of the endpoint's force that the site let act, per axis, before its limit.
/// arrival_tick : (m,) array of int64
///     The tick in which the endpoint was given each datagram, after the measurement and before the force.
/// arrival_time : (m,) array of uint64
///     When, ns on the site's clock.
/// datagram : (m, 112) array of uint8
///     The bytes.
///
/// Raises
/// ------
/// InvalidInput
///     If the lengths differ, the times do not rise, or the arrivals are out of order.
#[pyclass(frozen, eq, module = "telespring._core")]
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedSite(Arc<replay::RecordedSite>);

/// A recorded array that must have one value or row per tick, or per arrival.
fn refuse_length(name: &str, got: usize, needed: usize) -> InvalidInput {
    InvalidInput::new(
        name,
        format!("{got} row(s)"),
        format!("{needed} row(s), as in the times"),
        "Give one row per tick, and per arrival.",
    )
}

/// A column of a recording.
fn column<T: numpy::Element + Copy>(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    length: Option<usize>,
) -> Outcome<Vec<T>> {
    let array: PyReadonlyArray1<'_, T> = value.extract().map_err(|_| {
        let kind = value.getattr("dtype").map_or_else(|_| "no array".to_owned(), |dtype| dtype.to_string());
        InvalidInput::new(
            name,
            kind,
            "an array of one dimension and of the documented type",
            "Convert it with numpy.asarray(…, dtype=…).",
        )
    })?;
    let column: Vec<T> = array.as_array().iter().copied().collect();
    match length {
        Some(needed) if needed != column.len() => Err(refuse_length(name, column.len(), needed).into()),
        _ => Ok(column),
    }
}

/// Rows of a recording.
fn pairs(name: &'static str, value: &Bound<'_, PyAny>, needed: usize) -> Outcome<Vec<[f64; 2]>> {
    let pairs = rows(name, value)?;
    if pairs.len() == needed { Ok(pairs) } else { Err(refuse_length(name, pairs.len(), needed).into()) }
}

/// The pair of a recording, unless it is not a number.
fn known(pair: [f64; 2]) -> Option<[f64; 2]> {
    (!pair.iter().any(|value| value.is_nan())).then_some(pair)
}

#[pymethods]
impl RecordedSite {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        time: &Bound<'_, PyAny>,
        answered: &Bound<'_, PyAny>,
        is_given: &Bound<'_, PyAny>,
        position: &Bound<'_, PyAny>,
        velocity: &Bound<'_, PyAny>,
        acted: &Bound<'_, PyAny>,
        target_position: &Bound<'_, PyAny>,
        target_velocity: &Bound<'_, PyAny>,
        share: &Bound<'_, PyAny>,
        arrival_tick: &Bound<'_, PyAny>,
        arrival_time: &Bound<'_, PyAny>,
        datagram: &Bound<'_, PyAny>,
    ) -> Outcome<Self> {
        let times: Vec<u64> = column("time", time, None)?;
        let count = times.len();
        let answered: Vec<u64> = column("answered", answered, Some(count))?;
        let is_given: Vec<bool> = column("is_given", is_given, Some(count))?;
        let position = pairs("position", position, count)?;
        let velocity = pairs("velocity", velocity, count)?;
        let acted = pairs("acted", acted, count)?;
        let target_position = pairs("target_position", target_position, count)?;
        let target_velocity = pairs("target_velocity", target_velocity, count)?;
        let share = pairs("share", share, count)?;
        let ticks = (0..count).map(|tick| RecordedTick {
            time: LocalTime(times[tick]),
            motion: is_given[tick].then_some(Motion { position: position[tick], velocity: velocity[tick] }),
            acted: known(acted[tick]),
            target: known(target_position[tick])
                .map(|position| Motion { position, velocity: target_velocity[tick] }),
            answered: Some(answered[tick]).filter(|time| *time > 0).map(LocalTime),
            share: share[tick],
        });
        let arrival_tick: Vec<i64> = column("arrival_tick", arrival_tick, None)?;
        let arrival_time: Vec<u64> = column("arrival_time", arrival_time, Some(arrival_tick.len()))?;
        let array: Option<PyReadonlyArray2<'_, u8>> = datagram.extract().ok();
        let array = array.filter(|array| array.as_array().ncols() == LENGTH).ok_or_else(|| {
            InvalidInput::new(
                "datagram",
                "another array",
                format!("an array of bytes (uint8) of shape (m, {LENGTH})"),
                "Give the bytes of one packet per row.",
            )
        })?;
        let array = array.as_array();
        if array.nrows() != arrival_tick.len() {
            return Err(refuse_length("datagram", array.nrows(), arrival_tick.len()).into());
        }
        let arrivals =
            arrival_tick.iter().zip(&arrival_time).zip(array.outer_iter()).map(|((&tick, &time), bytes)| {
                let mut datagram = [0; LENGTH];
                datagram.iter_mut().zip(&bytes).for_each(|(place, byte)| *place = *byte);
                let tick = usize::try_from(tick).unwrap_or(usize::MAX);
                RecordedArrival { tick, time: LocalTime(time), datagram }
            });
        Ok(Self(Arc::new(replay::RecordedSite::new(ticks.collect(), arrivals.collect())?)))
    }

    /// The number of ticks of the recorded site.
    fn __len__(&self) -> usize {
        self.0.ticks().len()
    }

    fn __repr__(&self) -> String {
        let (ticks, arrivals) = (self.0.ticks().len(), self.0.arrivals().len());
        format!("<RecordedSite of {ticks} ticks and {arrivals} arrivals>")
    }
}

record! {
    /// What the endpoint of one site makes of a recording. `replay_site` and `replay_pair` return it.
    ///
    /// Row j is tick j of the recording.
    ReplayedSite {
        /// Force of the endpoint, N, (n, 2); 0 where it was not asked.
        wanted: Array<f64, Ix2>,
        /// Force that the site lets through: its share, cut to its limit, N, (n, 2).
        force: Array<f64, Ix2>,
        /// Age of the oldest sample of the partner in use, s, (n,); NaN while there is none.
        age: Array<f64, Ix1>,
        /// Energy in the account of the strategy, J, (n,); NaN if it keeps none.
        account: Array<f64, Ix1>,
        /// Energy given out to the own handle since the start, J, (n,).
        given_out: Array<f64, Ix1>,
        /// Whether the strategy changed the force of the spring, (n,).
        is_limited: Array<bool, Ix1>,
        /// Whether the watchdog let the force act, if only in part, (n,).
        is_engaged: Array<bool, Ix1>,
        /// Share of the ticks with a partner at which the strategy changed the force of the spring; NaN without any.
        limited_share: f64,
        /// Mean share of the spring's force that was withheld at those ticks.
        withheld_share: f64,
        /// Energy sent to the partner, J.
        energy_sent: f64,
        /// Energy taken in from the partner, J.
        energy_received: f64,
        /// Mean age of the partner's motion in use, s; this and the following are NaN without any.
        age_mean: f64,
        /// Smallest age of a partner's sample in use, s.
        age_low: f64,
        /// Largest age of a partner's sample in use, s.
        age_high: f64,
        /// Age that 99 of 100 ticks do not exceed, s.
        age_quantile_99: f64,
        /// Share of the ticks at which an old motion was held because no later one had come.
        held_share: f64,
        /// Packets that had not come although later ones had.
        lost: f64,
        /// Arrivals that got the content of the replayed partner; the others are as recorded.
        renewed: usize,
        /// When something happened, ns on the site's clock; what, in a word; and why, or "".
        events: Vec<SessionEvent>,
        /// Events for which there was no room.
        missed_events: usize,
    }
}

/// An event of a replayed session: ns, word, reason or nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionEvent(u64, String, String);

impl Value for SessionEvent {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok((self.0, &self.1, &self.2).into_pyobject(py)?.into_any())
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (time, word, reason) = value.extract()?;
        Ok(Self(time, word, reason))
    }
}

/// A replayed site as Python reads it.
fn replayed(py: Python<'_>, site: CoreReplayed) -> PyResult<ReplayedSite> {
    let CoreReplayed { ticks, report, events, missed_events, renewed } = site;
    let count = ticks.len();
    let forces = |force: fn(&ReplayedTick) -> [f64; 2]| -> PyResult<_> {
        let values: Vec<f64> = ticks.iter().flat_map(force).collect();
        Ok(values.into_pyarray(py).reshape([count, 2])?.into())
    };
    let numbers = |number: fn(&ReplayedTick) -> f64| -> Array<f64, Ix1> {
        ticks.iter().map(number).collect::<Vec<_>>().into_pyarray(py).into()
    };
    let flags = |flag: fn(&ReplayedTick) -> bool| -> Array<bool, Ix1> {
        let flags: Bound<'_, PyArray1<bool>> = ticks.iter().map(flag).collect::<Vec<_>>().into_pyarray(py);
        flags.into()
    };
    let (strategy, playout) = (report.strategy, report.playout);
    let of_ages = |span: fn(&telespring::session::playout::Ages) -> Span| {
        playout.ages.as_ref().map_or(f64::NAN, |ages| span(ages).seconds())
    };
    let has_ticks = strategy.ticks > 0;
    Ok(ReplayedSite {
        wanted: forces(|tick| tick.wanted)?,
        force: forces(|tick| tick.force)?,
        age: numbers(|tick| tick.age.unwrap_or(f64::NAN)),
        account: numbers(|tick| tick.balance.unwrap_or(f64::NAN)),
        given_out: numbers(|tick| tick.given_out),
        is_limited: flags(|tick| tick.is_limited),
        is_engaged: flags(|tick| !matches!(tick.state, WatchdogState::Disengaged { .. })),
        limited_share: if has_ticks {
            strategy.limited_ticks as f64 / strategy.ticks as f64
        } else {
            f64::NAN
        },
        withheld_share: if has_ticks { strategy.withheld } else { f64::NAN },
        energy_sent: strategy.energy_sent,
        energy_received: strategy.energy_received,
        age_mean: of_ages(|ages| ages.mean),
        age_low: of_ages(|ages| ages.smallest),
        age_high: of_ages(|ages| ages.largest),
        age_quantile_99: of_ages(|ages| ages.quantile_99),
        held_share: if playout.ages.is_some() { playout.held_share() } else { f64::NAN },
        lost: playout.lost as f64,
        renewed,
        events: events
            .iter()
            .map(|event| {
                let (word, reason) = (event.kind.word().to_owned(), event.kind.reason());
                SessionEvent(event.time.0, word, reason.unwrap_or_default())
            })
            .collect(),
        missed_events: usize::try_from(missed_events).unwrap_or(usize::MAX),
    })
}

/// What each site of a replay promised, in the words of `replay_pair`.
struct Promises<const N: usize> {
    largest_force: [f64; N],
    steepest_rise: [f64; N],
    silence: [f64; N],
    stall: [f64; N],
}

impl<const N: usize> Promises<N> {
    /// The settings of the replay of one site, which moves robot `side`, 1 or 2.
    fn settings(
        &self,
        place: usize,
        study: &Study,
        side: u8,
        session: u64,
        acted: Acted,
    ) -> Outcome<ReplaySettings> {
        let period = study.0.laboratory_without_traces()?.controller.sample_period;
        let [silence, stall, period] =
            [self.silence[place], self.stall[place], period].map(Span::from_seconds);
        let watchdog = WatchdogSettings::within(silence, stall, period)?;
        let endpoint = study.0.live_side(side, session, watchdog)?;
        let limits = ForceLimits { largest: self.largest_force[place], rise: self.steepest_rise[place] };
        Ok(ReplaySettings { endpoint, acted, limits })
    }
}

/// Which force a replay tells its endpoints.
fn acted(acted_as_recorded: Truth) -> Outcome<Acted> {
    Ok(if acted_as_recorded.named("acted_as_recorded")? { Acted::Recorded } else { Acted::Replayed })
}

/// Replays one site of a recorded session; its partner's packets have the content that they had.
///
/// Parameters
/// ----------
/// study : Study
///     Robots, coupling, sample period, strategy, predictor and play-out of the replay.
/// site : RecordedSite
///     What the endpoint was given.
/// side : int
///     The robot of the study that the site moved, 1 or 2.
/// session : int
///     The session id that it had.
/// acted_as_recorded : bool
///     Whether the endpoint is told the force that acted then: for the session's own settings. Otherwise it is told the
///     replayed force, as the site lets it through.
/// largest_force : float
///     The largest force that the site lets through, N; infinity for no limit.
/// steepest_rise : float
///     The steepest growth of this force, N/s; infinity for no limit.
/// silence, stall : float
///     As `safety.silence` and `safety.stall` of a site file, s.
///
/// Returns
/// -------
/// ReplayedSite
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of range, or a live session refuses the study.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub fn replay_site(
    py: Python<'_>,
    study: &Study,
    site: &RecordedSite,
    side: Argument<usize>,
    session: Argument<u64>,
    acted_as_recorded: Truth,
    largest_force: Number,
    steepest_rise: Number,
    silence: Number,
    stall: Number,
) -> Outcome<ReplayedSite> {
    let side = side.named("side")?;
    let promises = Promises {
        largest_force: [largest_force.named("largest_force")?],
        steepest_rise: [steepest_rise.named("steepest_rise")?],
        silence: [silence.named("silence")?],
        stall: [stall.named("stall")?],
    };
    // beyond 255 it is no side either
    let side = u8::try_from(side).unwrap_or(u8::MAX);
    let settings = promises.settings(0, study, side, session.named("session")?, acted(acted_as_recorded)?)?;
    let recording = Arc::clone(&site.0);
    let outcome = apart(py, move || replay::replay_site(settings, &recording))??;
    Ok(replayed(py, outcome)?)
}

/// Replays both sites of a recorded session: what arrived arrives again, with the content that the replayed partner gives it.
///
/// Parameters
/// ----------
/// study, acted_as_recorded, largest_force, steepest_rise, silence, stall
///     As in `replay_site`; the numbers as pairs, one per site.
/// sites : (RecordedSite, RecordedSite)
///     What the endpoints of sides 1 and 2 were given.
/// sessions : (int, int)
///     The session ids that they had.
///
/// Returns
/// -------
/// (ReplayedSite, ReplayedSite)
///
/// Raises
/// ------
/// InvalidInput
///     As `replay_site`, and if the two recordings are not of one session.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub fn replay_pair(
    py: Python<'_>,
    study: &Study,
    sites: (PyRef<'_, RecordedSite>, PyRef<'_, RecordedSite>),
    sessions: Argument<[u64; 2]>,
    acted_as_recorded: Truth,
    largest_force: Argument<[f64; 2]>,
    steepest_rise: Argument<[f64; 2]>,
    silence: Argument<[f64; 2]>,
    stall: Argument<[f64; 2]>,
) -> Outcome<(ReplayedSite, ReplayedSite)> {
    let pair = "a pair is required, one per site";
    let sessions = sessions.or_refuse("sessions", pair, "Give the ids of both sessions.")?;
    let numbers =
        |field, argument: Argument<[f64; 2]>| argument.or_refuse(field, pair, "Give a number for each site.");
    let promises = Promises {
        largest_force: numbers("largest_force", largest_force)?,
        steepest_rise: numbers("steepest_rise", steepest_rise)?,
        silence: numbers("silence", silence)?,
        stall: numbers("stall", stall)?,
    };
    let acted = acted(acted_as_recorded)?;
    let one = promises.settings(0, study, 1, sessions[0], acted)?;
    let two = promises.settings(1, study, 2, sessions[1], acted)?;
    let (first, second) = (Arc::clone(&sites.0.0), Arc::clone(&sites.1.0));
    let [one, two] = apart(py, move || replay::replay_pair([one, two], [&first, &second]))??;
    Ok((replayed(py, one)?, replayed(py, two)?))
}
