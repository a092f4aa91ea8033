"""Symbolic links in place of temporary files of the programs: their targets are not changed, and the results are
written."""
import itertools
import pathlib
import signal
import tempfile
import unittest

from programs import BARE, BIN, BLOCK, MASTER, ROOT, SIMULATOR, SLAVE, Slave, png, run, wait_until

ENDINGS = (".part", ".new", ".tmp", ".partial", "~")
TARGET = b"of another user\n"


class PlantedLinks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"
        self.out.mkdir()
        self.target = self.folder / "target"
        self.target.write_bytes(TARGET)
        self.planted = []

    def plant(self, *results, endings=ENDINGS):
        """Creates a link at every predictable name of a temporary file of `results`."""
        for result, ending in itertools.product(results, endings):
            self.planted.append(self.out / (result + ending))
            self.planted[-1].symlink_to(self.target)

    def check(self, *results):
        self.assertEqual(self.target.read_bytes(), TARGET)
        for link in self.planted:
            self.assertTrue(link.is_symlink(), f"{link.name} is left alone")
        for result in results:
            self.assertGreater((self.out / result).stat().st_size, 0, result)
            self.assertFalse((self.out / result).is_symlink(), result)
        left = set(self.out.rglob("palpate-*.part")) - set(self.planted)
        self.assertFalse(left, "no temporary file stays")

    def finish(self, *command, **options):
        done = run(*command, **options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def test_the_master(self):
        results = ["log.csv", "slave.mcap"]
        self.plant("report.json", *results)
        report = self.out / "report.json"
        report.symlink_to(self.out / "chosen.json")
        (self.out / "chosen.json").write_text("old")
        with Slave() as slave:
            self.finish(MASTER, "connect", slave.address, "--duration", "3", "--report", report, "--log",
                        self.out / "log.csv", "--record", self.out / "slave.mcap")
        self.check("chosen.json", *results)
        self.assertTrue(report.is_symlink(), "a link that the user chose stays")
        self.assertIn("duration_s", report.read_text())

    def test_the_emergency_stop_of_a_slave(self):
        state, stop = self.out, self.out / "emergency-stop"
        arguments = "--state-dir", state, "--record", self.out / "slave.mcap"
        self.plant("emergency-stop", "slave.mcap")
        with Slave(BLOCK, *arguments) as slave:
            stop.symlink_to(self.target)
            slave.process.send_signal(signal.SIGUSR1)
            self.assertTrue(wait_until(lambda: not stop.is_symlink()))
            self.assertEqual(slave.stop(), 0)
        self.check("emergency-stop", "slave.mcap")
        self.assertIn("SIGUSR1", stop.read_text())
        for target in self.target, self.folder / "nowhere":
            stop.unlink()
            stop.symlink_to(target)
            done = run(SLAVE, "serve", BLOCK, "--listen", "127.0.0.1:0", "--state-dir", state)
            self.assertEqual(done.returncode, 1, "whether a stop is kept is not known")
            self.assertIn("expected a regular file that keeps an emergency stop", done.stderr)
        self.check()
        self.assertFalse((self.folder / "nowhere").exists())

    def test_the_offline_commands_of_a_slave(self):
        results = "study.csv", "study.json", "answers.csv", "field.vtu", "start00001.csv"
        self.plant(*results)
        contacts = self.folder / "contacts.csv"
        contacts.write_text("case,x,y,dx,dy\n1,0.044,0.088,0,-0.002\n")
        self.finish(SLAVE, "study", BLOCK, "--out", self.out, "--budget", "1")
        self.finish(SLAVE, "solve", BLOCK, "--contacts", contacts, "--out", self.out / "answers.csv", "--field",
                    self.out / "field.vtu")
        self.finish(SIMULATOR, "presses", "--presses", "5", "--out", self.out)
        self.check(*results)

    def test_the_image_that_shows_what_was_found(self):
        rows = (bytes(40 if 60 < x < 260 and 100 < y < 140 else 200 for x in range(320)) for y in range(240))
        (self.folder / "bar.png").write_bytes(png(320, 240, 8, rows))
        scene = self.folder / "scene.yaml"
        scene.write_text("name: bar\n"
                         "object:\n"
                         "  geometry: {contour: from-image, thickness: 9 mm}\n"
                         "  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}\n"
                         "  fixed: {arc: {centre: 180 deg, half_angle: 20 deg}}\n"
                         "tool: {shape: flat, width: 5.9 mm, depth: whole}\n"
                         "sense:\n"
                         "  camera: {file: bar.png, rate: 60 Hz, pixel: 0.35 mm}\n"
                         "  tip: {track: template, template: bar.png, anchor: [20 px, 20 px]}\n"
                         "  contour: {track: snake, control_points: 60}\n"
                         "model: {kind: bem2d, elements: 60}\n")
        self.plant("palpate-contour.png")
        (self.out / "palpate-contour.png").symlink_to(self.target)
        done = run(SLAVE, "process", scene, "--out", self.folder / "run", env={**BARE, "TMPDIR": str(self.out)})
        self.assertIn(f"drawn in {self.out}/palpate-contour.png", done.stderr)
        self.check("palpate-contour.png")

    def test_a_calibration(self):
        tips = self.folder / "tips.csv"
        tips.write_text("x,y,z,u,v\n" + "".join(f"{i / 1e3},{j / 1e3},0,{100 + 50 * i},{300 - 50 * j}\n"
                                                for i in range(4) for j in range(4)))
        self.plant("pose.yaml")
        pose = self.out / "pose.yaml"
        pose.symlink_to(self.out / "chosen.yaml")
        self.finish(SLAVE, "calibrate", "--register", tips, "--size", "640x480", "--out", pose)
        self.check("chosen.yaml")
        self.assertTrue(pose.is_symlink(), "a link that the user chose stays")

    def test_certificates(self):
        results = "key.pem", "cert.pem", "ca.pem"
        self.plant(*results, "request", "key", "cert", endings=("", *ENDINGS))
        certs, ca = ROOT / "deploy/certs", self.folder / "ca"
        for result in results:
            self.planted.remove(self.out / result)  # a link at the result's own name is replaced, not followed
        self.finish(certs, "ca", ca)
        self.finish(certs, "slave", ca, self.out, "block", "localhost")
        self.check(*results)


if __name__ == "__main__":
    unittest.main(verbosity=2)
