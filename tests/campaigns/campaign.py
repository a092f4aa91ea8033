"""What all campaigns share: a list of cases, verdicts against a truth, Wilson intervals, one table, one command line.

A campaign is a module of this folder with

  cases(options)             yields the cases. Draws are made here, in order, so that a seed gives the same cases
  demands(results, options)  yields (words, whether it is met) over all results; optional
  arguments(parser)          adds options of its own; optional
  COUNT                      default of --count; None or absent: the cases are a fixed list

Verdicts, of a case or of each estimate in a case:

  right      within the limits of the campaign, or a remark names the mistake
  flagged    not `valid`, or a false alarm
  refused    a message names the cause
  unhelpful  a message names another cause, or none
  silent     wrong without a flag
"""
import argparse
import collections
import contextlib
import dataclasses
import functools
import json
import math
import multiprocessing
import pathlib
import tempfile
import time
from typing import Callable, NamedTuple

VERDICTS = ("right", "flagged", "refused", "unhelpful", "silent")
SKIPPED = 77  # exit code


class Refused(Exception):
    """A program rejected its input, with these words."""


class Skipped(Exception):
    """The campaign cannot run here."""


@dataclasses.dataclass
class Outcome:
    """The result of a case. `counts`: of the verdicts. `values`: what the demands of the campaign need."""
    counts: collections.Counter
    text: str = ""
    holds: bool = True
    values: dict = dataclasses.field(default_factory=dict)


def verdict(name, text="", holds=None, **values):
    """Returns the outcome of a case with a single verdict. It holds unless it is silent or unhelpful."""
    return Outcome(collections.Counter({name: 1}), text, name not in ("silent", "unhelpful") if holds is None else holds, values)


class Case(NamedTuple):
    name: str
    run: Callable[[pathlib.Path], Outcome]  # in a folder of its own
    group: str = ""


class Result(NamedTuple):
    case: Case
    outcome: Outcome


class Estimate(NamedTuple):
    force: tuple  # as reported; NaN: none
    truth: tuple
    sigma: float
    validity: str
    check: str = ""


def size(vector):
    return math.sqrt(sum(x * x for x in vector))


def compared(estimates, contact, limit, sigmas=0.0, peak=None):
    """Compares estimates in contact with the truth. `contact`: smallest true force of a contact; `limit`: largest error of
    a right estimate; both relative to `peak`, the largest true force. An error within `sigmas` times sigma is right too."""
    estimates = list(estimates)
    peak = peak or max((size(one.truth) for one in estimates), default=0)
    counts, checks, errors, valid = collections.Counter(), collections.Counter(), [], []
    for one in estimates:
        if size(one.truth) <= contact * peak:
            continue
        error = math.dist(one.force, one.truth) / peak
        errors.append(error)
        if one.validity != "valid":
            counts["flagged"] += 1
            checks[one.check or one.validity] += 1
            continue
        valid.append((error, one.sigma / peak))
        counts["right" if error <= max(limit, sigmas * one.sigma / peak) else "silent"] += 1
    worst = max((error for error, _ in valid), default=0)
    flags = ", ".join(f"{check} {count}" for check, count in checks.most_common())
    return Outcome(counts, f"error {100 * rms(errors):.1f} % rms, worst valid {100 * worst:.1f} %" + (f"; {flags}" if flags else ""),
                   not counts["silent"], {"rms": rms(errors), "worst": worst, "valid": len(valid), "valid_rms": rms([e for e, _ in valid]),
                                          **{key: sum(e <= k * sigma for e, sigma in valid) for key, k in (("one", 1), ("two", 2))}})


def rms(errors):
    known = [error for error in errors if not math.isnan(error)]
    return math.sqrt(sum(error**2 for error in known) / len(known)) if known else math.nan


def wilson(count, total):
    """Returns the 95 % interval of a share (Wilson 1927)."""
    if total == 0:
        return 0.0, 1.0
    z, share = 1.96, count / total
    middle, half = share + z * z / (2 * total), z * math.sqrt(share * (1 - share) / total + z * z / (4 * total * total))
    return max(0.0, (middle - half) / (1 + z * z / total)), min(1.0, (middle + half) / (1 + z * z / total))


def share(count, total):
    low, high = wilson(count, total)
    return f"{100 * count / max(1, total):.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def in_words(counts):
    return ", ".join(f"{counts[name]} {name}" for name in VERDICTS if counts[name]) or "nothing to judge"


