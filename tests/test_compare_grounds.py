"""On which grounds a strategy is safe, against sampled loops that are advanced by matrix exponentials."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

import telespring as ts
from telespring._types import FloatArray
from telespring.comparison.grounds import STRATEGY_GROUNDS, Place, find_grounds
from telespring.comparison.spring_verdicts import SpringVerdicts

PERIOD = 0.001
STUDY = ts.Study.paper()
LITERATURE = sorted(set(STRATEGY_GROUNDS) - {"spring", "guard"})


def place(
    strategy: object,
    stiffness: float = 71.2,
    delay: float = 0.084,
    oldest: float | None = None,
    verdict: str = "unstable",
    **sections: Any,
) -> Place:
    session = sections.pop("session", {}) | {"strategy": strategy}
    study = STUDY.replace(session=session, **sections)
    age = delay if oldest is None else oldest
    return Place(study, stiffness, delay, (age, age), verdict)


def held_robot(mass: float, damping: float, period: float = PERIOD) -> tuple[FloatArray, FloatArray]:
    """Return how position and velocity of a robot go on over a period, alone and by a held force."""
    whole = expm(period * np.array([[0.0, 1.0, 0.0], [0.0, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]]))
    return whole[:2, :2], whole[:2, 2]


def theta(mass: float, damping: float, period: float = PERIOD) -> float:
    p = -np.expm1(-damping * period / mass) * mass / (damping * period)
    return float((1.0 - p) * mass / (damping * period * p))


@pytest.mark.parametrize("seed", range(8))
def test_cross_the_balance_of_a_held_damper_is_exact(seed: int) -> None:
    """The equation of docs/strategies.md, with the robot's loss found by quadrature."""
    rng = np.random.default_rng(seed)
    mass, period = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-4.0, -1.5)
    damping, damper = 10.0 ** rng.uniform(-1.0, 2.0, 2)
    force, v = rng.normal(size=2)
    advance, push = held_robot(mass, damping, period)
    way, after = advance @ [0.0, v] + push * (force - damper * v)
    mean, weight = way / period, theta(mass, damping, period)
    rest = mass - weight * damper * period
    assert force * way == pytest.approx(
        0.5 * rest * (after**2 - v**2)
        + (damping + damper) * period * mean**2
        + (weight - 0.5) * rest * (after - v) ** 2,
        rel=1e-7,
        abs=1e-9 * (abs(force * way) + mass * v**2 + damper * v**2 * period),
    )
    assert 0.5 <= weight < 1.0


@pytest.mark.parametrize(("share", "takes"), [(1.0, True), (2.3, False)])
def test_cross_a_damper_up_to_the_mass_over_the_period_takes_energy(share: float, takes: bool) -> None:
    mass, damping = 0.8, 0.2
    damper = share * mass / PERIOD
    advance, push = held_robot(mass, damping)
    closed = advance - np.outer(push, [0.0, damper])
    assert (np.abs(np.linalg.eigvals(closed)) < 1.0 + 1e-12).all() == takes


@pytest.mark.parametrize("share", [0.2, 0.999])
def test_cross_the_end_of_a_line_is_passive_under_the_condition_and_not_far_beyond(share: float) -> None:
    """By the frequency response from the velocity of the end to the force, straight from the held loop."""
    mass, damping, k = 0.8, 5.0, 500.0
    advance, push = held_robot(mass, damping)

    def least_real_part(damper: float) -> float:
        # Position of the end, position and velocity of the handle; F = 2k (end - x) + d (w - v).
        gain = np.array([2.0 * k, -2.0 * k, -damper])
        step = np.zeros((3, 3))
        step[0, 0], step[1:, 1:] = 1.0, advance
        step[1:] += np.outer(push, gain)
        by_end = np.concatenate([[PERIOD], push * damper])
        frequencies = np.exp(
            1j * np.concatenate([np.geomspace(1e-5, 0.1, 300), np.linspace(0.1, np.pi, 700)])
        )
        found = [gain @ np.linalg.solve(z * np.eye(3) - step, by_end) + damper for z in frequencies]
        return float(np.real(found).min())

    weakest, strongest = 2.0 * k * PERIOD, mass / PERIOD
    assert least_real_part(weakest + share * (strongest - weakest)) > -1e-9
    assert least_real_part(weakest) > -1e-9
    assert least_real_part(0.45 * weakest) < 0.0
    assert least_real_part(2.2 * strongest) < 0.0


