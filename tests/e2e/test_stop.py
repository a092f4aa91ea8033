"""An emergency stop after a reset remains, whatever the network does to the two calls.

PALPATE_STOPS: number of trials with raw calls (default 40). There are 2 / 15 as many trials with the master, at least
5, and half as many random sequences of three stations at one slave.
"""
import os
import pathlib
import pty
import random
import re
import signal
import subprocess
import tempfile
import threading
import time
import unittest

from programs import BARE, BIN, BLOCK, MASTER, PATIENCE, SLAVE, FolderTest, Slave, operate, wait_until
from setups import LiveCamera, SetupSlave, first_image
from stalled_link import StalledLink

TRIALS = int(os.environ.get("PALPATE_STOPS", 40))
MASTER_TRIALS = max(5, TRIALS * 2 // 15)
SEQUENCES = TRIALS // 2
AT_ONCE = 4  # slaves, each with its stations
MODES = ("stalled", "open", "cut", "own connections", "slow disk")
ANSWER = 20  # [s]


class Station:
    """A master that stops by SIGUSR1 and resets by SIGUSR2. `said`: its states, each with the time of its line."""

    def __init__(self, address, *arguments):
        self.process = subprocess.Popen([MASTER, "connect", address, "--duration", "3600", *arguments], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=BARE)
        self.said = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            for word in re.findall(r"\bs  ([A-Z_]+) ", line):
                self.said.append((time.monotonic(), word))

    def state(self):
        return self.said[-1][1] if self.said else ""

    def stop(self):
        self.process.send_signal(signal.SIGUSR1)

    def reset(self):
        self.process.send_signal(signal.SIGUSR2)

    def close(self):
        self.process.terminate()
        self.process.wait(PATIENCE)
        self.reader.join(PATIENCE)
        self.process.stdout.close()


class Site:
    """A slave and three stations, the second behind a link that can be stalled and cut. Of a simulated scene the first operates and
    the others watch, until the lease is free; during a set-up all watch."""

    def __init__(self, slave, test):
        self.test, self.slave = test, slave
        self.stub = test.client(slave.address)
        self.link = StalledLink(slave.address).__enter__()
        self.stations = [Station(slave.address, "--name", "first")]
        test.assertTrue(wait_until(lambda: self.stations[0].state() in ("FOLLOWING", "DISCONNECTED")))
        self.stations += [Station(self.link.address, "--name", "second"), Station(slave.address, "--name", "third")]
        self.phases, self.ended = [], threading.Event()
        threading.Thread(target=self.watch, daemon=True).start()

    def watch(self):
        """Notes when the slave was in ESTOP."""
        while not self.ended.wait(0.02):
            self.phases.append((time.monotonic(), self.is_stopped()))

    def is_stopped(self):
        return self.stub.GetStatus(self.test.messages.GetStatusRequest(), timeout=ANSWER).phase == self.test.states.PHASE_ESTOP

    def close(self):
        self.ended.set()
        for station in self.stations:
            station.close()
        self.link.__exit__()

    def claims(self, since):
        """Returns the times at which a station said ESTOP [s], although the slave had not been in it for two seconds."""
        asked = [begin for begin, _ in self.phases if begin > since - 2]
        between = 0.1 + max((later - earlier for earlier, later in zip(asked, asked[1:])), default=0)  # two looks at the slave
        stopped = [begin for begin, is_stopped in self.phases if is_stopped]
        return [at - since for station in self.stations for at, state in station.said
                if state == "ESTOP" and at > since and not any(at - 2 < when < at + between for when in stopped)]

    def sequence(self, dice):
        """Stops and resets at random. Returns what was wrong."""
        first, second, _ = self.stations
        acts = {"stop 1": first.stop, "stop 2": second.stop, "reset 1": first.reset, "reset 2": second.reset, "stall": self.link.stall,
                "release": self.link.release, "cut": self.link.cut}
        begin, done = time.monotonic(), []
        while time.monotonic() - begin < 3.5:
            done.append(dice.choice(list(acts)))
            acts[done[-1]]()
            time.sleep(dice.choice((0, 0.02, 0.1, 0.5, 1)) * dice.uniform(0.5, 1.5))
        self.link.release()
        wrong = []
        pressed = [act for act in done if act[:4] in ("stop", "rese")]
        if pressed and pressed[-1].startswith("stop"):
            if not wait_until(self.is_stopped, patience=15):
                wrong.append("the last stop is undone")
        time.sleep(1)
        if not wait_until(lambda: all((station.state() == "ESTOP") == self.is_stopped() for station in self.stations), patience=20):
            wrong.append(f"the slave is {'' if self.is_stopped() else 'not '}stopped, the stations say " +
                         ", ".join(station.state() for station in self.stations))
        wrong += [f"a station says ESTOP at {at:.2f} s" for at in self.claims(begin)]
        if self.is_stopped():  # for the next sequence
            first.reset()
            if not wait_until(lambda: not self.is_stopped(), patience=15):
                wrong.append("the operator cannot reset the stop")
            wait_until(lambda: all(station.state() != "ESTOP" for station in self.stations), patience=20)
        return [f"{words}: {', '.join(done)}" for words in wrong]


class Stops(FolderTest):
    def enter(self, context):
        entered = context.__enter__()
        self.addCleanup(context.__exit__, None, None, None)
        return entered

    def serve(self, *prefix):
        """Starts a slave that saves its stops. `prefix` is put before its command line."""
        self.state = pathlib.Path(tempfile.mkdtemp(dir=self.out))
        slave = self.enter(Slave(command=[*prefix, SLAVE, "serve", BLOCK, "--listen", "127.0.0.1:0", "--override",
                                          "model.elements=60", "--state-dir", self.state]))
        self.direct = self.client(slave.address)
        return slave

    def status(self):
        return self.direct.GetStatus(self.messages.GetStatusRequest(), timeout=ANSWER)

    def is_stopped(self):
        return self.status().phase == self.states.PHASE_ESTOP

    def stop(self):
        return self.direct.Stop(self.messages.StopRequest(reason="a test"), timeout=ANSWER)

    def reset(self, stops):
        return self.direct.Reset(self.messages.ResetRequest(stops=stops), timeout=ANSWER)

    def test_a_reset_clears_the_stop_that_it_names_and_no_other(self):
        import grpc
        self.serve()
        first, second = self.stop(), self.stop()
        self.assertGreater(second.stops, first.stops)
        for stops in (0, first.stops, second.stops + 1):
            with self.assertRaises(grpc.RpcError) as refused:
                self.reset(stops)
            self.assertEqual(refused.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
            self.assertIn("emergency stop", refused.exception.details())
            self.assertTrue(self.is_stopped())
            self.assertTrue(list(self.state.iterdir()), "its record stays")
        self.assertEqual(self.reset(second.stops).phase, self.states.PHASE_READY)
        self.assertFalse(list(self.state.iterdir()))
        self.reset(0)  # nothing is stopped, so this restarts the sensing

    def trial(self, mode, link, stub, dice):
        """Sends Reset, then Stop. Returns whether the tool is free afterwards or the stop is not saved."""
        known = self.status().stops
        stub.GetStatus(self.messages.GetStatusRequest(), timeout=ANSWER)  # opens the connection
        if mode != "open":
            link.stall()
        reset = stub.Reset.future(self.messages.ResetRequest(stops=known), timeout=ANSWER)
        time.sleep(dice.uniform(0, 0.004) if mode == "open" else dice.uniform(0.05, 0.2))
        stopper = self.direct if mode == "own connections" else stub
        stop = stopper.Stop.future(self.messages.StopRequest(reason="later"), timeout=ANSWER)
        time.sleep(0.02)
        link.release()
        if mode == "cut":
            time.sleep(dice.uniform(0, 0.005))
            link.cut()
        if stop.exception() is not None:
            self.stop()  # an operator presses again until it is confirmed
        reset.exception()
        is_free = not self.is_stopped() or not list(self.state.iterdir())
        if is_free:
            self.stop()
        return is_free

    def run_trials(self, mode, slave):
        import grpc
        dice = random.Random(mode)
        options = [("grpc.enable_http_proxy", 0), ("grpc.initial_reconnect_backoff_ms", 50)]
        self.stop()
        with StalledLink(slave.address) as link, grpc.insecure_channel(link.address, options=options) as channel:
            stub = type(self.direct)(channel)
            trials = TRIALS // len(MODES)
            free = sum(self.trial(mode, link, stub, dice) for _ in range(trials))
        print(f"{mode}: free after a later stop in {free} of {trials} trials", flush=True)
        self.assertEqual(free, 0)
        self.reset(self.status().stops)
        self.assertFalse(self.is_stopped())

    def test_raw_calls(self):
        slave = self.serve()
        for mode in MODES[:-1]:
            with self.subTest(mode):
                self.run_trials(mode, slave)

    def test_raw_calls_while_the_disk_is_slow(self):
        self.run_trials("slow disk", self.serve("/usr/bin/env", f"LD_PRELOAD={BIN / 'slow_disk.so'}"))

    def test_the_slave_answers_while_the_disk_takes_the_record_of_a_stop(self):
        self.serve("/usr/bin/env", f"LD_PRELOAD={BIN / 'slow_disk.so'}", "SLOW_DISK_MS=1000")
        stops = [self.direct.Stop.future(self.messages.StopRequest(reason="a test"), timeout=ANSWER) for _ in range(4)]
        answers = []
        while not any(stop.done() for stop in stops):
            answers.append(self.is_stopped())
        for stop in stops:
            stop.result()
        self.assertGreater(len(answers), 5, "each took as long as the disk")
        self.assertTrue(all(answers[1:]), "the tool stops at once")

    def test_keys_of_a_master_on_a_terminal(self):
        dice = random.Random(8)
        slave = self.serve()
        link = self.enter(StalledLink(slave.address))
        keys, terminal = pty.openpty()
        self.addCleanup(os.close, keys)
        with open(self.out / "output", "w") as printed:
            master = subprocess.Popen([MASTER, "connect", link.address, "--duration", "3600"], stdin=terminal, stdout=printed,
                                      stderr=subprocess.STDOUT, env=BARE)
        os.close(terminal)
        self.addCleanup(master.wait, PATIENCE)
        self.addCleanup(master.terminate)
        free = 0
        for _ in range(MASTER_TRIALS):
            self.assertTrue(wait_until(lambda: self.status().operator_name and not self.is_stopped()))
            os.write(keys, b"\n")
            self.assertTrue(wait_until(self.is_stopped))
            time.sleep(0.5)
            link.stall()
            os.write(keys, b"r\n")
            time.sleep(dice.uniform(0.1, 0.5))
            os.write(keys, b"\n")
            time.sleep(0.1)
            link.release()
            time.sleep(1)
            is_stopped = wait_until(self.is_stopped, patience=10)  # it may have been released for a moment
            time.sleep(0.5)
            if not is_stopped or not self.is_stopped():
                free += 1
                continue
            os.write(keys, b"r\n")
            self.assertTrue(wait_until(lambda: not self.is_stopped()), "the operator goes on")
        print(f"keys of the master: free after a later stop in {free} of {MASTER_TRIALS} trials", flush=True)
        self.assertEqual(free, 0)
        self.assertNotIn("no terminal", (self.out / "output").read_text())

    def sequences(self, number, slave, count, wrong):
        site = Site(slave, self)
        try:
            if not wait_until(lambda: all(station.state() for station in site.stations), patience=30):
                wrong.append("a station says nothing")
            dice = random.Random(number)
            for _ in range(count):
                wrong += site.sequence(dice)
        except Exception as error:
            wrong.append(repr(error))
        finally:
            site.close()

    def test_what_stations_say_while_they_stop_and_reset_at_random(self):
        camera = LiveCamera(first_image(self.out / "images"))
        self.addCleanup(camera.close)
        slaves = [self.serve() for _ in range(AT_ONCE - 1)]
        slaves.append(self.enter(SetupSlave(self.out / "set-up", camera, self.out / "bin")))
        wrong = []
        threads = [threading.Thread(target=self.sequences, args=(number, slave, SEQUENCES // AT_ONCE, wrong))
                   for number, slave in enumerate(slaves)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        print(f"{SEQUENCES // AT_ONCE * AT_ONCE} sequences, {len(wrong)} wrong", flush=True)
        self.assertEqual(wrong, [])

    def test_a_master_without_a_terminal_names_the_signals(self):
        slave = self.serve()
        with open(self.out / "output", "w") as printed:
            operate(slave.address, "--duration", 1, stdout=printed).wait(PATIENCE)
        self.assertIn("the input is no terminal: Enter and r do nothing; SIGUSR1 stops the tool, SIGUSR2 resets the stop",
                      (self.out / "output").read_text())


if __name__ == "__main__":
    unittest.main(verbosity=2)
