"""Starts and stops the built programs as a person or a supervisor would."""
import csv
import json
import math
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin"))
OUT = pathlib.Path(os.environ.get("PALPATE_TEST_OUTPUT", ROOT / "build/release/test-output"))
SLAVE, MASTER, SIMULATOR = (str(BIN / f"palpate-{name}") for name in ("slave", "master", "simulator"))
PACKAGE = BIN.resolve().parent / "python"  # the Python package palpate
BLOCK = str(ROOT / "deploy/scenes/silicone-block.yaml")
# The environment of a headless machine, without display and terminal.
BARE = {"PATH": "/usr/bin:/bin", "LC_ALL": "C"}
IS_DEEP = "PALPATE_QUICK" not in os.environ
# [s] before a program counts as hung: ten times what it needs, because test machines stall, and instrumented programs are slow
PATIENCE = int(os.environ.get("PALPATE_PATIENCE", 300))


def deep(test):
    """Marks a test that runs by hand and with `tests/run.sh --full` only."""
    return test if IS_DEEP else None


def overrides(*settings):
    return [word for setting in settings for word in ("--override", setting)]


def run(*command, **options):
    """Runs a program to its end with closed stdin, and captures its output as text."""
    return subprocess.run([str(c) for c in command], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=options.pop("timeout", PATIENCE), env=options.pop("env", BARE), **options)


class Simulator:
    """Starts `palpate-simulator` with the scene and the overrides of a slave's command line, in the same network
    namespace."""

    def __init__(self, command, address, *arguments):
        serve = command.index("serve")
        overrides = [word for i, word in enumerate(command) if "--override" in (word, command[i - 1])]
        self.process = subprocess.Popen(
            [*command[:serve - 1], SIMULATOR, command[serve + 1], "--slave", address, *overrides, *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=BARE)
        line = self.process.stdout.readline()
        self.streams = line == f"streaming to {address}\n"
        if self.streams:
            # The log is read, because a full pipe would block the simulator.
            self.reader = threading.Thread(target=self.process.stderr.read, daemon=True)
            self.reader.start()
            return
        _, log = self.process.communicate(timeout=PATIENCE)
        if self.process.returncode != 2 or "no `source: simulated`" not in log:
            raise AssertionError(f"simulator: {line!r}; {log}")

    def stop(self, with_signal=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(with_signal)
            self.process.wait(timeout=PATIENCE)
        self.process.stdout.close()


class Slave:
    """`palpate-slave serve` on a free port, stopped at the end of the `with` block. What its scene simulates comes from
    `palpate-simulator`, unless `simulates` is False; with certificates of the folder `tls`."""

    def __init__(self, scene=BLOCK, *arguments, command=None, simulates=True, tls=None):
        self.command = [str(word) for word in command or [SLAVE, "serve", scene, "--listen", "127.0.0.1:0", *arguments]]
        self.simulates = simulates
        self.simulator_options = ["--tls", tls] if tls else []
        self.simulator = None

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, env=BARE, start_new_session=True)
        line = self.process.stdout.readline()
        match = re.fullmatch(r"listening on (\S+)\n", line)
        if not match:
            self.process.kill()
            raise AssertionError(f"slave printed {line!r}; {self.process.stderr.read()}")
        self.address = match.group(1)
        if self.simulates:
            try:
                self.simulator = Simulator(self.command, self.address, *self.simulator_options)
            except BaseException as error:
                self.process.kill()
                raise AssertionError(f"{error}; slave: {self.process.communicate()[1]}") from error
        return self

    def stop(self, with_signal=signal.SIGTERM):
        """Sends the signal and returns the exit code."""
        self.process.send_signal(with_signal)
        try:
            _, self.log = self.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError("the slave did not stop")
        finally:
            if self.simulator is not None:
                self.simulator.stop()
        return self.process.returncode

    def __exit__(self, *error):
        if self.process.poll() is None:
            self.stop()
        elif self.simulator is not None:
            self.simulator.stop()
        self.process.stdout.close()


def wait_until(condition, patience=PATIENCE):
    end = time.monotonic() + patience
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def operate(address, *arguments, stdout=subprocess.DEVNULL):
    """Starts `palpate-master connect` in the background."""
    return subprocess.Popen([str(word) for word in (MASTER, "connect", address, *arguments)], stdin=subprocess.DEVNULL, stdout=stdout,
                            stderr=subprocess.DEVNULL, env=BARE)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def png(width, height, bits, rows):
    """Returns a grey PNG of 8 or 16 bits. `rows` are the bytes of each row."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows), 1)) + chunk(b"IEND", b""))


def make_certificates(folder, *roles):
    """Makes a folder of certificates for each of `roles`, and those of the simulator."""
    for words in (["ca"], ["slave", "here", "127.0.0.1"], ["sensor", "site"], ["arm", "site"], *([role, "ada"] for role in roles)):
        own = [] if words == ["ca"] else [folder / words[0]]
        run(ROOT / "deploy/certs", words[0], folder / "ca", *own, *words[1:]).check_returncode()


def cpu_seconds(pid):
    """Returns the CPU time of all threads so far [s] (proc(5))."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid, which="VmRSS"):
    """Returns the resident memory [MB]; with VmHWM the largest so far."""
    return int(re.search(rf"^{which}:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text(), re.MULTILINE)[1]) * 1024e-6


def load_package():
    """Returns (palpate, messages, states). Skips the test if Python has no gRPC or NumPy."""
    sys.path.insert(0, str(PACKAGE))
    try:
        import palpate
    except ImportError as error:
        raise unittest.SkipTest(f"{error} (deploy/install.sh tests)")
    from palpate.v1 import state_pb2, teleoperation_pb2
    return palpate, teleoperation_pb2, state_pb2


def read_json(path):
    """Reads a report and requires that no number is missing."""
    def refuse(name):
        raise AssertionError(f"{name} in {path}")
    return json.loads(pathlib.Path(path).read_text(), parse_constant=refuse)


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class FolderTest(unittest.TestCase):
    """Base class whose `self.out` is a temporary folder of the test."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name)

    def client(self, address):
        """Returns the stub of a slave. Its messages are in `self.messages` and `self.states`."""
        palpate, self.messages, self.states = load_package()
        connection = palpate.connect(address)
        self.addCleanup(connection.close)
        return connection.stub

    def assert_finite(self, log):
        """Requires that every number in a master's log is finite."""
        for row in read_rows(log):
            for key, text in row.items():
                if key not in ("state", "reason") and text:
                    self.assertTrue(math.isfinite(float(text)), f"{key} = {text} at {row['t']} s")
