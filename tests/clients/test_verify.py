"""python3 -m palpate.verify with tables, with wrench topics of MCAP and rosbag2, with joined topics and with invalid
input. Needs PYTHONPATH.

The forces are synthetic, so each test knows the fault of the estimate.
"""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import bags  # noqa: E402

try:
    import palpate._core  # noqa: F401
    from palpate import verify
    from palpate.wrench_topics import join, read_topics
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh tests")
    sys.exit(77)

START = 1_700_000_000 * 10**9
COLUMNS = [f"{w}_f{a}" for w in ("measured", "estimated") for a in "xyz"]


def forces(count=600, seed=3):
    """Returns times [s], a smooth force, and an estimate with errors of 20 mN."""
    t = np.arange(count) * 0.02
    force = np.column_stack([2 * np.sin(1.1 * t), 1.5 * np.cos(1.7 * t), 2 * np.sin(0.6 * t) - 1])
    return t, force, force + 0.02 * np.random.default_rng(seed).normal(size=force.shape)


def messages(topic, kind, times, rows, sigma=0.03, **options):
    stamps = START + np.round(1e9 * np.asarray(times)).astype(np.int64)
    return [(topic, kind, int(t), bags.wrench(kind, int(t), row, sigma, **options)) for t, row in zip(stamps, rows)]


class VerifyTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def run_verify(self, *arguments):
        """Returns exit code, output, errors and the report's only card; None: none was written."""
        out, errors, report = io.StringIO(), io.StringIO(), self.folder / "report.json"
        report.unlink(missing_ok=True)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            code = verify.main([*map(str, arguments), "--json", str(report)])
        return code, out.getvalue(), errors.getvalue(), json.loads(report.read_text())["cards"][0] if report.exists() else None

    def wrong(self, *arguments):
        code, _, errors, card = self.run_verify(*arguments)
        self.assertIn(code, (0, 1), errors)
        return {key for key, line in card["lines"].items() if line["verdict"] == "wrong"}, card

    def refused(self, pattern, *arguments):
        code, _, errors, card = self.run_verify(*arguments)
        self.assertEqual((code, card), (2, None))
        self.assertRegex(errors, pattern)

    def table(self, t, measured, estimated, name="forces.csv", time="t"):
        np.savetxt(self.folder / name, np.column_stack([t, measured, estimated]), fmt="%.17g", delimiter=",",
                   header=",".join([time, *COLUMNS]), comments="")
        return self.folder / name

    def test_a_table_as_text_json_and_page(self):
        t, measured, estimated = forces()
        code, text, errors, card = self.run_verify(self.table(t, measured, estimated), "--html", self.folder / "card.html")
        self.assertEqual((code, errors), (0, ""))
        self.assertIn("Tool: passes", text)
        self.assertTrue(card["passes"])
        page = (self.folder / "card.html").read_text()
        self.assertIn("magnitude", page)
        self.assertNotIn("http", page)
        code, text, _, _ = self.run_verify(self.table(t, measured, 1.5 * estimated), "--html", self.folder / "card.html")
        self.assertEqual(code, 1)
        self.assertIn("likely wrong", text)
        self.assertRegex((self.folder / "card.html").read_text(), 'class="wrong"')

    def test_parquet_is_read_where_pyarrow_is_installed(self):
        t, measured, estimated = forces()
        table, columnar = self.table(t, measured, -estimated), self.folder / "forces.parquet"
        try:
            from pyarrow import csv, parquet
        except ImportError:
            columnar.write_bytes(b"PAR1")
            self.refused("forces.parquet: pyarrow, which reads Parquet, is not installed: expected CSV", columnar)
            return
        parquet.write_table(csv.read_csv(table), columnar)
        self.assertEqual(self.wrong(columnar)[1], self.wrong(table)[1])
        self.assertEqual(self.wrong(columnar)[0], {"sign"})
        columnar.write_bytes(b"PAR1 and no more")
        self.refused("forces.parquet", columnar)

    def test_nanoseconds_in_a_table(self):
        t, measured, estimated = forces()
        late = np.column_stack([np.interp(t - 0.2, t, column) for column in estimated.T])
        found, card = self.wrong(self.table(1.7e18 + np.round(1e9 * t), measured, late, time="stamp"), "--time", "stamp", "--time-unit", "ns")
        self.assertIn("delay", found)
        self.assertAlmostEqual(card["lines"]["delay"]["low_value_high"][1], 0.2, delta=0.02)

    def test_two_topics_of_one_file(self):
        t, measured, estimated = forces()
        for chunked in (False, True):
            bags.write_mcap(self.folder / "run.mcap", messages("/sensor", bags.STAMPED, t, measured) +
                            messages("/estimate", bags.CONTACT, t, estimated), chunked=chunked)
            found, card = self.wrong(self.folder / "run.mcap", "--measured", "/sensor", "--estimated", "/estimate")
            self.assertEqual(found, set())
            self.assertNotEqual(card["lines"]["sigma"]["verdict"], "not tested")  # sigma is in the ContactWrench
        # The other topic is the estimate.
        self.assertEqual(self.wrong(self.folder / "run.mcap", "--measured", "/sensor")[0], set())

    def test_a_wrench_on_the_object_has_the_other_sign(self):
        t, measured, estimated = forces()
        bags.write_mcap(self.folder / "object.mcap", messages("/sensor", bags.STAMPED, t, measured) +
                        messages("/estimate", bags.CONTACT, t, -estimated, acts_on=2))
        self.assertEqual(self.wrong(self.folder / "object.mcap", "--measured", "/sensor", "--estimated", "/estimate")[0], set())

    def test_topics_of_different_times_are_joined(self):
        t, measured, estimated = forces()
        dense = np.arange(0, t[-1], 0.003)
        sensor = np.column_stack([np.interp(dense, t, column) for column in measured.T])
        bag = self.folder / "bag"
        bag.mkdir()
        bags.write_db3(bag / "bag_0.db3", messages("/sensor", bags.PLAIN, dense, sensor))
        bags.write_mcap(self.folder / "estimate.mcap", messages("/estimate", bags.STAMPED, t, -estimated, order=">"))
        found, card = self.wrong(bag, self.folder / "estimate.mcap")
        self.assertEqual(found, {"sign"})
        self.assertGreater(card["states"], 500)

    def test_the_join_is_linear_and_leaves_out_gaps(self):
        t = np.array([0.0, 1.0, 2.0, 3.0, 20.0, 21.0])
        ramp = np.column_stack([t, 2 * t, -t])
        bags.write_mcap(self.folder / "a.mcap", messages("/a", bags.STAMPED, t, ramp))
        at = np.array([-1.0, 0.0, 0.25, 1.5, 10.0, 20.0, 20.5, 22.0])
        bags.write_mcap(self.folder / "b.mcap", messages("/b", bags.CONTACT, at, np.zeros((8, 3)), validity=2))
        joined = join(read_topics(self.folder / "a.mcap")["/a"], read_topics(self.folder / "b.mcap")["/b"])
        np.testing.assert_allclose(joined["measured"][:, 0], [0, 0.25, 1.5, 20, 20.5], atol=1e-9)
        np.testing.assert_allclose(joined["t"] - joined["t"][0], [0, 0.25, 1.5, 20, 20.5], atol=1e-9)
        self.assertEqual((joined["valid"].any(), joined["sigma"][0]), (False, 0.03))

    def test_messages_without_a_time_are_left_out(self):
        t, measured, estimated = forces()
        early = [(topic, kind, 0, bags.wrench(kind, 0, row, 0.03)) for topic, kind, _, row in
                 (("/sensor", bags.STAMPED, 0, row) for row in measured[:40])]
        bags.write_mcap(self.folder / "run.mcap", early + messages("/sensor", bags.STAMPED, t, measured) +
                        messages("/estimate", bags.CONTACT, t, estimated))
        code, _, errors, card = self.run_verify(self.folder / "run.mcap", "--measured", "/sensor", "--estimated", "/estimate")
        self.assertEqual((code, card["passes"]), (0, True), errors)
        self.assertIn("/sensor: 40 messages without a time are left out", errors)

    def test_what_is_refused(self):
        t, measured, estimated = forces(100)
        table = self.table(t, measured, estimated)
        self.refused("empty.csv:1: no row", self.table(t[:0], measured[:0], estimated[:0], "empty.csv"))
        stamped = np.concatenate([[0, 0], 1.7e9 + t[2:]])
        self.refused("zero.csv:4: t jumps from 0", self.table(stamped, measured, estimated, "zero.csv"))
        self.refused("no such file", self.folder / "nothing.csv")
        self.refused("forces.csv:1: no column other", table, "--measured", "other")
        self.refused("--time-unit = year", table, "--time-unit", "year")
        one = messages("/a", bags.STAMPED, t, measured)
        bags.write_mcap(self.folder / "one.mcap", one)
        self.refused(r"--measured = /c: expected a topic of .*: /a", self.folder / "one.mcap", "--measured", "/c")
        self.refused(r"--estimated = \(missing\)", self.folder / "one.mcap", "--measured", "/a")
        self.refused("expected with a table only", self.folder / "one.mcap", "--sigma", "s")
        self.refused("the other file", self.folder / "one.mcap", table)
        bags.write_mcap(self.folder / "late.mcap", messages("/b", bags.STAMPED, t + 1e4, estimated))
        self.refused("same time and clock", self.folder / "one.mcap", self.folder / "late.mcap")
        bags.write_mcap(self.folder / "other.mcap", [("/image", "sensor_msgs/msg/Image", START, b"")])
        self.refused(r"no topic of .*/image \(sensor_msgs", self.folder / "other.mcap", self.folder / "one.mcap")
        bags.write_mcap(self.folder / "json.mcap", one, encoding="json")
        self.refused("encoding json: expected cdr", self.folder / "json.mcap", self.folder / "one.mcap")
        bags.write_mcap(self.folder / "cut.mcap", [(*one[0][:3], one[0][3][:-20])])
        self.refused("message 1 is damaged", self.folder / "cut.mcap", self.folder / "one.mcap")
        (self.folder / "empty").mkdir()
        self.refused("no .mcap and no .db3", self.folder / "empty", self.folder / "one.mcap")
        (self.folder / "x.db3").write_bytes(b"SQLite format 3\x00" + bytes(200))
        self.refused("expected a database of rosbag2", self.folder / "x.db3", self.folder / "one.mcap")


if __name__ == "__main__":
    unittest.main()
