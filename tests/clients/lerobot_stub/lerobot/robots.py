"""Stand-in for lerobot.robots: the registry of configurations, the abstract robot and the factory, as the plug-in uses
them."""
import abc
import importlib
from dataclasses import dataclass


@dataclass(kw_only=True)
class RobotConfig:
    id: str | None = None
    known = {}

    @classmethod
    def register_subclass(cls, name):
        def register(kind):
            assert name not in cls.known, f"{name} is registered"
            cls.known[name] = kind
            return kind
        return register


class Robot(abc.ABC):
    def __init__(self, config):
        assert isinstance(config, self.config_class)
        self.id = config.id

    observation_features = abc.abstractproperty()
    action_features = abc.abstractproperty()
    is_connected = abc.abstractproperty()
    is_calibrated = abc.abstractproperty()

    @abc.abstractmethod
    def connect(self, calibrate=True): ...

    @abc.abstractmethod
    def calibrate(self): ...

    @abc.abstractmethod
    def configure(self): ...

    @abc.abstractmethod
    def get_observation(self): ...

    @abc.abstractmethod
    def send_action(self, action): ...

    @abc.abstractmethod
    def disconnect(self): ...


def make_robot_from_config(config):
    """Makes the robot whose class is beside the configuration's class and has its name without Config."""
    kind = type(config)
    assert kind.__name__.endswith("Config")
    return getattr(importlib.import_module(kind.__module__), kind.__name__[:-6])(config)
