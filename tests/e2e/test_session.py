"""Slave and master together, as in the demo."""
import fcntl
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import termios
import time
import unittest
from concurrent import futures

import grpc
from delayed_link import DelayedLink
from programs import BARE, BLOCK, MASTER, PATIENCE, ROOT, SLAVE, FolderTest, Slave, deep, free_port, read_json, read_rows, run, wait_until
from tick_log import followed, press_until, whole_presses

REPORT_KEYS = {"duration_s", "ticks", "missed", "rate_hz", "wake_us", "compute_us", "rtt_us", "states",
               "reconnects", "force_peak_N", "force_sent_peak_N", "force_error", "energy_min_J", "clamped_ticks",
               "stale_ticks", "state", "render"}
LOG_START = ["t", "state", "p_M_x", "p_M_y", "p_M_z", "p_S_x", "p_S_y", "p_S_z"]


def address_beyond_loopback():
    """Returns an address of this machine other than loopback; None: there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_way:
        try:
            any_way.connect(("192.0.2.1", 9))  # sends nothing
            return any_way.getsockname()[0]
        except OSError:
            return None


class Session(FolderTest):
    def connect(self, address, *arguments, seconds="5"):
        report = self.out / "report.json"
        done = run(MASTER, "connect", address, "--duration", seconds, "--report", report,
                   "--log", self.out / "log.csv", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return read_json(report), done

    def operator(self, slave, *arguments):
        master = subprocess.Popen([MASTER, "connect", slave.address, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, env=BARE)
        self.addCleanup(master.kill)
        return master

    def read_until(self, word, master):
        while word not in (line := master.stdout.readline()):
            self.assertTrue(line, f"the operator never printed {word}")

    def test_datagrams_do_not_wait_for_a_slow_stream(self):
        # The link delays the stream by 100 ms each way. Datagrams bypass it.
        with Slave() as slave, DelayedLink(slave.address, 0.1) as line:
            report, printed = press_until(lambda rows: followed(rows) > 1500, line.address, self.out, "--datagrams")
        self.assertGreater(report["states_by_datagram"], 0.9 * report["states"], printed)
        self.assertLess(report["state_delay_us"]["p50"], 50e3)
        self.assertEqual(report["trouble"], [])
        self.assertGreater(report["force_sent_peak_N"], 0)

    def test_datagrams_go_beyond_this_machine_by_themselves(self):
        address = address_beyond_loopback()
        if address is None:
            self.skipTest("no address here but loopback's")
        with Slave(command=[SLAVE, "serve", BLOCK, "--listen", f"{address}:0", "--insecure"]) as slave:
            tried, _ = self.connect(slave.address, "--insecure", seconds="2")
            left, _ = self.connect(slave.address, "--insecure", "--no-datagrams", seconds="2")
        self.assertGreater(tried["states_by_datagram"], 0)
        self.assertEqual(left["states_by_datagram"], 0)

    def test_a_scripted_hand_feels_the_block(self):
        # A 5 mm press of the 88 mm block takes 2.37 N (closed-form independent reference b); the hand may stop short or
        # overshoot a little. On a busy machine delayed states make it press deeper; then it presses again.
        with Slave() as slave:
            report, printed = press_until(lambda rows: any(1.5 < peak < 3.0 for peak in whole_presses(rows)), slave.address, self.out)
            self.assertEqual(slave.stop(), 0, "SIGTERM is a clean end")
        self.assertLessEqual(REPORT_KEYS, report.keys())
        self.assertGreater(report["states"], 100)
        self.assertEqual(report["render"], "local")
        error = report["force_error"]
        self.assertGreater(error["contact_ticks"], 500)
        print(f"force error {error['rms_N'] / report['force_peak_N']:.1%} of {report['force_peak_N']:.3f} N")
        # Every elapsed millisecond is either a tick or a missed tick.
        self.assertAlmostEqual((report["ticks"] + report["missed"]) / report["duration_s"], 1000, delta=1)
        rows = read_rows(self.out / "log.csv")
        self.assertEqual(list(rows[0])[: len(LOG_START)], LOG_START)
        self.assertGreater(len(rows), 0.9 * report["ticks"])
        self.assertIn("N", printed, "a person sees forces with their unit")

    @deep
    def test_every_rendering_mode_runs(self):
        with Slave() as slave:
            for mode in ("hold", "interpolate"):
                report, _ = press_until(lambda rows: max(whole_presses(rows), default=0) > 0.5, slave.address, self.out, "--render", mode)
                self.assertEqual(report["render"], mode)

    def test_a_recording_drives_the_master(self):
        motion = self.out / "motion.csv"
        with open(motion, "w") as out:
            out.write("time_s,x,y,z,note\n")
            for i in range(300):  # 8 mm down within 2 s, then rest
                out.write(f"{i * 0.01},0,{-0.008 * min(1, i / 200)},0,ignored\n")
        with Slave() as slave:  # a busy machine may hold the tool while the playback continues
            self.assertTrue(any(self.connect(slave.address, "--device", f"playback:{motion}")[0]["force_peak_N"] > 0.2 for _ in range(5)))

    def test_a_second_operator_is_refused_with_the_holder_of_the_lease(self):
        with Slave() as slave:
            first = self.operator(slave, "--duration", "20", "--name", "first-hand")
            try:
                self.read_until("FOLLOWING", first)
                second = run(MASTER, "connect", slave.address, "--duration", "3")
                self.assertIn("first-hand", second.stdout + second.stderr)
            finally:
                first.send_signal(signal.SIGINT)
                self.assertIsNotNone(first.communicate(timeout=PATIENCE))
            self.assertEqual(first.returncode, 0, "SIGINT is a clean end")

    def test_an_administrator_evicts_the_operator(self):
        with Slave() as slave:
            evict = (MASTER, "evict", slave.address, "--reason", "maintenance")
            nobody = run(*evict)
            self.assertEqual((nobody.returncode, nobody.stdout), (1, ""))
            self.assertIn("there is no operator", nobody.stderr)
            evicted = self.operator(slave, "--name", "Ada")
            self.assertTrue(wait_until(lambda: run(*evict).returncode == 0))
            self.read_until("evicted", evicted)
            report_of_next, _ = self.connect(slave.address, "--name", "Bob", seconds="2")
            self.assertGreater(report_of_next["states"], 0)
            evicted.send_signal(signal.SIGINT)
            evicted.communicate(timeout=PATIENCE)

    def test_an_operator_that_vanishes_frees_the_lease(self):
        with Slave() as slave:
            first = self.operator(slave, "--duration", "30")
            self.read_until("FOLLOWING", first)
            first.kill()
            first.communicate()
            press_until(lambda rows: max(whole_presses(rows), default=0) > 0.5, slave.address, self.out)

    def test_a_master_that_starts_first_waits_for_its_slave(self):
        address = f"127.0.0.1:{free_port()}"
        with subprocess.Popen([MASTER, "connect", address, "--wait", str(PATIENCE), "--duration", "1"], env=BARE,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as first:
            # The master has found no slave: its channel waits, and a later slave must end this.
            self.assertTrue(wait_until(lambda: len(os.listdir(f"/proc/{first.pid}/task")) > 2))
            time.sleep(0.5)
            with Slave(command=[SLAVE, "serve", BLOCK, "--listen", address, "--override", "model.elements=60"]):
                printed, _ = first.communicate(timeout=2 * PATIENCE)
        self.assertEqual(first.returncode, 0, printed)

    def test_nobody_there_is_reported(self):
        done = run(MASTER, "connect", "127.0.0.1:9", "--wait", "1", "--duration", "1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("127.0.0.1:9", done.stderr)


class Unit(unittest.TestCase):
    def test_the_systemd_unit_runs_headless_and_stops_on_sigterm(self):
        unit = (ROOT / "deploy/palpate-slave.service").read_text()
        command = next(line for line in unit.splitlines() if line.startswith("ExecStart="))[len("ExecStart="):]
        values = {"/usr/bin/palpate-slave": SLAVE, "${SCENE}": BLOCK, "${LISTEN}": "127.0.0.1:0"}
        with Slave(command=[values.get(word, word) for word in command.split() if word != "$OPTIONS"]) as slave:
            self.assertEqual(slave.stop(signal.SIGTERM), 0)

    def test_the_systemd_unit_is_hardened(self):
        tool = shutil.which("systemd-analyze")
        if not tool:
            self.skipTest("no systemd-analyze")
        done = run(tool, "security", "--offline=true", "--threshold=30", ROOT / "deploy/palpate-slave.service")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_port_in_use_is_an_error(self):
        with Slave() as slave:
            done = run(SLAVE, "serve", BLOCK, "--listen", slave.address)
            self.assertEqual(done.returncode, 1)
            self.assertIn(slave.address.rsplit(":", 1)[1], done.stderr)

    def test_health_answers_for_supervisors(self):
        with Slave() as slave:
            self.assertTrue(wait_until(lambda: run(SLAVE, "health", slave.address).returncode == 0))  # after the first sample
            self.assertEqual(run(SLAVE, "health", slave.address).stdout, "SERVING\n")
            slave.stop()
        done = run(SLAVE, "health", slave.address, "--wait", "0.5")
        self.assertEqual(done.returncode, 1)
        self.assertIn(slave.address, done.stderr)
        self.assertEqual(run(SLAVE, "health", "nowhere").returncode, 2)

    def test_health_tells_a_slave_that_senses_nothing(self):
        def check(request, _):
            return b"\x08\x02" if request == b"\x0a\x18palpate.v1.Teleoperation" else b"\x08\x01"  # NOT_SERVING; SERVING

        server = grpc.server(futures.ThreadPoolExecutor(1))
        handler = grpc.unary_unary_rpc_method_handler(check)
        server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler("grpc.health.v1.Health", {"Check": handler}),))
        address = f"127.0.0.1:{server.add_insecure_port('127.0.0.1:0')}"
        server.start()
        done = run(SLAVE, "health", address)
        server.stop(None)
        self.assertEqual((done.returncode, done.stdout), (1, "NOT_SERVING\n"))

    def test_the_demo_names_what_it_accepts(self):
        for words in (["--duration", "long"], ["--scene", "none"], ["--what"], ["--out"]):
            done = run(SLAVE, "demo", *words)
            self.assertEqual(done.returncode, 2, words)
            self.assertIn(words[0], done.stderr)

    def test_an_address_that_is_not_loopback_needs_a_word(self):
        for done in (run(SLAVE, "serve", BLOCK, "--listen", "0.0.0.0:0"), run(MASTER, "connect", "192.0.2.1:50051")):
            self.assertEqual(done.returncode, 2)
            self.assertIn("--insecure", done.stderr)

    def test_an_address_that_is_none_is_unusable(self):
        for done in (run(SLAVE, "serve", BLOCK, "--listen", "50051"), run(MASTER, "connect", "unix:/tmp/x")):
            self.assertEqual(done.returncode, 2)
            self.assertIn("HOST:PORT", done.stderr)


class Signals(unittest.TestCase):
    def stopped(self, *command, when):
        """Sends SIGTERM to a program as soon as `when()` is true. Returns the exit code."""
        with subprocess.Popen([str(c) for c in command], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, env=BARE) as program:
            try:
                self.assertTrue(wait_until(lambda: when(program)))
                self.assertIsNone(program.poll(), "it ended too early to be stopped")
                program.send_signal(signal.SIGTERM)
                return program.wait(timeout=PATIENCE)
            finally:
                program.kill()

    @staticmethod
    def catches_sigterm(program):
        """Returns whether the program blocks or catches SIGTERM (proc(5), status). All signals blocked does not count:
        this is so while a thread is created."""
        status = pathlib.Path(f"/proc/{program.pid}/status").read_text()
        masks = [int(line.split()[1], 16) for line in status.splitlines() if line.startswith(("SigBlk", "SigCgt"))]
        has = lambda mask, number: mask >> (number - 1) & 1
        return any(has(mask, signal.SIGTERM) and not has(mask, signal.SIGWINCH) for mask in masks)

    def test_a_master_that_still_connects(self):
        self.assertEqual(self.stopped(MASTER, "connect", "127.0.0.1:9", "--wait", "3600", when=self.catches_sigterm), 0)

    def test_a_slave_that_still_computes_its_model(self):
        self.assertEqual(self.stopped(SLAVE, "serve", BLOCK, "--listen", "127.0.0.1:0", "--override",
                                      "model.elements=4000", when=self.catches_sigterm), 0)

    def hung_up(self, address, begun):
        """Starts a master on a terminal that is closed while it operates. Returns it and its threads before."""
        ours, its = os.openpty()

        def own_it():
            os.setsid()
            fcntl.ioctl(its, termios.TIOCSCTTY, 0)
            begun()

        master = subprocess.Popen([MASTER, "connect", address], stdin=its, stdout=its, stderr=its, env=BARE, preexec_fn=own_it)
        self.addCleanup(master.kill)
        os.close(its)
        printed = b""
        while b"FOLLOWING" not in printed:
            printed += os.read(ours, 4096)
        threads = set(os.listdir(f"/proc/{master.pid}/task"))
        os.close(ours)
        return master, threads

    def test_a_terminal_that_goes_away_ends_the_master_as_it_should(self):
        with Slave(BLOCK, "--override", "model.elements=60") as slave:
            master, _ = self.hung_up(slave.address, lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
            self.assertEqual(master.wait(timeout=PATIENCE), 0)

    def test_where_that_is_to_be_nothing_it_goes_on_without_keys(self):
        """With SIGHUP ignored, as by nohup, the master continues. A closed terminal is always readable, so its reader
        must end."""
        with Slave(BLOCK, "--override", "model.elements=60") as slave:
            master, threads = self.hung_up(slave.address, lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
            # The thread that read the keys has ended. The number of threads may be the same, because gRPC starts
            # threads at any time.
            self.assertTrue(wait_until(lambda: threads - set(os.listdir(f"/proc/{master.pid}/task"))))
            self.assertIsNone(master.poll())
            master.send_signal(signal.SIGTERM)
            self.assertEqual(master.wait(timeout=PATIENCE), 0)

    def test_an_offline_run_leaves_readable_files(self):
        with tempfile.TemporaryDirectory() as folder:
            states = pathlib.Path(folder, "states.csv")
            code = self.stopped(SLAVE, "process", BLOCK, "--out", folder, "--frames",
                                when=lambda _: states.exists() and states.read_text().count("\n") > 3)
            self.assertEqual(code, 0)
            self.assertEqual(read_json(f"{folder}/summary.json")["frames"], len(read_rows(states)))


if __name__ == "__main__":
    unittest.main(verbosity=2)