def grows(
    robots: list[tuple[float, float]], k: float, damper: FloatArray, ages: NDArray[np.int_], period: float
) -> float:
    """Return how two damped robots on a spring grow from the first to the last quarter; ages in ticks."""
    parts = [held_robot(mass, damping, period) for mass, damping in robots]
    ticks, longest = len(ages), int(ages.max())
    rng = np.random.default_rng(1)
    x, v = rng.normal(size=(2, longest + 1 + ticks)), rng.normal(size=2)
    x[:, : longest + 1] = rng.normal(size=(2, 1))
    sizes = []
    for n in range(ticks):
        now = longest + n
        forces = [k * (x[1 - i, now - ages[n, i]] - x[i, now]) - damper[i] * v[i] for i in (0, 1)]
        for i, (advance, push) in enumerate(parts):
            x[i, now + 1], v[i] = advance @ [x[i, now], v[i]] + push * forces[i]
        sizes.append(np.abs(x[0, now] - x[1, now]) + period * 30.0 * np.abs(v).sum())
    quarter = ticks // 4
    return float(np.max(sizes[-quarter:]) / np.max(sizes[:quarter]))


@pytest.mark.parametrize("seed", range(6))
def test_cross_the_rule_for_injected_damping_holds_for_any_ages_up_to_the_oldest(seed: int) -> None:
    """On the bound of the rule: constant ages, ages that jump, and a sawtooth."""
    rng = np.random.default_rng(seed)
    period = 0.004
    robots = [
        (float(m), float(b)) for m, b in zip(rng.uniform(0.5, 2.0, 2), rng.uniform(0.5, 6.0, 2), strict=True)
    ]
    oldest = rng.integers(10, 60, 2)
    damper = rng.uniform(0.0, 60.0, 2)
    total = np.array([b for _, b in robots]) + damper
    # k (A1 + A2 + h) = 2 sqrt((B1 - kh/2)(B2 - kh/2)), by bisection.
    low, high = 0.0, 2.0 * total.min() / period
    for _ in range(80):
        k = 0.5 * (low + high)
        rest = total - 0.5 * k * period
        holds = (rest > 0.0).all() and k * period * (oldest.sum() + 1) < 2.0 * np.sqrt(rest.prod())
        low, high = (k, high) if holds else (low, k)
    ticks = 6000
    constant = np.broadcast_to(oldest, (ticks, 2))
    jumping = rng.integers(0, oldest + 1, (ticks, 2))
    falling = oldest - np.arange(ticks)[:, None] % (oldest + 1)
    for ages in (constant, jumping, falling):
        assert grows(robots, 0.99 * low, damper, ages, period) < 1.0
    # The rule is no empty one: these robots do run away, if on a stiffer spring.
    assert grows(robots, 20.0 * low, damper, constant, period) > 1.0


def test_law_the_condition_of_injected_damping_is_this_rule() -> None:
    """The oldest age at which the grounds end is that of the rule, with the core's own damper."""
    k, delay = 142.5, 0.084
    held = place("injected-damping", k, delay).held
    total = np.array([robot.damping for robot in STUDY.dyad.robots]) + np.array(held.damping)
    rest = total - 0.5 * k * PERIOD
    limit = 0.5 * (2.0 * np.sqrt(rest[0] * rest[1]).min() / k - PERIOD)
    # The damper is sized as if each sample, the own one too, were half a period older than it is on average.
    assert limit == pytest.approx(delay + PERIOD, abs=1e-6)
    for age, lack in (
        (delay, ""),
        (limit - 1e-9, ""),
        (limit + 1e-9, "shorter ages"),
        (np.nan, "shorter ages"),
    ):
        assert find_grounds(place("injected-damping", k, delay, age))[1] == lack


