"""Runs every example of deploy/examples against a real slave, and tests the further functions of the client libraries.

  test_examples.py Python|Cpp    needs PALPATE_BIN; Cpp PALPATE_TEST_OUTPUT and PALPATE_BUILD
"""
import contextlib
import gc
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time
import unittest
from concurrent import futures

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from delayed_link import DelayedLink  # noqa: E402
from programs import BARE, BIN, BLOCK, PACKAGE, PATIENCE, ROOT, FolderTest, Simulator, Slave, make_certificates, operate, run, wait_until  # noqa: E402

sys.path.insert(0, str(PACKAGE))
EXAMPLES = ROOT / "deploy/examples"
HERE = pathlib.Path(__file__).parent
CUBE = str(ROOT / "deploy/scenes/foam-cube.yaml")
ARM = ("--override", "manipulator.source=stream")
CAMERA = ("--override", "sense.camera.source=stream")
TACTILE = ("--override", "sense.tactile.source=stream")
HOME = "0.044,0.09416,0"
# [N] force of the block at the end of the press of `operate`; a test compares it with the simulator's true force.
STILL = 1.28


def fake_slave():
    """Returns the base class of fake slaves, which do on demand what no real slave does."""
    import grpc
    from palpate.v1 import teleoperation_pb2_grpc

    class FakeSlave(teleoperation_pb2_grpc.TeleoperationServicer):
        @contextlib.contextmanager
        def served(self):
            server = grpc.server(futures.ThreadPoolExecutor(4))
            teleoperation_pb2_grpc.add_TeleoperationServicer_to_server(self, server)
            port = server.add_insecure_port("127.0.0.1:0")
            server.start()
            try:
                yield f"127.0.0.1:{port}"
            finally:
                server.stop(None)
    return FakeSlave


def skip(reason):
    print(f"skipped: {reason}")
    raise SystemExit(77)


