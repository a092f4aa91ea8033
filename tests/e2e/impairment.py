"""Effect of delay, jitter and loss on the rendered force: one session of slave and master per cell, one row of CSV each.

  impairment.sh --quick|--full [--out FILE.csv] [--seed N] [--only TEXT] [--datagrams|--stream] [--jobs N]

--quick      the cells in QUICK, at most five minutes
--full       all cells, four and a half hours with one job; rows that FILE.csv already has are kept, so an interrupted
             run can be continued
--only       the cells whose text contains TEXT
--jobs N     number of sessions at the same time, each on its own link
--datagrams  states and commands may also travel by UDP (the default)
--stream     states and commands travel by the stream alone, as behind a firewall

All cells need network namespaces and a TUN device. Without them the run is skipped (exit code 77).
The columns delay_* are delays of states from slave to master; age_* are times since the states were sensed.
A cell is unsafe if the force exceeds its limit, the energy exceeds what noise explains, or an oscillation grows.
late_tick_J is the largest energy released during one late tick. A busy machine adds it to the energy.
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

from impaired_link import SLAVE_ADDRESS, ImpairedLink, can_impair_links
from programs import BARE, MASTER, ROOT, SLAVE, Slave

ROUND_TRIPS = [0, 10, 50, 100, 200, 500, 1000, 5000]  # [ms]
JITTERS = [0, 20]  # [% of the delay]
LOSSES = [0, 1, 5]  # [% of the packets]
OBJECTS = {"soft": "foam-cube", "stiff": "silicone-block", "membrane": "rubber-membrane", "moving": "silicone-block"}
MOTION = ["--override", "site.motion={amplitude: [0 mm, 2 mm], period: 3 s}"]  # of the object, up to 4 mm/s
RENDERS = ["local", "interpolate", "hold"]
QUICK = [("stiff", render, trip, 0, 0) for render in ("local", "hold") for trip in (0, 100, 500)] + [
    ("stiff", "local", 50, 20, 1), ("stiff", "local", 200, 20, 5), ("stiff", "local", 1000, 0, 0),
    ("soft", "local", 100, 0, 0), ("membrane", "local", 100, 0, 0), ("moving", "local", 100, 0, 0)]
FORCE_LIMIT = 3.3  # [N]
MIN_NOISE_ENERGY = -1e-3  # [J]: noise explains no lower energy
MAX_TICK_PERIOD = 2e-3  # [s]: a tick that follows later than this is late
DELAYS = [("state_delay_us", "p50"), ("state_delay_us", "p99"), ("state_delay_us", "max"), ("state_age_us", "p50"), ("state_age_us", "p99")]
COLUMNS = ["object", "render", "round_trip_ms", "jitter_pct", "loss_pct", "seed", "seconds", "rms_N", "relative_rms",
           "delay_compensated_rms_N", "delay_compensated_relative", "drift_m", "energy_min_J", "growing", "stale_share", "packets_per_s",
           "rtt_p50_ms", "reconnects", "force_sent_peak_N", "served", "safe", "datagrams", "delay_p50_ms", "delay_p99_ms",
           "delay_max_ms", "age_p50_ms", "age_p99_ms", "hold_s", "late_tick_J"]


def forces_while_following(rows):
    """Returns the magnitudes of the forces sent [N]: one list per uninterrupted interval of FOLLOWING."""
    intervals, number = {}, 0
    for row in rows:
        if row["state"] == "FOLLOWING":
            intervals.setdefault(number, []).append(math.hypot(*(float(row[f"sent_{axis}"]) for axis in "xyz")))
        else:
            number += 1
    return intervals.values()


def oscillation_grows(forces):
    """Returns whether the oscillation above 5 Hz grows: its rms relative to the mean force is three times as large at the end
    as at the beginning. It is relative because a force held from state to state has steps in proportion to the force."""
    width, deviations, means = 100, [], []
    mean = sum(forces[:width]) / width if len(forces) > width else 0
    for k in range(width, len(forces) - width, 1):
        mean += (forces[k + width // 2 - 1] - forces[k - width // 2 - 1]) / width
        deviations.append(forces[k] - mean)
        means.append(mean)
    windows = [(math.sqrt(sum(d * d for d in deviations[k:k + 500]) / 500), sum(means[k:k + 500]) / 500)
               for k in range(0, len(deviations) - 500, 500)]
    min_force = 0.1 * max((force for _, force in windows), default=0)
    in_contact = [(rms, rms / force) for rms, force in windows if force > min_force]
    return len(in_contact) > 2 and in_contact[-1][1] > 3 * max(in_contact[0][1], 0.02) and in_contact[-1][0] > 0.1


def late_tick_energy(rows):
    """Returns the largest energy released during one late tick [J]: the force held meanwhile times the displacement of the
    device. Damping could not prevent it, because the loop did not run."""
    largest = 0.0
    for last, row in zip(rows, rows[1:]):
        if float(row["t"]) - float(last["t"]) > MAX_TICK_PERIOD:
            largest = max(largest, sum(float(last[f"sent_{axis}"]) * (float(row[f"p_M_{axis}"]) - float(last[f"p_M_{axis}"]))
                                       for axis in "xyz"))
    return largest


def drift(rows):
    """Returns how far the commanded tool position has moved when the device is back at its first position [m]."""
    positions = [([float(row[f"p_M_{axis}"]) for axis in "xyz"], [float(row[f"p_S_{axis}"]) for axis in "xyz"])
                 for row in rows if row["state"] == "FOLLOWING"]
    if not positions:
        return 0.0
    first_device, first_tool = positions[0]
    distances = [math.dist(first_tool, tool) for device, tool in positions if math.dist(device, first_device) < 1e-5]
    return min(distances[-1], 1.0) if distances else 0.0


def run_session(link, kind, render, seconds, trip, folder, datagrams):
    """Runs a session of `seconds` over `link`, whose round trip is about `trip` [s]. Returns its report and the rows of its log."""
    scene = ROOT / "deploy/scenes" / f"{OBJECTS[kind]}.yaml"
    report, log = folder / "report.json", folder / "log.csv"
    with link:
        serve = [*link.at_slave, SLAVE, "serve", scene, "--listen", f"{SLAVE_ADDRESS}:50051", "--insecure",
                 *(MOTION if kind == "moving" else [])]
        with Slave(command=serve):
            report.unlink(missing_ok=True)
            subprocess.run([*link.at_master, MASTER, "connect", f"{SLAVE_ADDRESS}:50051", "--insecure", "--render", render,
                            "--wait", str(20 + 8 * trip), "--duration", str(seconds), "--report", report, "--log", log,
                            *([] if datagrams else ["--no-datagrams"])],
                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=BARE, timeout=seconds + 90 + 16 * trip)
    if not report.exists():
        return None, []
    return json.loads(report.read_text()), list(csv.DictReader(log.open()))


def run_cell(kind, render, trip, jitter, loss, seed, datagrams):
    # After idling a TCP stream needs some round trips to reach 200 states per second. A pinch takes longer than a press.
    seconds = (20 if kind == "soft" else 8) + 16 * trip / 1000
    with tempfile.TemporaryDirectory() as folder:
        link = ImpairedLink(trip / 1000, jitter / 100, loss / 100, seed)
        printed, rows = run_session(link, kind, render, seconds, trip / 1000, pathlib.Path(folder), datagrams)
    if printed is None:  # no connection, so no force
        return dict.fromkeys(COLUMNS, "") | dict(zip(COLUMNS, [kind, render, trip, jitter, loss, seed, seconds])) | {
            "served": 0, "safe": 1, "datagrams": 0}
    error, compensated = printed["force_error"] or {}, printed.get("force_error_delay_compensated") or {}
    # The first contact is excluded, so one contact gives no figure. The force of a moving object depends on more than
    # the position, so it gives none either.
    compensated = compensated if compensated.get("contact_ticks") and kind != "moving" else {}
    grows = any(oscillation_grows(forces) for forces in forces_while_following(rows))
    safe = printed["force_sent_peak_N"] <= FORCE_LIMIT + 1e-6 and printed["energy_min_J"] >= MIN_NOISE_ENERGY and not grows
    return dict(zip(COLUMNS, [
        kind, render, trip, jitter, loss, seed, seconds, error.get("rms_N", ""), error.get("relative_rms", ""),
        compensated.get("rms_N", ""), compensated.get("relative_rms", ""), f"{drift(rows):.2e}", printed["energy_min_J"], int(grows),
        round(printed["stale_ticks"] / max(printed["ticks"], 1), 4),
        round((printed["states"] + printed["commands"]) / printed["duration_s"], 1), round(printed["rtt_us"]["p50"] / 1000, 2),
        printed["reconnects"], printed["force_sent_peak_N"], int(printed["states"] > 0), int(safe), int(printed["states_by_datagram"] > 0),
        *(round(printed[times][q] / 1000, 2) for times, q in DELAYS), round(printed["seconds_in"].get("HOLD", 0), 3),
        round(late_tick_energy(rows), 7)]))


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
    if not can_impair_links():
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
        for ended in concurrent.futures.as_completed([sessions.submit(run_cell, *one, a.seed, not a.stream) for one in missing]):
            row = ended.result()
            writer.writerow(row)
            out.flush()
            unsafe += not row["safe"]
            print(" ".join(f"{column}={row[column]}" for column in COLUMNS if row[column] != ""), flush=True)
    print(f"{unsafe} unsafe cells; seed {a.seed}, {time.monotonic() - begin:.0f} s")
    return 1 if unsafe else 0


if __name__ == "__main__":
    sys.exit(main())
