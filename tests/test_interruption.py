"""Signals and forks during long calls, each in a process of its own."""

import os
import signal
import subprocess
import sys
import time

import pytest

# Between the calls of `starmap(call, ...)` no line of Python runs, so that only the compiled function can see
# the signal; what it returned is in `done`. Some compiled functions are private names here: the public ones
# around them are Python, which sees signals before and after.
START = """
import signal, sys, _thread
from functools import partial
from itertools import starmap
from operator import call
import numpy as np
import telespring as ts
from telespring import _core as core

signal.signal(signal.SIGINT, signal.default_int_handler)
done = []

def show(text):
    sys.stdout.write(text + "\\n")
    sys.stdout.flush()
"""

OBJECTS = """
rng = np.random.default_rng(0)
size = 60
matrix = lambda: rng.normal(size=(size, size))
system = ts.DelaySystem(matrix() - 8 * np.eye(size), [(1.0, matrix()), (0.37, matrix())])
dyad = ts.hman()
numbers = (0.8334, 7.7257, 0.7776, 7.4208)
loop = (dyad, 71.2, 0.1, 0)
steps = [[1.0, 0.0], [0.0, 0.0]]
noise = [[lambda t: np.sin(1e8 * t * t), 0.0], [0.0, 0.0]]
options = dict(rtol=1e-9, atol=1e-9, max_steps=10**9, initial_step=None, max_step=1e-3, breakpoints=[])
arm = ts.Arm(kind="two-link", base=[0.0, -0.45], elbow="right", link_length=0.325, link_mass=[0.88, 0.40],
             link_centre=[0.25, 0.16], link_inertia=[0.010, 0.004])
angle = np.linspace(0.0, 2 * np.pi, 20_000)
places = np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])
laboratory = core.Laboratory.paper()
"""

# y' = min(t, y, y(t - 1)) from 1e9, which is t
CALLS = [
    "system.characteristic_roots, 8",
    "system.spectral_abscissa,",
    "core.frequency_response, loop, np.linspace(0.01, 1e3, 3_000_000), 'exact'",
    "core.frequency_grid, loop, 0.0, 1e7, 1e-3, 100_000_000",
    "core.transfer_matrix, loop, np.full(2_000_000, 1j), 'exact'",
    "ts.stability_map, dyad, np.linspace(1, 500, 6000), np.linspace(0, 3, 10_000)",
    "ts.maximum_stiffness, dyad, np.linspace(0.01, 3.0, 300_000)",
    "ts.maximum_stiffness, *numbers, np.full((4000, 1), 2.9)",
    "core.simulate, dyad, 71.2, 0.01, steps, 1e5, 10.0, None, False",
    "core.simulate, dyad, 71.2, 0.01, noise, 1e4, 10.0, None, False",
    "core.solve_dde, min, [1.0], partial(max, 1e9), 1, None, (0.0, 1e6), options",
    "core.pose_stability, dyad, (arm, arm), 71.2, 0.15, places, (0.0, 0.0)",
    "laboratory.run, 71.2, 0.08, 1, 1e4, 1.0",
    "laboratory.run_many, [71.2] * 8, [0.08] * 8, list(range(8)), 1e4, 1.0",
]


def test_law_a_long_call_ends_at_a_signal() -> None:
    body = START + OBJECTS
    for i, arguments in enumerate(CALLS):
        body += f"""
arguments = ({arguments})
show("{i}")
try:
    done.extend(starmap(call, [arguments]))
except KeyboardInterrupt:
    pass
"""
    # the state is as before: the same call gives the same answer
    body += """
again = ts.stability_map(dyad, np.linspace(1, 500, 60), np.linspace(0, 3, 60))
show(f"finished {len(done)} {again.sum()}")
"""
    with subprocess.Popen([sys.executable, "-c", body], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("finished"):
                break
            time.sleep(0.15)
            process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
    assert (line, rest, process.returncode) == ("finished 0 393\n", "", 0)


@pytest.mark.parametrize(
    "first", ["getattr, ts.Robot(1.0, 2.0), 'mass'", "core.Laboratory.paper().target, 1.0, 10.0"]
)
def test_law_a_signal_in_the_first_call_is_an_exception(first: str) -> None:
    body = (
        START
        + f"""
arguments = [(_thread.interrupt_main,), ({first})]
try:
    done.extend(starmap(call, arguments))
except KeyboardInterrupt:
    show("interrupted")
"""
    )
    ended = subprocess.run([sys.executable, "-c", body], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "interrupted\n", "")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_law_a_forked_process_computes_in_parallel() -> None:
    body = (
        START
        + OBJECTS
        + """
import os
from telespring.theory.poses import pose_stability

def answers():
    return [
        ts.stability_map(dyad, np.linspace(1, 500, 60), np.linspace(0, 3, 60)),
        ts.critical_stiffness(*numbers, kh1=np.linspace(0, 1, 5000)),
        pose_stability(dyad, (arm, arm), 71.2, 0.15, places[:4]).spectral_abscissa,
        laboratory.run_many([71.2] * 3, [0.08] * 3, [1, 2, 3], 1.0, 10.0).position,
        ts.characteristic_roots(dyad, 71.2, 0.1),
    ]

here = answers()
same = lambda: all(np.array_equal(a, b) for a, b in zip(here, answers(), strict=True))
def forked(then):
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    os._exit(0 if then() else 1)

show(f"child {forked(same)}")
show(f"grandchild {forked(lambda: same() and forked(same) == 0)}")
show(f"parent {same()}")
"""
    )
    process = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", body], capture_output=True, text=True, timeout=60, check=False
    )
    assert (process.stdout.split("\n"), process.stderr) == (
        ["child 0", "grandchild 0", "parent True", ""],
        "",
    )
