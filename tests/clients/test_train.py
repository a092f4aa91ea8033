"""Training of force networks: `python3 -m palpate.train`. Needs the built Python client (PYTHONPATH) and PyTorch."""
import contextlib
import io
import json
import math
import os
import pathlib
import sys
import tempfile
import unittest

try:
    import numpy as np
    import torch  # noqa: F401

    from palpate import train
    from palpate.training import networks
    from palpate.training.recordings import (MersenneTwister64, Recording, Stretch, parse_argument, read_recording,
                                             split_contacts, windows_of)
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh training")
    sys.exit(77)

DATA = pathlib.Path(__file__).resolve().parents[2].parent / "shared/data"


def write_recording(file, seed, contacts=6, seconds=3.0):
    """Contacts of a second whose electrodes fall in proportion to a force along -z; returns the forces."""
    random = np.random.default_rng(seed)
    t = np.arange(0, seconds * contacts, 0.01)
    phase = t % seconds
    force = np.where((phase > 1) & (phase < 2), np.sin(math.pi * (phase - 1))**2, 0.0) * random.uniform(0.5, 2, contacts)[
        (t // seconds).astype(int)]
    gains = np.linspace(20, 60, 19)
    counts = 3000 - force[:, None] * gains + random.normal(0, 0.5, (len(t), 19))
    names = ["t", *(f"E{i}" for i in range(1, 20)), "pac0", "pdc", "fx", "fy", "fz"]
    with open(file, "w", encoding="utf-8") as stream:
        print(",".join(names), file=stream)
        for i, row in enumerate(counts):
            values = [t[i], *row, 2000, 2400 + 100 * force[i], 0.1 * force[i], 0, -force[i]]
            print(",".join(f"{value:.6g}" for value in values), file=stream)
    return force


class TrainTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_train(self, *arguments):
        """Exit code, standard output, standard error."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = train.main([str(a) for a in arguments])
            except SystemExit as end:
                code = end.code
        return code, out.getvalue(), err.getvalue()

    def refusal(self, *arguments):
        code, _, err = self.run_train(*arguments, "--out", self.folder / "out")
        self.assertEqual(code, 2, err)
        self.assertFalse((self.folder / "out/network.json").exists())
        return err

    # Reference: the C++ standard, [rand.predef]: the 10000th number of a default-constructed mt19937_64.
    def test_the_split_draws_the_numbers_of_the_standard_generator(self):
        random = MersenneTwister64(5489)
        for _ in range(9999):
            random()
        self.assertEqual(random(), 9981545732273789042)

    def test_no_sample_is_in_two_parts_of_the_split(self):
        for recordings in (1, 6):
            files = [self.folder / f"{k}.csv" for k in range(recordings)]
            for k, file in enumerate(files):
                write_recording(file, k)
            read = [r for file in files for r in read_recording(parse_argument(str(file)), "", 50)]
            split = split_contacts(read, False, 1)
            parts = [{tuple(w) for w in windows_of(part, 50)} for part in (split.train, split.validation, split.test)]
            self.assertTrue(all(parts))
            samples = [{(r, i - k) for r, i in part for k in range(50)} for part in parts]
            for a in range(3):
                for b in range(a):
                    self.assertFalse(samples[a] & samples[b], split.how)

    # Reference: the formulas of FORMAT.md, written out for one window.
    def test_an_lstm_is_evaluated_as_its_file_format_says(self):
        random = np.random.default_rng(1)
        n, inputs, steps = 5, 19, 50
        kernel, bias = random.normal(0, 0.3, (inputs + n, 4 * n)), random.normal(0, 0.3, 4 * n)
        dense = (random.normal(0, 1, (n, 3)), random.normal(0, 1, 3))
        network = networks.Network("rnn_19", inputs, steps, 3, np.zeros(inputs), np.full(inputs, 2.0), np.zeros(3), np.full(3, 3.0),
                                   [(kernel, bias)], [dense], gain=1.5)
        change = random.normal(0, 2, (60, 21))
        recording = Recording("r", pathlib.Path(), np.arange(60) / 100, change, np.zeros((60, 3)), 0, 60)
        forces = networks.evaluate(network, [recording], windows_of([Stretch(0, 0, 60, 0)], steps))
        h, c = np.zeros(n), np.zeros(n)
        for x in change[-steps:, :inputs] / 2:
            i, j, f, o = np.split(np.concatenate([x, h]) @ kernel + bias, 4)
            c = c / (1 + np.exp(-f - 1)) + np.tanh(j) / (1 + np.exp(-i))
            h = np.tanh(c) / (1 + np.exp(-o))
        np.testing.assert_allclose(forces[-1], 1.5 * 3 * (h @ dense[0] + dense[1]), rtol=1e-12)

    # The force follows the electrodes, so little more than their noise can remain: 2 % of the peak.
    def test_every_kind_of_network_learns_a_force_that_follows_the_electrodes(self):
        for k in range(6):
            write_recording(self.folder / f"{k}.csv", k)
        for name, epochs in (("dnn_19", 40), ("tnn_21", 10), ("rnn_21", 10)):
            out = self.folder / name
            code, printed, err = self.run_train(self.folder, "--network", name, "--epochs", epochs, "--out", out)
            self.assertEqual(code, 0, err)
            self.assertIn("by whole recordings: train 4 recordings, validation 1 recording, test 1 recording", printed)
            file = json.loads((out / "network.json").read_text())
            self.assertLess(file["sigma"][2], 0.04, name)
            self.assertGreater(file["learnt_force"], 1)
            self.assertEqual(file["architecture"], name)
            self.assertTrue((out / "training.csv").read_text().startswith("epoch,loss,validation_loss\n1,"))

    def test_the_same_seed_gives_the_same_file(self):
        write_recording(self.folder / "a.csv", 1)
        files = []
        for out in ("one", "two"):
            self.run_train(self.folder / "a.csv", "--network", "dnn_19", "--epochs", 3, "--out", self.folder / out)
            files.append((self.folder / out / "network.json").read_bytes())
        self.assertEqual(*files)

    # A network trained on forces that are twice as large needs a gain of one half.
    def test_a_gain_adapts_a_known_network(self):
        file = self.folder / "a.csv"
        write_recording(file, 1)
        self.run_train(file, "--network", "dnn_19", "--epochs", 30, "--out", self.folder / "known")
        lines = file.read_text().splitlines()
        halves = [lines[0]] + [",".join([*cells[:-3], *(str(float(c) / 2) for c in cells[-3:])])
                               for cells in (line.split(",") for line in lines[1:])]
        (self.folder / "half.csv").write_text("\n".join(halves) + "\n")
        code, printed, err = self.run_train(self.folder / "half.csv", "--from", self.folder / "known", "--out", self.folder / "gain")
        self.assertEqual(code, 0, err)
        file = json.loads((self.folder / "gain/network.json").read_text())
        self.assertAlmostEqual(file["gain"], 0.5, delta=0.02)
        self.assertEqual(file["sigma"][:2], [0, 0])

    def test_unusable_data_are_refused_with_file_and_line(self):
        good = self.folder / "good.csv"
        write_recording(good, 1)
        lines = good.read_text().splitlines()

        def changed(name, change):
            file = self.folder / name
            file.write_text("\n".join(change(list(lines))) + "\n")
            return file

        def cell(line, column, text):
            def change(all_lines):
                cells = all_lines[line].split(",")
                cells[column] = text
                return all_lines[:line] + [",".join(cells)] + all_lines[line + 1:]
            return change

        self.assertIn("nan.csv:8: E3 = nan: expected a finite number", self.refusal(changed("nan.csv", cell(7, 3, "nan"))))
        self.assertIn("short.csv:8: 24 columns, expected 25",
                      self.refusal(changed("short.csv", lambda l: l[:7] + [l[7].rsplit(",", 1)[0]] + l[8:])))
        self.assertIn("back.csv:9: the time decreases", self.refusal(changed("back.csv", cell(8, 0, "0.001"))))
        self.assertIn("no column E7", self.refusal(changed("no.csv", cell(0, 7, "F7"))))
        self.assertIn("absent.csv: cannot be read", self.refusal(self.folder / "absent.csv"))
        self.assertIn("share samples", self.refusal(f"{good}@0:5", f"{good}@4:9"))
        self.assertIn("--network rnn_20: expected", self.refusal(good, "--network", "rnn_20"))

    @unittest.skipUnless(DATA.exists(), f"needs {DATA}")
    def test_a_network_trained_on_the_first_press_of_the_foam_tracks_the_second(self):
        folder = DATA / "seed001_rf_foam_bar"
        data = f"{folder}/rh_tactile.csv+{folder}/sensor_readings_wrench.csv"
        code, printed, err = self.run_train(f"{data}@0:9.5", "--test", f"{data}@9.5:15", "--finger", "rf", "--network", "dnn_21",
                                            "--epochs", 40, "--out", self.folder / "foam")
        self.assertEqual(code, 0, err)
        self.assertGreater(float(printed.rsplit("correlation ", 1)[1].split(",")[0]), 0.95)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    unittest.main()
