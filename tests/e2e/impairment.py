"""Effect of delay, jitter and loss on the rendered force: one session of the programs per cell, one row of CSV each.

  impairment.sh --quick|--full [--out FILE.csv] [--seed N] [--only WORDS] [--datagrams|--stream] [--jobs N]

--quick: at most five minutes. --full: every cell, four and a half hours by one; rows that FILE.csv has already are kept, so that it can be
gone on with. --jobs N: so many sessions beside each other, each on a line of its own: as many as the processors bear.
Cells with loss need network namespaces and a TUN device: without them they are listed as skipped, and so are all others.
--datagrams: states and commands may travel by UDP, too, as they do by themselves; --stream: none, as behind a firewall. Delay is that of a state from slave to master, age its time since it was sensed.
A cell fails where the hand is not safe: a force beyond the limit, energy beyond what noise explains, an oscillation that grows.
late_tick_J: what the worst tick that came late let out, which a busy machine adds to that energy.
"""
import argparse
import concurrent.futures
import csv
import itertools
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

from bad_line import SLAVE_AT, BadLine, permitted
from programs import BARE, MASTER, ROOT, SLAVE, Slave

ROUND_TRIPS = [0, 10, 50, 100, 200, 500, 1000, 5000]  # [ms]
JITTERS, LOSSES = [0, 20], [0, 1, 5]                  # [%]
OBJECTS = {"soft": "foam-cube", "stiff": "silicone-block", "membrane": "rubber-membrane", "moving": "silicone-block"}
MOTION = ["--override", "site.motion={amplitude: [0 mm, 2 mm], period: 3 s}"]  # of what moves; 4 mm/s
RENDERS = ["local", "interpolate", "hold"]
QUICK = [("stiff", render, trip, 0, 0) for render in ("local", "hold") for trip in (0, 100, 500)] + [
    ("stiff", "local", 50, 20, 1), ("stiff", "local", 200, 20, 5), ("stiff", "local", 1000, 0, 0),
    ("soft", "local", 100, 0, 0), ("membrane", "local", 100, 0, 0), ("moving", "local", 100, 0, 0)]
FORCE_LIMIT, NOISE_ENERGY, LATE = 3.3, -1e-3, 2e-3  # [N], [J], [s]: of a tick
DELAYS = [("state_delay_us", "p50"), ("state_delay_us", "p99"), ("state_delay_us", "max"), ("state_age_us", "p50"), ("state_age_us", "p99")]
COLUMNS = ["object", "render", "round_trip_ms", "jitter_pct", "loss_pct", "seed", "seconds", "rms_N", "relative_rms",
           "delay_compensated_rms_N", "delay_compensated_relative", "drift_m", "energy_min_J", "growing", "stale_share", "packets_per_s",
           "rtt_p50_ms", "reconnects", "force_sent_peak_N", "served", "safe", "datagrams", "delay_p50_ms", "delay_p99_ms",
           "delay_max_ms", "age_p50_ms", "age_p99_ms", "hold_s", "late_tick_J"]


def stretches(rows):
    """The forces sent while the tool followed without a break; after an interruption the list starts again."""
    known, number = {}, 0
    for row in rows:
        if row["state"] == "FOLLOWING":
            known.setdefault(number, []).append(math.hypot(*(float(row[f"sent_{axis}"]) for axis in "xyz")))
        else:
            number += 1
    return known.values()


