"""HEBI modules as a device of telespring-link.

python -m drivers.hebi drivers/hebi/arm.toml --listen 127.0.0.1:4600 --site 127.0.0.1:4601
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from pathlib import Path
from types import FrameType

from drivers.device_protocol import Link, address
from drivers.hebi.modules import Imitation, Modules, RobotModel
from drivers.hebi.robot import Robot
from drivers.hebi.settings import BadSetting, read


def serve(robot: Robot, modules: Modules, link: Link) -> None:
    """Be the robot until a signal comes; then let the force fall, and go."""
    is_over = False

    def end(_signal: int, _frame: FrameType | None) -> None:
        nonlocal is_over
        is_over = True
        robot.release()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    said: str | None = ""
    while not (is_over and robot.share == 0.0):
        feedback = modules.read()
        now = time.monotonic()
        robot.hear(now, link.commands())
        state, efforts = robot.tick(now, feedback)
        modules.apply(efforts)
        if state is not None:
            link.send(state)
        if robot.fault != said:
            said = robot.fault
            print("ready" if said is None else f"not ready: {said}", flush=True)


def main() -> int:
    """Read the arm file, find the modules and serve."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("arm", type=Path, help="the arm file, as arm.toml beside this program")
    parser.add_argument("--listen", type=address, required=True, help="where this program listens")
    parser.add_argument("--site", type=address, required=True, help="device.local of the site file")
    parser.add_argument("--imitation", action="store_true", help="imitated modules: no motion, for checks")
    arguments = parser.parse_args()
    try:
        settings = read(arguments.arm, RobotModel)
        modules = Imitation(settings) if arguments.imitation else Modules(settings)
        link = Link(arguments.listen, arguments.site)
    except (BadSetting, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    try:
        serve(Robot(settings.arm, settings.limits), modules, link)
    finally:
        modules.release()
        link.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
