"""Simulated devices outside of the slave: images by URL, GStreamer pipeline, camera and FeedImages, fingertips by
FeedTactile, the tool by DriveTool. The force must be as accurate as with devices simulated inside, within 1 % of the
peak.

usage: test_plug_paths.py [NAME...]   of silicone-block, rubber-membrane, foam-cube

Prints a table with the force error of the same slow press by each path: rms relative to the peak, against the true
force at the delay for which they agree best, and that delay, which is the latency of the path.
"""
import re
import shutil
import subprocess
import sys
import unittest

from force_error import force_error
from plugs import EXAMPLES, Plugged
from programs import BIN, ROOT, SLAVE, FolderTest, Slave, overrides, read_rows, run

SCENES = ROOT / "deploy/scenes"
SECONDS = 16
SLOW = ["--override", "operator.press.speed=4 mm/s"]
# The Python driver may be delayed on a busy machine.
PLUGGED = ["manipulator.source=stream", "manipulator.silence=100 ms"]
MAX_DIFFERENCE = 0.01  # between the errors by two paths, relative to the peak
MIN_TICKS = 2000  # ticks in contact whose force is known
NAMES = [name for name in sys.argv[1:] if not name.startswith("-")] or ["silicone-block", "rubber-membrane", "foam-cube"]
PIPELINE = ("tcpclientsrc host=127.0.0.1 port={port} ! rawvideoparse width={width} height=480 format=gray8 framerate=60/1 "
            "! appsink max-buffers=1 drop=true sync=false")


class Paths(Plugged):
    def setUp(self):  # each path starts its own slave
        FolderTest.setUp(self)

    def press(self, name, environment=(), command=SLAVE, **how):
        """Starts a slave with simulated devices, or with external ones by `overrides`. Returns force_error of a
        session."""
        settings = how.get("overrides", ())
        whole = ["/usr/bin/env", *environment, str(command), "serve", str(SCENES / f"{name}.yaml"), "--listen", "127.0.0.1:0",
                 *SLOW, *overrides(*settings)]
        with Slave(command=whole) as self.slave:
            self.stub = self.connect()
            processes = [start() for start in how.get("beside", ())]
            try:
                self.assertTrue(self.ready(), (name, settings, self.status()))
                self.report(self.operate(SECONDS))
                return force_error(self.out / "log.csv")
            finally:
                for process in processes:
                    self.end(process)

    def home(self):
        first = next(row for row in read_rows(self.out / "log.csv") if row["state"] == "FOLLOWING")
        return ",".join(first[f"p_S_{axis}"] for axis in "xyz")

    def site(self, name, to):
        """Starts the external simulation of the scene. Returns its process and the port of its images; `self.tool` is
        the address for the tool's position."""
        player = self.start(BIN / "site_player", SCENES / f"{name}.yaml", to, stdout=subprocess.PIPE)
        printed = iter(player.stdout.readline, "")  # includes progress lines of the precomputation
        self.tool = next(filter(None, (re.fullmatch(r"site on (\S+)\n", line) for line in printed))).group(1)
        port = re.fullmatch(r"images on \S+:(\d+)\n", next(printed)).group(1) if ":" not in to else None
        return player, port

    def arm(self, home):
        return self.start("/usr/bin/python3", EXAMPLES / "drive_arm.py", self.slave.address, "--home", home,
                          "--site", self.tool, "--rate", "500", stdout=subprocess.DEVNULL)

    def plugged(self, name, home, source, to, **options):
        """Presses with images by the settings that `source(port)` returns for the port of the images."""
        player, port = self.site(name, to)
        environment, settings = source(port)
        try:
            return self.press(name, environment, overrides=[*PLUGGED, *settings],
                              beside=[lambda: self.arm(home)], **options)
        finally:
            self.end(player)

    def fed(self, name, home, settings):
        def feeder():
            player, _ = self.site(name, self.slave.address)
            return player
        return self.press(name, overrides=[*PLUGGED, *settings], beside=[feeder, lambda: self.arm(home)])

    def fake_camera(self):
        """Returns a copy of the slave beside a camera module that is a fake, which `device` opens."""
        folder = self.out / "fake"
        folder.mkdir()
        shutil.copy(BIN / "palpate-slave", folder)
        shutil.copy(BIN / "fake_cameras.so", folder / "palpate-cameras.so")
        return folder / "palpate-slave"

    def table(self, name, paths):
        errors = {"in-process": self.press(name)}
        home = self.home()
        errors.update((path, play(home)) for path, play in paths.items())
        print(f"{name}: " + " | ".join(f"{path} {100 * error:.2f} % after {delay} ms" for path, (error, delay, _) in errors.items()),
              flush=True)
        for path, (error, _, ticks) in errors.items():
            self.assertGreater(ticks, MIN_TICKS, path)
            self.assertLess(error, errors["in-process"][0] + MAX_DIFFERENCE, path)

    def wanted(self, name):
        if name not in NAMES:
            self.skipTest("not asked for")
        return name

    def test_block(self):
        name = self.wanted("silicone-block")
        one = "sense.camera={{{}, rate: 60 Hz, size: [640, 480], pixel: 0.35 mm, pose: {{translation: [44 mm, 54 mm, 0]}}}}"

        def url(port):
            return [], [one.format(f'url: "tcp://127.0.0.1:{port}"')]

        def pipeline(port):
            return [], [one.format(f'url: "{PIPELINE.format(port=port, width=640)}"')]

        def device(port):
            return [f"PALPATE_FAKE_CAMERA={port} 640 480"], [one.format("device: 0")]
        self.table(name, {
            "URL": lambda home: self.plugged(name, home, url, "y4m"),
            "pipeline": lambda home: self.plugged(name, home, pipeline, "raw"),
            "device": lambda home: self.plugged(name, home, device, "raw", command=self.fake_camera()),
            "FeedImages": lambda home: self.fed(name, home, ["sense.camera.source=stream"])})

    def test_membrane(self):
        name = self.wanted("rubber-membrane")
        frames = self.out / "rig"
        done = run(SLAVE, "process", SCENES / f"{name}.yaml", "--frames", "--out", frames)
        pose = re.search(r"pose: (\{.*\})\}", done.stdout).group(1)
        rig = next(frames.rglob("rig.yaml"))
        pair = f'sense.camera={{{{stereo: {{{{{{}}, rig: "{rig}"}}}}, rate: 30 Hz, pose: {pose.replace("{", "{{").replace("}", "}}")}}}}}'

        def url(port):
            return [], [pair.format(f'url: "tcp://127.0.0.1:{port}", layout: side-by-side')]

        def pipeline(port):
            return [], [pair.format(f'url: "{PIPELINE.format(port=port, width=1280)}", layout: side-by-side')]

        def device(port):
            return [f"PALPATE_FAKE_CAMERA={port} 1280 480"], [pair.format("device: 0, layout: side-by-side")]
        self.table(name, {
            "URL": lambda home: self.plugged(name, home, url, "y4m"),
            "pipeline": lambda home: self.plugged(name, home, pipeline, "raw"),
            "device": lambda home: self.plugged(name, home, device, "raw", command=self.fake_camera()),
            "FeedImages": lambda home: self.fed(name, home, [pair.format("source: stream")])})

    def test_cube(self):
        name = self.wanted("foam-cube")
        self.table(name, {"FeedTactile": lambda home: self.fed(name, home, ["sense.tactile.source=stream"])})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
