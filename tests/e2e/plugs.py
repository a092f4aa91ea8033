"""A slave with an external camera and arm: one process simulates the object and its camera, another one drives the
arm."""
import re
import signal
import subprocess
import sys

from programs import BARE, BIN, BLOCK, MASTER, PACKAGE, PATIENCE, ROOT, FolderTest, Slave, read_json, wait_until

EXAMPLES = ROOT / "deploy/examples"
sys.path[:0] = [str(EXAMPLES), str(PACKAGE)]
try:
    import grpc
    import palpate
    from palpate.v1 import state_pb2 as states, teleoperation_pb2 as messages
except ImportError as error:
    print(f"skipped: {error}")
    raise SystemExit(77)

ENVIRONMENT = {**BARE, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": f"{EXAMPLES}:{PACKAGE}"}
PLUGGED = ["--override", "manipulator.source=stream", "--override", "sense.camera.source=stream"]
HOME = "0.044,0.09416,0"


class Plugged(FolderTest):
    """A slave of the block that waits for an external camera and arm."""

    def setUp(self):
        super().setUp()
        self.slave = Slave(BLOCK, *PLUGGED)
        self.slave.__enter__()
        self.addCleanup(self.slave.__exit__)
        self.stub = self.connect()

    def connect(self):
        return palpate.connect(self.slave.address).stub

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.send_signal(signal.SIGCONT)
            process.kill()
        process.wait()
        if process.stdout:
            process.stdout.close()

    def start(self, *command, **options):
        process = subprocess.Popen([str(c) for c in command], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   text=True, env=ENVIRONMENT, **options)
        self.addCleanup(self.end, process)
        return process

    def play(self):
        player = self.start(BIN / "site_player", BLOCK, self.slave.address, stdout=subprocess.PIPE)
        self.site = re.fullmatch(r"site on (\S+)\n", player.stdout.readline()).group(1)
        return player

    def drive(self, driver=EXAMPLES / "drive_arm.py", *arguments):
        return self.start("/usr/bin/python3", driver, self.slave.address, "--home", HOME, "--site", self.site,
                          "--rate", "500", *arguments, stdout=subprocess.DEVNULL)

    def status(self):
        return self.stub.GetStatus(messages.GetStatusRequest(), timeout=10)

    def ready(self):
        return wait_until(lambda: not self.status().alarms and self.status().validity == states.VALIDITY_VALID)

    def operate(self, seconds):
        return self.start(MASTER, "connect", self.slave.address, "--device", "sim-hand", "--duration", seconds, "--report",
                          self.out / "report.json", "--log", self.out / "log.csv", stdout=subprocess.DEVNULL)

    def report(self, master):
        master.wait(timeout=PATIENCE)
        return read_json(self.out / "report.json")
