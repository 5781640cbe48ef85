"""Every change that `decide` prints is made as printed, and asked again: the answer is STABLE."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from questions import MINE, answered, decide, flat, one_axis, run

_TIME = "([0-9.e+-]+) (m?s)"


def changed(arguments: list[str], **options: str) -> list[str]:
    """Replace the options by these, named with underscores."""
    new = {f"--{name.replace('_', '-')}": value for name, value in options.items()}
    pairs = zip(arguments[::2], arguments[1::2], strict=True)
    kept = [text for pair in pairs if pair[0] not in new for text in pair]
    return [*kept, *(text for pair in new.items() for text in pair)]


def with_added_damping(arguments: list[str], added: str) -> list[str]:
    texts = list(arguments)
    for i, name in enumerate(arguments):
        if name == "--robot" and texts[i + 1].endswith(".toml"):
            file = Path(texts[i + 1])
            old = re.search(r"(?<=damping = )\S+", file.read_text())
            assert old is not None
            firmer = file.with_name(f"firmer_{added}_{file.name}")
            damping = f"damping = {float(old[0]) + float(added)}"
            firmer.write_text(file.read_text().replace(f"damping = {old[0]}", damping))
            texts[i + 1] = str(firmer)
        elif name == "--robot":
            mass, robot_damping = texts[i + 1].split(",")
            texts[i + 1] = f"{mass},{float(robot_damping) + float(added)}"
    return texts


def advice(screen: str) -> list[str]:
    """Return the lines that say what to change, from a screen wide enough for each of them."""
    lines = iter(screen.splitlines())
    for line in lines:
        if line.startswith(("To be stable", "To guarantee stability")):
            return [each.strip() for each in itertools.takewhile(lambda text: text.strip(), lines)]
    return []


def followed(line: str, arguments: list[str]) -> list[str] | None:
    """Return the question with a printed change, as a user would type it; None if the line has none."""
    buffer = ["--playout-buffer"] if "a playout buffer" in line else []
    if told := re.search(r"a stiffness of up to ([0-9.e+-]+) N/m", line):
        asked = changed(arguments, stiffness=told[1])
    elif told := re.search(rf"a delay of up to {_TIME} each way", line):
        asked = changed(arguments, delay=told[1] + told[2])
    elif told := re.search(
        r"a delay of up to ([0-9.e+-]+) (m?s) forward and ([0-9.e+-]+) (m?s) backward", line
    ):
        asked = changed(arguments, delay=told[1] + told[2], backward=told[3] + told[4])
    elif told := re.search(r"at least ([0-9.e+-]+) N·s/m of damping", line):
        asked = with_added_damping(arguments, told[1])
    elif told := re.search(r"a sample period of ([0-9.e+-]+) ms", line):
        asked = changed(arguments, sample_period=f"{told[1]}ms")
    elif buffer:
        asked = arguments
    else:
        return None
    return asked + buffer


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


def with_errors(arguments: list[str], generator: np.random.Generator, folder: Path) -> list[str]:
    """Write robot files with errors of mass and damping, and return the question about these robots."""
    texts = list(arguments)
    for i in range(1, 4, 2):
        mass, damping = map(float, texts[i].split(","))
        errors = generator.uniform(0.005, 0.05, 2) * (mass, damping)
        file = folder / f"robot{i}_{mass}.toml"
        file.write_text(
            f"[robot]\nmass = {mass}\ndamping = {damping}\n"
            f"mass_sd = {errors[0]:.4g}\ndamping_sd = {errors[1]:.4g}\n"
        )
        texts[i] = str(file)
    return texts


def check_changes(seeds: range, folder: Path) -> int:
    """Ask random questions, follow what is printed, and return how many changes were followed."""
    count = 0
    for seed in seeds:
        generator = np.random.default_rng(seed)
        arguments = random_question(generator)
        if seed % 5 == 4:
            arguments = with_errors(arguments, generator, folder)
        first = run("decide", *arguments, columns=200)
        assert first.exit_code == 0, (arguments, first.output)
        for line in advice(first.stdout):
            again = followed(line, arguments)
            if again is None:
                assert line.startswith(("no stiffness", "nothing to change", "(no ", "robots identified")), (
                    line
                )
                continue
            answer = run("decide", *again, "--check", columns=200)
            assert answer.exit_code == 0, (seed, arguments, first.stdout, again, answer.output)
            count += 1
    return count


def test_law_every_printed_change_is_stable_with_the_reserve(tmp_path: Path) -> None:
    assert check_changes(range(25), tmp_path) > 40


@pytest.mark.verify
def test_law_every_printed_change_of_many_questions_is_stable_with_the_reserve(tmp_path: Path) -> None:
    assert check_changes(range(1000, 2000), tmp_path) > 2000


# -- what is recommended is accepted

STIFF = ("--robot", "50,900", "--robot", "60,900", "--ping", "4ms")


def test_law_no_stiffness_is_recommended_that_is_refused() -> None:
    """These robots may use more than 20,000 N/m, the most that a laboratory uses."""
    screen = flat(run("decide", *STIFF).stdout)
    assert (
        "You may use any stiffness that laboratories use (up to 20000 N/m) at this constant delay" in screen
    )
    [row] = answered(*STIFF)["delays"]
    assert row["usable_stiffness"] > row["recommended_stiffness"] == 20000.0
    assert run("decide", *STIFF, "--stiffness", "20000", "--check").exit_code == 0
    assert run("decide", *STIFF, "--stiffness", str(row["usable_stiffness"])).exit_code == 2
    table = run("decide", *STIFF[:4]).stdout
    told = re.findall(r"(?<![0-9.])[0-9]{5,}(?![0-9.])", table[: table.index("20000") + 5])
    assert told == ["20000"]


def test_law_what_may_be_used_of_an_unlimited_stiffness_is_usual() -> None:
    screen = flat(run("decide", *MINE, "--delay", "0", "--continuous").stdout)
    assert "any stiffness that laboratories use (up to 20000 N/m)" in screen
    [row] = answered(*MINE, "--delay", "0", "--continuous")["delays"]
    assert row["usable_stiffness_unbounded"]
    assert row["recommended_stiffness"] == 20000.0


def test_law_no_delay_is_recommended_that_is_refused() -> None:
    asked = ("--robot", "1,6", "--robot", "1,6", "--stiffness", "17.16")
    limits = answered(*asked)["stiffness"]
    assert limits["usable_delay"] is None or limits["usable_delay"] > 2.0
    assert limits["recommended_delay"] == 2.0


# -- limits of sampled delays are whole periods


def test_law_the_margin_of_the_delay_adds_up() -> None:
    """From 40 to 54 ms are 14 ms, in which floating point sees 13.999999999999999 ms."""
    screen = flat(run("decide", *MINE, "--ping", "80ms", "--stiffness", "150").stdout)
    told = re.search(r"The delay may grow by ([0-9.]+) ms, to ([0-9.]+) ms", screen)
    assert told is not None
    assert 40.0 + float(told[1]) == float(told[2])
    assert float(told[2]).is_integer()


def test_law_a_usable_delay_of_whole_periods_is_whole_periods() -> None:
    """Where 5 % more stiffness sets the delay, it is the last period at which that is stable."""
    found = 0
    for k in range(40, 320, 40):
        usable = answered(*MINE, "--stiffness", str(k))["stiffness"]["usable_delay"]
        limit = answered(*MINE, "--stiffness", str(1.05 * k))["stiffness"]["delay_limit"]
        assert usable is not None
        assert usable <= limit
        if usable == limit:
            found += 1
            assert abs(1e3 * usable - round(1e3 * usable)) < 1e-9
            screen = flat(run("decide", *MINE, "--stiffness", str(k)).stdout)
            assert f"up to {round(1e3 * usable)} ms each way" in screen
            again = run(
                "decide", *MINE, "--stiffness", str(k), "--delay", f"{round(1e3 * usable)}ms", "--check"
            )
            assert again.exit_code == 0
    assert found > 1


def test_law_two_limits_of_the_delay_are_told_apart() -> None:
    asked = ("decide", *MINE, "--ping", "80ms", "--stiffness")
    for k in ("150", "250"):
        assert "Margins by axis if the controllers were continuous" in flat(run(*asked, k).stdout)
    screen = flat(run(*asked, "250").stdout)
    judged = re.search(
        r"With these controllers, sampled every 1 ms, a delay up to ([0-9]+) ms is stable", screen
    )
    assert judged is not None
    assert decide(one_axis(), 250.0, 1e-3 * float(judged[1])).stable
    assert not decide(one_axis(), 250.0, 1e-3 * float(judged[1]) + 1e-4).stable
    continuous = flat(run("decide", *MINE, "--ping", "80ms", "--stiffness", "150", "--continuous").stdout)
    assert "if the controllers were continuous" not in continuous
    assert "With these controllers" not in continuous


# -- what you may use


def check_usable(seeds: range) -> int:
    """Ask random questions without a stiffness, then without a delay, and use as much as is printed."""
    count = 0
    for seed in seeds:
        arguments = random_question(np.random.default_rng(seed))
        for left_out in ("--stiffness", "--delay"):
            kept = [
                text
                for pair in zip(arguments[::2], arguments[1::2], strict=True)
                for text in pair
                if pair[0] not in (left_out, "--backward")
            ]
            screen = run("decide", *kept, columns=300).stdout
            for buffered in ([], ["--playout-buffer"]):
                lines = [
                    line
                    for line in screen.splitlines()
                    if ("with a playout" in line.lower()) == bool(buffered)
                ]
                if buffered and not any(lines):
                    continue
                unit = "N/m" if left_out == "--stiffness" else "m?s"
                told = [
                    found
                    for line in lines
                    for found in re.findall(
                        rf"(?:You may use|The delay may be) up to ([0-9.e+-]+) ({unit})", line
                    )
                ]
                verdicts = [line for line in lines if re.search("You may|The delay may|No |Any ", line)]
                if not told or len(told) < len(verdicts):
                    continue  # one of free and held handles may use none
                factor = {"N/m": 1.0, "ms": 1e-3, "s": 1.0}
                least, written = min(told, key=lambda each: float(each[0]) * factor[each[1]])
                value = least if written == "N/m" else least + written
                answer = run("decide", *kept, left_out, value, *buffered, "--check", columns=200)
                assert answer.exit_code == 0, (seed, kept, screen, value, answer.output)
                count += 1
    return count


def test_law_as_much_as_is_printed_may_be_used() -> None:
    assert check_usable(range(8)) > 8


@pytest.mark.verify
def test_law_as_much_as_is_printed_may_be_used_of_many_questions() -> None:
    assert check_usable(range(1000, 1500)) > 500
