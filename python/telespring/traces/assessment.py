"""The answer of the command `trace`: what was recorded, what fits it, and what it allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from telespring._arrays import as_number, quoted_value
from telespring._core import Trace, TraceFit, TraceStatistics, usual_range
from telespring._errors import InvalidInput
from telespring.decision.question import Question, are_axes_independent
from telespring.decision.usable import LONGEST_USUAL_DELAY, recommended_stiffness, round_limit
from telespring.model import Network, Study
from telespring.traces.evidence import TraceEvidence, check_evidence
from telespring.traces.missing_rows import MissingRows, complete_trace
from telespring.traces.playouts import (
    PlayoutChoice,
    RobotErrors,
    best_playout,
    judge_playouts,
    longest_useful,
)
from telespring.traces.silences import Silences, find_silences

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord

__all__ = ["RecordedWay", "TraceAssessment", "assess_trace"]

#: Between two packets of a session whose controllers are continuous, s.
_PACKETS = 0.001


@dataclass(frozen=True)
class RecordedWay:
    """What was recorded of one way.

    Attributes
    ----------
    trace
        The trace that was judged, lost packets without a row inserted.
    missing
        How missing rows were understood; None if none is missing.
    statistics
        What the trace shows.
    fit
        The emulator's models that fit it.
    evidence
        How much was recorded, and what that cannot show.
    silences
        How often nothing comes for so long that a live session lets the force go.
    """

    trace: Trace
    missing: MissingRows | None
    statistics: TraceStatistics
    fit: TraceFit
    evidence: TraceEvidence
    silences: Silences


@dataclass(frozen=True)
class TraceAssessment:
    """What a recorded trace of a network allows.

    Attributes
    ----------
    ways
        What was recorded: of one way, which counts for both, or of forward and backward.
    study
        The study whose robots, operators and controllers were judged.
    question
        The robots, their operators and the timing of their controllers.
    sample_period
        The time between two packets of a session, s.
    playouts
        A play-out for the delays that 50 to 100 % of the packets do not exceed, the shortest first.
    recommended
        The one to use: for a bare spring, or for the guard if it is needed.
    guarded
        The one for a stiffer spring with the guard.
    needs_guard
        Whether nothing is proven for a bare spring, or only what holds on any network because motions were in
        use that are older than any useful play-out, or because forces lag behind their commands.
    guard_stiffness
        The stiffness up to which the guard is proven with these robots and controllers, N/m; `docs/guard.md`.
    longest_useful
        No longer play-out is recommended, s.
    if_paused
        What would be recommended if no packet without a row were lost; None if none counts as lost.
    axes_independent
        Whether identification found the axes of both robots independent; None if it is not known.
    """

    ways: tuple[RecordedWay, ...]
    study: Study
    question: Question
    sample_period: float
    playouts: tuple[PlayoutChoice, ...]
    recommended: PlayoutChoice
    guarded: PlayoutChoice
    needs_guard: bool
    guard_stiffness: float
    longest_useful: float
    if_paused: PlayoutChoice | None = None
    axes_independent: bool | None = None

    @property
    def has_lag(self) -> bool:
        """Whether the robots' forces lag behind their commands, which no limit of a bare spring counts."""
        return _controllers_of(self.study)[1]

    @property
    def is_completed(self) -> bool:
        """Whether the trace that was judged differs from the recorded one by missing rows."""
        return any(way.missing is not None for way in self.ways)

    @property
    def stiffness(self) -> float | None:
        """The stiffness to use, N/m, rounded down to four digits; None if nothing is proven.

        With the guard it is that for 99 % of the time, where that is the larger one, as far as the guard is
        proven.
        """
        best = self.recommended
        usable = best.usable_stiffness
        if self.needs_guard:
            usable = min(max(usable, best.mostly_usable_stiffness), self.guard_stiffness)
        stiffness = recommended_stiffness(usable)
        return round_limit(stiffness) if stiffness else None

    def settings(self, file: str | None = None, *, round_trip: bool = False) -> dict[str, Any]:
        """Return the keys of a study over this network, for `Study.replace`.

        With a file the network is its trace, behind the play-out. Without one it has the ages as played: what
        `decide` judges alike. Outages are longer than what is usual: then `allow_unusual` is among the keys.
        So is the sample period, unless it is what a study has that says nothing about it. Robots that cannot
        be rehearsed, because they have not two axes, have the ages as played and no session.

        Parameters
        ----------
        file : str, optional
            The file of the trace, as the study names it: relative to its folder. It must record its losses:
            write `ways[0].trace.to_csv()` where lost packets have no rows.
        round_trip : bool
            Whether the delays in the file are round trips.
        """
        (forward, backward), jitter = self.recommended.network
        delay = forward if forward == backward else {"forward": forward, "backward": backward}
        network: dict[str, Any] = {"delay": delay} | ({"jitter": jitter} if jitter > 0.0 else {})
        can_rehearse = self.study.experiment is not None
        session: dict[str, Any] = {"strategy": "guard"} if self.needs_guard and can_rehearse else {}
        if file is not None and can_rehearse:
            playout = self.recommended.delay
            trace = {"file": file, "round_trip": True} if round_trip else file
            network = {"delay": playout, "trace": trace}
            session["playout"] = {"kind": "fixed", "delay": playout}
        is_usual = max(forward, backward) <= LONGEST_USUAL_DELAY and jitter <= usual_range("time span")[1]
        period = self.question.network.sample_period
        is_default = period == _network_of(self.study.replace(controller=None)).sample_period
        return {
            **({} if is_usual else {"allow_unusual": True}),
            "network": network,
            **({"session": session} if session else {}),
            **({} if is_default else {"controller": {"sample_period": period}}),
        }

    def recommended_study(self, file: str, *, round_trip: bool = False) -> Study:
        """Return a whole study of what is recommended, which `decide` and `rehearse` take as it is.

        Robots, operators, controllers and the laboratory are those of the study that was judged. The network
        is the trace and nothing else. The protocol has one connected condition: `stiffness`, or with the
        guard the study's own if it has one, as far as the guard is proven, and the delay of the play-out.
        Robots that have not two axes cannot be rehearsed: their network is the ages as played.

        Parameters
        ----------
        file, round_trip
            As in `settings`.

        Returns
        -------
        Study
            The study; `to_toml` writes it.

        Examples
        --------
        >>> import telespring as ts
        >>> trace = ts.Trace([0.01 * n for n in range(1000)], [0.09 + 0.005 * (n % 2) for n in range(1000)])
        >>> study = ts.assess_trace(trace).recommended_study("uplink.csv")
        >>> study.session.playout_delay, study.stiffness
        (0.095, 98.61)
        >>> [delay for stiffness, delay in study.experiment.conditions if stiffness]
        [0.095]
        """
        settings = self.settings(file, round_trip=round_trip)
        changes: dict[str, Any] = {**settings, "name": f"{self.study.name} over {file}"}
        stiffness = self.stiffness
        if self.needs_guard and self.study.has_stiffness:
            stiffness = self.study.stiffness
            if stiffness > self.guard_stiffness:
                stiffness = round_limit(self.guard_stiffness)
        if stiffness is not None:
            changes["coupling"] = {"stiffness": stiffness}
        if self.study.experiment is not None and stiffness is not None:
            condition = {"stiffness": stiffness, "delay": self.recommended.delay}
            changes["protocol"] = {"stiffness": None, "delay": None, "conditions": [condition]}
        return self.study.replace(network=None, session=None, comparison=None).replace(**changes)


