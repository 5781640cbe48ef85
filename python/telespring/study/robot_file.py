"""Robot files, as `telespring identify` writes them: what identification recorded beside the robot."""

from telespring._core import RobotRecord, robot_record

__all__ = ["RobotRecord", "robot_record"]