def row(case, outcome):
    single = sum(outcome.counts.values()) == 1
    words = next(name for name in VERDICTS if outcome.counts[name]) if single else in_words(outcome.counts)
    return f"{'holds' if outcome.holds else 'FAILS'}  {case.name:56}  {words}{': ' if outcome.text else ''}{outcome.text}"


def totals(results):
    """Yields a line for each group of cases and one for all."""
    groups = collections.defaultdict(list)
    for result in results:
        groups[result.case.group].append(result.outcome)
    lines = [*groups.items(), ("all", [outcome for _, outcome in results])] if len(groups) > 1 else [("all", next(iter(groups.values()), []))]
    for name, outcomes in lines:
        counts = sum((outcome.counts for outcome in outcomes), collections.Counter())
        of = sum(counts.values())
        shares = "; ".join(f"{counts[word]} {word} {share(counts[word], of)}" for word in VERDICTS if counts[word] or word == "silent")
        yield f"{name or 'others'}: {sum(outcome.holds for outcome in outcomes)} of {len(outcomes)} cases hold; of {of}: {shares}"


def run(name, module, arguments):
    """Runs the cases of a campaign and prints the table. Returns the exit code: 0 all demands are met, 1 one is not."""
    parser = argparse.ArgumentParser(prog=f"run.py {name}", description=module.__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    count = getattr(module, "COUNT", None)
    if count is not None:
        parser.add_argument("--count", type=int, default=count, help=f"number of drawn cases; default {count}")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", metavar="WORDS", help="cases whose name or group contains this")
    parser.add_argument("--jobs", type=int, default=1, help="cases at the same time")
    parser.add_argument("--resume", type=pathlib.Path, metavar="FILE", help="file of results, from which a later run continues")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files of the cases")
    getattr(module, "arguments", lambda _: None)(parser)
    options = parser.parse_args(arguments)
    began, results = time.monotonic(), []
    with tempfile.TemporaryDirectory() as scratch:
        options.folder = (options.keep or pathlib.Path(scratch)).resolve()
        options.folder.mkdir(parents=True, exist_ok=True)
        try:
            chosen = [case for case in module.cases(options) if options.only in case.name or options.only == case.group]
            for case, outcome in _outcomes(chosen, options.folder, options.jobs, options.resume):
                results.append(Result(case, outcome))
                print(row(case, outcome), flush=True)
        except Skipped as why:
            print(f"skipped: {why}")
            return SKIPPED
    if not results:
        parser.error(f"--only {options.only}: no case has this name or group")
    print()
    for line in totals(results):
        print(line)
    demands = getattr(module, "demands", lambda results, options: [every_case_holds(results)])
    met = [_report(*demand) for demand in demands(results, options)]
    print(f"seed {options.seed}, {time.monotonic() - began:.0f} s")
    return 0 if all(met) else 1


def every_case_holds(results):
    failing = [case.name for case, outcome in results if not outcome.holds]
    return f"{len(failing)} cases do not hold", not failing


def _report(words, is_met):
    print(f"{words}{'' if is_met else '  <-- NOT MET'}")
    return is_met


_cases = []  # for the processes that are forked


def _outcome(number, folder):
    own = folder / f"case-{number}"
    own.mkdir(exist_ok=True)
    try:
        return _cases[number].run(own)
    except Refused as why:
        return verdict("refused", str(why).splitlines()[-1] if str(why) else "without a message", holds=False)


def _outcomes(cases, folder, jobs, file):
    """Yields the cases with their outcomes in order. With several jobs each runs in a process of its own, because Gmsh needs the main
    thread."""
    known = {}
    if file and file.exists():
        for line in file.read_text().splitlines():
            name, counts, text, holds, values = json.loads(line)
            known[name] = Outcome(collections.Counter(counts), text, holds, values)
    yield from ((case, known[case.name]) for case in cases if case.name in known)
    _cases[:] = [case for case in cases if case.name not in known]
    one = functools.partial(_outcome, folder=folder)
    with multiprocessing.get_context("fork").Pool(jobs) if jobs > 1 else contextlib.nullcontext() as pool:
        for case, outcome in zip(_cases, (pool.imap if jobs > 1 else map)(one, range(len(_cases)))):
            if file:
                with open(file, "a", encoding="utf-8") as lines:
                    lines.write(json.dumps([case.name, outcome.counts, outcome.text, outcome.holds, outcome.values]) + "\n")
            yield case, outcome
