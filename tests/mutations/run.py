#!/usr/bin/python3
"""Applies hand-made faults to the code, one at a time, and reports which of them the test command finds.

usage: tests/mutations/run.py [--only TEXT ...] [--draw N --seed S] [--tree DIR]

Each patch in this folder is one fault; its first line names it. The faults are applied to the last commit in a worktree
of its own, so that the working tree stays as it is. Of the tests that `tests/run.sh` runs, those that `--changed` selects
run first, then the others. A fault is found if a test fails twice with it and passes without it.
"""
import argparse
import os
import pathlib
import random
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OPTIONS = ["-DPALPATE_TESTS=ON", "-DPALPATE_VALIDATE=ON", "-DPALPATE_WERROR=OFF"]
FOUND, NOT_FOUND, NOT_APPLIED, NOT_BUILT = "found", "not found", "does not apply", "does not build"


class Tree:
    """A worktree of the last commit with a release build."""

    def __init__(self, folder):
        self.folder = folder
        folder.parent.mkdir(parents=True, exist_ok=True)
        shared = folder.parent / "shared"  # tests look for this folder beside the tree
        if not shared.exists():
            shared.symlink_to(ROOT.parent / "shared")
        if not folder.exists():
            self.git(ROOT, "worktree", "prune")
            self.git(ROOT, "worktree", "add", "--detach", str(folder))
        self.git(folder, "checkout", "--force", "--detach", self.git(ROOT, "rev-parse", "HEAD").stdout.strip())

    @staticmethod
    def git(folder, *arguments):
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"git {' '.join(arguments)}: {done.stderr}")
        return done

    def run(self, *command):
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})

    def build(self):
        return self.run("deploy/build.sh", "release", *OPTIONS, "--", "quick_tests").returncode == 0

    def failed(self, *selection):
        """Returns the names of the tests that fail twice."""
        ctest = ("ctest", "--test-dir", "build/release", f"-j{os.cpu_count() + 1}", "-LE", "slow", *selection)
        if self.run(*ctest).returncode == 0:
            return []
        self.run(*ctest, "--rerun-failed")
        log = self.folder / "build/release/Testing/Temporary/LastTestsFailed.log"
        return [line.split(":", 1)[1] for line in log.read_text().split()] if log.exists() else []

    def try_fault(self, patch, ignored):
        """Returns the outcome and the tests that found the fault."""
        if self.run("git", "apply", str(patch)).returncode != 0:
            return NOT_APPLIED, []
        try:
            if not self.build():
                return NOT_BUILT, []
            near = self.run("tests/changed.py", "build/release").stdout.strip()
            for selection in ([("-R", near)] if near else []) + [("--stop-on-failure",)]:
                found = [test for test in self.failed(*selection) if test not in ignored]
                if found:
                    return FOUND, found
            return NOT_FOUND, []
        finally:
            self.git(self.folder, "checkout", "--force", "--", ".")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="faults whose names contain one of these")
    parser.add_argument("--draw", type=int, metavar="N", help="this many of them, at random")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tree", type=pathlib.Path, default=ROOT / "build/mutations/tree", help="the worktree")
    options = parser.parse_args()

    patches = [patch for patch in sorted(HERE.glob("*.patch")) if any(text in patch.stem for text in options.only)]
    if options.draw:
        patches = sorted(random.Random(options.seed).sample(patches, min(options.draw, len(patches))))
    tree = Tree(options.tree.resolve())
    if not tree.build():
        sys.exit(f"the last commit does not build: see {tree.folder}/build/release.log")
    ignored = tree.failed()
    for test in ignored:
        print(f"{test} fails without a fault, and is not used")

    counts = {}
    print(f"{'fault':44} {'outcome':14} {'s':>5}  what it does; found by")
    for patch in patches:
        began = time.monotonic()
        outcome, tests = tree.try_fault(patch, ignored)
        counts[outcome] = counts.get(outcome, 0) + 1
        text = patch.read_text().split("\n", 1)[0].removeprefix("Fault: ")
        print(f"{patch.stem:44} {outcome:14} {time.monotonic() - began:5.0f}  {text}; {' '.join(tests)}", flush=True)
    print(f"{len(patches)} faults: " + ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())))
    return 1 if counts.get(NOT_APPLIED) or counts.get(NOT_BUILT) else 0


if __name__ == "__main__":
    sys.exit(main())
