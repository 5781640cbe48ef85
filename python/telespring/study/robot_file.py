"""Robot files, as `telespring identify` writes them: the record of the identification."""

from telespring._core import RobotRecord, robot_record

__all__ = ["RobotRecord", "robot_record"]
