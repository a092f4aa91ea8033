#!/usr/bin/env python3
"""A study in shards: killed, repeated and merged, it is the study of one run. The examples of deploy/studies run, too."""
import json
import pathlib
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

from programs import BARE, BIN, PATIENCE, ROOT, SLAVE, run

# Wide against the object, so that few elements fit the tool: 27 models take some seconds.
SCENE = """name: wide-tool
object:
  geometry:
    rectangle: {width: 60 mm, height: 40 mm, thickness: 10 mm}
  material: {young_modulus: 40 kPa, poisson_ratio: 0.45}
  fixed: {side: bottom}
tool: {shape: flat, width: 30 mm}
operator: {press: {depth: 2 mm, speed: 20 mm/s}}
model: {kind: auto, plane: stress, tolerance: 2 %, rate: 1 kHz}
"""
SHARDS = 8
# Sums of several threads differ in their last digits from run to run.
ENVIRONMENT = {**BARE, "OPENBLAS_NUM_THREADS": "1"}
# Times, and what the rows are judged by them.
TIMES = {"update_s", "precompute_s", "expected_s", "on_front", "meets_rate", "recommended", "recommendation"}
TIME_COLUMNS = {"update_median_s", "update_p99_s", "precompute_s", "expected_s", "on_front", "meets_rate", "recommended"}


def without_times(json_value):
    if isinstance(json_value, dict):
        return {name: without_times(value) for name, value in json_value.items() if name not in TIMES}
    return [without_times(value) for value in json_value] if isinstance(json_value, list) else json_value


