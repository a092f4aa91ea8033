"""Set-ups by gRPC calls in random order with stops, operators, broken connections and a full disk: no saved scene is
lost."""
import os
import pathlib
import random
import struct
import subprocess
import tempfile
import threading
import time
import unittest
import zlib

from programs import PATIENCE, SLAVE, FolderTest, load_package, memory, operate, run, wait_until
from setups import LiveCamera, SetupSlave, first_image, proposal, saved_modulus

try:
    palpate, messages, states = load_package()
except unittest.SkipTest as error:
    print(f"skipped: {error}")
    raise SystemExit(77)
import grpc
from palpate.v1 import setup_pb2 as setups

# Number of random set-ups, and the seed of their order.
ROUNDS = int(os.environ.get("PALPATE_SETUPS", 6))
SEED = int(os.environ.get("PALPATE_SEED", 1))
Phase = states.Phase


def empty_png(width, height):
    """Returns a black image, which is compressed to almost nothing."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    packer, data = zlib.compressobj(1), b""
    for _ in range(height):
        data += packer.compress(bytes(width + 1))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", data + packer.flush()) + chunk(b"IEND", b""))


class SetupTest(FolderTest):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.rows = first_image(pathlib.Path(folder))

    def setUp(self):
        super().setUp()
        self.camera = LiveCamera(self.rows)
        self.addCleanup(self.camera.close)
        self.saved = self.out / "saved"

    def start(self, *arguments):
        slave = SetupSlave(self.saved, self.camera, self.out / "bin", *arguments)
        slave.__enter__()
        self.addCleanup(lambda: slave.process.poll() is None and slave.__exit__())
        connection = palpate.connect(slave.address)
        self.addCleanup(connection.close)
        self.slave, self.stub = slave, connection.stub
        return slave

    @staticmethod
    def again(call, request):
        """Repeats a call until it is answered, because the slave may be restarting."""
        end = time.monotonic() + PATIENCE
        while True:
            try:
                return call(request, timeout=PATIENCE, wait_for_ready=True)
            except grpc.RpcError as error:
                # gRPC cancels calls that arrive while a server shuts down.
                if error.code() not in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED) or time.monotonic() > end:
                    raise
            time.sleep(0.05)

    def scene(self):
        return self.again(self.stub.GetScene, messages.GetSceneRequest())

    def status(self):
        return self.again(self.stub.GetStatus, messages.GetStatusRequest())

    def is_changing(self):
        """Returns whether a change of settings is in progress: then another proposal is rejected."""
        try:
            self.again(self.stub.ProposeScene, setups.SceneProposal())
        except grpc.RpcError as error:
            return error.code() == grpc.StatusCode.ABORTED
        return False

    def settled(self):
        """Waits until no call is in progress. Returns Young's modulus of the scene that is served and saved [kPa];
        None: there is none."""
        served = []

        def is_settled():
            busy, scene = self.is_changing(), self.scene()
            served[:] = [scene.material.young_modulus / 1e3 if scene.name else None]
            return not busy and saved_modulus(self.saved) == served[0]
        self.assertTrue(wait_until(is_settled), f"served {served}, saved {saved_modulus(self.saved)}")
        return served[0]

    def proposal(self, **changes):
        return proposal(setups, self.scene().setup_camera, self.rows, **changes)

    def use(self, scene, **options):
        """Calls UseScene at a slave that may be restarting. Returns (reply, code)."""
        try:
            return self.stub.UseScene(scene, **{"timeout": 10 * PATIENCE, "wait_for_ready": True, **options}), grpc.StatusCode.OK
        except grpc.RpcError as error:
            return error.details(), error.code()

    def refusal(self, call, request):
        with self.assertRaises(grpc.RpcError) as refused:
            call(request, timeout=PATIENCE)
        return refused.exception


class Operator:
    """Holds the lease with a revision of the settings, and is engaged."""

    def __init__(self, stub, revision):
        self.closing = threading.Event()
        self.phases, self.error, self.revision = [], None, revision
        self.stream = stub.Operate(self.commands())
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def commands(self):
        sequence = 0
        while not self.closing.is_set():
            sequence += 1
            command = states.OperatorCommand(sequence=sequence, settings_revision=self.revision, operator_name="ada",
                                             epoch=1 + sequence // 250, engaged=sequence % 250 > 5)
            command.sent_at.GetCurrentTime()
            for axis in "xyz":
                setattr(command.p_M, axis, 0.0)
            yield command
            time.sleep(0.004)

    def read(self):
        try:
            for state in self.stream:
                self.phases.append(state.phase)
        except grpc.RpcError as error:
            self.error = error

    def follows(self, patience):
        return wait_until(lambda: Phase.PHASE_FOLLOWING in self.phases or self.error is not None, patience) and self.error is None

    def leave(self):
        self.closing.set()
        self.reader.join(timeout=PATIENCE)


class Mistakes(SetupTest):
    def test_what_no_scene_may_contain_is_named_and_harms_nothing(self):
        self.start()
        good = self.proposal()
        secret = self.out / "secret.txt"
        secret.write_text("token: hunter2-AAAA-BBBB\n1,2\n")
        outline = "object: {geometry: {contour: '%s', thickness: 9 mm}}"
        for key in ("5 object.", "object.", ""):
            for value in ("", ": 1\n"):
                self.assert_mistake(f'? "{key}{"a" * 100_000}"\n{value}')
        self.assert_mistake(outline % ("a" * 100_000))
        answers = []
        for name in (secret, self.out / "none.txt", "/root", "/nothere", "../../etc/passwd"):
            errors = self.assert_mistake(outline % name)
            answers.append([(e.key, e.message, e.expected, e.line) for e in errors])
        self.assertTrue(all(answer == answers[0] for answer in answers), answers)
        self.assertEqual(answers[0][0][0], "object.geometry.contour")
        self.assertNotIn("hunter2", str(answers))
        before = sorted(path.name for path in self.saved.rglob("*"))
        for name in ("run.sh", "key.pem", "emergency-stop", "../tip.png", "a" * 100_000):
            wrong = setups.SceneProposal(scene=good.scene, files={**good.files, name: b"x"})
            for call in (self.stub.ProposeScene, self.stub.UseScene):
                error = self.refusal(call, wrong)
                self.assertEqual(error.code(), grpc.StatusCode.INVALID_ARGUMENT)
                self.assertLess(len(error.details()), 300)
        self.assertEqual(sorted(path.name for path in self.saved.rglob("*")), before)
        self.assertFalse(self.stub.ProposeScene(good, timeout=10 * PATIENCE).errors)
        self.assertEqual(self.status().phase, Phase.PHASE_SETUP)

    def assert_mistake(self, scene):
        errors = self.stub.ProposeScene(setups.SceneProposal(scene=scene), timeout=PATIENCE).errors
        self.assertTrue(errors)
        for error in errors:
            self.assertLess(len(error.key), 80)
            self.assertLess(len(error.value), 80)
            self.assertLess(len(error.message), 700)
        return errors

    def test_large_images_are_refused_by_their_headers(self):
        slave = self.start()
        self.status()
        before = memory(slave.process.pid, "VmHWM")
        large, wide = empty_png(10_000, 10_000), empty_png(4_000, 4_000)
        for images in ([large] * 12, [wide] * 40):
            request = setups.FindBoardRequest(images=images, columns=9, rows=6, square=5e-3)
            error = self.refusal(self.stub.FindBoard, request)
            self.assertEqual(error.code(), grpc.StatusCode.INVALID_ARGUMENT, error.details())
        error = self.refusal(self.stub.FindOutline, setups.FindOutlineRequest(image=large))
        self.assertIn("25 megapixels", error.details())
        self.assertLess(memory(slave.process.pid, "VmHWM"), before + 60)

    def test_a_camera_that_stopped_gives_no_image_to_a_set_up(self):
        self.start()
        good = self.proposal()
        self.camera.running.clear()
        time.sleep(0.5)  # earlier messages have arrived
        error = self.refusal(self.stub.FindOutline, setups.FindOutlineRequest())
        self.assertIn("no new image", error.details())
        self.assertIn("no new image", self.stub.ProposeScene(good, timeout=PATIENCE).errors[0].message)
        self.assertIn("no new image", self.use(good)[0])
        self.camera.running.set()
        self.assertTrue(wait_until(lambda: not self.stub.ProposeScene(good, timeout=10 * PATIENCE).errors))

    def test_a_proposal_ends_with_its_call(self):
        self.start()
        self.assertFalse(self.stub.ProposeScene(self.proposal(), timeout=10 * PATIENCE).errors)
        slow = self.proposal(model="{kind: bem2d, plane: stress, order: quadratic, elements: 1000}")
        for call in (self.stub.ProposeScene, self.stub.UseScene):
            with self.assertRaises(grpc.RpcError) as late:
                call(slow, timeout=0.3)
            self.assertEqual(late.exception.code(), grpc.StatusCode.DEADLINE_EXCEEDED)
            began = time.monotonic()
            self.assertTrue(wait_until(lambda: not self.is_changing()))
            print(f"{call._method.decode()} ended after {time.monotonic() - began:.2f} s", flush=True)
        self.assertIsNone(saved_modulus(self.saved))

    def test_the_operators_master_connects_to_a_slave_without_a_scene(self):
        slave = self.start()
        master = operate(slave.address, "--view", "127.0.0.1:0", stdout=subprocess.PIPE)
        self.addCleanup(master.stdout.close)
        self.addCleanup(master.wait)
        self.addCleanup(master.terminate)
        lines = iter(master.stdout.readline, b"")
        self.assertTrue(any(b"view at" in line for line in lines), "it ended")


class Rounds(SetupTest):
    def test_the_saved_scene_is_always_the_one_that_is_served(self):
        order = random.Random(SEED)
        state = self.out / "state"
        state.mkdir()
        slave = self.start("--state-dir", str(state))
        kinds = ["good", "stop", "cut", "full", "operator", "wrong", "signal"]
        plan = [kinds[i % len(kinds)] for i in range(max(0, ROUNDS - 1))]
        order.shuffle(plan)
        served, revision = None, self.scene().settings_revision
        for number, kind in enumerate(["good", *plan], 1):
            modulus = 100.0 + number
            got = getattr(self, kind)(order, f"{modulus:g} kPa")
            now, scene = self.settled(), self.scene()
            allowed = {"good": {modulus}, "stop": {modulus}, "signal": {modulus}, "wrong": {served}, "operator": {served}}.get(kind, {served, modulus})
            print(f"{number} {kind}: {got}, served {now}, revision {scene.settings_revision}", flush=True)
            self.assertIn(now, allowed)
            if now != served:
                self.assertGreater(scene.settings_revision, revision)
                self.refuse_old(revision, scene.settings_revision)
            served, revision = now, self.scene().settings_revision
            self.assertLessEqual(len([p for p in (self.saved / "palpate-scenes").iterdir() if p.name.isdigit()]), 2)
        self.assertIsNone(slave.process.poll())
        slave.__exit__()
        for file in (self.saved / "scene.yaml", self.saved / "palpate-scenes/last/scene.yaml"):
            check = run(SLAVE, "check", file, timeout=10 * PATIENCE)
            self.assertEqual(check.returncode, 0, check.stderr)
        self.start("--state-dir", str(state))
        self.assertEqual(self.scene().material.young_modulus, served * 1e3)

    def refuse_old(self, former, present):
        """An operator with the settings of the previous scene is not followed; one with the present settings is."""
        operator = Operator(self.stub, former)
        time.sleep(1)
        operator.leave()
        self.assertIn(Phase.PHASE_CLUTCHED, set(operator.phases))
        self.assertNotIn(Phase.PHASE_FOLLOWING, set(operator.phases))
        time.sleep(0.1)
        operator = Operator(self.stub, present)
        follows = operator.follows(PATIENCE)
        operator.leave()
        self.assertTrue(follows, operator.error)

    def good(self, _, modulus):
        reply, code = self.use(self.proposal(modulus=modulus, manipulator="{source: simulated}"))
        self.assertEqual(code, grpc.StatusCode.OK, reply)
        return code.name

    def stopped(self, order, modulus, stop):
        """A stop at any time during a set-up stays until it is reset."""
        scene = self.proposal(modulus=modulus, manipulator="{source: simulated}")
        answer = []
        user = threading.Thread(target=lambda: answer.append(self.use(scene)))
        user.start()
        time.sleep(order.uniform(0, 2.5))
        delayed = bool(order.getrandbits(1))
        if delayed:  # as close to the exchange as possible
            user.join(timeout=order.uniform(0, 5))
        stop()
        user.join(timeout=10 * PATIENCE)
        self.assertEqual(answer[0][1], grpc.StatusCode.OK, answer)
        self.settled()
        self.assertTrue(wait_until(lambda: self.status().phase == Phase.PHASE_ESTOP), "the stop is lost")
        self.assertTrue((self.out / "state/emergency-stop").exists())
        self.again(self.stub.Reset, messages.ResetRequest(stops=self.status().stops))
        self.assertNotEqual(self.status().phase, Phase.PHASE_ESTOP)
        return "stopped and reset"

    def stop(self, order, modulus):
        def repeat():
            """Repeats a stop until the slave confirms it, as the master does."""
            def is_confirmed():
                try:
                    return self.stub.Stop(messages.StopRequest(reason="by the test"), timeout=5).phase == Phase.PHASE_ESTOP
                except grpc.RpcError:
                    return False
            self.assertTrue(wait_until(is_confirmed))
        return self.stopped(order, modulus, repeat)

    def signal(self, order, modulus):
        return self.stopped(order, modulus, lambda: self.slave.process.send_signal(10))

    def cut(self, order, modulus):
        return self.use(self.proposal(modulus=modulus, manipulator="{source: simulated}"), timeout=order.uniform(0.1, 3))[1].name

    def full(self, order, modulus):
        scene = self.proposal(modulus=modulus, manipulator="{source: simulated}")
        self.slave.limit_files(order.choice([0, 1, len(scene.scene) - 1, 1000]))
        try:
            reply, code = self.use(scene)
        finally:
            self.slave.limit_files(-1)
        self.assertIn(code, (grpc.StatusCode.OK, grpc.StatusCode.INTERNAL), reply)
        return code.name

    def operator(self, order, modulus):
        scene = self.proposal(modulus=modulus, manipulator="{source: simulated}")
        operator = Operator(self.stub, self.scene().settings_revision)
        self.assertTrue(wait_until(lambda: operator.phases or operator.error))
        self.assertIsNone(operator.error)
        reply, code = self.use(scene)
        operator.leave()
        self.assertEqual(code, grpc.StatusCode.FAILED_PRECONDITION, reply)
        return code.name

    def wrong(self, _, modulus):
        reply, code = self.use(self.proposal(modulus=modulus, pixel="0.32 mm"))
        self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT, reply)
        return code.name


if __name__ == "__main__":
    unittest.main()
