"""A slave that is set up by gRPC calls: its live camera, and proposed scenes for the block in the images."""
import itertools
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import threading
import time
import zlib

from programs import BARE, BIN, BLOCK, PATIENCE, SLAVE, png, run

WIDTH, HEIGHT = 640, 480
# Tip in the first image [px], from the scene: 0.35 mm per pixel, and the tip is 40.16 mm above the image's centre.
TIP = (319.5, 239.5 - 40.16 / 0.35)
BOX = (305, 80, 335, 124)  # left, top, right, bottom of the tip's template [px]


def first_image(folder):
    """Returns the image of the block before the press, as rows of bytes."""
    run(SLAVE, "process", BLOCK, "--out", folder, "--frames", "--override", "operator.press.depth=2 mm",
        "--override", "sense.camera.rate=30 Hz", timeout=10 * PATIENCE).check_returncode()
    return decoded(sorted((folder / "frames").glob("*.png"))[0].read_bytes())


def decoded(data):
    """Returns the rows of an 8-bit grey PNG."""
    packed, at = b"", 8
    while at < len(data):
        size, name = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        if name == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw, rows, above = zlib.decompress(packed), [], bytes(WIDTH)
    for v in range(HEIGHT):
        kind, line = raw[v * (WIDTH + 1)], bytearray(raw[v * (WIDTH + 1) + 1:(v + 1) * (WIDTH + 1)])
        for u in range(WIDTH):
            a, b, c = line[u - 1] if u else 0, above[u], above[u - 1] if u else 0
            paeth = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            line[u] = (line[u] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
        rows.append(bytes(line))
        above = bytes(line)
    return rows


class LiveCamera:
    """Serves the fake camera's images: one image at 30 Hz whose lowest bit toggles. While `running` is cleared it sends
    none."""

    def __init__(self, rows):
        flat = b"".join(rows)
        self.images = [flat, bytes(value ^ 1 for value in flat)]
        self.running = threading.Event()
        self.running.set()
        self.ended = False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.setting = f"{self.listener.getsockname()[1]} {WIDTH} {HEIGHT}"
        threading.Thread(target=self.show, daemon=True).start()

    def show(self):
        while not self.ended:
            try:
                reader = self.listener.accept()[0]
                with reader:
                    for image in itertools.cycle(self.images):
                        while not self.running.wait(0.1):
                            pass
                        reader.sendall(image)
                        time.sleep(1 / 30)
            except OSError:
                pass

    def close(self):
        self.ended = True
        self.listener.close()


def proposal(messages, camera_lines, rows, modulus="127 kPa", manipulator="none", model="{kind: bem2d, plane: stress, elements: 60}",
             pixel="0.35 mm"):
    left, top, right, bottom = BOX
    lines = "".join(f"    {line}\n" for line in camera_lines.splitlines())
    scene = ("name: my-block\nobject:\n  geometry:\n    rectangle: {width: 88 mm, height: 88 mm, thickness: 9 mm}\n"
             f"  material: {{young_modulus: {modulus}, poisson_ratio: 0.49}}\n  fixed: {{side: bottom}}\n"
             f"tool: {{shape: flat, width: 5.87 mm, depth: whole}}\nmanipulator: {manipulator}\nsense:\n  camera:\n{lines}"
             f"    pixel: {pixel}\n    pose: {{translation: [44 mm, 54 mm, 0]}}\n"
             f"  tip: {{track: template, template: tip.png, anchor: [{TIP[0] - left}, {TIP[1] - top}]}}\n"
             f"  contour: {{track: snake}}\nmodel: {model}\n")
    tip = png(right - left, bottom - top, 8, [row[left:right] for row in rows[top:bottom]])
    return messages.SceneProposal(scene=scene, files={"tip.png": tip})


class SetupSlave:
    """`palpate-slave serve --setup` with the fake camera, in a `with` block. `limit_files` limits the size of its
    files, as a full disk does."""

    def __init__(self, folder, camera, beside, *arguments):
        beside.mkdir(exist_ok=True)
        for name, copy in (("palpate-slave", "palpate-slave"), ("fake_cameras.so", "palpate-cameras.so")):
            if not (beside / copy).exists():
                shutil.copy(BIN / name, beside / copy)
        self.command = [str(word) for word in (beside / "palpate-slave", "serve", "--setup", folder, "--listen", "127.0.0.1:0", *arguments)]
        self.environment = {**BARE, "PALPATE_FAKE_CAMERA": camera.setting, "HOME": str(beside)}

    def __enter__(self):
        # Ignoring SIGXFSZ makes a write beyond the limit fail instead of ending the program.
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, env=self.environment, restore_signals=False,
                                        preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN))
        line = self.process.stdout.readline()
        match = re.fullmatch(r"listening on (\S+)\n", line)
        if not match:
            self.process.kill()
            raise AssertionError(f"slave printed {line!r}; {self.process.stderr.read()}")
        self.address = match.group(1)
        self.log = []
        self.reader = threading.Thread(target=lambda: self.log.extend(self.process.stderr), daemon=True)
        self.reader.start()
        return self

    def limit_files(self, size):
        resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

    def __exit__(self, *error):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError("the slave did not stop")
        finally:
            self.reader.join(timeout=PATIENCE)
            self.process.stdout.close()
            self.process.stderr.close()


def saved_modulus(folder):
    """Returns Young's modulus of the saved scene [kPa]; None: no scene is saved."""
    file = pathlib.Path(folder) / "scene.yaml"
    match = re.search(r"young_modulus: (\S+) kPa", file.read_text()) if file.exists() else None
    return float(match[1]) if match else None
