"""Slave, master or link dies, stalls or is stopped: the force on the operator ends, and motion resumes only after the
required steps."""
import pathlib
import signal
import tempfile
import unittest

from programs import BLOCK, PATIENCE, SLAVE, FolderTest, Slave, operate, read_json, wait_until
from tick_log import TICK, force, whole_rows

# By design the force is zero 80 ms after the last state. Time that the machine keeps from the loop is added.
MAX_DELAY = 0.100  # [s]


class Death(FolderTest):
    def operate(self, address, seconds):
        with open(self.out / "output", "w") as printed:
            master = operate(address, "--duration", seconds, "--report", self.out / "report.json", "--log", self.out / "log.csv",
                             stdout=printed)
        self.addCleanup(master.kill)
        return master

    def rows(self):
        return whole_rows(self.out / "log.csv")

    def pressed(self, since=0):
        return wait_until(lambda: any(force(row) > 0.3 for row in self.rows()[-200:])
                          and len(self.rows()) > since)

    def finish(self, master):
        master.wait(timeout=PATIENCE)
        self.assertEqual(master.returncode, 0)
        rows = self.rows()
        lost = [0.0] + [max(0.0, float(b["t"]) - float(a["t"]) - TICK) for a, b in zip(rows, rows[1:])]
        for k, row in enumerate(rows):
            if force(row) > 0:
                self.assertLessEqual(float(row["age_s"]), MAX_DELAY + sum(lost[max(0, k - 200):k + 1]), row)
        return read_json(self.out / "report.json")

    def again(self, address):
        """Returns a slave that will listen at the address of a former one."""
        return Slave(command=[SLAVE, "serve", BLOCK, "--listen", address])

    def test_a_killed_slave_lets_the_hand_go_and_its_successor_needs_an_engagement(self):
        with Slave() as slave:
            master = self.operate(slave.address, 600)
            self.assertTrue(self.pressed())
            slave.process.kill()
            slave.process.communicate()
        known = len(self.rows())
        with self.again(slave.address):
            self.assertTrue(self.pressed(since=known + 1000))
            master.send_signal(signal.SIGINT)
            report = self.finish(master)
        self.assertGreaterEqual(report["reconnects"], 1)
        self.assertGreaterEqual(report["epochs"], 2)
        self.assertIn("ended", report["reasons"])

    def test_another_scene_at_the_slaves_address_is_not_taken_up(self):
        with Slave(BLOCK, "--override", "model.elements=60") as slave:
            master = self.operate(slave.address, 60)
            self.assertTrue(self.pressed())
            slave.process.kill()
            slave.process.communicate()
        with Slave(command=[SLAVE, "serve", BLOCK, "--listen", slave.address, "--override", "model.elements=60",
                            "--override", "name=another"]):
            self.assertTrue(wait_until(lambda: "another scene is served" in (self.out / "output").read_text()))
            # At least a second without states is expected, unless the other slave starts sooner.
            self.assertTrue(wait_until(lambda: self.rows()[-1]["state"] == "DISCONNECTED"))
            master.terminate()
            report = self.finish(master)
        self.assertEqual(report["reconnects"], 0)
        self.assertEqual(report["state"], "DISCONNECTED")
        self.assertIn("another scene is served there now, another instead of silicone-block: restart palpate-master",
                      report["trouble"])

    def test_who_waits_takes_over_when_the_operator_leaves(self):
        with Slave() as slave:
            ada = self.operate(slave.address, 120)
            self.assertTrue(self.pressed())
            second = tempfile.TemporaryDirectory()
            self.addCleanup(second.cleanup)
            self.out, first = pathlib.Path(second.name), self.out
            bea = self.operate(slave.address, 120)
            self.assertTrue(wait_until(lambda: len(self.rows()) > 500))
            self.assertEqual({row["state"] for row in self.rows()}, {"DISCONNECTED"}, "the lease is Ada's")
            ada.send_signal(signal.SIGINT)
            ada.wait(timeout=PATIENCE)
            self.assertTrue(wait_until(lambda: any(row["state"] == "FOLLOWING" for row in self.rows()[-500:])))
            states = [row["state"] for row in self.rows()]
            self.assertIn("READY", states[:states.index("FOLLOWING")], "and only by an engagement of her own")
            bea.send_signal(signal.SIGINT)
            self.finish(bea)
            self.assertEqual(read_json(first / "report.json")["reconnects"], 0)

    def test_an_emergency_stop_of_the_operator_outlives_the_slave(self):
        state = self.out / "state"
        state.mkdir()
        with Slave(BLOCK, "--state-dir", state) as slave:
            master = self.operate(slave.address, 120)
            self.assertTrue(self.pressed())
            master.send_signal(signal.SIGUSR1)
            self.assertTrue(wait_until(lambda: self.rows() and self.rows()[-1]["state"] == "ESTOP"))
            self.assertTrue(wait_until(lambda: list(state.iterdir())), "it is kept")
            slave.process.kill()
            slave.process.communicate()
        with Slave(command=[SLAVE, "serve", BLOCK, "--listen", slave.address, "--state-dir", state]):
            known = len(self.rows())

            def is_back():  # the log is written in pieces, so its last rows may be of the old slave
                return any(0 < float(row["age_s"]) < MAX_DELAY for row in self.rows()[known + 1000:])
            self.assertTrue(wait_until(is_back))
            self.assertEqual(self.rows()[-1]["state"], "ESTOP")
            master.send_signal(signal.SIGUSR2)
            self.assertTrue(wait_until(lambda: self.rows()[-1]["state"] != "ESTOP"))
            master.send_signal(signal.SIGINT)
            self.finish(master)
        self.assertFalse(list(state.iterdir()), "the reset is kept, too")


if __name__ == "__main__":
    unittest.main(verbosity=2)
