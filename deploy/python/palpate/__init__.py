"""Client of a Palpate slave.

    import palpate

    with palpate.connect("127.0.0.1:50051") as slave:
        for state in slave.states(rate=10, seconds=3):
            if state.valid:
                print(state.force, "+-", state.sigma, "N")

`Slave` watches, operates, and feeds images, fingertips and a manipulator. Points, forces and images are NumPy arrays in
SI units, in the frame S of the slave. The messages of palpate.v1 are in `palpate.v1`; `state.message` is the whole
message behind a state.
"""
from palpate.arm import Arm, ArmReading, Exchange
from palpate.errors import Error, Interrupted, LeaseHeld
from palpate.feeds import Image, TactileSample, paced, replayed
from palpate.operator import Operator
from palpate.recording import Recording, RecordingWarning, read_recording
from palpate.slave import Slave, connect
from palpate.state import Fingertip, Mesh, Phase, State, States, Validity, check_name

__all__ = ["Arm", "ArmReading", "Error", "Exchange", "Fingertip", "Image", "Interrupted", "LeaseHeld", "Mesh", "Operator",
           "Phase", "Recording", "RecordingWarning", "Slave", "State", "States", "TactileSample", "Validity", "check_name", "connect", "paced",
           "read_recording", "replayed"]
