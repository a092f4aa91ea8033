"""Each kind of sensing from its scene to a rendered force, once, and short enough for programs with sanitizers."""
import math
import unittest

from programs import MASTER, ROOT, SLAVE, FolderTest, Slave, overrides, read_json, read_rows, run

SCENES = ROOT / "deploy/scenes"


class EverySense(FolderTest):
    """Other tests judge the force. These only require that all programs run and end without error."""

    def process(self, scene, *settings):
        done = run(SLAVE, "process", SCENES / scene, "--out", self.out, *overrides(*settings))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = read_rows(self.out / "states.csv")
        forces = [math.hypot(*(float(row[axis]) for axis in ("fx", "fy", "fz"))) for row in rows if row["fx"]]
        self.assertGreater(max(forces), 0.01)
        self.assertTrue(all(map(math.isfinite, forces)))

    def serve(self, scene, *settings):
        with Slave(SCENES / scene, *overrides(*settings)) as slave:
            done = run(MASTER, "connect", slave.address, "--duration", "3", "--report", self.out / "report.json")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(slave.stop(), 0, slave.log)
        self.assertGreater(read_json(self.out / "report.json")["states"], 10)

    def test_a_camera(self):
        settings = "silicone-block.yaml", "model.elements=60", "operator.press.depth=2 mm"
        self.process(*settings)
        self.serve(*settings)

    def test_points(self):
        settings = "rubber-membrane.yaml", "operator.press.depth=0.5 mm"
        self.process(*settings)
        self.serve(*settings)

    def test_fingertips(self):
        settings = "foam-cube.yaml", "operator.press.depth=2 mm"
        self.process(*settings)
        self.serve(*settings)

    def test_nothing_moves_a_real_tool_that_nobody_asked_for(self):
        real = overrides("model.elements=60", "sense.camera.source=stream", "manipulator.source=stream")
        with Slave(SCENES / "silicone-block.yaml", *real, simulates=False) as slave:
            done = run(MASTER, "connect", slave.address, "--duration", "1", "--log", self.out / "log.csv")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("this master observes", done.stdout)
        self.assertEqual({row["state"] for row in read_rows(self.out / "log.csv")}, {"DISCONNECTED"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
