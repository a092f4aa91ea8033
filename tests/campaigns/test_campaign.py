#!/usr/bin/python3
"""The library of campaigns: verdicts, intervals, random numbers, table and exit codes."""
import collections
import contextlib
import io
import math
import pathlib
import tempfile
import types
import unittest

import campaign
from alter.engine import Engine
from campaign import Case, Estimate, Refused, verdict
from draw import Dice


def run(*cases, arguments=(), **functions):
    """Returns the exit code of a campaign with these cases, and what it prints."""
    module = types.SimpleNamespace(__doc__="test", cases=lambda options: cases, **functions)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        return campaign.run("test", module, [*arguments]), printed.getvalue()


def refuses(_):
    raise Refused("first line\nthe cause")


RIGHT, SILENT = Case("good", lambda folder: verdict("right"), "a"), Case("bad", lambda folder: verdict("silent"), "b")


class Verdicts(unittest.TestCase):
    def test_an_error_within_the_limit_or_sigma_is_right_and_others_are_silent(self):
        def one(error, sigma=0.0, validity="valid", truth=1.0):
            return Estimate((truth + error,), (truth,), sigma, validity, "arm" if validity != "valid" else "")
        estimates = [one(0.05), one(0.2, 0.07), one(0.2, 0.06), one(math.nan), one(9, 0, "extrapolated"), one(9, truth=0.005)]
        outcome = campaign.compared(estimates, contact=0.01, limit=0.1, sigmas=3)
        self.assertEqual(outcome.counts, {"right": 2, "silent": 2, "flagged": 1})
        self.assertFalse(outcome.holds)
        self.assertEqual(outcome.values["valid"], 4)
        self.assertIn("arm 1", outcome.text)

    def test_wilson_interval(self):
        low, high = campaign.wilson(2, 16)
        self.assertAlmostEqual(low, 0.0350, places=4)
        self.assertAlmostEqual(high, 0.3602, places=4)
        self.assertEqual(campaign.wilson(0, 0), (0.0, 1.0))


class Runs(unittest.TestCase):
    def test_a_silent_case_fails_the_campaign(self):
        code, printed = run(RIGHT, SILENT)
        self.assertEqual(code, 1)
        self.assertRegex(printed, r"holds  good +right\nFAILS  bad +silent\n")
        self.assertIn("all: 1 of 2 cases hold; of 2: 1 right 50.0 % (9.5 to 90.5)", printed)
        self.assertEqual(run(RIGHT)[0], 0)

    def test_a_refusal_that_no_case_expects_fails(self):
        code, printed = run(Case("refused", refuses))
        self.assertEqual(code, 1)
        self.assertRegex(printed, r"FAILS  refused +refused: the cause")

    def test_demands_decide_where_a_campaign_has_some(self):
        self.assertEqual(run(SILENT, demands=lambda results, options: [("accepted", True)])[0], 0)
        self.assertEqual(run(RIGHT, demands=lambda results, options: [("missed", False)])[0], 1)

    def test_only_chooses_by_name_or_group(self):
        self.assertEqual(run(RIGHT, SILENT, arguments=["--only", "goo"])[0], 0)
        self.assertEqual(run(RIGHT, SILENT, arguments=["--only", "b"])[0], 1)

    def test_several_jobs_give_the_same_table(self):
        cases = [Case(f"case {k}", lambda folder, k=k: verdict("right", str(folder.is_dir() and k))) for k in range(5)]
        one, two = (run(*cases, arguments=["--jobs", jobs])[1].split("\nseed")[0] for jobs in ("1", "2"))
        self.assertEqual(one, two)

    def test_a_run_continues_with_the_results_of_an_earlier_one(self):
        with tempfile.TemporaryDirectory() as folder:
            file = str(pathlib.Path(folder) / "results")
            run(RIGHT, arguments=["--resume", file])
            code, printed = run(Case("good", refuses, "a"), Case("new", refuses), arguments=["--resume", file])
            self.assertEqual(code, 1)
            self.assertIn("1 cases do not hold", printed)


class Draws(unittest.TestCase):
    def test_numbers_are_those_of_the_standard(self):
        random = Engine(5489)
        for _ in range(9999):
            random()
        self.assertEqual(random(), 9981545732273789042)  # the 10,000th of std::mt19937_64, ISO C++, rand.predef
        dice = Dice(5489)
        for _ in range(10000 - 16 - 1):
            dice.share()
        self.assertEqual(dice.share() * 2**32, 4123659995)  # of std::mt19937

    def test_normal_numbers(self):
        random = Engine(1)
        draws = [random.normal(2.0) for _ in range(4000)]
        self.assertAlmostEqual(sum(draws) / 4000, 0, delta=0.1)
        self.assertAlmostEqual(math.sqrt(sum(x * x for x in draws) / 4000), 2, delta=0.1)

    def test_whole_numbers_are_spread_evenly(self):
        random = Engine(1)
        counts = collections.Counter(random.index(3) for _ in range(3000))
        self.assertEqual(sorted(counts), [0, 1, 2])
        self.assertLess(max(counts.values()) - min(counts.values()), 200)


if __name__ == "__main__":
    unittest.main()