def assess_trace(
    trace: Trace | tuple[Trace, Trace],
    study: Study | None = None,
    *,
    longest_loss: float | None = None,
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    allow_unusual: bool = False,
) -> TraceAssessment:
    """Find the play-out delay and the stiffness that a recorded trace of a network allows.

    A session is played over the trace, once round a circle, behind fixed play-outs: a packet in every sample
    period, each with the delay and the fate of the recorded packet that was sent last before it. The ages of
    the motion that is then in use say which verdicts hold, and up to which stiffness: for a network that does
    no worse than the recording.

    Parameters
    ----------
    trace : Trace or (Trace, Trace)
        One way, which counts for both, or the ways forward and backward.
    study : Study, optional
        Robots, operators and the timing of the controllers; its own network counts for nothing. The default
        is the paper's two H-MANs with free handles, sampled every 1 ms.
    longest_loss : float, optional
        If the trace has no row for lost packets: packets that are missing in a step between two rows of up
        to this, s, count as lost, longer ones as pauses of the sender; 0 takes every one as a pause. The
        default is 1 s, or ten periods if they are longer.
    records : pair of RobotRecord, optional
        What identification recorded about the robots.
    allow_unusual : bool
        Accept times and delays whose unit is probably another one.

    Returns
    -------
    TraceAssessment
        What was recorded, what fits, what each play-out allows, and the one to use.

    Raises
    ------
    InvalidInput
        If an argument has another type, the trace has fewer than 299 packets or 10 s, or its times or delays
        are longer than any network's.

    Examples
    --------
    Every packet takes 90 or 95 ms. A play-out of 95 ms makes the delay constant:

    >>> import telespring as ts
    >>> numbers = range(1000)
    >>> trace = ts.Trace([0.01 * n for n in numbers], [0.09 + 0.005 * (n % 2) for n in numbers])
    >>> found = ts.assess_trace(trace)
    >>> best = found.recommended
    >>> best.delay, best.tier
    (0.095, 'constant delay')
    >>> round(best.stiffness_limit, 1), round(best.usable_stiffness, 1)
    (103.5, 98.6)
    """
    traces = _both_ways(trace)
    _check_arguments(study, records, allow_unusual)
    if longest_loss is not None:
        longest_loss = as_number("longest_loss", longest_loss)
    if study is None:
        study = Study.paper().replace(coupling=None, network=None, controller=None)
    network, has_lag = _controllers_of(study)
    question = Question.of(study, network, has_playout_buffer=False)
    errors = RobotErrors(study.uncertainty, records)
    period = network.sample_period or _PACKETS
    completed = _complete(traces, longest_loss)
    different = completed[:1] if completed[0] is completed[1] else completed
    evidence = [check_evidence(one, allow_unusual=allow_unusual) for one, _ in different]
    ways = tuple(
        RecordedWay(one, missing, one.statistics(), one.fit(), shown, find_silences(one, period))
        for (one, missing), shown in zip(different, evidence, strict=True)
    )
    useful = longest_useful([way.trace for way in ways])

    def judge(forward: Trace, backward: Trace) -> tuple[PlayoutChoice, ...]:
        return judge_playouts((forward, backward), question, errors, period)

    playouts = judge(completed[0][0], completed[1][0])
    bare, guarded = best_playout(playouts, useful), best_playout(playouts, useful, guarded=True)
    oldest = max(age for _, age in bare.ages)
    is_old = bare.tier == "any network" and oldest > useful
    needs_guard = has_lag or bare.usable_stiffness == 0.0 or is_old
    if_paused = None
    if any(way.missing is not None and way.missing.lost for way in ways):
        forward, backward = _complete(traces, 0.0)
        if_paused = best_playout(judge(forward[0], backward[0]), useful)
    return TraceAssessment(
        ways,
        study,
        question,
        period,
        playouts,
        guarded if needs_guard else bare,
        guarded,
        needs_guard,
        # the same whatever the stiffness asked for
        study.guard_overdraft(1.0).proven_stiffness,
        useful,
        if_paused,
        are_axes_independent(records),
    )


