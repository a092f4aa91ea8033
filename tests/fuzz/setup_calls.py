#!/usr/bin/python3
"""Sends random set-up calls to a live `serve --setup`, and to the page of a master: random keys, sizes, names, images
and bodies, and calls that are cancelled. Exit code 1: a program ended, took more than 200 MB, left a file that a set-up
does not have, or did not recover.

usage: tests/fuzz/setup_calls.py [--seconds N] [--seed N]   (60 s; of build/release, or PALPATE_BIN)
"""
import argparse
import base64
import collections
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from programs import BARE, MASTER, PATIENCE, load_package, memory, png, wait_until  # noqa: E402
from setups import LiveCamera, SetupSlave, first_image, proposal  # noqa: E402

palpate, messages, states = load_package()
import grpc  # noqa: E402
from palpate.v1 import setup_pb2 as setups  # noqa: E402

MAX_MB = 200
ALLOWED = re.compile(r"(scenes(/(current|last|\d+))?/)?(scene\.yaml|tip\.png|outline\.csv|lens\.yaml|image\.jpg)"
                     r"|scenes(/(current|last|\d+))?")
WORDS = ["", "-1", "0", "1e308", "nan", "127 kPa", "5 object.", "object.", "/etc/passwd", "../../x", "/", "..", "~", "*", "%s%n", "\x00",
         "[", "{", "]", "&a", "*a", "!!binary", "? ", "- ", ": ", "\t", "'", '"', "ä", "💡", "from-image", "stream", "auto", "a" * 70]


