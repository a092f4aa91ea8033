"""Whether `study` accepts the model that `kind: auto` takes, on scenes drawn at random.

A scene is right if the model meets tolerance and rate by the study; also where no model does and its error is at most 1.1 times the
least one. It is flagged if the model does not but `check` says so, and silent otherwise. It is refused if there is no model, or the
study does not have it.
"""
import functools
import re

import runners
from campaign import Case, Refused, verdict
from draw import random_scene

COUNT = 20
AS_NEAR = 1.1
SAYS_SO = r"MISSES|misses|beyond|extrapolated|not known|no model"


def arguments(parser):
    parser.add_argument("--budget", type=float, default=20, help="of a study [s]")


def judged(files, budget, folder):
    for name, content in files.items():
        (folder / name).write_text(content)
    try:
        report = runners.run(runners.SLAVE, "check", folder / "scene.yaml").stdout
    except Refused as why:
        return verdict("refused", str(why).splitlines()[-1])
    rows = [row for row in runners.study(folder / "scene.yaml", folder / "study", budget) if row["outcome"] == "answered"]
    taken = re.search(r"auto: (.*?, .*?): ", report)
    row = next((row for row in rows if taken and taken[1] == f"{row['family']}, {row['resolution']}"), None)
    if row is None:
        return verdict("refused", "not in the study: " + re.search(r"^ +model +(.*)", report, re.M)[1])
    known = [float(row["error"]) for row in rows if row["error"] and row["validity"] == "valid"]
    met = [row for row in rows if row["meets_tolerance"] == row["meets_rate"] == "1"]
    error = float(row["error"] or "nan")
    is_right = row in met or (not met and bool(known) and error <= AS_NEAR * min(known))
    says_so = re.search(SAYS_SO, "\n".join(line for line in report.splitlines() if not re.match(r" +not ", line)))
    return verdict("right" if is_right else "flagged" if says_so else "silent", f"{taken[1]}: {100 * error:.2g} % error, {len(met)} of {len(rows)} "
                   f"models meet tolerance and rate")


def cases(options):
    for seed in range(options.seed, options.seed + options.count):
        name, files = random_scene(seed)
        yield Case(f"{seed} {name}", functools.partial(judged, files, options.budget), name.split()[0])
