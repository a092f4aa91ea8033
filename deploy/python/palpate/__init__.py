"""Contact forces of soft bodies.

The force of a mesh, here a block of foam that a disc of 20 mm presses by 2 mm:

    import palpate
    block = {"box": {"size": [0.06, 0.06, 0.03], "cells": [12, 12, 6]}}
    answer = palpate.solve(block, 20e3, 0.45, [0.03, 0.03, 0.03, 0, 0, -0.002],
                           tool={"shape": "flat", "width": 0.02}, fixed={"plane": {"axis": "z", "at": 0}})
    print(answer.force, answer.validity)

`Model` keeps its preparation, `verify_forces` compares measured with estimated forces, and `identify` finds the constants of
a material. These need no slave.

The forces of a running slave:

    with palpate.connect("127.0.0.1:50051") as slave:
        for state in slave.states(rate=10, seconds=3):
            if state.valid:
                print(state.force, "+-", state.sigma, "N")

`Slave` watches, operates, and feeds images, fingertips and a manipulator. Points, forces and images are NumPy arrays in
SI units, in the frame S of the slave. The messages of palpate.v1 are in `palpate.v1`; `state.message` is the whole
message behind a state.
"""
import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.arm import Arm, ArmReading, Exchange
    from palpate.comparison import Comparison, verify_forces, verify_table
    from palpate.errors import Error, Interrupted, LeaseHeld
    from palpate.feeds import Image, TactileSample, paced, replayed
    from palpate.material import Material, identify
    from palpate.model import Answer, ForceWarning, Model, solve
    from palpate.operator import Operator
    from palpate.recording import Recording, RecordingWarning, read_recording
    from palpate.slave import Slave, connect
    from palpate.state import Fingertip, Mesh, Phase, State, States, Validity, check_name

__all__ = ["Answer", "Arm", "ArmReading", "Comparison", "Error", "Exchange", "Fingertip", "ForceWarning", "Image", "Interrupted",
           "LeaseHeld", "Material", "Mesh", "Model", "Operator", "Phase", "Recording", "RecordingWarning", "Slave", "State",
           "States", "TactileSample", "Validity", "check_name", "connect", "identify", "paced", "read_recording", "replayed",
           "solve", "verify_forces", "verify_table"]

# Each is imported when it is used first: models need no gRPC, and a client needs no models.
_MODULES = {
    "arm": ("Arm", "ArmReading", "Exchange"),
    "comparison": ("Comparison", "verify_forces", "verify_table"),
    "errors": ("Error", "Interrupted", "LeaseHeld"),
    "feeds": ("Image", "TactileSample", "paced", "replayed"),
    "material": ("Material", "identify"),
    "model": ("Answer", "ForceWarning", "Model", "solve"),
    "operator": ("Operator",),
    "recording": ("Recording", "RecordingWarning", "read_recording"),
    "slave": ("Slave", "connect"),
    "state": ("Fingertip", "Mesh", "Phase", "State", "States", "Validity", "check_name"),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "_core":
        try:
            return importlib.import_module("palpate._core")
        except ModuleNotFoundError:
            raise ImportError(f"{__path__[0]} has no module _core of Python {sys.version_info.major}.{sys.version_info.minor}, which "
                              "models and comparisons need; build.sh writes the client only. Expected a package of pip or "
                              "python3-palpate: deploy/python/README.md") from None
    if name in _MODULES:
        return importlib.import_module(f"palpate.{name}")
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'palpate' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"palpate.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
