#!/usr/bin/python3
"""Applies hand-made faults to the code, one at a time, and reports which of them the tests find.

usage: tests/mutations/run.py [--only TEXT ...] [--full] [--tree DIR]

Each patch in this folder is one fault. Its first lines name the fault, the tests of its module that the test command
runs (`Tests:`), and those that only `tests/run.sh --full` runs (`Full:`). The faults are applied to the last commit in a
worktree of its own, so that the working tree stays as it is. A fault is found if a test fails twice with it and passes
without it.
"""
import argparse
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OPTIONS = ["-DPALPATE_TESTS=ON", "-DPALPATE_WERROR=ON", "-DPALPATE_SANITIZED_APART=OFF", "-DPALPATE_FULL_TESTS=ON"]
FOUND, FOUND_BY_FULL, NOT_FOUND = "found", "found with --full", "not found"
NOT_APPLIED, NOT_BUILT = "does not apply", "does not build"


class Fault:
    def __init__(self, patch):
        self.patch = patch
        self.name = patch.stem
        fields = dict(line.split(":", 1) for line in patch.read_text().split("\n\n", 1)[0].splitlines())
        self.text = fields["Fault"].strip()
        self.tests = fields["Tests"].split()
        self.full_tests = fields.get("Full", "").split()


class Tree:
    """A worktree of the last commit with a release build."""

    def __init__(self, folder):
        self.folder = folder
        self.seconds = {}  # duration of each test without a fault [s]
        self.failing = set()  # tests that fail without a fault
        folder.parent.mkdir(parents=True, exist_ok=True)
        shared = folder.parent / "shared"  # tests look for this folder beside the tree
        if not shared.is_symlink():
            shared.symlink_to(ROOT.parent / "shared")
        if not folder.exists():
            self.git(ROOT, "worktree", "prune")
            self.git(ROOT, "worktree", "add", "--detach", str(folder))
        commit = self.git(ROOT, "rev-parse", "HEAD").stdout.strip()
        self.git(folder, "checkout", "--force", "--detach", commit)

    @staticmethod
    def git(folder, *arguments):
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"git {' '.join(arguments)}: {done.stderr}")
        return done

    def apply(self, patch):
        done = subprocess.run(["git", "-C", str(self.folder), "apply", str(patch)], capture_output=True)
        return done.returncode == 0

    def undo(self):
        self.git(self.folder, "checkout", "--force", "--", ".")

    def build(self, tests):
        command = ["deploy/build.sh", "release", *OPTIONS, "--", *tests]
        return subprocess.run(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def passes(self, test):
        limit = max(60, 10 * self.seconds.get(test, 100))
        command = ["ctest", "--test-dir", "build/release", "--timeout", str(int(limit)), "--no-tests=error", "-R", f"^{test}$"]
        environment = {"GTEST_FAIL_FAST": "1", "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.run(["env", *[f"{key}={value}" for key, value in environment.items()], *command],
                              cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def fails(self, test):
        return not self.passes(test) and not self.passes(test)

    def try_without_fault(self, tests):
        if not self.build(tests):
            sys.exit(f"the last commit does not build: see {self.folder}/build/release.log")
        for test in tests:
            began = time.monotonic()
            if self.fails(test):
                self.failing.add(test)
                print(f"{test} fails without a fault, and is not used")
            self.seconds[test] = time.monotonic() - began

    def try_fault(self, fault, full):
        """Tests one fault. Returns the outcome and the test that found it."""
        if not self.apply(fault.patch):
            return NOT_APPLIED, ""
        try:
            for tests, outcome in ((fault.tests, FOUND), (fault.full_tests if full else [], FOUND_BY_FULL)):
                if tests and not self.build(tests):
                    return NOT_BUILT, ""
                for test in tests:
                    if test not in self.failing and self.fails(test):
                        return outcome, test
            return NOT_FOUND, ""
        finally:
            self.undo()


def in_order(lists):
    return list(dict.fromkeys(name for names in lists for name in names))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="faults whose names contain one of these")
    parser.add_argument("--full", action="store_true", help="try the tests of --full on what the others do not find")
    parser.add_argument("--tree", type=pathlib.Path, default=ROOT / "build/mutations/tree", help="the worktree")
    options = parser.parse_args()

    faults = [Fault(patch) for patch in sorted(HERE.glob("*.patch"))]
    faults = [fault for fault in faults if any(text in fault.name for text in options.only)]
    tree = Tree(options.tree.resolve())
    tree.try_without_fault(in_order([fault.tests + (fault.full_tests if options.full else []) for fault in faults]))

    counts = {}
    print(f"{'fault':44} {'outcome':18} {'by':24} {'s':>5}  what it does")
    for fault in faults:
        began = time.monotonic()
        outcome, test = tree.try_fault(fault, options.full)
        counts[outcome] = counts.get(outcome, 0) + 1
        print(f"{fault.name:44} {outcome:18} {test:24} {time.monotonic() - began:5.0f}  {fault.text}", flush=True)
    print(f"{len(faults)} faults: " + ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())))
    return 1 if counts.get(NOT_APPLIED) or counts.get(NOT_BUILT) else 0


if __name__ == "__main__":
    sys.exit(main())