class Fuzzer:
    def __init__(self, stub, page, scene, rows, seed):
        self.stub, self.page, self.scene, self.rows = stub, page, scene, rows
        self.random = random.Random(seed)
        self.counts = collections.Counter()
        self.last = {}  # message of the newest error of each code

    def word(self):
        draw = self.random.random()
        if draw < 0.5:
            return self.random.choice(WORDS)
        if draw < 0.6:
            return self.random.choice(["a", "[", "{", "é", "1", "a.", "../", "x: "]) * self.random.choice([100, 10_000, 100_000])
        if draw < 0.8:
            return f"{self.random.uniform(-10, 500):g}{self.random.choice(['', ' mm', ' px', ' kPa', ' Hz', ' %'])}"
        return "".join(chr(self.random.randrange(1, 0x250)) for _ in range(self.random.randrange(30)))

    def text(self):
        """Returns the valid scene with a few random mistakes."""
        lines = self.scene.scene.splitlines()
        for _ in range(self.random.choice([0, 1, 1, 1, 2, 5])):
            i, draw = self.random.randrange(len(lines)), self.random.randrange(7)
            if draw == 0:
                del lines[i]
            elif draw == 1:
                lines.insert(i, self.random.choice(lines))
            elif draw == 2:
                lines[i] = self.word()
            elif draw == 3:
                lines.insert(i, f'{" " * self.random.choice([0, 2, 4])}? "{self.word()}"\n: {self.word()}')
            elif draw == 4:
                lines[i] = re.sub(r": [^:]*$", lambda _: f": {self.word()}", lines[i])
            elif draw == 5:
                numbers = list(re.finditer(r"\d+(\.\d+)?", lines[i]))
                if numbers:
                    at = self.random.choice(numbers)
                    lines[i] = f"{lines[i][:at.start()]}{self.random.choice([0, 1, 3, 100, 300, -5, 0.1])}{lines[i][at.end():]}"
            else:
                at = self.random.randrange(len(lines[i]) + 1)
                lines[i] = lines[i][:at] + self.word() + lines[i][at:]
            if not lines:
                lines = [""]
        return "\n".join(lines) + "\n"

    def bytes(self, good):
        draw = self.random.random()
        if draw < 0.5:
            return good
        if draw < 0.65:
            return self.random.randbytes(self.random.choice([0, 1, 30, 10_000]))
        broken = bytearray(good)
        for _ in range(self.random.randrange(1, 10)):
            broken[self.random.randrange(len(broken))] = self.random.randrange(256)
        return bytes(broken[:self.random.randrange(len(broken) + 1)] if draw < 0.8 else broken)

    def image(self):
        draw = self.random.random()
        if draw < 0.4:
            return self.bytes(png(640, 480, 8, self.rows))
        width, height = (self.random.choice([1, 3, 16, 640, 5000, 20_000]) for _ in range(2))
        size = min(height, 2_000_000 // width + 1)  # fewer rows than the header states
        return png(width, height, 8, [bytes(width)] * size)

    def proposal(self):
        text = self.text() if self.random.random() < 0.8 else self.scene.scene
        while True:
            try:
                scene = setups.SceneProposal(scene=text.encode("utf-8", "ignore").decode())
                break
            except ValueError:
                text = self.text()
        for name, content in self.scene.files.items():
            if self.random.random() < 0.9:
                scene.files[name] = self.bytes(content)
        if self.random.random() < 0.3:
            name = self.random.choice(["outline.csv", "lens.yaml", "image.jpg", "scene.yaml", "run.sh", "../x", "/tmp/x", "a" * 70_000, "."])
            scene.files[name] = self.bytes(b"x,y\n0,0\n1,0\n0,1\n")
        return scene

    def request(self):
        """Returns a random (name on the page, call, request)."""
        draw = self.random.random()
        if draw < 0.55:
            return "propose", self.stub.ProposeScene, self.proposal()
        if draw < 0.7:
            return "use", self.stub.UseScene, self.proposal()
        point = lambda: setups.ImagePoint(u=self.random.choice([-1e9, 0, 100, 320, 1e300]), v=self.random.uniform(-50, 500))
        if draw < 0.87:
            near = [point() for _ in range(self.random.choice([0, 1, 3, 4, 50]))]
            if self.random.random() < 0.4:
                near = [setups.ImagePoint(u=u, v=v) for u, v in ((194, 394), (446, 394), (446, 142), (194, 142))]
            return "outline", self.stub.FindOutline, setups.FindOutlineRequest(image=self.random.choice([b"", self.image()]), near=near)
        images = [self.image() for _ in range(self.random.choice([0, 1, 3]))]
        return "board", self.stub.FindBoard, setups.FindBoardRequest(
            images=images, columns=self.random.choice([0, 3, 9, 100, 2 ** 31]), rows=self.random.choice([3, 6, 99]),
            square=self.random.choice([0, 5e-3, float("nan"), -1]))

    def call(self, name, call, request):
        timeout = self.random.choice([0.02, 0.2, 1, 60, 60, 60])
        try:
            call(request, timeout=timeout, wait_for_ready=True)
            self.counts[f"{name} OK"] += 1
            return True
        except grpc.RpcError as error:
            self.counts[f"{name} {error.code().name}"] += 1
            self.last[error.code().name] = error.details()
            return False

    def post(self, name, request):
        body = json.dumps(self.json(request)).encode()
        if self.random.random() < 0.3:
            body = self.bytes(body)
        if self.random.random() < 0.1:
            name = self.random.choice(["", "image", "none", "../use", "a" * 5000])
        address = self.page.replace("#", f"setup/{name}?token=") if "#" in self.page else f"{self.page}setup/{name}"
        try:
            with urllib.request.urlopen(urllib.request.Request(address, data=body), timeout=self.random.choice([0.1, 1, 60])) as answer:
                self.counts[f"page {answer.status}"] += 1
        except urllib.error.HTTPError as error:
            self.counts[f"page {error.code}"] += 1
        except OSError:
            self.counts["page cut"] += 1

    @staticmethod
    def json(request):
        def encoded(value):
            return base64.b64encode(value).decode()
        if isinstance(request, setups.SceneProposal):
            return {"scene": request.scene, "files": {name: encoded(content) for name, content in request.files.items()}}
        if isinstance(request, setups.FindOutlineRequest):
            return {"image": encoded(request.image), "near": [{"u": p.u, "v": p.v} for p in request.near]}
        return {"images": [encoded(image) for image in request.images], "columns": request.columns, "rows": request.rows}

    def step(self):
        name, call, request = self.request()
        if self.random.random() < 0.3:
            self.post(name, request)
        else:
            self.call(name, call, request)


def start_master(address):
    master = subprocess.Popen([MASTER, "connect", address, "--device", "pointer", "--view", "127.0.0.1:0"], stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=BARE)
    for line in master.stdout:
        if match := re.search(r"view at (\S+)", line):
            # The output is read, because a full pipe would block the master.
            threading.Thread(target=collections.deque, args=(master.stdout, 20), daemon=True).start()
            return master, match[1]
    raise AssertionError("the master ended")


def strange_files(folder):
    # Folders change meanwhile; os.walk skips removed ones.
    paths = [pathlib.Path(parent, name) for parent, folders, files in os.walk(folder) for name in folders + files]
    return [str(path) for path in paths if not ALLOWED.fullmatch(str(path.relative_to(folder)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        rows = first_image(scratch / "images")
        camera, saved = LiveCamera(rows), scratch / "saved"
        slave, temporary = SetupSlave(saved, camera, scratch / "bin"), scratch / "tmp"
        temporary.mkdir()
        slave.environment["TMPDIR"] = str(temporary)
        with slave:
            stub = palpate.connect(slave.address).stub
            scene = proposal(setups, stub.GetScene(messages.GetSceneRequest()).setup_camera, rows)
            master, page = start_master(slave.address)
            fuzzer, found = Fuzzer(stub, page, scene, rows, options.seed), []
            end = time.monotonic() + options.seconds
            while time.monotonic() < end and not found:
                fuzzer.step()
                # The scene in use has a manipulator, so the master operates.
                if "lease is held" in fuzzer.last.pop("FAILED_PRECONDITION", ""):
                    master.terminate()
                    master.wait(timeout=PATIENCE)
                    if not wait_until(lambda: fuzzer.call("use", stub.UseScene, scene)):
                        found.append("no scene can be used after the master left")
                    master, fuzzer.page = start_master(slave.address)
                if slave.process.poll() is not None:
                    found.append(f"the slave ended: {slave.process.returncode}")
                elif master.poll() is not None:
                    found.append(f"the master ended: {master.returncode}")
                elif memory(slave.process.pid, "VmHWM") > MAX_MB:
                    found.append(f"the slave took {memory(slave.process.pid, 'VmHWM'):.0f} MB")
                # A file has a temporary name while it is written.
                elif strange_files(saved) and not wait_until(lambda: not strange_files(saved)):
                    found.append(f"files: {strange_files(saved)}")
            if not found:
                def recovers():
                    try:
                        return not stub.ProposeScene(scene, timeout=10 * PATIENCE, wait_for_ready=True).errors
                    except grpc.RpcError as error:
                        fuzzer.last["at the end"] = error.details()
                        return False
                if not wait_until(recovers):
                    found.append("a good scene is refused")
                print(f"memory: slave {memory(slave.process.pid, 'VmHWM'):.0f} MB, master {memory(master.pid, 'VmHWM'):.0f} MB")
            master.terminate()
            master.wait(timeout=PATIENCE)
            if slave.process.poll() is not None:
                print("".join(slave.log[-20:]))
        camera.close()
        if left := [path.name for path in temporary.iterdir()]:
            found.append(f"temporary files are left: {left}")
    print(f"{sum(fuzzer.counts.values())} calls: " + ", ".join(f"{count} {name}" for name, count in sorted(fuzzer.counts.items())))
    for code, details in fuzzer.last.items():
        print(f"newest {code}: {details[:200]}")
    for what in found:
        print(f"FOUND: {what} (seed {options.seed})")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
