"""Contact wrench of a Palpate slave for LeRobot: importing the package registers the robot type `palpate_wrench`."""
from lerobot_robot_palpate.palpate_wrench import PalpateWrench, PalpateWrenchConfig
from lerobot_robot_palpate.sensor import FEATURES, Wrench, WrenchSensor

__all__ = ["FEATURES", "PalpateWrench", "PalpateWrenchConfig", "Wrench", "WrenchSensor"]
