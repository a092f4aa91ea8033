"""Every example of deploy/examples against a real slave, and what the client libraries promise beyond them.

  test_examples.py Python|Cpp|Node    needs PALPATE_BIN; Cpp and Node PALPATE_TEST_OUTPUT, Cpp PALPATE_BUILD
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from programs import BARE, BLOCK, PACKAGE, ROOT, FolderTest, Slave, make_certificates, operate, run  # noqa: E402

sys.path.insert(0, str(PACKAGE))
EXAMPLES = ROOT / "deploy/examples"
HERE = pathlib.Path(__file__).parent
CUBE = str(ROOT / "deploy/scenes/foam-cube.yaml")
ARM = ("--override", "manipulator.source=stream")
CAMERA = ("--override", "sense.camera.source=stream")
TACTILE = ("--override", "sense.tactile.source=stream")
HOME = "0.044,0.09416,0"
STILL = 1.28  # [N] force of the block at the end of the press of `operate`, which the simulator's true force confirms below


def skip(reason):
    print(f"skipped: {reason}")
    raise SystemExit(77)


class Examples(FolderTest):
    """What all languages show."""
    environment = BARE

    def run_example(self, name, *arguments, **options):
        """Output of an example that ends with exit code 0."""
        done = run(*self.command(name), *arguments, env={**self.environment, **options.pop("environment", {})})
        self.assertEqual(done.returncode, 0, f"{name}: {done.stdout}{done.stderr}")
        print(f"{type(self).__name__} {name}: {done.stdout.strip()}", flush=True)
        return done.stdout

    def number(self, pattern, text):
        found = re.search(pattern, text)
        self.assertTrue(found, text)
        return float(found.group(1))

    def check_operating(self, scene=BLOCK):
        with Slave(scene) as slave:
            watching = subprocess.Popen([*map(str, self.command("watch")), slave.address], stdout=subprocess.PIPE, text=True,
                                        env=self.environment)
            peak = self.number(r"peak force ([0-9.]+) N", self.run_example("operate", slave.address))
            watched, _ = watching.communicate(timeout=60)
            self.assertEqual(watching.returncode, 0, watched)
            self.assertIn("100 states", watched)
        self.assertAlmostEqual(peak, STILL, delta=0.02 * STILL)

    def check_tls(self, option=()):
        make_certificates(self.out, "observer")
        with Slave(BLOCK, "--tls", self.out / "slave", tls=self.out) as slave:
            self.run_example("watch", slave.address, *option, self.out / "observer")
            done = run(*self.command("operate"), slave.address, *option, self.out / "observer", env=self.environment)
            self.assertEqual(done.returncode, 1)
            self.assertIn("role", done.stderr)  # an observer may not operate

    def check_feeding(self, size, *check):
        with Slave(BLOCK, *CAMERA) as slave:
            text = self.run_example("feed_images", slave.address, *size, *check)
            self.assertIn("30 of 30 images accepted", text)
            self.assertIn("expected", text)
        with Slave(CUBE, *TACTILE) as slave:
            text = self.run_example("feed_tactile", slave.address, *check)
            self.assertRegex(text, "100 (of 100 )?samples of ff, th accepted")
            self.assertIn("expected 19", text)

    def check_driving(self, *arguments):
        with Slave(BLOCK, *ARM, simulates=False) as slave:
            text = self.run_example("drive_arm", slave.address, *arguments)
        self.assertGreater(self.number(r"(\d+) reports", text), 50)
        self.assertGreater(self.number(r"(\d+) targets", text), 50)


class Python(Examples):
    environment = {**BARE, "PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1"}

    @classmethod
    def setUpClass(cls):
        try:
            import palpate
        except ImportError as error:
            skip(error)

    def command(self, name):
        return "/usr/bin/python3", EXAMPLES / f"{name}.py"

    def test_operating(self):
        self.check_operating()

    def test_tls(self):
        self.check_tls(["--tls"])

    def test_feeding(self):
        self.check_feeding(["--size", "640x480"], "--check")

    def test_driving(self):
        self.check_driving("--duration", "1", "--home", HOME)

    def test_watching_fingers(self):
        with Slave(CUBE) as slave:
            self.assertRegex(self.run_example("watch", slave.address), r"finger 2: (in contact|free), [0-9.]+ N, VALID")

    def test_record_to_numpy(self):
        import numpy as np
        import palpate
        recording = self.out / "session.mcap"
        with Slave(BLOCK, "--record", self.out / "slave.mcap") as slave:
            master = operate(slave.address, "--duration", "4", "--record", recording)
            self.run_example("record", slave.address, self.out / "live.npz", "--seconds", "4")
            self.assertEqual(master.wait(timeout=60), 0)
            self.assertEqual(slave.stop(), 0)
        live = np.load(self.out / "live.npz")
        contact = live["true_force"][:, 1] > 0.1
        error = live["force"][contact, 1] - live["true_force"][contact, 1]
        self.assertGreater(contact.sum(), 20)
        self.assertLess(np.sqrt(np.mean(error ** 2)), 0.1 * live["true_force"][:, 1].max())
        # Reference: the arrays that are exported of the same files.
        self.run_example("record", recording, self.out / "read.npz")
        from palpate.export import export
        for file in (recording, self.out / "slave.mcap"):
            ticks, states = export(file, file.with_suffix(""))
            self.assertGreater(states, 100)
        arrays = palpate.read_recording(recording)
        np.testing.assert_array_equal(arrays.sent, np.load(self.out / "session/numpy/force.npy"))
        np.testing.assert_allclose(arrays.device, np.load(self.out / "session/numpy/p_M.npy"), rtol=0, atol=0)
        sensed = palpate.read_recording(self.out / "slave.mcap").states
        exported = np.load(self.out / "slave/numpy/force.npy")
        np.testing.assert_array_equal(sensed.force, exported)
        np.testing.assert_array_equal(sensed.tip, np.load(self.out / "slave/numpy/p_S_tip.npy"))
        self.assertGreater(len(sensed), 100)
        # A file that was cut is read up to the cut.
        cut = self.out / "cut.mcap"
        cut.write_bytes((self.out / "slave.mcap").read_bytes()[:-(self.out / "slave.mcap").stat().st_size // 2])
        part = palpate.read_recording(cut).states
        self.assertTrue(0 < len(part) < len(sensed))
        np.testing.assert_array_equal(part.force, sensed.force[:len(part)])

    def test_stiffness_map(self):
        import palpate
        with Slave(BLOCK) as slave:
            planar = self.run_example("palpation_map", slave.address, self.out / "block.svg", "--planar", "--span", "70")
            with palpate.connect(slave.address) as connected, connected.operate("test") as tool:
                tool.engage()
                tool.move_by([0, tool.state.depth - 0.003, 0], 0.01)
                held = tool.hold(0.5)
        # Reference: the simulator's true force at the same depth.
        truth = held.true_force[-1, 1] / held.depth[-1]
        self.assertIn("5 of 5 presses", planar)
        self.assertAlmostEqual(self.number(r"([0-9.]+) N/m", planar), truth, delta=0.02 * truth)
        self.assertLess(self.number(r"centre, ([0-9.]+) to", planar), 0.9)  # near its free sides a block is softer
        self.assertEqual((self.out / "block.svg").read_text().count("<rect"), 5)

    def test_ros_bridge(self):
        published = self.out / "published"
        with Slave(BLOCK) as slave:
            operating = subprocess.Popen([*map(str, self.command("operate")), slave.address], env=self.environment,
                                         stdout=subprocess.DEVNULL)
            paths = f"{PACKAGE}:{HERE / 'ros'}:{ROOT / 'deploy/ros2/palpate_bridge'}"
            done = run("/usr/bin/python3", "-m", "palpate_bridge.bridge", slave.address, "--messages", "150",
                       env={**self.environment, "PYTHONPATH": paths, "ROS_PUBLISHED": str(published)})
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(operating.wait(timeout=60), 0)
        def refuse(number):
            raise AssertionError(f"{number} is published")
        everything = [json.loads(line, parse_constant=refuse) for line in published.read_text().splitlines()]
        messages = [message for message in everything if message["topic"] == "palpate/wrench"]
        self.assertEqual(len(messages), 150)
        statuses = [message["status"][0] for message in everything if message["topic"] == "/diagnostics"]
        self.assertGreaterEqual(len(statuses), 150)
        self.assertEqual(sum(status["message"] == "valid" for status in statuses), 150)
        for status in statuses:
            values = {pair["key"]: pair["value"] for pair in status["values"]}
            self.assertEqual(status["message"] == "valid", values["validity"] == "valid")
            self.assertTrue(status["message"] != "valid" or float(values["sigma [N]"]) >= 0)
        stamps = [(message["header"]["stamp"]["sec"], message["header"]["stamp"]["nanosec"]) for message in messages]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertEqual({(m["topic"], m["header"]["frame_id"]) for m in messages}, {("palpate/wrench", "palpate_slave")})
        self.assertAlmostEqual(max(m["wrench"]["force"]["y"] for m in messages), STILL, delta=0.02 * STILL)

    def test_pip_installs_the_client_without_network(self):
        """The lines of deploy/python/README.md, in an environment that has nothing of the build."""
        environment = self.out / "venv"
        made = run("/usr/bin/python3", "-m", "venv", "--system-site-packages", environment)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        installed = run(environment / "bin/pip", "install", "--no-index", "--no-build-isolation", ROOT, env=BARE)
        self.assertEqual(installed.returncode, 0, installed.stdout + installed.stderr)
        page = (ROOT / "deploy/python/README.md").read_text()
        lines = re.search(r"-c '(import palpate\n.*?)'\n", page, re.DOTALL).group(1)
        with Slave(BLOCK) as slave:
            printed = run(environment / "bin/python", "-c", lines.replace("127.0.0.1:50051", slave.address), env=BARE)
        self.assertEqual(printed.returncode, 0, printed.stderr)
        self.assertRegex(printed.stdout, r"^\[.*\] \+- [0-9.]+ N\n")

    def test_lease_and_stop(self):
        import numpy as np
        import palpate
        with Slave(BLOCK) as server, palpate.connect(server.address) as slave:
            with slave.operate("first") as tool:
                with self.assertRaises(palpate.LeaseHeld) as held:
                    slave.operate("second")
                self.assertIn("first", held.exception.details)
                waiting = threading.Thread(target=lambda: setattr(self, "second", slave.operate("second", wait=30)))
                tool.engage()
                home = tool.position
                for tip, speed in ((home * np.nan, 0.01), (home, 0), (home, np.nan)):
                    with self.assertRaisesRegex(ValueError, "expected finite"):
                        tool.move_to(tip, speed)
                stopping = threading.Timer(0.5, slave.stop)
                stopping.start()
                with self.assertRaises(palpate.Interrupted):
                    tool.move_to(home + [0, -0.005, 0], 0.002)
                paused = tool.position
                self.assertLess(np.linalg.norm(paused - home), 0.004)  # it did not go on behind the stop
                slave.reset(slave.status())
                time.sleep(0.3)
                np.testing.assert_array_equal(tool.position, paused)  # nor after it
                tool.engage()  # moves nothing
                self.assertLess(np.linalg.norm(tool.position - paused), 5e-4)
                tool.move_to(home, 0.01)
                waiting.start()
                time.sleep(0.5)
            waiting.join(30)
            self.second.close()

    def test_a_frozen_script_holds_the_tool(self):
        import palpate
        script = "import sys, palpate\nwith palpate.connect(sys.argv[1]) as s, s.operate('frozen') as t:\n    t.move_by([0, -0.05, 0], 0.002)\n"
        with Slave(BLOCK) as server, palpate.connect(server.address) as slave:
            process = subprocess.Popen(["/usr/bin/python3", "-c", script, server.address], env=self.environment, stderr=subprocess.DEVNULL)
            states = slave.states(rate=50, seconds=30)
            next(state for state in states if state.phase == palpate.Phase.FOLLOWING)
            process.send_signal(19)  # SIGSTOP
            next(state for state in states if state.phase == palpate.Phase.HOLD)
            process.kill()
            process.wait()

    def test_bad_input_is_explained(self):
        import numpy as np
        import palpate
        with Slave(BLOCK, *CAMERA) as server, palpate.connect(server.address) as slave:
            with self.assertRaisesRegex(ValueError, "expected uint8 or uint16"):
                slave.feed_images([np.zeros((4, 4))])
            with self.assertRaisesRegex(palpate.Error, "max_rate"):
                next(slave.states(rate=0.5))
            with self.assertRaisesRegex(palpate.Error, "FAILED_PRECONDITION"):
                slave.feed_fingertips([palpate.TactileSample("ff", [0.0] * 19)])
        not_a_recording = self.out / "text.mcap"
        not_a_recording.write_text("text")
        with self.assertRaisesRegex(ValueError, "expected an MCAP file"):
            palpate.read_recording(not_a_recording)
        with self.assertRaises(palpate.Error), palpate.connect("127.0.0.1:1") as nobody:
            nobody.scene()

    def test_types(self):
        mypy = shutil.which("mypy", path=BARE["PATH"])
        if mypy is None:
            self.skipTest("no mypy (apt-get install mypy)")
        paths = {**BARE, "MYPYPATH": f"{PACKAGE}:{HERE / 'ros'}"}
        check = [mypy, "--config-file", ROOT / "deploy/python/mypy.ini", "--cache-dir", self.out / "cache"]
        for arguments in (["-p", "palpate"], *([path] for path in EXAMPLES.glob("*.py"))):
            done = run(*check, *arguments, env=paths)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        wrong = self.out / "wrong.py"
        wrong.write_text("import palpate\n\nwith palpate.connect('a') as slave:\n    slave.operate(5)\n")
        self.assertEqual(run(*check, wrong, env=paths).returncode, 1)


class Cpp(Examples):
    @classmethod
    def setUpClass(cls):
        cls.build = pathlib.Path(os.environ["PALPATE_TEST_OUTPUT"]) / "cpp-examples"
        shutil.rmtree(cls.build, ignore_errors=True)
        prefix = cls.build / "prefix"
        for command in (["cmake", "--install", os.environ["PALPATE_BUILD"], "--prefix", prefix, "--component", "dev"],
                        ["cmake", "-S", EXAMPLES, "-B", cls.build, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release",
                         "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wconversion -Wshadow -Werror"],
                        ["cmake", "--build", cls.build]):
            done = run(*command, env={"PATH": os.environ["PATH"]}, timeout=300)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)
        # Nothing of the repository but the installed headers was read.
        read = subprocess.run(["c++", "-std=c++17", "-M", f"-I{prefix}/include", EXAMPLES / "operate.cpp"], capture_output=True,
                              text=True, check=True).stdout.split()
        inside = [word for word in read if word.startswith(str(ROOT)) and not word.startswith((str(prefix), str(EXAMPLES)))]
        if inside:
            raise AssertionError(f"headers of the repository: {inside}")

    def command(self, name):
        return (self.build / name,)

    def test_operating(self):
        self.check_operating()

    def test_tls(self):
        self.check_tls()

    def test_feeding(self):
        self.check_feeding(["640", "480"])

    def test_driving(self):
        self.check_driving("1")


class Node(Examples):
    @classmethod
    def setUpClass(cls):
        node, npm = shutil.which("node"), shutil.which("npm")
        if not (node and npm):
            skip("no node and npm")
        folder = pathlib.Path(os.environ["PALPATE_TEST_OUTPUT"]) / "node-examples"
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(EXAMPLES / "package.json", folder)
        if subprocess.run([npm, "install", "--no-audit", "--no-fund", "--ignore-scripts", "--silent"], cwd=folder).returncode != 0:
            skip("npm could not install the packages")
        cls.node, cls.environment = node, {**BARE, "NODE_PATH": str(folder / "node_modules")}

    def command(self, name):
        return self.node, EXAMPLES / f"{name}.js"

    def test_watching(self):
        with Slave() as slave:
            self.assertIn("100 states, ", self.run_example("watch", slave.address))


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=[sys.argv[0], *sys.argv[1:]])