def _controllers_of(study: Study) -> tuple[Network, bool]:
    """Return the timing of a study's controllers as `decide` judges it, and whether their forces lag."""
    judged = study.judged_network(0.0)
    period, computing = judged.network.sample_period, judged.network.computing_time
    return Network(0.0, sample_period=period, computing_time=computing), "actuator lag" in judged.unjudged


def _network_of(study: Study) -> Network:
    """Return the timing of a study's controllers, on a network without delay."""
    return study.replace(network={"delay": 0.0}).network


def _both_ways(trace: object) -> tuple[Trace, Trace]:
    """Return the traces forward and backward, or refuse what is neither one nor two traces."""
    match trace:
        case Trace():
            return trace, trace
        case (Trace() as forward, Trace() as backward):
            return forward, backward
    raise InvalidInput(
        "trace",
        quoted_value(trace),
        "a Trace is required, or the two traces (forward, backward)",
        "Read one with telespring.read_trace.",
    )


def _check_arguments(study: object, records: object, allow_unusual: object) -> None:
    """Refuse what is no study, no pair of robot records, or neither true nor false."""
    if not isinstance(allow_unusual, bool):
        raise InvalidInput(
            "allow_unusual", quoted_value(allow_unusual), "True or False is required", "Write one of them."
        )
    if not isinstance(study, Study | None):
        raise InvalidInput(
            "study", quoted_value(study), "a Study is required", "Read one with telespring.Study.read."
        )
    from telespring.study.robot_file import RobotRecord

    match records:
        case (RobotRecord() | None, RobotRecord() | None):
            return
    raise InvalidInput(
        "records",
        quoted_value(records),
        "what two robot files record is required: a pair of RobotRecord or None",
        "Leave it out if there are none.",
    )


def _complete(
    traces: tuple[Trace, Trace], longest_loss: float | None
) -> tuple[tuple[Trace, MissingRows | None], tuple[Trace, MissingRows | None]]:
    """Insert missing rows, once if both ways have one trace."""
    forward = complete_trace(traces[0], longest_loss)
    return forward, forward if traces[1] is traces[0] else complete_trace(traces[1], longest_loss)
