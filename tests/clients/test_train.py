"""Training of force networks: `python3 -m palpate.train`. Needs the built Python client (PYTHONPATH) and PyTorch."""
import contextlib
import io
import json
import math
import os
import pathlib
import re
import sys
import tempfile
import unittest
import zipfile

try:
    import numpy as np
    import torch  # noqa: F401

    from palpate import train
    from palpate.training import networks, quadratic
    from palpate.training.recordings import (MersenneTwister64, Recording, Sensor, Stretch, Table, parse_argument, read_recording,
                                             split_contacts, windows_of)
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh training")
    sys.exit(77)

DATA = pathlib.Path(__file__).resolve().parents[2].parent / "shared/data"


def write_recording(file, seed, contacts=6, seconds=3.0):
    """Writes contacts of one second, whose electrodes fall in proportion to a force along -z. Returns the forces."""
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
        """Returns exit code, standard output and standard error."""
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

    # The force is a function of the electrodes, so only their noise limits the error: 2 % of the peak.
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
        self.assertIn("share samples", self.refusal(f"{good}@0:9", "--test", f"{good}@8:15"))
        self.assertIn("--network rnn_20: expected", self.refusal(good, "--network", "rnn_20"))

    def write_channels(self, name, count, seed, contacts=8):
        """Writes channels in proportion to a normal force along -z, one of them quadratic in it."""
        random = np.random.default_rng(seed)
        t = np.arange(0, 3.0 * contacts, 0.01)
        phase = t % 3.0
        force = np.where(phase > 1, np.sin(math.pi * (phase - 1) / 2)**2, 0.0) * random.uniform(0.5, 2, contacts)[(t // 3).astype(int)]
        values = 5 + force[:, None] * np.linspace(1, 2, count) + random.normal(0, 0.01, (len(t), count))
        values[:, 0] += 0.1 * force**2
        rows = ["t," + ",".join(f"c{i}" for i in range(1, count + 1)) + ",fx,fy,fz"]
        rows += [",".join(f"{x:.6g}" for x in (t[k], *values[k], 0, 0, -force[k])) for k in range(len(t))]
        file = self.folder / name
        file.write_text("\n".join(rows) + "\n")
        return file

    # The force is a function of the channels, whose noise is equivalent to 5 to 10 mN each: the error is at most 2 % of
    # the peak.
    def test_any_number_of_channels_gives_the_force_that_they_follow(self):
        for count in (1, 16, 256):
            file = self.write_channels("a.csv", count, count)
            code, printed, err = self.run_train(file, "--unit", "kPa", "--out", self.folder / "net")
            self.assertEqual(code, 0, err)
            network = json.loads((self.folder / "net/network.json").read_text())
            self.assertEqual((network["architecture"], network["unit"]), (f"qnn_{count}", "kPa"))
            self.assertLess(network["sigma"][2], 0.04, printed)
            self.assertAlmostEqual(network["noise"], 0.01, delta=0.003)
            channels = network["channels"]
            self.assertEqual(np.shape(channels["expectation"]), (count, count))
            self.assertEqual({len(channels[key]) for key in ("tolerance", "below", "above", "second_difference")}, {count})
            self.assertNotIn("baseline", channels, "one recording does not tell how baselines differ")
            self.assertTrue(0 < network["drift"] < 0.1)
            self.assertLess(network["longest_constant"], 0.2)

    def test_wrong_channels_are_refused_with_line_and_column(self):
        good = self.write_channels("good.csv", 4, 1)
        lines = good.read_text().splitlines()

        def refused(text, *arguments):
            file = self.folder / "bad.csv"
            file.write_text("\n".join(text) + "\n")
            return self.refusal(file, *arguments, "--unit", "kPa")

        header = lines[0]
        self.assertIn("bad.csv:1: no column c3: expected all up to 4", refused([header.replace("c3", "d3"), *lines[1:]]))
        self.assertIn("bad.csv:1: column c2 [Pa]: expected the unit [kPa]", refused([header.replace("c2", "c2 [Pa]"), *lines[1:]]))
        cells = lines[7].split(",")
        cells[3] = ""
        self.assertIn("bad.csv:8: c3 = nothing: expected a finite number", refused([*lines[:7], ",".join(cells), *lines[8:]]))
        self.assertIn("good.csv: 4 channels: expected 5 as in", refused(self.write_channels("five.csv", 5, 1).read_text()
                                                                        .splitlines(), good))
        # Samples of the training may not be used for the test, even if the file is named by another path.
        other = good.parent / "." / ".." / good.parent.name / good.name
        self.assertIn("share samples", self.refusal(good, "--test", other, "--unit", "kPa"))
        self.assertIn("share samples", self.refusal(f"{good}@0:9", "--test", f"{good}@8:15", "--unit", "kPa"))
        self.assertIn("--network: not with --unit", self.refusal(good, "--unit", "kPa", "--network", "all"))
        self.assertIn("--from: not with --unit", self.refusal(good, "--unit", "kPa", "--from", self.folder))
        self.assertIn("--normal scale: expected COLUMN=FACTOR", refused(lines, "--normal", "scale"))

    def changed(self, name, file, change, header=lambda names: names):
        """Writes a changed copy of a table. `change` gets the rows of numbers and the index of each column by name."""
        names, *rows = file.read_text().splitlines()
        values = np.array([[float(cell) for cell in row.split(",")] for row in rows])
        columns = {title: i for i, title in enumerate(names.split(","))}
        change(values, columns)
        other = self.folder / name
        other.write_text("\n".join([header(names), *(",".join(f"{x:.6g}" for x in row) for row in values)]) + "\n")
        return other

    def test_forces_of_the_reaction_and_a_beginning_in_contact_are_refused(self):
        good = self.write_channels("good.csv", 4, 1)

        def reverse(values, columns):
            values[:, columns["fz"]] *= -1
        printed = self.refusal(self.changed("reaction.csv", good, reverse), "--unit", "kPa")
        self.assertIn("reaction.csv: contacts have fz > 0", printed)
        self.assertIn("fingertip on the object", printed)

        def touch(values, columns):
            values[:20, columns["fz"]] -= 1
        printed = self.refusal(self.changed("touched.csv", good, touch), "--unit", "kPa")
        self.assertIn("touched.csv: the force changes by", printed)
        self.assertIn("--rest", printed)

    def test_channels_are_counted_from_one(self):
        good = self.write_channels("good.csv", 4, 1)

        def from_zero(names):
            for k in range(1, 5):
                names = names.replace(f"c{k}", f"c{k - 1}")
            return names
        printed = self.refusal(self.changed("zero.csv", good, lambda *_: None, from_zero), "--unit", "kPa")
        self.assertIn("zero.csv:1: column c0: channels are counted from c1", printed)

    def test_names_that_occur_twice_are_refused(self):
        good = self.write_channels("good.csv", 4, 1)
        for name, other in (("c4", "c3"), ("fx", "fz"), ("c4", "t")):
            twice = self.changed("twice.csv", good, lambda *_: None, lambda names: names.replace(name, other))
            self.assertRegex(self.refusal(twice, "--unit", "kPa"), r"twice.csv:1: column \w+ (occurs twice|is a second fz)")

    def test_a_force_in_another_unit_is_converted_where_it_is_named_and_remarked_where_not(self):
        good = self.write_channels("good.csv", 4, 1)

        def thousandfold(values, columns):
            values[:, columns["fz"]] *= 1000
        newtons = self.changed("newtons.csv", good, thousandfold)
        code, _, err = self.run_train(newtons, "--unit", "kPa", "--out", self.folder / "newtons")
        self.assertEqual(code, 0, err)
        peak = json.loads((self.folder / "newtons/network.json").read_text())["learnt_force"]
        self.assertIn(f"in millinewtons these are {1e-3 * peak:.4g} N", err)
        self.assertIn("fx [mN]", err)
        named = self.changed("named.csv", good, thousandfold, lambda names: re.sub(r"\b(f[xyz])\b", r"\1 [mN]", names))
        code, _, err = self.run_train(named, "--unit", "kPa", "--out", self.folder / "named")
        self.assertEqual((code, err), (0, ""))
        self.assertAlmostEqual(json.loads((self.folder / "named/network.json").read_text())["learnt_force"], 1e-3 * peak, places=5)
        grams = self.changed("grams.csv", good, lambda *_: None, lambda names: names.replace("fz", "fz (g)"))
        self.assertIn("grams.csv:1: column fz (g): expected a force in N, mN", self.refusal(grams, "--unit", "kPa"))

    def test_times_in_another_unit_are_named(self):
        good = self.write_channels("good.csv", 4, 1)
        for unit, size in (("nanoseconds", 1e-9), ("milliseconds", 1e-3)):
            def scaled(values, columns):
                values[:, columns["t"]] /= size
            printed = self.refusal(self.changed("scaled.csv", good, scaled), "--unit", "kPa")
            self.assertIn(f"scaled.csv: a sample every {0.01 / size:.3g} s", printed)
            self.assertIn(f"in {unit} this would be 0.01 s", printed)

    def test_a_file_of_another_program_is_named(self):
        book = self.folder / "test.xlsx"
        with zipfile.ZipFile(book, "w") as archive:
            archive.writestr("[Content_Types].xml", "<Types/>")
        self.assertIn("test.xlsx: a workbook (.xlsx): save the table as CSV", self.refusal(book, "--unit", "kPa"))

    # Reference: the scale under the sensor. The trials differ: a linear fit to one has an error of 0.76 N and more on
    # the other.
    @unittest.skipUnless((DATA / "tactile_eflesh").exists(), f"needs {DATA}/tactile_eflesh")
    def test_a_magnetic_sensor_trained_on_one_trial_measures_the_other(self):
        for first, second in ((1, 2), (2, 1)):
            one, other = (DATA / f"tactile_eflesh/normal_trial{k}.csv" for k in (first, second))
            options = ("--unit", "uT", "--channels", "m", "--sample-rate", 14, "--rest", 10, "--normal", "scale_g=-9.80665e-3")
            code, _, err = self.run_train(one, *options, "--out", self.folder / "magnets")
            self.assertEqual(code, 0, err)
            network = networks.read_network(self.folder / "magnets")
            sensor = Sensor("uT", "m", 14.0, ("scale_g", -9.80665e-3))
            table = Table(other)
            weighed = set(table.without_empty(table.find("scale_g")).times())
            errors, sigmas = [], []
            for r in read_recording(parse_argument(str(other)), "", 10, sensor):
                estimated = quadratic.features(r.change / network.input_scale) @ network.dense[0][0]
                rows = np.array([t in weighed for t in r.t])
                errors.append((estimated - r.force)[rows, 2])
                sigmas.append(np.hypot(network.rest_sigma, network.law.at(np.linalg.norm(estimated, axis=1)))[rows])
            error, sigma = np.abs(np.concatenate(errors)), np.concatenate(sigmas)
            self.assertGreater(len(error), 1500)
            self.assertLess(math.sqrt((error**2).mean()), 0.8)
            self.assertTrue(0.63 < (error < sigma).mean() < 0.73, (error < sigma).mean())
            self.assertTrue(0.90 < (error < 2 * sigma).mean() < 0.99, (error < 2 * sigma).mean())

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
