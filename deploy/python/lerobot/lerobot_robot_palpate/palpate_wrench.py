"""A robot of LeRobot with the contact wrench of a slave among its observations."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lerobot.robots import Robot, RobotConfig, make_robot_from_config

from lerobot_robot_palpate.sensor import WrenchSensor


@RobotConfig.register_subclass("palpate_wrench")
@dataclass(kw_only=True)
class PalpateWrenchConfig(RobotConfig):
    """--robot.type=palpate_wrench --robot.robot.type=so101_follower --robot.target=127.0.0.1:50051"""
    robot: RobotConfig  # the robot that moves
    target: str = "127.0.0.1:50051"  # the slave
    tls: str | None = None  # folder of certificates
    frame: str = "palpate_slave"  # name of frame S


class PalpateWrench(Robot):  # type: ignore[misc]
    """Delegates to the robot, and adds WrenchSensor.features to its observations."""

    config_class = PalpateWrenchConfig
    name = "palpate_wrench"

    def __init__(self, config: PalpateWrenchConfig) -> None:
        super().__init__(config)
        self.robot = make_robot_from_config(config.robot)
        self.wrench = WrenchSensor(config.target, config.tls, config.frame)
        doubled = sorted(set(self.robot.observation_features) & set(self.wrench.features))
        if doubled:
            raise ValueError(f"{type(self.robot).__name__}.observation_features has {', '.join(doubled)}: expected no wrench")

    @property
    def observation_features(self) -> dict[str, Any]:
        return {**self.robot.observation_features, **self.wrench.features}

    @property
    def action_features(self) -> dict[str, Any]:
        return dict(self.robot.action_features)

    @property
    def cameras(self) -> Any:
        return getattr(self.robot, "cameras", {})

    @property
    def is_connected(self) -> bool:
        return bool(self.robot.is_connected and self.wrench.is_connected)

    @property
    def is_calibrated(self) -> bool:
        return bool(self.robot.is_calibrated)

    def connect(self, calibrate: bool = True) -> None:
        self.wrench.connect()
        try:
            self.robot.connect(calibrate)
        except BaseException:
            self.wrench.disconnect()
            raise

    def calibrate(self) -> None:
        self.robot.calibrate()

    def configure(self) -> None:
        self.robot.configure()

    def get_observation(self) -> dict[str, Any]:
        return {**self.robot.get_observation(), **self.wrench.read()}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        sent: dict[str, Any] = self.robot.send_action(action)
        return sent

    def disconnect(self) -> None:
        try:
            self.robot.disconnect()
        finally:
            self.wrench.disconnect()
