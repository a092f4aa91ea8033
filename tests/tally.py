#!/usr/bin/env python3
"""Counts the tests inside a ctest log, skipped ones with their reasons.

tally.py LOG        one line `passed failed skipped`, then `skip: reason` lines
tally.py --sum FILE adds such blocks up and prints what a person and a machine read
"""
import collections
import re
import sys


def count(log):
    passed = failed = skipped = 0
    reasons = collections.Counter()
    text = open(log, encoding="utf-8", errors="replace").read()
    passed += sum(int(n) for n in re.findall(r"\[  PASSED  \] (\d+) tests?", text))
    failed += sum(int(n) for n in re.findall(r"\[  FAILED  \] (\d+) tests?, listed", text))
    skipped += sum(int(n) for n in re.findall(r"\[  SKIPPED \] (\d+) tests?, listed", text))
    for reason in re.findall(r": Skipped\n(.*)\n", text):
        reasons[reason.strip()] += 1
    # Python's unittest.
    for ran, result in re.findall(r"^Ran (\d+) tests? in .*\n\n(.*)$", text, re.M):
        bad = sum(int(n) for n in re.findall(r"(?:failures|errors)=(\d+)", result))
        skip = sum(int(n) for n in re.findall(r"skipped=(\d+)", result))
        passed, failed, skipped = passed + int(ran) - bad - skip, failed + bad, skipped + skip
    for reason in re.findall(r"\.\.\. skipped ['\"](.*)['\"]$", text, re.M):
        reasons[reason] += 1
    # Scripts tell for themselves: a line `skipped: why` or `passed: what`.
    for reason in re.findall(r"^skipped: (.*)$", text, re.M):
        skipped += 1
        reasons[reason] += 1
    passed += len(re.findall(r"^passed: ", text, re.M))
    print(passed, failed, skipped)
    for reason, n in reasons.items():
        print(f"skip: {n} x {reason}")


def total(path):
    sums = [0, 0, 0]
    for line in open(path, encoding="utf-8"):
        if line.startswith("skip: "):
            print("skipped " + line[6:].rstrip())
        else:
            sums = [a + int(b) for a, b in zip(sums, line.split())]
    print(f"{sums[0]} passed, {sums[1]} failed, {sums[2]} skipped")
    return 1 if sums[1] or not sums[0] else 0


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--sum":
        sys.exit(total(sys.argv[2]))
    count(sys.argv[1])
