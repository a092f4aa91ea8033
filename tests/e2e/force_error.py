"""Error of the force that a slave estimated, from the master's log."""
import csv
import math

MAX_DELAY = 150  # ticks of 1 ms


def vector(row, name):
    return tuple(float(row[f"{name}_{axis}"]) for axis in "xyz") if row[f"{name}_x"] else None


def force_error(log):
    """Compares each estimate with the true force some ticks earlier. Returns for the delay with the smallest error: rms
    error relative to the largest true force, delay [ticks], number of ticks compared."""
    with open(log, encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    truth = [vector(row, "true") for row in rows]
    estimated = [vector(row, "estimated") if row["state"] == "FOLLOWING" else None for row in rows]
    peak = max((math.hypot(*force) for force in truth if force), default=0)
    if peak == 0:
        return math.inf, 0, 0  # there was no contact

    def after(delay):
        pairs = [(estimated[i], truth[i - delay]) for i in range(delay, len(rows)) if estimated[i] and truth[i - delay]]
        squares = [math.dist(*pair) ** 2 for pair in pairs if math.hypot(*pair[1]) > 0.01 * peak]
        return math.sqrt(sum(squares) / max(1, len(squares))) / peak, delay, len(squares)
    return min(after(delay) for delay in range(0, MAX_DELAY, 5))