def oscillation_grows(forces):
    """Whether what is faster than 5 Hz in the force on the hand becomes three times larger from the begin to the end, in parts of
    the force: what is held from state to state has steps, which are as large as it changes."""
    width, swings, means = 100, [], []
    mean = sum(forces[:width]) / width if len(forces) > width else 0
    for k in range(width, len(forces) - width, 1):
        mean += (forces[k + width // 2 - 1] - forces[k - width // 2 - 1]) / width
        swings.append(forces[k] - mean)
        means.append(mean)
    windows = [(math.sqrt(sum(s * s for s in swings[k:k + 500]) / 500), sum(means[k:k + 500]) / 500)
               for k in range(0, len(swings) - 500, 500)]
    least = 0.1 * max((force for _, force in windows), default=0)
    pressed = [(swing, swing / force) for swing, force in windows if force > least]
    return len(pressed) > 2 and pressed[-1][1] > 3 * max(pressed[0][1], 0.02) and pressed[-1][0] > 0.1


def late_energy(rows):
    """The most that one tick which came late let out: the force it held times the hand's way meanwhile [J]. Nobody could have
    damped that: the machine was elsewhere."""
    most = 0.0
    for last, row in zip(rows, rows[1:]):
        if float(row["t"]) - float(last["t"]) > LATE:
            most = max(most, sum(float(last[f"sent_{axis}"]) * (float(row[f"p_M_{axis}"]) - float(last[f"p_M_{axis}"]))
                                 for axis in "xyz"))
    return most


def drift(rows):
    """How far the tool's commanded place has moved when the hand is back where it began, within an epoch [m]."""
    place = [([float(row[f"p_M_{axis}"]) for axis in "xyz"], [float(row[f"p_S_{axis}"]) for axis in "xyz"])
             for row in rows if row["state"] == "FOLLOWING"]
    if not place:
        return 0.0
    hand, tool = place[0]
    back = [math.dist(tool, now) for at, now in place if math.dist(at, hand) < 1e-5]
    return min(back[-1], 1.0) if back else 0.0


def session(line, kind, render, seconds, trip, folder, datagrams):
    """Report and rows of the log of a session of `seconds` over `line`, a BadLine with round trips of about `trip` [s]."""
    scene = ROOT / "deploy/scenes" / f"{OBJECTS[kind]}.yaml"
    report, log = folder / "report.json", folder / "log.csv"
    with line:
        serve = [*line.at_slave, SLAVE, "serve", scene, "--listen", f"{SLAVE_AT}:50051", "--insecure",
                 *(MOTION if kind == "moving" else [])]
        with Slave(command=serve):
            report.unlink(missing_ok=True)
            subprocess.run([*line.at_master, MASTER, "connect", f"{SLAVE_AT}:50051", "--insecure", "--render", render,
                            "--wait", str(20 + 8 * trip), "--duration", str(seconds), "--report", report, "--log", log,
                            *([] if datagrams else ["--no-datagrams"])],
                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=BARE, timeout=seconds + 90 + 16 * trip)
    if not report.exists():
        return None, []
    return json.loads(report.read_text()), list(csv.DictReader(log.open()))


def cell(kind, render, trip, jitter, loss, seed, datagrams):
    # A line that was idle takes some round trips to carry 200 states a second; a pinch takes its time.
    seconds = (20 if kind == "soft" else 8) + 16 * trip / 1000
    with tempfile.TemporaryDirectory() as folder:
        line = BadLine(trip / 1000, jitter / 100, loss / 100, seed)
        printed, rows = session(line, kind, render, seconds, trip / 1000, pathlib.Path(folder), datagrams)
    if printed is None:  # nobody was found, and nothing reached the hand
        return dict.fromkeys(COLUMNS, "") | dict(zip(COLUMNS, [kind, render, trip, jitter, loss, seed, seconds])) | {
            "served": 0, "safe": 1, "datagrams": 0}
    error, compensated = printed["force_error"] or {}, printed.get("force_error_delay_compensated") or {}
    # One contact alone is the first; a moving position determines no force.
    compensated = compensated if compensated.get("contact_ticks") and kind != "moving" else {}
    grows = any(oscillation_grows(forces) for forces in stretches(rows))
    safe = printed["force_sent_peak_N"] <= FORCE_LIMIT + 1e-6 and printed["energy_min_J"] >= NOISE_ENERGY and not grows
    return dict(zip(COLUMNS, [
        kind, render, trip, jitter, loss, seed, seconds, error.get("rms_N", ""), error.get("relative_rms", ""),
        compensated.get("rms_N", ""), compensated.get("relative_rms", ""), f"{drift(rows):.2e}", printed["energy_min_J"], int(grows),
        round(printed["stale_ticks"] / max(printed["ticks"], 1), 4),
        round((printed["states"] + printed["commands"]) / printed["duration_s"], 1), round(printed["rtt_us"]["p50"] / 1000, 2),
        printed["reconnects"], printed["force_sent_peak_N"], int(printed["states"] > 0), int(safe), int(printed["states_by_datagram"] > 0),
        *(round(printed[times][q] / 1000, 2) for times, q in DELAYS), round(printed["seconds_in"].get("HOLD", 0), 3),
        round(late_energy(rows), 7)]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    size = parser.add_mutually_exclusive_group(required=True)
    size.add_argument("--quick", action="store_true")
    size.add_argument("--full", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("impairment.csv"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--datagrams", action="store_true")
    way.add_argument("--stream", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    a = parser.parse_args()
    cells = QUICK if a.quick else list(itertools.product(OBJECTS, RENDERS, ROUND_TRIPS, JITTERS, LOSSES))
    cells = [one for one in cells if a.only in " ".join(map(str, one))]
    if not permitted():
        print(f"skipped: {len(cells)} cells, no network namespaces or no TUN device here")
        return 77
    begin = time.monotonic()
    known = list(csv.DictReader(a.out.open())) if a.full and a.out.exists() else []
    done = {tuple(row[column] for column in COLUMNS[:6]) for row in known}
    print(f"seed {a.seed}; {len(cells)} cells, {len(done)} known", flush=True)
    with a.out.open("a" if done else "w", newline="") as out, concurrent.futures.ThreadPoolExecutor(a.jobs) as sessions:
        writer = csv.DictWriter(out, COLUMNS)
        if not done:
            writer.writeheader()
        unsafe = sum(row["safe"] == "0" for row in known)
        missing = [one for one in cells if tuple(map(str, (*one, a.seed))) not in done]
        for ended in concurrent.futures.as_completed([sessions.submit(cell, *one, a.seed, not a.stream) for one in missing]):
            row = ended.result()
            writer.writerow(row)
            out.flush()
            unsafe += not row["safe"]
            print(" ".join(f"{column}={row[column]}" for column in COLUMNS if row[column] != ""), flush=True)
    print(f"{unsafe} unsafe cells; seed {a.seed}, {time.monotonic() - begin:.0f} s")
    return 1 if unsafe else 0


if __name__ == "__main__":
    sys.exit(main())
