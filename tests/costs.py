#!/usr/bin/env python3
"""What building and testing cost: the dearest units of every preset, the slowest tests, the time of every step.

costs.py [--since EPOCH] [--walls FILE]   of what was built and run since EPOCH [s]. FILE has a line `SHARE SECONDS STEP` for
                                          each step. With PALPATE_CI_LIMIT=SECONDS in the environment: exit 1 if the steps
                                          took longer together, with the step that is farthest beyond its share
"""
import argparse
import os
import pathlib
import re
import sys

BUILD = pathlib.Path(__file__).resolve().parents[1] / "build"
SHOWN = 10


def compiled(log, since):
    """{output: seconds} of what ninja made since then; where others compute too, more than its own work."""
    made = {}
    for line in log.read_text(encoding="utf-8").splitlines()[1:]:
        start, end, written, output, _ = line.split("\t")
        if int(written) >= since * 1e9:
            made[output] = (int(end) - int(start)) / 1000
    return made


def unit_name(output):
    """slave/vision/CMakeFiles/palpate_vision.dir/palpate_vision_0.cpp.o -> slave/vision/palpate_vision_0.cpp"""
    return re.sub(r"CMakeFiles/[^/]*\.dir/(.*)\.o$", r"\1", output)


def print_compiled(since):
    for log in sorted(BUILD.glob("*/.ninja_log")):
        units = {output: seconds for output, seconds in compiled(log, since).items() if output.endswith(".o")}
        if not units:
            continue
        rest = sum(compiled(log, since).values()) - sum(units.values())
        print(f"{log.parent.name}: {len(units)} units compiled in {sum(units.values()):.0f} s of work, "
              f"linked and generated in {rest:.0f} s; the slowest:")
        for output, seconds in sorted(units.items(), key=lambda item: -item[1])[:SHOWN]:
            print(f"  {seconds:6.1f} s  {unit_name(output)}")


def cases(log):
    """(seconds, name) of every GoogleTest case, and of every entry that has none."""
    text = log.read_text(encoding="utf-8", errors="replace")
    for entry in re.split(r"^\d+/\d+ Testing: ", text, flags=re.M)[1:]:
        name = entry.split("\n", 1)[0]
        own = re.findall(r"^\[\s+(?:OK|FAILED)\s+\] (\S+?),? .*?\((\d+) ms\)$", entry, re.M)
        own += re.findall(r"^\[\s+OK \] (\S+) \((\d+) ms\)$", entry, re.M)
        whole = re.search(r"^Test time =\s+([0-9.]+) sec", entry, re.M)
        if own:
            yield from {(int(ms) / 1000, f"{name}: {case}") for case, ms in own}
        elif whole:
            yield float(whole[1]), name


def print_slowest(since):
    for log in sorted(BUILD.glob("*/Testing/Temporary/LastTest.log")):
        if log.stat().st_mtime < since:
            continue
        found = sorted(cases(log), reverse=True)
        print(f"{log.parents[2].name}: {len(found)} tests in {sum(seconds for seconds, _ in found):.0f} s; the slowest:")
        for seconds, name in found[:SHOWN]:
            print(f"  {seconds:6.1f} s  {name}")


def judge(walls, limit):
    """Prints the steps; False if they took longer than the limit."""
    steps = [(int(share), int(seconds), name.strip())
             for share, seconds, name in (line.split(" ", 2) for line in walls.read_text().splitlines())]
    for _, seconds, name in steps:
        print(f"  {seconds:6} s  {name}")
    total = sum(seconds for _, seconds, _ in steps)
    print(f"  {total:6} s  total" + (f", accepted are {limit}" if limit else ""))
    if not limit or total <= limit:
        return True
    share, seconds, name = max(steps, key=lambda step: step[1] - step[0])
    print(f"FAILED: {total} s are more than the accepted {limit} s. The step '{name}' grew most: {seconds} s, its share is "
          f"{share} s. The list above shows its slowest parts.", file=sys.stderr)
    return False


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--since", type=float, default=0)
    options.add_argument("--walls", type=pathlib.Path)
    given = options.parse_args()
    print_compiled(given.since)
    print_slowest(given.since)
    if given.walls:
        return 0 if judge(given.walls, int(os.environ.get("PALPATE_CI_LIMIT", "0"))) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
