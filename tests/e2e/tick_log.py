"""Reads the master's log while it is written."""
import collections
import csv
import math
import signal
import time

from programs import PATIENCE, operate, read_json, wait_until

TICK = 0.001   # [s]
KEPT = 60000   # rows of one minute


class Log:
    """Follows the master's log and keeps its last minute. `behind` is this machine's monotonic clock minus the log's
    time [s]."""

    def __init__(self, file):
        self.file, self.position, self.rows, self.behind = file, 0, [], float("inf")
        self.fields = None

    def follow(self):
        if not self.file.exists():
            return self.rows
        with open(self.file, encoding="ascii") as text:
            text.seek(self.position)
            lines = text.read()
        lines = lines[:lines.rfind("\n") + 1]
        self.position += len(lines)
        lines = lines.splitlines()
        if self.fields is None and lines:
            self.fields, lines = lines[0].split(","), lines[1:]
        new = list(csv.DictReader(lines, self.fields)) if lines else []
        if new:
            self.rows = (self.rows + new)[-KEPT:]
            self.behind = min(self.behind, time.monotonic() - float(new[-1]["t"]))
        return self.rows

    def newest_force(self):
        rows = self.follow()
        return max((force(row) for row in rows[-50:]), default=0)

    def states(self):
        """Returns the number of kept rows by state and reason."""
        return dict(collections.Counter(f"{row['state']} {row['reason']}".strip() for row in self.rows))

    def fell_silent(self, since):
        """Returns the time [s] from `since` (monotonic) to the last tick with a force that a second without force
        follows, without lost ticks. None: there was no such second yet."""
        after = [row for row in self.follow() if float(row["t"]) + self.behind > since]
        estimated = [k for k, row in enumerate(after) if force(row) > 0]
        last = estimated[-1] if estimated else 0
        if len(after) - last < 1000:
            return None
        times = [float(row["t"]) for row in after[:last + 2]]
        lost = sum(max(0.0, b - a - TICK) for a, b in zip(times, times[1:]))
        return max(0.0, times[-1] + self.behind - since - lost) if estimated else 0.0

    def oldest_rendered(self, since):
        """Returns the age of the newest state [s] at the last tick with a force after `since` (monotonic), without lost
        ticks. It is at least the time since the event that ended the states."""
        after = [row for row in self.rows if float(row["t"]) + self.behind > since]
        estimated = [k for k, row in enumerate(after) if force(row) > 0]
        if not estimated:
            return 0.0
        times = [float(row["t"]) for row in after[max(0, estimated[-1] - 200):estimated[-1] + 1]]
        return float(after[estimated[-1]]["age_s"]) - sum(max(0.0, b - a - TICK) for a, b in zip(times, times[1:]))


def whole_rows(file):
    """Returns all complete rows of a log."""
    text = file.read_text() if file.exists() else ""
    return list(csv.DictReader(text[:text.rfind("\n") + 1].splitlines()))


def times_held(states):
    """Counts how often FOLLOWING changed to HOLD or DISCONNECTED."""
    return sum(b in ("HOLD", "DISCONNECTED") and a == "FOLLOWING" for a, b in zip(states, states[1:]))


def force(row):
    return max(abs(float(row[f"sent_{axis}"])) for axis in "xyz")


def followed(rows):
    """Counts the ticks in FOLLOWING with a force."""
    return sum(row["state"] == "FOLLOWING" and force(row) > 0 for row in rows)


def whole_presses(rows):
    """Returns the largest true force [N] of each press that was in FOLLOWING from before the contact until after it."""
    peaks, peak = [], None  # peak is None until a tick in FOLLOWING without force
    for row in rows:
        if row["state"] != "FOLLOWING":
            peak = None
        elif force(row) > 0:
            if peak is not None and row["true_x"]:
                peak = max(peak, math.hypot(*(float(row[f"true_{axis}"]) for axis in "xyz")))
        else:
            peaks += [peak] if peak else []
            peak = 0.0
    return peaks


def press_until(enough, address, folder, *arguments):
    """Runs a simulated operator until `enough(rows)` is true for the rows of log.csv. Returns (report, output). A busy
    machine may hold the tool at any time; the operator then engages again, as a person does."""
    log = Log(folder / "log.csv")
    with (folder / "output").open("w") as printed:
        master = operate(address, "--report", folder / "report.json", "--log", log.file, *arguments, stdout=printed)
    try:
        is_enough = wait_until(lambda: enough(log.follow()))
        master.send_signal(signal.SIGINT)
        master.wait(timeout=PATIENCE)
    finally:
        master.kill()
        master.wait()
    if not is_enough or master.returncode != 0:
        raise AssertionError(f"exit code {master.returncode}; {log.states()}; {(folder / 'output').read_text()}")
    return read_json(folder / "report.json"), (folder / "output").read_text()