@pytest.mark.parametrize("strategy", LITERATURE)
@pytest.mark.parametrize("delay", [0.0, 0.334])
def test_law_with_the_papers_robots_each_strategy_has_grounds_where_the_spring_has_none(
    strategy: str, delay: float
) -> None:
    grounds, lack = find_grounds(place(strategy, 142.5, delay))
    assert (grounds, lack) == ("bounded ages" if strategy == "injected-damping" else "honest partner", "")
    assert find_grounds(place("spring", 142.5, delay)) == ("", "stable spring")
    assert find_grounds(place("guard", 142.5, delay)) == ("any network", "")


@pytest.mark.parametrize("verdict", ["stable", "marginal", "unstable", "not proven", ""])
def test_law_the_bare_spring_stands_on_its_verdict_alone(verdict: str) -> None:
    expected = ("stable spring", "") if verdict == "stable" else ("", "stable spring")
    assert find_grounds(place("spring", verdict=verdict)) == expected
    shared = place("spring", verdict=verdict, session={"predictor": "shared-target"})
    assert find_grounds(shared) == expected


@pytest.mark.parametrize(
    ("strategy", "keys", "lack"),
    [
        ("spring", {"session": {"predictor": "linear"}}, "known prediction"),
        ("spring", {"laboratory": {"actuator_lag": 0.005}}, "force without a lag"),
        ("injected-damping", {"session": {"predictor": "kalman"}}, "known prediction"),
        *(
            (strategy, {"laboratory": {key: value}}, lack)
            for strategy in LITERATURE
            for key, value, lack in (
                ("computing_tick", True, "force without a computing tick"),
                ("actuator_lag", 0.005, "force without a lag"),
                ("encoder_resolution", 1e-5, "exact positions"),
            )
            if (strategy, key) != ("injected-damping", "encoder_resolution")
        ),
        ({"kind": "wave-variables", "impedance": 780.0}, {}, "weaker damper"),
        ({"kind": "wave-variables", "impedance": 0.1}, {}, "stronger damper"),
        ({"kind": "time-domain-passivity", "largest_damping": 780.0}, {}, "weaker damper"),
        ({"kind": "two-layer", "largest_damping": 780.0}, {}, "weaker damper"),
        ({"kind": "two-layer", "saturation": 600.0}, {}, "softer spring"),
        ({"kind": "set-position-modulation", "damping": 780.0}, {}, "weaker damper"),
        ({"kind": "set-position-modulation", "damping": 0.07}, {}, "stronger damper"),
    ],
)
def test_law_what_a_strategy_lacks_is_named(strategy: object, keys: dict[str, Any], lack: str) -> None:
    assert find_grounds(place(strategy, verdict="stable", **keys)) == ("", lack)


@pytest.mark.parametrize("computing_time", [0.0, 1e-6, PERIOD])
def test_law_a_spring_behind_a_computing_tick_stands_on_a_verdict_that_counts_the_tick(
    computing_time: float,
) -> None:
    late: dict[str, Any] = {
        "laboratory": {"computing_tick": True},
        "controller": {"sample_period": PERIOD, "computing_time": computing_time},
    }
    ages = (0.1, 0.1), (0.1, 0.1)
    verdicts = SpringVerdicts(STUDY.replace(**late))
    stiffest = ts.decide(
        STUDY.replace(controller={"sample_period": PERIOD, "computing_time": PERIOD}), delay=0.1
    ).stiffness_limit
    immediate = ts.decide(STUDY.replace(controller={"sample_period": PERIOD}), delay=0.1).stiffness_limit
    assert stiffest is not None
    assert immediate is not None
    assert stiffest < immediate
    between = (stiffest + 0.3 * (immediate - stiffest)) / 1.05
    for stiffness, expected in ((0.999 * stiffest / 1.05, "stable"), (between, "marginal")):
        assert verdicts.status(stiffness, 0.1, *ages) == expected
        grounds = find_grounds(place("spring", stiffness, 0.1, verdict=expected, **late))
        assert grounds == (("stable spring", "") if expected == "stable" else ("", "stable spring"))


