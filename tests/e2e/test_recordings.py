"""Recordings of both programs are read by an independent library, cut by kill -9, processed, played and exported."""
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import unittest
import xml.etree.ElementTree

from programs import BARE, BLOCK, MASTER, PACKAGE, ROOT, SLAVE, FolderTest, Slave, deep, overrides, read_json, read_rows, run, wait_until

SCENES = ROOT / "deploy/scenes"
HERE = pathlib.Path(__file__).resolve().parent / "recordings"
KILLS = int(os.environ.get("PALPATE_KILLS", 20))
AT_ONCE = 4


def reader():
    """Returns the folder with read.js and its packages, or None and the reason why there is none."""
    folder = ROOT / "build/npm/recordings"
    if not (folder / "node_modules/@mcap/core").is_dir():
        return None, "no @mcap/core (tests/npm.sh)"
    shutil.copy(HERE / "read.js", folder)
    return folder, ""


READER, WHY_NOT = reader()


def read(*files):
    """Returns the contents of each file as read by @mcap/core."""
    done = run("node", READER / "read.js", *files, env={**os.environ})
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return [json.loads(line) for line in done.stdout.splitlines()]


def files_of(recording):
    """Returns the recording's file, or its parts in the order of their names."""
    return [recording] if recording.exists() else sorted(recording.parent.glob(f"{recording.stem}-*{recording.suffix}"))


def as_one(parts):
    """Joins the contents of a recording's parts; without parts nothing is returned."""
    parts = parts or [{"whole": False, "topics": {}}]
    one = {**parts[-1], "topics": {}, "first": {}, "last": {}, "indexed": sum(part.get("indexed", 0) for part in parts)}
    for part in parts:
        for topic, count in part["topics"].items():
            one["topics"][topic] = one["topics"].get(topic, 0) + count
            one["first"].setdefault(topic, part["first"][topic])
            one["last"][topic] = max(one["last"].get(topic, 0), part["last"][topic])
    return one


class ReferenceWriter:
    """Writes to a file in `folder` every 50 ms, as a recorder does. Its delays show by how long the machine delays a
    recording."""
    PERIOD = 0.05  # [s]

    def __init__(self, folder):
        self.longest, self.ended = 0, threading.Event()  # longest time between two writes beyond the period [s]
        self.thread = threading.Thread(target=self.write, args=(folder / "reference",), daemon=True)
        self.thread.start()

    def write(self, file):
        last = time.time()
        with open(file, "wb", buffering=0) as out:
            while not self.ended.wait(self.PERIOD):
                out.write(bytes(100_000))
                self.longest = max(self.longest, time.time() - last - self.PERIOD)
                last = time.time()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()