class Shards(unittest.TestCase):
    """A scene, and its study by one run."""
    text = SCENE

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.scene = cls.folder / "scene.yaml"
        cls.scene.write_text(cls.text)
        begun = time.monotonic()
        done = run(SLAVE, "study", cls.scene, "--out", cls.folder / "whole", env=ENVIRONMENT)
        cls.seconds = time.monotonic() - begun
        assert done.returncode == 0, done.stderr
        cls.table = done.stdout

    def study(self, *options):
        return run(SLAVE, "study", self.scene, *options, env=ENVIRONMENT)

    def shard(self, index, out, *options):
        done = self.study("--shard", f"{index}/{SHARDS}", "--out", out, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def expect_whole(self, out):
        """Every file of the merged study is that of the whole one, apart from times."""
        whole = self.folder / "whole"
        ours, theirs = (json.loads((folder / "study.json").read_text()) for folder in (out, whole))
        self.assertTrue(ours["complete"])
        self.assertGreater(len(ours["rows"]), 20)
        self.assertEqual(without_times(ours), without_times(theirs))
        tables = []
        for folder in (out, whole):
            lines = [line.split(",") for line in (folder / "study.csv").read_text().splitlines()]
            keep = [i for i, name in enumerate(lines[0]) if name not in TIME_COLUMNS]
            tables.append([[line[i] for i in keep] for line in lines])
        self.assertEqual(*tables)
        drawings = [xml.etree.ElementTree.parse(folder / "study.svg") for folder in (out, whole)]
        titles = [sorted(re.sub(r"[:,].*", "", node.text or "") for node in drawing.iter("{http://www.w3.org/2000/svg}title"))
                  for drawing in drawings]
        self.assertEqual(*titles)
        self.assertGreater(len(titles[0]), 20)


class Study(Shards):
    def kill_at_random(self, chance, out):
        """SIGKILL while the shard with the most work runs.."""
        index = (len(json.loads((self.folder / "whole/study.json").read_text())["rows"]) - 1) % SHARDS + 1
        file = out / f"shard-{index}-of-{SHARDS}.json"
        longest = self.seconds / 4
        while True:
            process = subprocess.Popen([SLAVE, "study", self.scene, "--shard", f"{index}/{SHARDS}", "--out", out],
                                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=ENVIRONMENT)
            try:
                process.wait(timeout=chance.uniform(0, longest))
            except subprocess.TimeoutExpired:
                process.kill()
            was_killed = process.wait() == -signal.SIGKILL
            if was_killed and not file.exists():
                return
            json.loads(file.read_text())  # it was faster: the file is whole
            file.unlink()
            longest /= 2

    def test_a_shard_that_is_killed_twice_and_repeated_ends_with_the_same_study(self):
        out = self.folder / "killed"
        seed = random.randrange(2**32)
        with self.subTest(seed=seed):
            chance = random.Random(seed)
            for _ in range(2):
                self.kill_at_random(chance, out)
            for index in range(1, SHARDS + 1):
                self.shard(index, out)
            done = self.study("--merge", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.expect_whole(out)
            models = [sorted(re.findall(r"^(bem2d \w+ +\d+ elements)", table, re.MULTILINE)) for table in (done.stdout, self.table)]
            self.assertEqual(*models)

    def test_a_stopped_shard_continues_and_a_finished_one_does_nothing(self):
        out = self.folder / "stopped"
        process = subprocess.Popen([SLAVE, "study", self.scene, "--shard", "1/1", "--out", out], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=ENVIRONMENT, text=True)
        partial, file = out / "shard-1-of-1.json.partial", out / "shard-1-of-1.json"
        end = time.monotonic() + PATIENCE
        while not partial.exists() and time.monotonic() < end:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        printed, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual((process.returncode, file.exists()), (1, False), printed)
        done = self.study("--shard", "1/1", "--out", out)
        before = int(re.search(r"(\d+) of them measured before", done.stdout).group(1))
        self.assertGreater(before, 0)
        self.assertFalse(partial.exists())
        bytes_before = file.read_bytes()
        self.assertIn("was done before", self.study("--shard", "1/1", "--out", out).stdout)
        self.assertEqual(file.read_bytes(), bytes_before)
        self.assertEqual(self.study("--merge", out, "--out", out / "merged").returncode, 0)
        self.expect_whole(out / "merged")

    def test_what_does_not_belong_together_is_refused_by_name(self):
        out = self.folder / "mixed"
        few = ("--override", "model.kind=bem2d", "--override", "model.elements=30", "--budget", "9")
        for index in (1, 2, 4):
            done = self.study("--shard", f"{index}/4", "--out", out, *few)
            self.assertEqual(done.returncode, 0, done.stderr)

        def refused(*options, words):
            done = self.study(*options)
            self.assertEqual((done.returncode, done.stdout), (2, ""), options)
            self.assertIn(words, done.stderr)

        merge = ("--merge", out, *few[:4])
        refused(*merge, words="missing are the shards 3/4")
        (out / "shard-3-of-4.json.partial").write_text("")
        refused(*merge, words="missing are the shards 3/4 (not finished)")
        self.assertEqual(self.study("--shard", "3/4", "--out", out, *few[:4], "--budget", "8").returncode, 0)
        refused(*merge, words="shard-3-of-4.json: budget = 8 s: expected 9 s")
        self.assertEqual(self.study("--shard", "3/4", "--out", out, *few).returncode, 0, "another one is replaced")
        self.assertEqual(self.study(*merge).returncode, 0)
        refused("--merge", out, *few[:2], words="overrides = model.kind=bem2d, model.elements=30: expected model.kind=bem2d")
        whole = self.scene.read_text()
        self.addCleanup(self.scene.write_text, whole)
        self.scene.write_text(whole.replace("40 kPa", "50 kPa"))
        refused(*merge, words="shard-1-of-4.json: scene = wide-tool")
        self.scene.write_text(whole)
        shutil.copy(out / "shard-1-of-4.json", out / "shard-1-of-5.json")
        refused(*merge, words="found shards of 4 and of 5")
        (out / "shard-1-of-5.json").unlink()
        (out / "shard-2-of-4.json").write_text("{}")
        refused(*merge, words="shard-2-of-4.json: expected a file of study --shard")
        for wrong in ("0/8", "9/8", "1", "1/0", "-1/8", "1/8/2", "a/b", "1.5/8"):
            refused("--shard=" + wrong, "--out", self.folder / "none", words="expected i/n with 1 <= i <= n")
        refused("--merge", self.folder / "none", words="expected a folder with files of study --shard")
        refused("--shard", "1/8", "--merge", out, "--out", out, words="excludes")
        refused("--shard", "1/8", words="--out is required")
        self.assertFalse((self.folder / "none").exists())


class Examples(Shards):
    text = SCENE.replace("kind: auto", "kind: bem2d")

    def example(self, *command, **variables):
        done = run(*command, env={**BARE, "PATH": f"{BIN}:{BARE['PATH']}", "HOME": str(self.folder), **variables}, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def test_slurm_array(self):
        """Without Slurm: each task of the array, then two of them again."""
        script = ROOT / "deploy/studies/study.sbatch"
        first, last = re.search(r"^#SBATCH --array=(\d+)-(\d+)$", script.read_text(), re.MULTILINE).groups()
        out = self.folder / "slurm"
        for task in [*range(int(first), int(last) + 1), 3, 7]:
            self.example("bash", script, self.scene, out, SLURM_ARRAY_TASK_ID=str(task))
        self.assertEqual(self.study("--merge", out).returncode, 0)
        self.expect_whole(out)

    @unittest.skipUnless(shutil.which("parallel", path=BARE["PATH"]), "no parallel (deploy/install.sh studies)")
    def test_gnu_parallel(self):
        out = self.folder / "with parallel"
        self.example(ROOT / "deploy/studies/study_parallel.sh", self.scene, out, 3, 2)
        self.expect_whole(out)
        (out / "shard-2-of-3.json").unlink()
        self.assertEqual(self.example(ROOT / "deploy/studies/study_parallel.sh", self.scene, out, 3).stdout.count("was done before"), 2)
        self.expect_whole(out)

    @unittest.skipUnless(shutil.which("snakemake", path=BARE["PATH"]), "no snakemake (deploy/install.sh studies)")
    def test_snakemake(self):
        out = self.folder / "with snakemake"
        command = ("snakemake", "-s", ROOT / "deploy/studies/Snakefile", "--cores", "2", "--config", f"scene={self.scene}", f"out={out}", "shards=3")
        self.example(*command)
        self.expect_whole(out)
        for lost in ("shard-2-of-3.json", "study.json"):
            (out / lost).unlink()
        again = self.example(*command)
        self.assertRegex(again.stderr, r"shard\s+1\s")
        self.expect_whole(out)


if __name__ == "__main__":
    unittest.main(verbosity=2)