class Examples(FolderTest):
    """Tests of the examples in all languages."""
    environment = BARE

    def run_example(self, name, *arguments, **options):
        """Returns the output of an example that must end with exit code 0."""
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
            watched, _ = watching.communicate(timeout=PATIENCE)
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

    def check_cut_link(self, *examples):
        """Every example ends with an error when no more data arrives, although the connection is not closed."""
        def cut(slave, words):
            with DelayedLink(slave.address, 0, max_down=10_000) as link:
                return words[0], run(*self.command(words[0]), link.address, *words[1:], env=self.environment), link.bytes_down - link.max_down

        with Slave(BLOCK) as simulated, Slave(BLOCK, *ARM, simulates=False) as driven, futures.ThreadPoolExecutor() as pool:
            ends = [pool.submit(cut, driven if words[0] == "drive_arm" else simulated, words) for words in examples]
        for name, done, lost in (end.result() for end in ends):
            self.assertGreater(lost, 0, f"{name} ended before the cut: {done.stdout}{done.stderr}")
            self.assertEqual(done.returncode, 1, f"{name}: {done.stdout}{done.stderr}")
            self.assertIn("error: ", done.stderr)

    def check_changed_settings(self, operator):
        """`operator(address)` yields a function that returns `ok` after `engage`, `release` and `change`."""
        import palpate
        with Slave(BLOCK, simulates=False) as slave, palpate.connect(slave.address) as connected, operator(slave.address) as command:
            # When the first sample arrives the description of the scene becomes complete and gets another revision.
            before, answers = connected.scene().settings_revision, []

            def engages():  # engages again after a hold, which a busy machine may cause
                answers.append(command("engage"))
                return answers[-1] == "ok"

            slave.simulator = Simulator(slave.command, slave.address)
            self.assertNotEqual(connected.scene().settings_revision, before)
            self.assertTrue(wait_until(engages), answers)
            self.assertEqual(command("release"), "ok")
            self.assertTrue(wait_until(lambda: connected.status().phase != palpate.Phase.FOLLOWING))
            self.assertEqual(command("change"), "ok")
            self.assertTrue(wait_until(engages), answers)

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

    def test_depth_camera(self):
        """A depth camera by OpenNI2, with a stand-in for the package `openni`, in front of a membrane without
        contact."""
        import palpate
        depth = ("sense.camera={depth: {source: stream}, rate: 30 Hz, unit: 0.02 mm, sigma: 0.2 mm, fx: 400, fy: 400, cx: 159.5, "
                 "cy: 119.5, pose: {translation: [0, 0, -250 mm]}}")
        packages = {"PYTHONPATH": f"{PACKAGE}:{HERE / 'openni'}"}
        with Slave(str(ROOT / "deploy/scenes/rubber-membrane.yaml"), "--override", depth, "--override", "sense.points={track: surface}",
                   simulates=False) as server, palpate.connect(server.address) as slave, futures.ThreadPoolExecutor() as pool:
            feeding = pool.submit(self.run_example, "feed_openni", server.address, "--count", "150", environment=packages)
            self.assertTrue(any(state.valid for state in slave.states(rate=30, seconds=PATIENCE)), slave.status())
            self.assertIn("150 of 150 images accepted", feeding.result())

    def test_driving(self):
        self.check_driving("--duration", "1", "--home", HOME)

    def test_cut_link(self):
        self.check_cut_link(["operate"], ["watch", "--states", "6000"], ["drive_arm", "--home", HOME])

    def test_watching_fingers(self):
        import palpate
        with Slave(CUBE) as slave:
            with palpate.connect(slave.address) as observed:  # until the baselines are complete
                self.assertTrue(any(state.valid for state in observed.states(rate=30, seconds=PATIENCE)))
            self.assertRegex(self.run_example("watch", slave.address), r"finger 2: (in contact|free), [0-9.]+ N, VALID")

    def test_record_to_numpy(self):
        import numpy as np
        import palpate
        recording = self.out / "session.mcap"
        with Slave(BLOCK, "--record", self.out / "slave.mcap") as slave:
            master = operate(slave.address, "--duration", "4", "--record", recording)
            self.run_example("record", slave.address, self.out / "live.npz", "--seconds", "4")
            self.assertEqual(master.wait(timeout=PATIENCE), 0)
            self.assertEqual(slave.stop(), 0)
        live = np.load(self.out / "live.npz")
        contact = live["true_force"][:, 1] > 0.1
        error = live["force"][contact, 1] - live["true_force"][contact, 1]
        self.assertGreater(contact.sum(), 20)
        self.assertLess(np.sqrt(np.mean(error ** 2)), 0.1 * live["true_force"][:, 1].max())
        # Reference: the arrays exported from the same files.
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
        # A truncated file is read up to its end.
        cut = self.out / "cut.mcap"
        cut.write_bytes((self.out / "slave.mcap").read_bytes()[:-(self.out / "slave.mcap").stat().st_size // 2])
        part = palpate.read_recording(cut).states
        self.assertTrue(0 < len(part) < len(sensed))
        np.testing.assert_array_equal(part.force, sensed.force[:len(part)])

    def test_stiffness_map(self):
        import palpate
        with Slave(BLOCK) as slave:
            planar = self.pressed(slave.address, "palpation_map", self.out / "block.svg", "--planar", "--span", "70")
            with palpate.connect(slave.address) as connected, connected.operate("test") as tool:
                tool.engage()
                tool.move_by([0, tool.state.depth - 0.003, 0], 0.01)
                held = tool.hold(0.5)
        # Reference: the simulator's true force at the same depth.
        truth = held.true_force[-1, 1] / held.depth[-1]
        self.assertIn("5 of 5 presses", planar)
        self.assertAlmostEqual(self.number(r"([0-9.]+) N/m", planar), truth, delta=0.02 * truth)
        self.assertLess(self.number(r"centre, ([0-9.]+) to", planar), 0.9)  # a block is softer near its free sides
        self.assertEqual((self.out / "block.svg").read_text().count("<rect"), 5)

    def pressed(self, address, name, *arguments):
        """Returns the output of an example that presses. If a busy machine held the tool, it is moved home and the
        example repeated."""
        import palpate
        done = []

        def presses():
            done.append(run(*self.command(name), address, *arguments, env=self.environment))
            if done[-1].returncode == 0 or "HOLD" not in done[-1].stderr:
                return True
            with contextlib.suppress(palpate.Error), palpate.connect(address) as slave, slave.operate("back") as tool:
                tool.move_to([float(x) for x in HOME.split(",")], 0.05)
            return False
        self.assertTrue(wait_until(presses))
        self.assertEqual(done[-1].returncode, 0, f"{name}: {done[-1].stdout}{done[-1].stderr}")
        return done[-1].stdout

    def test_ros_bridge(self):
        with Slave(BLOCK) as slave, self.ros_bridge(slave.address) as messages:
            self.pressed(slave.address, "operate")
            wrenches = messages("palpate/wrench")
            contacts, states = messages("palpate/wrench/contact"), messages("/diagnostics")
            done = run("/usr/bin/python3", "-m", "palpate_bridge.bridge", slave.address, "--messages", "50",
                       env={**self.ros_environment(), "ROS_PUBLISHED": str(self.out / "fifty")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual((self.out / "fifty").read_text().count('"palpate/wrench"'), 50)
        for message in wrenches:
            self.assertTrue(all(map(math.isfinite, message["wrench"]["force"].values())))
        by_stamp = {tuple(m["header"]["stamp"].values()): m for m in contacts if m["validity"] == 1}
        self.assertGreaterEqual(len(contacts), len(wrenches))
        for message in wrenches:
            contact = by_stamp[tuple(message["header"]["stamp"].values())]
            self.assertEqual((contact["wrench"]["force"], contact["acts_on"]), (message["wrench"]["force"], 1))
            self.assertGreaterEqual(contact["sigma"], 0)
        statuses = [message["status"][0] for message in states]
        self.assertGreaterEqual(len(statuses), len(wrenches))
        for status in statuses:
            values = {pair["key"]: pair["value"] for pair in status["values"]}
            self.assertEqual(status["message"] == "valid", values["validity"] == "valid")
            self.assertTrue(status["message"] != "valid" or float(values["sigma [N]"]) >= 0)
        stamps = [(message["header"]["stamp"]["sec"], message["header"]["stamp"]["nanosec"]) for message in wrenches]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertEqual({(m["topic"], m["header"]["frame_id"]) for m in wrenches}, {("palpate/wrench", "palpate_slave")})
        self.assertAlmostEqual(max(m["wrench"]["force"]["y"] for m in wrenches), STILL, delta=0.02 * STILL)

    def ros_environment(self):
        paths = f"{PACKAGE}:{HERE / 'ros'}:{ROOT / 'deploy/ros2/palpate_bridge'}"
        return {**self.environment, "PYTHONPATH": paths}

    @contextlib.contextmanager
    def ros_bridge(self, address):
        """Runs the bridge. Yields a function that returns the messages published on a topic."""
        published = self.out / "published"
        published.touch()
        with subprocess.Popen(["/usr/bin/python3", "-m", "palpate_bridge.bridge", address], stderr=subprocess.DEVNULL,
                              env={**self.ros_environment(), "ROS_PUBLISHED": str(published)}) as process:
            def messages(topic):
                text = published.read_text()
                found = map(json.loads, text[:text.rfind("\n") + 1].splitlines())
                return [message for message in found if message["topic"] == topic]
            try:
                yield messages
            finally:
                process.kill()

    def test_ros_bridge_reports_a_silent_sensor_and_connects_again(self):
        with Slave(BLOCK) as slave, DelayedLink(slave.address, 0) as link, self.ros_bridge(link.address) as messages:
            def newest():
                return messages("/diagnostics")[-1]["status"][0]

            self.assertTrue(wait_until(lambda: messages("palpate/wrench")))
            self.assertEqual((newest()["level"], newest()["message"]), ([0], "valid"))
            slave.simulator.stop()
            self.assertTrue(wait_until(lambda: newest()["level"] == [3]), newest())
            self.assertIn({"key": "validity", "value": "stale"}, newest()["values"])
            link.max_down = 0  # everything is lost, and the connection is not closed
            self.assertTrue(wait_until(lambda: re.match(r"no state for \d+ s", newest()["message"])), newest())
            self.assertEqual(newest()["level"], [3])
            count, link.max_down = len(messages("palpate/wrench")), math.inf
            link.cut()
            self.assertTrue(wait_until(lambda: any(m["status"][0]["level"] == [2] for m in messages("/diagnostics"))))
            slave.simulator = Simulator(slave.command, slave.address)
            self.assertTrue(wait_until(lambda: len(messages("palpate/wrench")) > count), newest())

    def test_ros_bridge_stamps_by_its_own_clock_and_publishes_no_unknown_moment(self):
        """The fake slave's clock is one hour ahead and later two, and it reports a moment in some of its states."""
        from palpate.v1 import state_pb2, telemetry_pb2

        class Ahead(fake_slave()):
            hours, sequence = 1, 0

            def now(self):
                return time.time_ns() + self.hours * 3600 * 10**9

            def GetStatus(self, request, context):
                status = telemetry_pb2.Status()
                status.now.FromNanoseconds(self.now())
                return status

            def WatchState(self, request, context):
                while context.is_active():
                    self.sequence += 1
                    state = state_pb2.SlaveState(sequence=self.sequence, validity=state_pb2.VALIDITY_VALID,
                                                 force=state_pb2.Vec3(y=self.sequence))
                    if self.sequence % 2:
                        state.moment.z = 0.25
                    state.sensed_at.FromNanoseconds(self.now())
                    yield state
                    time.sleep(0.05)

        fake = Ahead()
        with fake.served() as address, self.ros_bridge(address) as messages:
            def is_late():  # age of the newest message [s]
                return abs(messages("palpate/wrench")[-1]["header"]["stamp"]["sec"] - time.time())

            self.assertTrue(wait_until(lambda: len(messages("palpate/wrench")) > 5))
            self.assertLess(is_late(), 600)
            fake.hours, changed = 2, fake.sequence
            self.assertTrue(wait_until(lambda: messages("palpate/wrench")[-1]["wrench"]["force"]["y"] > changed + 1 and is_late() < 600))
            torques = {message["wrench"]["torque"]["z"] for message in messages("palpate/wrench") if not
                       math.isnan(message["wrench"]["torque"]["z"])}
            unknown = [message for message in messages("palpate/wrench") if math.isnan(message["wrench"]["torque"]["z"])]
            self.assertEqual(torques, {0.25})
            self.assertGreater(len(unknown), 1)

    def test_changed_settings_are_named(self):
        from unittest import mock

        import palpate
        from palpate.v1 import scene_pb2, state_pb2

        class Changed(fake_slave()):
            def GetScene(self, request, context):
                scene = scene_pb2.SceneDescription(settings_revision=3)
                scene.operator.position_scale = 1
                scene.operator.orientation.extend([1, 0, 0, 0])
                return scene

            def Operate(self, commands, context):
                for command in commands:
                    yield state_pb2.SlaveState(sequence=command.sequence, epoch=command.epoch, phase=state_pb2.PHASE_CLUTCHED,
                                               settings_revision=4)

        with Changed().served() as address, palpate.connect(address) as slave, slave.operate("late") as tool:
            with mock.patch("palpate.operator.TIMEOUT", 0.5), \
                    self.assertRaisesRegex(palpate.Interrupted, "the settings changed: revision 3, now 4"):
                tool.engage()

    def test_plots_of_tables(self):
        """Each kind of table that the programs write is drawn. For other or damaged tables the message names the
        file."""
        if run("/usr/bin/python3", "-c", "import matplotlib").returncode:
            self.skipTest("no python3-matplotlib")
        plot = lambda file, *options: run("/usr/bin/python3", "-m", "palpate.plot", file, *options, env=self.environment)
        tables = {
            "study.csv": "family,update_median_s,error,error_bar,on_front,recommended\nbem2d,1e-6,0.02,0.001,1,1\nfem,1e-3,,,0,0\n",
            "states.csv": "t,finger,fx,fy,fz,sigma,validity\n0,0,0,0,1,0.1,valid\n1,0,0,0,2,0.1,stale\n2,0,,,,,tracking_lost\n",
            "log.csv": "t,sent_x,sent_y,sent_z\n0,0,0,1\n1,0,0,2\n",
            "forces.csv": "t,measured_fz,estimated_fz\n0,1,1.1\n1,2,2.1\n"}
        for name, text in tables.items():
            (self.out / name).write_text(text)
            done = plot(self.out / name)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("<svg", (self.out / name).with_suffix(".svg").read_text())
        other = self.out / "other.csv"
        head = "family,update_median_s,precompute_s,error,error_bar,on_front,recommended\n"
        (self.out / "study.csv").write_text(head + "bem2d,1e-6,0.1,0.02,0.001,1,1\nfem,1e-3,,,,0,0\n")
        other.write_text(head + "bem2d,3e-6,0.3,0.04,0.001,0,0\n")
        done = plot(self.out / "study.csv", other)
        self.assertIn("| bem2d | 2 | 2 | 3 / 3.8 | 2 / 2.8 | 200 / 280 | 50 % |", done.stdout, done.stderr)
        self.assertEqual(plot(self.out / "study.csv", self.out / "states.csv").returncode, 2)
        for text, message in (("a,b\n1,2\n", "expected study.csv"), ("t,fx,fy,fz\n0,0\n", "bad.csv:2: 2 cells: expected 4"),
                              ("t,fx,fy,fz\n0,one,0,0\n", "column fx"), ("", "expected a CSV file with a header")):
            (self.out / "bad.csv").write_text(text)
            done = plot(self.out / "bad.csv")
            self.assertEqual(done.returncode, 2)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_pip_installs_the_client_without_network(self):
        """Runs the commands of deploy/python/README.md in an environment without access to the build."""
        environment = self.out / "venv"
        made = run("/usr/bin/python3", "-m", "venv", "--system-site-packages", environment)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        installed = run(environment / "bin/pip", "install", "--no-index", "--no-build-isolation", ROOT, env=BARE)
        self.assertEqual(installed.returncode, 0, installed.stdout + installed.stderr)
        page = (ROOT / "deploy/python/README.md").read_text()
        lines = re.search(r"```python\n(import palpate\n\nwith palpate.connect.*?)```\n", page, re.DOTALL).group(1)
        with Slave(BLOCK) as slave:
            printed = run(environment / "bin/python", "-c", lines.replace("127.0.0.1:50051", slave.address), env=BARE)
        self.assertEqual(printed.returncode, 0, printed.stderr)
        self.assertRegex(printed.stdout, r"^\[.*\] \+- [0-9.]+ N\n")

    def test_changed_settings(self):
        import palpate
        from palpate.v1 import teleoperation_pb2

        @contextlib.contextmanager
        def operator(address):
            with palpate.connect(address) as slave, slave.operate("script") as tool:
                def change():
                    slave.stub.SetParameters(teleoperation_pb2.SetParametersRequest(force_limit=3))

                def command(name):
                    try:
                        {"engage": tool.engage, "release": tool.release, "change": change}[name]()
                    except palpate.Interrupted as error:
                        return str(error)
                    return "ok"
                yield command
        self.check_changed_settings(operator)

    def test_who_waits_for_the_lease_uses_the_settings_of_its_engagement(self):
        import palpate
        from palpate.v1 import teleoperation_pb2
        with Slave(BLOCK) as server, palpate.connect(server.address) as slave, contextlib.ExitStack() as second:
            with slave.operate("first"):
                tools = []
                waiting = threading.Thread(target=lambda: tools.append(second.enter_context(slave.operate("second", wait=30))))
                waiting.start()
                time.sleep(0.5)
                with palpate.errors.translated():
                    slave.stub.SetParameters(teleoperation_pb2.SetParametersRequest(position_scale=0.5))
            waiting.join(60)
            home = tools[0].state.tip

            def moves():  # engages again after a hold, which a busy machine may cause
                try:
                    tools[0].move_to(home + [0, -0.004, 0], 0.01)
                except palpate.Interrupted:
                    tools[0].release()
                    return False
                return True

            self.assertTrue(wait_until(moves))
            self.assertAlmostEqual(tools[0].hold(0.5).tip[-1, 1] - home[1], -0.004, delta=5e-4)

    def test_an_idle_operator_keeps_no_states(self):
        import palpate
        with Slave(BLOCK) as server, palpate.connect(server.address) as slave, slave.operate("idle") as tool:
            first = tool.state.sequence
            self.assertTrue(wait_until(lambda: tool.state.sequence > first + 100))
            kept = sum(isinstance(each, palpate.State) for each in gc.get_objects())
            self.assertLess(kept, 10)
            self.assertGreater(len(tool.hold(0.5)), 10, "a motion returns all of its own")

    def test_enumerations_are_those_of_the_protocol(self):
        import palpate
        from palpate.v1 import state_pb2
        for own, kind in ((palpate.Validity, state_pb2.Validity), (palpate.Phase, state_pb2.Phase)):
            prefix = own.__name__.upper() + "_"
            self.assertEqual({each.name: each.value for each in own}, {name.removeprefix(prefix): n for name, n in kind.items()})

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
                self.assertLess(np.linalg.norm(paused - home), 0.004)  # it did not continue after the stop
                slave.reset(slave.status())
                time.sleep(0.3)
                np.testing.assert_array_equal(tool.position, paused)  # and it stays there
                tool.engage()  # does not move the tool
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
        with self.assertRaisesRegex(ValueError, r"no MCAP file: expected a recording \(.mcap\)"):
            palpate.read_recording(not_a_recording)
        with self.assertRaises(palpate.Error), palpate.connect("127.0.0.1:1") as nobody:
            nobody.scene()

    def test_types(self):
        mypy = shutil.which("mypy", path=BARE["PATH"])
        if mypy is None:
            self.skipTest("no mypy (apt-get install mypy)")
        paths = {**BARE, "MYPYPATH": f"{PACKAGE}:{HERE / 'ros'}:{HERE / 'openni'}"}
        check = [mypy, "--config-file", ROOT / "deploy/python/mypy.ini", "--cache-dir", self.out / "cache"]
        for arguments in (["-p", "palpate"], *([path] for path in EXAMPLES.glob("*.py"))):
            done = run(*check, *arguments, env=paths)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        wrong = self.out / "wrong.py"
        wrong.write_text("import palpate\n\nwith palpate.connect('a') as slave:\n    slave.operate(5)\n")
        self.assertEqual(run(*check, wrong, env=paths).returncode, 1)


@contextlib.contextmanager
def script_operator(address):
    """Starts the program of this name. Yields a function that sends it a line and returns its answer."""
    with subprocess.Popen([str(BIN / "script_operator"), address], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                          env={**BARE, "MALLOC_ARENA_MAX": "1"}) as process:
        first = process.stdout.readline()
        if first != "ok\n":
            raise AssertionError(first)

        def command(line):
            process.stdin.write(line + "\n")
            process.stdin.flush()
            return process.stdout.readline().strip()
        yield command
        process.stdin.close()


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
            done = run(*command, env={"PATH": os.environ["PATH"]}, timeout=3000)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)
        # The compiler read no headers of the repository except the installed ones.
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

    def test_cut_link(self):
        self.check_cut_link(["operate"], ["watch"], ["drive_arm", "60"])

    def test_changed_settings(self):
        self.check_changed_settings(script_operator)

    # A state has about 500 bytes, so 400 states would be 200 kB.
    def test_an_idle_operator_keeps_no_states(self):
        with Slave(BLOCK) as slave, script_operator(slave.address) as command:
            first, second = int(command("idle 200")), int(command("idle 400"))
        self.assertLess(second - first, 50_000)


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=[sys.argv[0], *sys.argv[1:]])
