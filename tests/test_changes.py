"""Every change that `decide` prints is made as printed, and asked again: the answer is STABLE."""

from __future__ import annotations

import re

import numpy as np
import pytest
from questions import MINE, answered, flat, run

_ADVICE = re.compile(r"To (?:be stable|guarantee stability)[^:]*:(.*?)(?: Margins by axis|$)")


def changed(arguments: list[str], **options: str) -> list[str]:
    """Replace the options by these, named with underscores."""
    new = {f"--{name.replace('_', '-')}": value for name, value in options.items()}
    pairs = zip(arguments[::2], arguments[1::2], strict=True)
    kept = [text for pair in pairs if pair[0] not in new for text in pair]
    return [*kept, *(text for pair in new.items() for text in pair)]


def with_added_damping(arguments: list[str], added: str) -> list[str]:
    texts = list(arguments)
    for i, name in enumerate(arguments):
        if name == "--robot":
            mass, damping = texts[i + 1].split(",")
            texts[i + 1] = f"{mass},{float(damping) + float(added)}"
    return texts


def followed(screen: str, arguments: list[str]) -> list[list[str]]:
    """Read every change from a screen, and return the questions with it, as a user would type them."""
    [advice] = _ADVICE.findall(flat(screen))
    asked = []
    number = r"([0-9.e+-]+)"
    patterns = (
        (rf"a stiffness of up to {number} N/m", lambda told: changed(arguments, stiffness=told[0])),
        (
            rf"a delay of up to {number} (m?s) each way",
            lambda told: changed(arguments, delay=told[0] + told[1]),
        ),
        (
            rf"a delay of up to {number} (m?s) forward and {number} (m?s) backward",
            lambda told: changed(arguments, delay=told[0] + told[1], backward=told[2] + told[3]),
        ),
        (rf"at least {number} N·s/m of damping", lambda told: with_added_damping(arguments, told[0])),
        (rf"a sample period of {number} ms", lambda told: changed(arguments, sample_period=f"{told[0]}ms")),
    )
    for pattern, follow in patterns:
        for found in re.finditer(
            rf"(a playout buffer and )?{pattern}( \S+( \S+){{1,3}} behind a playout buffer)?", advice
        ):
            told = [text for text in found.groups()[1:] if text is not None]
            buffer = ["--playout-buffer"] if "playout buffer" in found[0] else []
            asked.append([*follow(told), *buffer])
    if re.search("a playout buffer of [^(]*[(]then say", advice):
        asked.append([*arguments, "--playout-buffer"])
    return asked


def random_question(generator: np.random.Generator) -> list[str]:
    """Draw robots, a network, its controllers and hands, the stiffness from too soft to far too stiff."""
    masses, dampings = generator.uniform(0.3, 3.0, 2), 10.0 ** generator.uniform(-0.3, 1.2, 2)
    delay = 10.0 ** generator.uniform(-2.3, -0.5)
    arguments: list[str] = []
    for mass, damping in zip(masses, dampings, strict=True):
        arguments += ["--robot", f"{mass:.4g},{damping:.4g}"]
    # 2 sqrt(b₁b₂) over the round trip, from a third of it to four times
    scale = np.sqrt(dampings.prod()) / (delay + 0.002)
    arguments += ["--stiffness", f"{min(scale * 10.0 ** generator.uniform(-0.5, 0.6), 19000.0):.4g}"]
    arguments += ["--delay", f"{1e3 * delay:.4g}ms"]
    if generator.random() < 0.3:
        arguments += ["--backward", f"{1e3 * delay * generator.uniform(0.2, 2.0):.4g}ms"]
    if generator.random() < 0.4:
        arguments += ["--jitter", f"{1e3 * delay * generator.uniform(0.05, 0.6):.3g}ms"]
    arguments += ["--sample-period", f"{generator.choice(['0', '0.5', '1', '1', '2', '5', '10'])}ms"]
    if generator.random() < 0.3:
        low = generator.uniform(20.0, 200.0)
        arguments += ["--grip", f"{low:.3g}:{low * generator.uniform(1.0, 4.0):.3g}"]
    return arguments


def check_changes(seeds: range) -> int:
    """Ask random questions, follow what is printed, and return how many changes were followed."""
    count = 0
    for seed in seeds:
        arguments = random_question(np.random.default_rng(seed))
        first = run("decide", *arguments, columns=200)
        assert first.exit_code == 0, (arguments, first.output)
        for again in followed(first.stdout, arguments):
            answer = run("decide", *again, "--check", columns=200)
            assert answer.exit_code == 0, (seed, arguments, first.stdout, again, answer.output)
            count += 1
    return count


def test_law_every_printed_change_is_stable_with_the_reserve() -> None:
    assert check_changes(range(25)) > 40


@pytest.mark.verify
def test_law_every_printed_change_of_many_questions_is_stable_with_the_reserve() -> None:
    assert check_changes(range(1000, 2000)) > 2000
