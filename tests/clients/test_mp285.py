"""Tests the driver of the MP-285 with a fake device, whose transmission fails in six ways. Its time passes only while
the driver waits for data; one test uses a pseudo-terminal in real time.
"""
import importlib.util
import os
import pathlib
import pty
import random
import select
import struct
import sys
import threading
import tty
import types
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
try:
    import palpate  # noqa: F401
    import serial  # noqa: F401
except ImportError as error:
    print(f"skipped: {error} (apt-get install python3-serial; build/release/python)")
    raise SystemExit(77)
spec = importlib.util.spec_from_file_location("drive_mp285", ROOT / "deploy/examples/drive_mp285.py")
driver = importlib.util.module_from_spec(spec)
spec.loader.exec_module(driver)
PORT = "/dev/ttyUSB0"  # that of the fake device


class FakeMp285:
    """A fake device that behaves as the manual states, as a serial port. Of a hundred answers `failing` fail: missing,
    truncated, with a wrong bit, garbage, late, or an error."""

    def __init__(self, failing=0, seed=1):
        self.failing, self.random = failing, random.Random(seed)
        self.at, self.mute, self.failures, self.late = (200_000, 200_000, 200_000), False, 0, b""
        self.came, self.output = b"", b""
        self.timeout, self.now = driver.PATIENCE, 0.0  # [s]

    def write(self, data):
        self.came += data
        while self.came:
            length = {b"m": 14, b"c": 2}.get(self.came[:1], 1)
            if len(self.came) < length:
                break
            command, self.came = self.came[:length], self.came[length:]
            self.obey(command)

    def read(self, count):
        data, self.output = self.output[:count], self.output[count:]
        if len(data) < count:
            self.now += self.timeout
        return data

    def obey(self, command):
        if command[:1] == b"\x03":
            self.answer(b"\r")
        elif command[:1] == b"c":
            self.answer(struct.pack("<3i", *self.at) + b"\r")
        elif command[:1] == b"m":
            to = struct.unpack("<3i", command[1:13])
            if self.failing and self.random.random() < 0.01:  # it stops before the target and reports this
                self.failures += 1
                self.at = tuple((a + b) // 2 for a, b in zip(self.at, to))
                self.send(b"8\r")
                return
            self.at = to
            self.answer(b"\r")
        else:
            self.answer(b"4\r")

    def answer(self, data):
        self.send(self.late)
        self.late = b""
        if self.mute:
            return
        if self.random.random() * 100 >= self.failing:
            return self.send(data)
        self.failures += 1
        kind = self.random.randrange(6)
        if kind == 1:
            self.send(data[: len(data) // 2])
        elif kind == 2:
            i = self.random.randrange(len(data))
            self.send(data[:i] + bytes([data[i] ^ 1 << self.random.randrange(8)]) + data[i + 1:])
        elif kind == 3:
            self.send(b"\x7f\x11" + data)
        elif kind == 4:
            self.late = data
        elif kind == 5:
            self.send(bytes([self.random.choice(b"0124")]) + b"\r")

    def send(self, data):
        self.output += data


class Terminal:
    """A pseudo-terminal that passes data between its port and `fake`."""

    def __init__(self, fake):
        self.fake, self.ends = fake, False
        self.line, self.kept = pty.openpty()
        tty.setraw(self.kept)
        self.port = os.ttyname(self.kept)
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def close(self):
        self.ends = True
        self.thread.join()
        os.close(self.line)
        os.close(self.kept)

    def run(self):
        while not self.ends:
            if select.select([self.line], [], [], 0.02)[0]:
                self.fake.write(os.read(self.line, 64))
                os.write(self.line, self.fake.read(len(self.fake.output)))


class Mp285Test(unittest.TestCase):
    def fake(self, failing=0, seed=1):
        """Returns a fake device, which is that of every port from now on, as its clock is that of the driver."""
        fake = FakeMp285(failing, seed)
        for patch in (unittest.mock.patch.object(driver.serial, "Serial", lambda *_, **__: fake),
                      unittest.mock.patch.object(driver, "time", types.SimpleNamespace(monotonic=lambda: fake.now))):
            patch.start()
            self.addCleanup(patch.stop)
        return fake

    def test_it_moves_where_it_is_sent(self):
        fake = FakeMp285()
        terminal = Terminal(fake)
        self.addCleanup(terminal.close)
        with unittest.mock.patch.object(driver, "PATIENCE", 2):  # [s] a busy machine may delay an answer
            self.moves_where_it_is_sent(fake, driver.Mp285(terminal.port))

    def moves_where_it_is_sent(self, fake, drive):
        self.assertEqual(drive.find(), fake.at)
        self.assertEqual(drive.move_to((200_100, 199_900, 200_000), 0), (200_100, 199_900, 200_000))
        self.assertEqual(fake.at, (200_100, 199_900, 200_000))
        fake.at = (200_200, 199_900, 200_000)  # moved by the manual control
        self.assertEqual(drive.poll(), fake.at)

    def test_a_silent_line_is_a_fault(self):
        fake = self.fake()
        drive = driver.Mp285(PORT)
        drive.find()
        fake.mute = True
        for call in (drive.poll, drive.find, lambda: drive.move_to((0, 0, 0), 0)):
            with self.assertRaises(driver.Fault):
                call()

    def test_a_power_cycle_is_a_fault_until_it_is_where_it_was(self):
        fake = self.fake()
        drive = driver.Mp285(PORT)
        drive.find()
        fake.mute = True
        fake.now += 5 * driver.PATIENCE
        fake.mute, fake.at = False, (0, 0, 0)
        with self.assertRaisesRegex(driver.Fault, "switched off and on"):
            drive.find()
        fake.at = (200_000, 200_000, 200_000)
        fake.now += 5 * driver.PATIENCE
        self.assertEqual(drive.find(), fake.at)

    def test_no_position_is_accepted_that_it_does_not_have(self):
        for seed in range(3):
            fake = self.fake(failing=10, seed=seed)
            drive = driver.Mp285(PORT)
            found = False
            accepted = faults = 0
            for i in range(150):
                try:
                    to = (200_000 + 10 * i, 200_000, 200_000 - 7 * i)
                    at = drive.move_to(to, 0) if found and i % 2 else drive.poll() if found else drive.find()
                    self.assertEqual(at, fake.at)
                    found = True
                    accepted += 1
                except driver.Fault:
                    found = False
                    faults += 1
            self.assertGreater(accepted, 40)
            self.assertGreater(faults, 5, "the line did not fail")

    def test_the_arm_follows_at_its_speed_and_holds_after_a_fault(self):
        fake = self.fake()
        arm = driver.Arm(driver.Mp285(PORT), (0.01, 0, 0), speed=1e-3)
        arm.go(driver.np.array([0.011, 0, 0]), driver.np.zeros(3), None)
        first = arm.measure(0.05)
        self.assertAlmostEqual(first.tip[0], 0.01005, delta=1e-7)
        for _ in range(30):
            last = arm.measure(0.05)
        self.assertAlmostEqual(last.tip[0], 0.011, delta=1e-7)
        fake.mute = True
        self.assertIn("the micromanipulator", arm.measure(0.05).fault)
        fake.mute = False
        arm.go(driver.np.array([0.02, 0, 0]), driver.np.zeros(3), None)
        stood = fake.at
        self.assertEqual(arm.measure(0.05).fault, "", "found again")
        arm.measure(0.05)
        self.assertEqual(fake.at, stood, "nothing moves before a new target")


if __name__ == "__main__":
    sys.exit(unittest.main())