class Recordings(FolderTest):
    def good(self, *command, **options):
        done = run(*command, **options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def process_again(self, recording, least):
        printed = self.good(SLAVE, "process", recording, "--out", self.out / "again")
        summary = read_json(self.out / "again/summary.json")
        self.assertGreater(summary["states"], least, printed)
        self.assertEqual(summary["different"], 0, printed)
        return summary

    def both_ends(self, scene, *settings, parts=()):
        """Records a slave and a master. The slave is killed, the master ends normally."""
        slave_file, master_file = self.out / "slave.mcap", self.out / "master.mcap"
        with Slave(SCENES / scene, *overrides(*settings), "--record", slave_file, *parts) as slave:
            self.good(MASTER, "connect", slave.address, "--duration", "3", "--record", master_file, *parts,
                      "--log", self.out / "log.csv")
            slave.stop(signal.SIGKILL)
        return slave_file, master_file

    @unittest.skipUnless(READER, WHY_NOT)
    def check_master(self, master_file, images):
        parts = read(*files_of(master_file))
        for part in parts:
            self.assertTrue(part["whole"])
            self.assertIn("version", part["notes"]["palpate.session"])
            self.assertIn("/slave/scene", part["topics"])
        seen = as_one(parts)
        self.assertEqual(seen["indexed"], sum(seen["topics"].values()))
        self.assertGreater(seen["topics"]["/master/tick"], 200)
        self.assertGreater(seen["topics"]["/slave/state"], 20)
        self.assertGreater(seen["topics"]["/master/command"], 20)
        self.assertEqual("/slave/image" in seen["topics"], images)
        self.assertIn("foxglove.CompressedImage", seen["schemas"])
        return seen

    def check_slave(self, slave_file):
        """Checks the recording of the killed slave up to its end."""
        if not READER:
            return
        seen = as_one(read(*files_of(slave_file)))
        self.assertFalse(seen["whole"])
        self.assertGreater(seen["topics"]["/slave/sense"], 15)
        self.assertTrue(any(name.endswith(".yaml") for name in seen["attachments"]))

    def test_a_camera(self):
        """The recording has parts of one second; all of them are read under its one name."""
        slave_file, master_file = self.both_ends("silicone-block.yaml", "model.elements=60", "operator.press.depth=2 mm",
                                                 parts=("--record-part", "1"))
        self.assertGreater(len(files_of(slave_file)), 1)
        self.assertGreater(len(files_of(master_file)), 1)
        self.process_again(slave_file, 5)
        self.check_slave(slave_file)
        seen = self.check_master(master_file, True)
        seconds = seen["last"]["/master/tick"] - seen["first"]["/master/tick"]
        self.assertLess(sum(file.stat().st_size for file in files_of(master_file)) / seconds * 3600, 1e9, "an hour in a GB")
        self.export(master_file, seen)

    @deep
    def test_points(self):
        slave_file, master_file = self.both_ends("rubber-membrane.yaml", "operator.press.depth=0.5 mm")
        self.process_again(slave_file, 5)
        self.check_slave(slave_file)
        self.check_master(master_file, True)

    def test_fingertips(self):
        slave_file, master_file = self.both_ends("foam-cube.yaml", "operator.press.depth=2 mm")
        self.process_again(slave_file, 5)
        self.check_slave(slave_file)
        self.check_master(master_file, False)

    @staticmethod
    def is_same(kept, logged):
        """Returns whether two values are equal to seven digits."""
        return kept == logged or abs(float(kept) - float(logged)) <= 1e-6 * abs(float(logged)) + 1e-12

    def export(self, master_file, seen):
        sys.path.insert(0, str(PACKAGE))
        try:
            from palpate.export import export
        except ImportError:
            return  # python3-numpy or python3-protobuf is not installed
        ticks, _ = export(master_file, self.out / "exported")
        self.assertEqual(ticks, seen["topics"]["/master/tick"])
        images = list((self.out / "exported/images").iterdir())
        self.assertEqual(len(images), seen["topics"]["/slave/image"])
        self.assertTrue(all(image.read_bytes().startswith(b"\xff\xd8") for image in images), "JPEG")
        meshes = list((self.out / "exported/meshes").iterdir())
        self.assertEqual(len(meshes), seen["topics"]["/slave/mesh"])
        for mesh in meshes:
            xml.etree.ElementTree.parse(mesh)
        logged, rows = read_rows(self.out / "log.csv"), read_rows(self.out / "exported/ticks.csv")
        self.assertEqual(len(rows), len(logged))
        for row, tick in zip(rows, logged):
            for name, column in (("force_x", "sent_x"), ("force_y", "sent_y"), ("p_M_y", "p_M_y"), ("p_S_y", "p_S_y")):
                self.assertTrue(self.is_same(row[name], tick[column]), (name, tick["t"], tick[column], row[name]))

    @unittest.skipUnless(READER, WHY_NOT)
    def test_a_master_killed_at_any_moment_loses_the_last_second_at_most(self):
        seed = random.randrange(1 << 32)
        chance = random.Random(seed)
        with Slave(BLOCK, *overrides("model.elements=60")) as slave, ReferenceWriter(self.out) as reference:
            for first in range(0, KILLS, AT_ONCE):
                victims = []
                for number in range(first, min(first + AT_ONCE, KILLS)):
                    file = self.out / f"{number}.mcap"
                    parts = ["--record-part", "1"] if number % 2 else []
                    with open(file.with_suffix(".output"), "w") as printed:
                        process = subprocess.Popen([MASTER, "connect", slave.address, "--record", file, *parts], env=BARE,
                                                   stdin=subprocess.DEVNULL, stdout=printed, stderr=subprocess.DEVNULL)
                    victims.append((chance.uniform(0.3, 1.5), process, file))
                began = time.time()
                killed = {}
                for moment, process, file in sorted(victims, key=lambda victim: victim[0]):
                    time.sleep(max(0, began + moment - time.time()))
                    self.assertIsNone(process.poll())
                    killed[file] = time.time()
                    process.kill()
                    process.wait()
                found = {seen["file"]: seen for seen in read(*(part for file in killed for part in files_of(file)))}
                for file, moment in killed.items():
                    seen = as_one([found[str(part)] for part in files_of(file)])
                    self.assertFalse(seen["whole"])
                    if "/master/tick" not in seen["topics"]:
                        reported = re.findall(r"^ *([\d.]+) s ", file.with_suffix(".output").read_text(), re.MULTILINE)
                        self.assertFalse([t for t in reported if float(t) > 1 + reference.longest], f"seed {seed}: nothing was kept of a second and more")
                        continue
                    self.assertGreater(seen["last"]["/master/tick"], moment - 1 - reference.longest, f"seed {seed}")
                    length = seen["last"]["/master/tick"] - seen["first"]["/master/tick"]
                    self.assertGreater(seen["topics"]["/master/tick"], 0.1 * 1000 * length)

    def test_what_is_no_recording_is_refused(self):
        file = self.out / "none.mcap"
        file.write_bytes(b"not a recording")
        for command in ((MASTER, "replay", file), (SLAVE, "process", file, "--out", self.out / "x")):
            done = run(*command)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("expected a recording", done.stderr)
        for limit in ("0", "much"):
            done = run(SLAVE, "serve", BLOCK, "--record", self.out / "a.mcap", "--record-limit", limit)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("--record-limit", done.stderr)

    def test_a_limit_or_a_full_disk_ends_the_recording_and_nothing_else(self):
        """/dev/full is refused at once; a limit of the file's size acts as a disk that fills up."""
        done = run(MASTER, "connect", "127.0.0.1:1", "--record", "/dev/full")
        self.assertEqual(done.returncode, 2, done.stderr)
        file = self.out / "small.mcap"
        with Slave(BLOCK, *overrides("model.elements=60")) as slave:
            done = run(MASTER, "connect", slave.address, "--duration", "2", "--record", file, "--record-limit", "150 kB")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("has reached its limit of 150 kB", done.stderr)
            full = [str(word) for word in (MASTER, "connect", slave.address, "--duration", "2", "--record", self.out / "full.mcap")]
            done = run("sh", "-c", 'trap "" XFSZ; ulimit -f 200; exec "$@"', "sh", *full)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("cannot be written: File too large", done.stderr)
            self.assertIn("FOLLOWING", done.stdout)
            self.assertEqual(slave.stop(), 0, slave.log)
        self.assertLessEqual(file.stat().st_size, 150_000)

    def test_a_slave_whose_disk_fills_up_reports_it_to_its_clients(self):
        serve = [str(word) for word in (SLAVE, "serve", BLOCK, "--listen", "127.0.0.1:0", *overrides("model.elements=60"),
                                        "--record", self.out / "full.mcap")]
        with Slave(command=["sh", "-c", 'trap "" XFSZ; ulimit -f 8000; exec "$@"', "sh", *serve]) as slave:
            def reported():
                return "full.mcap: the recording has ended: it cannot be written: File too large" in run(
                    MASTER, "doctor", slave.address, "--seconds", "0.1").stdout
            self.assertTrue(wait_until(reported))
            self.assertEqual(slave.stop(), 0, slave.log)
        self.process_again(self.out / "full.mcap", 0)

    def test_an_existing_recording_stays(self):
        file = self.out / "a.mcap"
        with Slave(BLOCK, *overrides("model.elements=60")) as slave:
            printed = [self.good(MASTER, "connect", slave.address, "--duration", "1", "--record", file) for _ in range(2)]
        self.assertIn(f"recording to {file}\n", printed[0])
        self.assertIn(f"recording to {self.out / 'a-2.mcap'}\n", printed[1])
        kept = {name: (self.out / name).read_bytes() for name in ("a.mcap", "a-2.mcap")}
        with Slave(BLOCK, *overrides("model.elements=60"), "--record", file) as slave:
            self.assertEqual(slave.stop(), 0, slave.log)
        self.assertIn(f"recording to {self.out / 'a-3.mcap'}, ", slave.log)
        self.assertGreater((self.out / "a-3.mcap").stat().st_size, 0)
        for name, content in kept.items():
            self.assertEqual((self.out / name).read_bytes(), content, name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