@pytest.mark.parametrize("strategy", ["time-domain-passivity", "set-position-modulation"])
def test_law_a_spring_too_stiff_for_the_sample_period_has_no_grounds(strategy: str) -> None:
    limit = 0.1 * 0.7776 / (2.0 * PERIOD**2)
    settings = {"kind": strategy, "damping" if strategy.startswith("set") else "largest_damping": 300.0}
    assert find_grounds(place(settings, 0.999 * limit))[1] in {"", "stronger damper"}
    assert find_grounds(place(settings, 1.001 * limit))[1] == "softer spring"


def test_law_the_guard_has_grounds_while_its_overdraft_is_small() -> None:
    limit = 0.1 * 0.7776 / PERIOD**2
    assert find_grounds(place("guard", 0.999 * limit)) == ("any network", "")
    assert find_grounds(place("guard", 1.001 * limit)) == ("", "softer spring")
    # a computing tick doubles the time for which a force acts
    late = {"computing_tick": True}
    assert find_grounds(place("guard", 0.2499 * limit, laboratory=late)) == ("any network", "")
    assert find_grounds(place("guard", 0.2501 * limit, laboratory=late)) == ("", "softer spring")


@pytest.mark.parametrize("kind", ["oldest-sample", "most-harmful-sample", "lying-peer", "stretch-timed"])
def test_law_behind_one_who_forges_packets_no_partner_is_honest(kind: str) -> None:
    keys: dict[str, float] = {"stretch-timed": {"longest": 0.1}}.get(kind, {"memory": 0.1})
    if kind == "lying-peer":
        keys = {"position": 0.01, "stamp": 0.0, "power": 0.0}
    network = {"adversary": {"backward": {"kind": kind, **keys}}}
    expected = ("honest partner", "") if kind == "stretch-timed" else ("", "honest partner")
    for strategy in ("wave-variables", "two-layer"):
        assert find_grounds(place(strategy, network=network)) == expected
    assert find_grounds(place("guard", network=network)) == ("any network", "")


def test_law_the_ends_of_the_intervals_count() -> None:
    """A robot of 0.7776 kg with a standard deviation of 0.1 kg may have 0.58 kg."""
    robot = {"mass": [0.8, 0.8], "damping": [7.0, 7.0], "mass_sd": [0.1, 0.1]}
    settings = {"kind": "wave-variables", "impedance": 700.0}
    assert find_grounds(place(settings, robot1=robot | {"mass_sd": [0.0, 0.0]})) == ("honest partner", "")
    assert find_grounds(place(settings, robot1=robot)) == ("", "weaker damper")
    assert find_grounds(place(settings | {"impedance": 600.0}, robot1=robot)) == ("honest partner", "")


@pytest.mark.parametrize(
    "strategy",
    [
        {"kind": "set-position-modulation", "damping": 0.0},
        {"kind": "time-domain-passivity", "largest_damping": 0.0},
        {"kind": "two-layer", "largest_damping": 0.0},
        {"kind": "two-layer", "filling": 0.0},
    ],
)
def test_law_a_damper_of_zero_is_refused_where_the_strategy_lives_on_it(strategy: dict[str, Any]) -> None:
    [key] = set(strategy) - {"kind"}
    with pytest.raises(ts.InvalidInput, match="stronger than 0") as refused:
        STUDY.replace(session={"strategy": strategy})
    assert refused.value.field == f"session.strategy.{key}"
    usual = float(refused.value.remedy.split(" ", 1)[0])
    assert STUDY.replace(session={"strategy": strategy | {key: usual}}).session.strategy == strategy["kind"]
