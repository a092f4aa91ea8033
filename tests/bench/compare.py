"""Compares benchmarks of two builds. It runs them alternately, so that a changing speed of the machine affects both.

  compare.py BEFORE_BIN AFTER_BIN [--rounds 3] [--seconds 0.05] [--only REGEX] [--max-ratio 1.05] [--same 1e-8]

For each benchmark in both builds it compares the smallest processor time of all rounds. Exit code 1: one takes more
than `--max-ratio` times as long as before, or a counter `same_*` differs by more than `--same`. Two runs of one build
differ by a few percent; repeat larger differences with `--only`.
"""
import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys


def measured(program, only, seconds):
    """Runs the matching benchmarks of `program`. Returns the processor time [ns] and the counters `same_*` of each."""
    ran = subprocess.run([program, f"--benchmark_filter={only}", f"--benchmark_min_time={seconds}", "--benchmark_format=json"],
                         capture_output=True, text=True, check=False)
    if ran.returncode != 0 or not ran.stdout.strip():
        return {}
    unit = {"ns": 1, "us": 1e3, "ms": 1e6, "s": 1e9}
    # Benchmarks with real time work in their own threads. Those with manual time measure processor time.
    return {one["name"]: (one["real_time" if re.search("/(real|manual)_time", one["name"]) else "cpu_time"] * unit[one["time_unit"]],
                          {key: one[key] for key in one if key.startswith("same_")})
            for one in json.loads(ran.stdout)["benchmarks"] if not one.get("error_occurred")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=0.05)
    parser.add_argument("--only", default=".")
    parser.add_argument("--programs", default="bench_", help="names that match this")
    parser.add_argument("--max-ratio", type=float, default=1.05)
    parser.add_argument("--same", type=float, default=1e-8, help="largest difference of counters same_*")
    a = parser.parse_args()
    names = sorted(one.name for one in a.before.glob("bench_*") if (a.after / one.name).exists() and re.search(a.programs, one.name))
    ratios, slower, differ = [], 0, 0
    for name in names:
        least, answers = [{}, {}], [{}, {}]
        for _ in range(a.rounds):
            for best, answer, folder in zip(least, answers, (a.before, a.after)):
                for key, (time, same) in measured(folder / name, a.only, a.seconds).items():
                    best[key] = min(best.get(key, time), time)
                    answer[key] = same
        for key in least[0].keys() & least[1].keys():
            ratio = least[1][key] / least[0][key]
            ratios.append(ratio)
            slower += ratio > a.max_ratio
            before, after = answers[0][key], answers[1][key]
            difference = max((abs(before[one] - after[one]) for one in before.keys() & after.keys()), default=0)
            differ += difference > a.same
            difference_text = f"  answers differ by {difference:.2g}" if before else ""
            print(f"{ratio:6.3f}  {least[0][key] / 1e3:12.2f} -> {least[1][key] / 1e3:12.2f} us  {name} {key}{difference_text}", flush=True)
    if not ratios:
        print("compare.py: no benchmark that both have", file=sys.stderr)
        return 2
    print(f"{len(ratios)} benchmarks: after / before, median {statistics.median(ratios):.3f}, least {min(ratios):.3f}, "
          f"most {max(ratios):.3f}; {slower} above {a.max_ratio:g}, {differ} with other answers")
    return 1 if slower or differ else 0


if __name__ == "__main__":
    sys.exit(main())
