"""`verify` with a running slave: with a force sensor, and with answers typed by a person."""
import signal
import subprocess
import time
import unittest

from programs import BARE, BLOCK, MASTER, PATIENCE, SLAVE, FolderTest, Slave, operate, read_json, read_rows, run


class Verify(FolderTest):
    def setUp(self):
        super().setUp()
        self.folder, self.out = self.out, self.out / "card"

    def test_a_correct_slave_that_is_operated_passes_against_its_sensor(self):
        """The simulator's true force replaces that of a sensor, since both are sent as the true force. Each line is
        judged by an interval of 95 %, so a correct slave fails now and then, but not three times in a row."""
        with Slave(BLOCK) as slave:
            for _ in range(3):
                master = operate(slave.address, "--duration", "7")
                done = run(SLAVE, "verify", BLOCK, "--connect", slave.address, "--sensor", "--duration", "6", "--out", self.out)
                self.assertEqual(master.wait(timeout=PATIENCE), 0)
                if done.returncode == 0:
                    break
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(read_json(self.out / "report.json")["cards"][0]["lines"]["magnitude"]["verdict"], "right")

    def test_answers_become_a_table_that_gives_the_same_card(self):
        """Nothing touches the tool, so the slave does not estimate the force that is entered as known."""
        answers = "none\nweight 100\nforce 0 1 0\nweight 100 g +y\nspring 200 N/m 5 mm +y\ndone\n"
        with Slave(BLOCK) as slave:
            asked = subprocess.run([SLAVE, "verify", BLOCK, "--connect", slave.address, "--hold", "0.5", "--out", self.out],
                                   input=answers, capture_output=True, text=True, env=BARE, timeout=PATIENCE)
        self.assertEqual(asked.returncode, 1, asked.stdout + asked.stderr)
        self.assertIn("expected a mass in g or kg", asked.stdout)
        first = read_json(self.out / "report.json")
        self.assertIn("zero under every load", first["cards"][0]["lines"]["magnitude"]["remark"])
        self.assertEqual(self.holds(), {"0", "1", "2", "3"})
        again = self.folder / "again"
        done = run(SLAVE, "verify", BLOCK, "--forces", self.out / "forces.csv", "--out", again)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertEqual(read_json(again / "report.json")["cards"], first["cards"])

    def holds(self):
        return {row["hold"] for row in read_rows(self.out / "forces.csv")}

    def test_answers_survive_a_hiccup_a_slave_that_is_silent_and_an_interrupt(self):
        with Slave(BLOCK) as slave, \
                subprocess.Popen([SLAVE, "verify", BLOCK, "--connect", slave.address, "--hold", "0.5", "--out", self.out],
                                 stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=BARE) as asked:
            def answer(line, until, stopped=None):
                asked.stdin.write(line + "\n")
                asked.stdin.flush()
                if stopped is not None:
                    time.sleep(stopped)
                    slave.process.send_signal(signal.SIGCONT)
                printed = ""
                while until not in printed:
                    character = asked.stdout.read(1)
                    self.assertTrue(character, printed)
                    printed += character

            answer("none", "states with a force")
            slave.process.send_signal(signal.SIGSTOP)
            answer("force 0 1 0", "states with a force", stopped=1.0)  # longer than the load is observed
            self.assertEqual(self.holds(), {"0", "1"})
            slave.process.send_signal(signal.SIGSTOP)
            try:
                answer("force 0 2 0", "try again")
            finally:
                slave.process.send_signal(signal.SIGCONT)
            self.assertEqual(self.holds(), {"0", "1"})
            answer("", "load 3> ")
            answer("force 0 2 0", "load 4> ")
            asked.send_signal(signal.SIGINT)
            asked.wait(timeout=PATIENCE)
        self.assertEqual(self.holds(), {"0", "1", "2"})

    def test_a_recording_is_compared_with_a_table(self):
        """The recording's own forces, enlarged by a quarter, serve as known ones, so the report must state a factor of
        0.8."""
        recording, loads = self.folder / "slave.mcap", self.folder / "loads.csv"
        with Slave(BLOCK, "--record", recording) as slave:
            master = run(MASTER, "connect", slave.address, "--duration", "4")
            self.assertEqual(master.returncode, 0, master.stderr)
        self.assertEqual(run(SLAVE, "process", recording, "--out", self.folder / "states").returncode, 0)
        rows = [f"{row['t']},{float(row['fx']) / 0.8},{float(row['fy']) / 0.8},0\n"
                for row in read_rows(self.folder / "states/states.csv") if row["fy"]]
        loads.write_text("t,fx,fy,fz\n" + "".join(rows))
        done = run(SLAVE, "verify", recording, "--loads", loads, "--out", self.out)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        magnitude = read_json(self.out / "report.json")["cards"][0]["lines"]["magnitude"]
        self.assertEqual(magnitude["verdict"], "wrong")
        self.assertAlmostEqual(magnitude["low_value_high"][1], 0.8, delta=1e-3)

    def test_no_slave_is_reported(self):
        done = run(SLAVE, "verify", BLOCK, "--connect", "127.0.0.1:9", "--sensor", "--duration", "1", "--out", self.out)
        self.assertEqual(done.returncode, 1)
        self.assertIn("127.0.0.1:9: no state from a slave", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
