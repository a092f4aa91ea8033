#!/usr/bin/env python3
"""Counts the tests inside a ctest log, the skipped ones with their reasons.

tally.py LOG [AGAIN]  one line `passed failed skipped`, then `skip: ...` lines; an entry of the log AGAIN stands for that of the
                      same name in LOG, and is told as `again: NAME`
tally.py --sum FILE   adds such blocks up and prints what a person and a machine read
"""
import collections
import re
import sys


def count_one(text, reasons):
    """(passed, failed, skipped) of one ctest entry: its GoogleTest or unittest cases, or itself where it has none."""
    numbers = lambda pattern: sum(int(n) for n in re.findall(pattern, text))
    if "[==========]" in text:
        for reason in re.findall(r": Skipped\n(.*)\n", text):
            reasons[reason.strip()] += 1
        return (numbers(r"\[  PASSED  \] (\d+) tests?\."), numbers(r"\[  FAILED  \] (\d+) tests?, listed"),
                numbers(r"\[  SKIPPED \] (\d+) tests?, listed"))
    ran = re.search(r"^Ran (\d+) tests? in .*\n\n(.*)$", text, re.M)
    if ran:
        counted = lambda kind: sum(int(n) for n in re.findall(kind + r"=(\d+)", ran.group(2)))
        bad, skipped = counted("failures") + counted("errors"), counted("skipped")
        for reason in re.findall(r"\.\.\. skipped ['\"](.*)['\"]$", text, re.M):
            reasons[reason] += 1
        return int(ran.group(1)) - bad - skipped, bad, skipped
    said = re.search(r"^skipped: (.*)$", text, re.M)
    if said:
        reasons[said.group(1)] += 1
        return 0, 0, 1
    # An entry that is judged by what it prints ends with a reason in place of "Test Passed."
    return (1, 0, 0) if re.search(r"^Test (Passed\.|Pass Reason:)$", text, re.M) else (0, 1, 0)


def entries_of(log):
    """{name: text} of the entries of a ctest log."""
    text = open(log, encoding="utf-8", errors="replace").read()
    return {entry.split("\n", 1)[0]: entry for entry in re.split(r"^\d+/\d+ Testing: ", text, flags=re.M)[1:]}


def count(log, again=None):
    repeated = entries_of(again) if again else {}
    reasons = collections.Counter()
    entries = [count_one(entry, reasons) for entry in (entries_of(log) | repeated).values()]
    print(*(sum(column) for column in zip(*entries)))
    for name in repeated:
        print(f"again: {name}")
    for reason, n in reasons.items():
        print(f"skip: {n} x {reason}")


def total(path):
    sums = [0, 0, 0]
    for line in open(path, encoding="utf-8"):
        if line.startswith("skip: "):
            print("skipped " + line[6:].rstrip())
        elif line.startswith("again: "):
            print("unsteady: " + line[7:].rstrip() + " failed first and passed when repeated alone: the reason is above")
        else:
            sums = [a + int(b) for a, b in zip(sums, line.split())]
    print(f"{sums[0]} passed, {sums[1]} failed, {sums[2]} skipped")
    return 1 if sums[1] or not sums[0] else 0


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--sum":
        sys.exit(total(sys.argv[2]))
    count(*sys.argv[1:])
