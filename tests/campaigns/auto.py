"""Whether the rules of `kind: auto` choose as a study would, on scenes drawn at random.

A scene is right if the chosen model meets the tolerance by the study, at no more than twice the update time of the fastest that does, or
if no model meets it. It is flagged if the model meets it more slowly, or misses it and `check` says so, and silent otherwise.
With --keep FOLDER, FOLDER/case-*/study/study.csv are the studies, which palpate.plot draws and counts.
"""
import functools
import json
import re

import runners
from campaign import Case, Refused, verdict
from draw import random_scene

COUNT = 20
AS_FAST = 2
NEEDED = 0.9  # of the scenes


def arguments(parser):
    parser.add_argument("--budget", type=float, default=30, help="of a study [s]")


def judged(files, budget, folder):
    for name, content in files.items():
        (folder / name).write_text(content)
    scene, out = folder / "scene.yaml", folder / "study"
    try:
        report = runners.run(runners.SLAVE, "check", scene).stdout
    except Refused as why:
        return verdict("refused", str(why).splitlines()[-1])
    runners.study(scene, out, budget)
    study = json.loads((out / "study.json").read_text())
    rows = [row for row in study["rows"] if row["outcome"] == "answered"]
    own = next((row for row in rows if row["own"]), None)
    if own is None:
        return verdict("refused", "the study has no answer of the chosen model", holds=False)
    name, tolerance = f"{own['family']}, {own['resolution']}", study["settings"]["tolerance"]
    error = own["error"]["value"]
    error = float("nan") if error is None else error
    words = f"{name}: {100 * error:.2g} % for {100 * tolerance:.2g} %"
    met = [row for row in rows if row["meets_tolerance"]]
    if not met:
        return verdict("right", f"{words}; no model meets it", none=True)
    fastest = min(met, key=lambda row: row["update_s"]["median"])
    slower = own["update_s"]["median"] / fastest["update_s"]["median"]
    values = {"error": error / tolerance, "slower": slower, "met": bool(own["meets_tolerance"]), "family": own["family"]}
    words += f"; {slower:.2g} times the time of {fastest['family']}, {fastest['resolution']}"
    if own["meets_tolerance"]:
        return verdict("right" if slower <= AS_FAST else "flagged", words, **values)
    says_so = re.search("MISSES|may miss|extrapolated|not known", report)
    return verdict("flagged" if says_so else "silent", "misses it; " + words, **values)


def cases(options):
    for seed in range(options.seed, options.seed + options.count):
        name, files = random_scene(seed)
        yield Case(f"{seed} {name}", functools.partial(judged, files, options.budget), name.split()[0])


def demands(results, options):
    can = [outcome.values for _, outcome in results if "met" in outcome.values]
    met, fast = sum(one["met"] for one in can), sum(one["met"] and one["slower"] <= AS_FAST for one in can)
    without, all_of = sum("none" in outcome.values for _, outcome in results), len(results)
    yield f"{all_of} scenes; {without} that no model meets; {met} of the other {len(can)} meet the tolerance, {fast} within twice the least time", (
        fast + without >= NEEDED * all_of)
