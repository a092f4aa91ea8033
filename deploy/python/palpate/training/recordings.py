"""Recordings of a fingertip with measured forces: reading, contacts, and their split."""
from __future__ import annotations

import copy
import csv
import dataclasses
import math
import pathlib
import re
from typing import Sequence

import numpy as np
import numpy.typing as npt

from palpate.formats import what_is

Array = npt.NDArray[np.float64]
Windows = npt.NDArray[np.int64]  # n x 2: recording and last sample

RATE = 100.0  # sample rate of the networks [Hz]
ELECTRODES = tuple(f"E{i}" for i in range(1, 20))
SIGNALS = (*ELECTRODES, "pac0", "pdc")
WINDOW = 50  # samples

TIME_COLUMNS = ("rel_time_s", "time_s", "t_s", "t", "time", "timestamp")
FORCE_UNITS = {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216152605}
MAX_CHANNELS = 256
MAX_CONSTANT = 5.0  # a channel that is constant for longer cannot be distinguished from a dead one [s]
MAX_FORCE_GAP = 0.1  # longer gaps of a force sensor are not interpolated [s]
OFFSET_TIME = 0.5  # mean force of this time is the force sensor's offset [s]
TIME_UNITS = (("nanoseconds", 1e-9), ("microseconds", 1e-6), ("milliseconds", 1e-3))
MAX_GAP = 3  # periods; a longer step is a gap
SAME_PERIOD = 0.1  # relative difference up to which samples are used unchanged

MAX_FORCE = 200.0  # a fingertip and its sensor would not withstand more [N]
REVERSED = 0.5  # mean fz relative to the mean force in contact; above it the recorded force is the reaction
PULLS = 0.1  # share of the contact with fz > 0 above which a remark is printed
REST_CHANGE = 0.05  # largest change of the force in the time without contact, relative to the largest force
REST_NOISES = 5  # the same limit in rms of the force without contact

CONTACT_SHARE = 0.05  # contact: force above this share of the largest one
PAUSE = 0.5  # shorter pauses belong to the contact [s]
MIN_CONTACT = 0.1  # shorter contacts are spikes of the force sensor [s]
SET_ASIDE = 0.2
ENOUGH_RECORDINGS = 5
MIN_PART = 60  # samples: a window of 50 and a few more


@dataclasses.dataclass(frozen=True)
class Sensor:
    """Columns of a recording. Default: the 19 electrodes of a fingertip and its two pressures."""
    unit: str = ""  # of the channels; empty: electrodes
    prefix: str = "E"  # prefix of the channels' columns
    rate: float = RATE  # of the samples [Hz]
    normal: tuple[str, float] | None = None  # column and factor [N] of fz, the only measured force

    @property
    def are_electrodes(self) -> bool:
        return not self.unit


class InputError(ValueError):
    """Data that cannot be used; the message names the file and the reason."""


@dataclasses.dataclass(frozen=True)
class DataArgument:
    """TACTILE.csv[+WRENCH.csv][@FROM:TO]"""
    text: str
    tactile: pathlib.Path
    wrench: pathlib.Path | None = None
    start: float = -math.inf  # [s], of the tactile file's clock
    end: float = math.inf

    @property
    def name(self) -> str:
        """The argument without folders."""
        text = self.tactile.name + (f"+{self.wrench.name}" if self.wrench else "")
        sliced = math.isfinite(self.start) or math.isfinite(self.end)
        return text + (self.text[self.text.rindex("@"):] if sliced else "")


@dataclasses.dataclass
class Recording:
    """One fingertip without a gap at RATE. `change`: counts minus baseline, n x 21; `force`: of the fingertip on the
    object, frame F, n x 3 [N]. Windows may begin before the selected samples [begin, end)."""
    name: str
    file: pathlib.Path
    t: Array
    change: Array
    force: Array
    begin: int = 0
    end: int = 0
    constant: float = 0.0  # longest time for which a channel stayed the same [s]
    baseline: Array = dataclasses.field(default_factory=lambda: np.zeros(0))  # the baseline that was subtracted
    baseline_time: float = 0.0  # middle of the time over which it was averaged, in the clock of t [s]
    missing: str = ""  # pac0 or pdc if the file lacks it; that signal is 0


@dataclasses.dataclass(frozen=True)
class Stretch:
    """Samples [begin, end) of a recording, usually one contact. Windows begin at `look_back` or later."""
    recording: int
    begin: int
    end: int
    look_back: int


@dataclasses.dataclass
class Split:
    train: list[Stretch]
    validation: list[Stretch]
    test: list[Stretch]
    how: str


class Table:
    """A CSV file with one header row. Lines that begin with # are comments."""

    def __init__(self, file: pathlib.Path) -> None:
        self.file = file
        self.lines: list[int] = []  # of the rows
        self.header = 1  # its line
        self.names: list[str] = []
        self.rows: list[list[str]] = []
        if foreign := what_is(file):
            raise InputError(f"{file}: {foreign}: expected a CSV file")
        try:
            with open(file, newline="", encoding="utf-8-sig") as stream:
                for number, row in enumerate(csv.reader(stream), 1):
                    if not any(cell.strip() for cell in row) or row[0].lstrip().startswith("#"):
                        continue
                    if not self.names:
                        self.names, self.header = [cell.strip() for cell in row], number
                        continue
                    if len(row) != len(self.names):
                        raise InputError(f"{file}:{number}: {len(row)} columns, expected {len(self.names)} as in the header")
                    self.rows.append(row)
                    self.lines.append(number)
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise InputError(f"{file}: cannot be read: {error}") from error
        if not self.rows:
            raise InputError(f"{file}: no samples: expected a header and one row or more")

    def find(self, *names: str) -> int | None:
        """Index of the first of these columns that exists. Raises InputError: it occurs twice."""
        for name in names:
            if self.names.count(name) > 1:
                raise InputError(f"{self.file}:{self.header}: column {name} occurs twice: expected one recording in a table")
            if name in self.names:
                return self.names.index(name)
        return None

    def numbers(self, column: int) -> Array:
        values = np.empty(len(self.rows))
        for i, row in enumerate(self.rows):
            try:
                values[i] = float(row[column])
            except ValueError:
                values[i] = math.nan
            if not math.isfinite(values[i]):
                raise InputError(f"{self.file}:{self.lines[i]}: {self.names[column]} = {row[column] or 'nothing'}: "
                                 "expected a finite number")
        return values

    def without_empty(self, column: int) -> "Table":
        """Returns a table of the rows in which this column has a value."""
        used = copy.copy(self)
        kept = [i for i, row in enumerate(self.rows) if row[column].strip()]
        used.rows, used.lines = [self.rows[i] for i in kept], [self.lines[i] for i in kept]
        if not kept:
            raise InputError(f"{self.file}: column {self.names[column]} is empty: expected a force")
        return used

    def times(self) -> Array:
        column = self.find(*TIME_COLUMNS)
        if column is None:
            raise InputError(f"{self.file}: no time: expected a column {', '.join(TIME_COLUMNS)} [s]")
        t = self.numbers(column)
        falls = np.flatnonzero(np.diff(t) < 0)
        if len(falls):
            raise InputError(f"{self.file}:{self.lines[int(falls[0]) + 1]}: the time decreases")
        return t


def parse_argument(text: str) -> DataArgument:
    """Raises InputError: an invalid slice, an empty name."""
    files, start, end = text, -math.inf, math.inf
    if "@" in files and not pathlib.Path(files).exists():
        files, _, window = files.rpartition("@")
        match = re.fullmatch(r"([^:]*):([^:]*)", window)
        try:
            if not match:
                raise ValueError
            start, end = (float(part) if part else default for part, default in zip(match.groups(), (start, end)))
            if not start < end:
                raise ValueError
        except ValueError:
            raise InputError(f"{text}: @{window}: expected @FROM:TO in seconds, FROM < TO") from None
    tactile, plus, wrench = (files, "", "") if pathlib.Path(files).exists() else files.partition("+")
    if not tactile or (plus and not wrench):
        raise InputError(f"{text}: expected TACTILE.csv, TACTILE.csv+WRENCH.csv, either with @FROM:TO, or a folder")
    return DataArgument(text, pathlib.Path(tactile), pathlib.Path(wrench) if wrench else None, start, end)


def parse_arguments(texts: Sequence[str]) -> list[DataArgument]:
    """Parses arguments. A folder stands for its CSV files in alphabetical order."""
    arguments: list[DataArgument] = []
    for text in texts:
        if pathlib.Path(text).is_dir():
            files = sorted(pathlib.Path(text).glob("*.csv"))
            if not files:
                raise InputError(f"{text}: a folder without CSV files")
            arguments += [DataArgument(str(file), file) for file in files]
        else:
            arguments.append(parse_argument(text))
    return arguments


def refuse_repetitions(arguments: Sequence[DataArgument]) -> None:
    """Raises InputError where two arguments contain the same samples, which would count twice."""
    seen: dict[pathlib.Path, list[DataArgument]] = {}
    for argument in arguments:
        for other in seen.setdefault(argument.tactile.resolve(), []):
            if argument.start < other.end and other.start < argument.end:
                raise InputError(f"{other.text} and {argument.text} share samples: expected each sample once")
        seen[argument.tactile.resolve()].append(argument)


def fingers_of(table: Table) -> list[str]:
    """Returns the prefixes of the fingers in a table; the prefix is empty for columns without one."""
    prefixes = [re.sub(r"(E|ele)1$", "", name) for name in table.names if re.search(r"(^|_)(E|ele)1$", name)]
    return list(dict.fromkeys(prefixes))


def _signals(table: Table, finger: str) -> tuple[Array, str]:
    """Returns n x 21 counts and the name of a missing pressure column."""
    prefixes = fingers_of(table)
    if finger:
        prefixes = [prefix for prefix in prefixes if prefix in ("", finger + "_")]
    if not prefixes:
        raise InputError(f"{table.file}: no electrodes E1 to E19" + (f" of finger {finger}" if finger else ""))
    if len(prefixes) > 1:
        raise InputError(f"{table.file}: several fingers: choose one with --finger: "
                         + ", ".join(prefix.rstrip("_") for prefix in prefixes))
    prefix, missing = prefixes[0], ""
    counts = np.zeros((len(table.rows), len(SIGNALS)))
    for i, signal in enumerate(SIGNALS):
        other = signal.replace("E", "ele") if signal.startswith("E") else {"pac0": "pac1"}.get(signal, signal)
        column = table.find(prefix + signal, prefix + other)
        if column is not None:
            counts[:, i] = table.numbers(column)
        elif signal in ELECTRODES:
            raise InputError(f"{table.file}: no column {prefix}{signal}")
        else:
            missing = missing or prefix + signal
    return counts, missing


def _channels(table: Table, finger: str, sensor: Sensor) -> Array:
    """Returns the channels, n x channels, in the unit of the sensor."""
    where, own = f"{table.file}:{table.header}", f"{finger}_" if finger else ""
    found: dict[str, dict[int, int]] = {}
    for title in table.names:
        if re.fullmatch(rf"(|\w+_){re.escape(sensor.prefix)}0\d*(?: ?[\[(].*[\])])?", title):
            raise InputError(f"{where}: column {title}: channels are counted from {sensor.prefix}1, without leading zeros: expected "
                             f"{own}{sensor.prefix}1 to {own}{sensor.prefix}N")
    for column, title in enumerate(table.names):
        match = re.fullmatch(rf"(|\w+_){re.escape(sensor.prefix)}([1-9]\d*)(?: ?[\[(](.*)[\])])?", title)
        if not match or (own and match[1] not in ("", own)):
            continue
        if match[3] is not None and match[3] != sensor.unit:
            raise InputError(f"{where}: column {title}: expected the unit [{sensor.unit}]")
        if int(match[2]) in found.setdefault(match[1], {}):
            raise InputError(f"{where}: column {title} occurs twice: expected one recording in a table")
        found[match[1]][int(match[2])] = column
    if not found:
        raise InputError(f"{where}: no column {own}{sensor.prefix}1: expected {own}{sensor.prefix}1 to {own}{sensor.prefix}N")
    if len(found) > 1:
        raise InputError(f"{where}: several fingers: choose one with --finger: " + ", ".join(p.rstrip("_") for p in found))
    (prefix, columns), = found.items()
    for k in range(1, max(columns) + 1):
        if k not in columns:
            raise InputError(f"{where}: no column {prefix}{sensor.prefix}{k}: expected all up to {max(columns)}")
    if len(columns) > MAX_CHANNELS:
        raise InputError(f"{where}: {len(columns)} channels: expected 1 to {MAX_CHANNELS}")
    return np.stack([table.numbers(columns[k]) for k in sorted(columns)], axis=1)


def _longest_constant(t: Array, values: Array) -> float:
    longest = 0.0
    for column in values.T:
        changes = np.flatnonzero(np.concatenate([[True], np.diff(column) != 0, [True]]))
        last = np.minimum(changes[1:], len(t) - 1)
        longest = max(longest, float((t[last] - t[changes[:-1]]).max()))
    return longest


def _force_columns(table: Table) -> list[tuple[int, float]]:
    """Returns column and unit [N] of fx, fy and fz: `fx`, `fx_N`, `fx [mN]`. Raises InputError: none, or a unit that is
    no force."""
    found: dict[str, tuple[int, float]] = {}
    for column, title in enumerate(table.names):
        match = re.fullmatch(r"f([xyz])(?: ?[\[(] ?(.*?) ?[\])]|_(\w+))?", title)
        if not match:
            continue
        if match[1] in found:
            raise InputError(f"{table.file}:{table.header}: column {title} is a second f{match[1]}: expected one force in a table")
        unit = match[2] if match[2] is not None else match[3] or "N"
        if unit not in FORCE_UNITS:
            raise InputError(f"{table.file}:{table.header}: column {title}: expected a force in {', '.join(FORCE_UNITS)}")
        found[match[1]] = column, FORCE_UNITS[unit]
    if len(found) < 3:
        raise InputError(f"{table.file}: no force columns: expected fx, fy, fz [N], or with another unit as in fx [mN], "
                         "or a file with them: TACTILE.csv+WRENCH.csv")
    return [found[axis] for axis in "xyz"]


class ForceCurve:
    """Recorded forces of a force sensor, minus the mean of its first half second."""

    def __init__(self, table: Table, sensor: Sensor = Sensor()) -> None:
        self.gap = max(MAX_FORCE_GAP, MAX_GAP / sensor.rate)
        if sensor.normal is not None:
            column = table.find(sensor.normal[0])
            if column is None:
                raise InputError(f"{table.file}:{table.header}: no column {sensor.normal[0]}: expected the normal force")
            table = table.without_empty(column)
            self.t, first = np.unique(table.times(), return_index=True)
            fz = sensor.normal[1] * table.numbers(column)[first]
            fz -= fz[self.t - self.t[0] < OFFSET_TIME].mean()
            self.force = np.stack([np.zeros_like(fz), np.zeros_like(fz), fz], axis=1)
            return
        self.t, first = np.unique(table.times(), return_index=True)
        force = np.stack([unit * table.numbers(column) for column, unit in _force_columns(table)], axis=1)[first]
        self.force = force - force[self.t - self.t[0] < OFFSET_TIME].mean(axis=0)

    def at(self, t: Array) -> Array:
        """Returns the forces at times t, n x 3 [N]. NaN before the first sample, after the last one and in gaps."""
        force = np.stack([np.interp(t, self.t, self.force[:, k]) for k in range(3)], axis=1)
        after = np.clip(np.searchsorted(self.t, t), 0, len(self.t) - 1)
        before = np.maximum(after - 1, 0)
        between = self.t[after] != t
        unknown = (t < self.t[0]) | (t > self.t[-1]) | (between & (self.t[after] - self.t[before] > self.gap))
        force[unknown] = math.nan
        return force


def _instants(file: pathlib.Path, t: Array, rate: float) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Returns the times of samples at `rate`, and which of them follow a gap."""
    steps = np.diff(t)
    period = float(np.median(steps)) if len(steps) else 1 / rate
    if period > 4 / rate:
        likely = [f"; in {unit} this would be {period * size:.3g} s: expected times in seconds" for unit, size in TIME_UNITS
                  if 0.25 / rate <= period * size <= 4 / rate]
        raise InputError(f"{file}: a sample every {period:.3g} s: expected at most {4 / rate:.3g} s, or another --sample-rate"
                         + "".join(likely[:1]))
    step = period if abs(period - 1 / rate) <= SAME_PERIOD / rate else 1 / rate
    largest = MAX_GAP * max(period, 1 / rate)
    cuts = [0, *(int(i) + 1 for i in np.flatnonzero(steps > largest)), len(t)]
    times: list[Array] = []
    for begin, end in zip(cuts, cuts[1:]):
        if step == period:
            whole = [t[begin:begin + 1]]
            for i in range(begin + 1, end):
                # After a late timestamp the next one seems early. This is no gap.
                around = t[min(i + 1, end - 1)] - t[max(i - 2, begin)]
                count = min(i + 1, end - 1) - max(i - 2, begin)
                missing = min(round(steps[i - 1] / period) - 1, round(around / period) - count)
                whole.append(np.linspace(t[i - 1], t[i], max(missing, 0) + 2)[1:])
            times.append(np.concatenate(whole))
        else:
            times.append(np.arange(t[begin], t[end - 1] + 1e-9, step))
    after_gap = np.concatenate([np.arange(len(part)) == 0 for part in times])
    return np.concatenate(times), after_gap


def read_recording(data: DataArgument, finger: str, rest_samples: int, sensor: Sensor = Sensor()) -> list[Recording]:
    """Reads a recording. Returns several if it has gaps, or times with unknown force."""
    table = Table(data.tactile)
    times = table.times()
    counts, missing = _signals(table, finger) if sensor.are_electrodes else (_channels(table, finger, sensor), "")
    unique, first = np.unique(times, return_index=True)
    counts = counts[first]
    curve = ForceCurve(table if data.wrench is None else Table(data.wrench), sensor)
    t, after_gap = _instants(data.tactile, unique, sensor.rate)
    if len(t) < rest_samples:
        raise InputError(f"{data.tactile}: {len(t)} samples: too few for a baseline from the first {rest_samples}")
    signals = np.stack([np.interp(t, unique, counts[:, k]) for k in range(counts.shape[1])], axis=1)
    baseline = signals[:rest_samples].mean(axis=0)
    change = signals - baseline
    force = curve.at(t)
    known = np.isfinite(force).all(axis=1)
    if not known.any():
        raise InputError(f"{data.text}: the force's times and the samples' do not overlap")
    starts = known & (after_gap | ~np.concatenate([[False], known[:-1]]))
    part = np.where(known, np.cumsum(starts), 0)
    recordings = []
    for k in range(1, int(part.max()) + 1):
        rows = part == k
        begin, end = np.searchsorted(t[rows], (data.start, data.end))
        if begin < end:
            recordings.append(Recording(data.text, data.tactile, t[rows], change[rows], force[rows], int(begin), int(end),
                                        _longest_constant(unique, counts), baseline, float(t[:rest_samples].mean()), missing))
    if not recordings:
        raise InputError(f"{data.text}: no samples between these times: the recording has {t[0]:g} to {t[-1]:g} s")
    return recordings


def read_recordings(arguments: Sequence[DataArgument], finger: str, rest_samples: int,
                    sensor: Sensor = Sensor()) -> list[Recording]:
    recordings = [recording for data in arguments for recording in read_recording(data, finger, rest_samples, sensor)]
    require_same_channels(recordings)
    if recordings:
        require_presses(recordings, rest_samples)
    return recordings


def require_presses(recordings: Sequence[Recording], rest_samples: int) -> None:
    """Raises InputError if the force is not that of the fingertip on the object, or the baseline was measured in
    contact."""
    force = np.concatenate([r.force[r.begin:r.end] for r in recordings])
    size = np.linalg.norm(force, axis=1)
    touches = size > CONTACT_SHARE * size.max()
    along = force[touches, 2].mean() / size[touches].mean() if touches.any() else 0.0
    if along > REVERSED:
        raise InputError(f"{recordings[0].name}: contacts have fz > 0 (mean {force[touches, 2].mean():+.3g} N): expected the force of the "
                         "fingertip on the object, whose fz is negative: the sign of this one is that of the reaction, or the recording "
                         "begins in contact")
    for r in recordings:
        if r.t[0] - r.baseline_time > OFFSET_TIME:
            continue  # a later piece of a recording with a gap
        rest = r.force[:rest_samples]
        third = len(rest) // 3
        if third < 2:
            continue
        change = np.linalg.norm(rest[-third:].mean(axis=0) - rest[:third].mean(axis=0))
        noise = np.linalg.norm(np.diff(rest, axis=0), axis=1).mean()
        if change > REST_CHANGE * size.max() and change > REST_NOISES * noise:
            raise InputError(f"{r.name}: the force changes by {change:.3g} N within the first {rest_samples} samples: expected a "
                             "beginning without contact, or --rest N with fewer samples")


def remarks_on(recordings: Sequence[Recording]) -> list[str]:
    """Returns remarks on unlikely data: forces in another unit, pulling forces."""
    force = np.concatenate([r.force[r.begin:r.end] for r in recordings])
    size = np.linalg.norm(force, axis=1)
    remarks = []
    if size.max() > MAX_FORCE:
        remarks.append(f"forces up to {size.max():.4g} N: more than a fingertip bears; in millinewtons these are {1e-3 * size.max():.4g} N: "
                       "then name the columns fx [mN], fy [mN], fz [mN], or divide FACTOR of --normal by 1000")
    touches = size > CONTACT_SHARE * size.max()
    pulls = float((force[touches, 2] > CONTACT_SHARE * size.max()).mean()) if touches.any() else 0.0
    if pulls > PULLS:
        remarks.append(f"fz > 0 in {100 * pulls:.0f} % of the contacts: a pull. A recording that begins in contact has such forces later")
    return remarks


def require_same_channels(recordings: Sequence[Recording]) -> None:
    """Raises InputError where a recording has another number of channels than the first."""
    for r in recordings:
        if r.change.shape[1] != recordings[0].change.shape[1]:
            raise InputError(f"{r.file}: {r.change.shape[1]} channels: expected {recordings[0].change.shape[1]} as in "
                             f"{recordings[0].file}")


def _contacts(recording: Recording, threshold: float) -> list[tuple[int, int]]:
    contacts: list[tuple[int, int]] = []
    size = np.linalg.norm(recording.force, axis=1)
    for i in range(recording.begin, recording.end):
        if not size[i] > threshold:
            continue
        if contacts and recording.t[i] - recording.t[contacts[-1][1] - 1] < PAUSE:
            contacts[-1] = (contacts[-1][0], i + 1)
        else:
            contacts.append((i, i + 1))
    return [(a, b) for a, b in contacts if recording.t[b - 1] - recording.t[a] >= MIN_CONTACT]


def find_contacts(recordings: Sequence[Recording]) -> list[Stretch]:
    """Stretches of contact, each with half of the quiet time around it."""
    largest = max((float(np.linalg.norm(r.force[r.begin:r.end], axis=1).max()) for r in recordings), default=0.0)
    stretches: list[Stretch] = []
    for k, r in enumerate(recordings):
        contacts = _contacts(r, CONTACT_SHARE * largest)
        begin = r.begin
        for i, (_, end) in enumerate(contacts):
            until = (end + contacts[i + 1][0]) // 2 if i + 1 < len(contacts) else r.end
            stretches.append(Stretch(k, begin, until, begin))
            begin = until
    return stretches


class MersenneTwister64:
    """The generator std::mt19937_64. With it a seed selects the same contacts as in earlier versions."""

    def __init__(self, seed: int) -> None:
        self.state = [seed % 2**64]
        for i in range(1, 312):
            last = self.state[-1]
            self.state.append((6364136223846793005 * (last ^ (last >> 62)) + i) % 2**64)
        self.at = 312

    def __call__(self) -> int:
        if self.at == 312:
            for i in range(312):
                x = (self.state[i] & 0xFFFFFFFF80000000) | (self.state[(i + 1) % 312] & 0x7FFFFFFF)
                self.state[i] = self.state[(i + 156) % 312] ^ (x >> 1) ^ (0xB5026F5AA96619E9 if x & 1 else 0)
            self.at = 0
        x = self.state[self.at]
        self.at += 1
        x ^= (x >> 29) & 0x5555555555555555
        x ^= (x << 17) & 0x71D67FFFEDA60000
        x ^= (x << 37) & 0xFFF7EEE000000000
        return x ^ (x >> 43)


def _take_fifth(units: list[list[Stretch]]) -> list[Stretch]:
    wanted = max(1, math.floor(SET_ASIDE * len(units) + 0.5))
    return [stretch for _ in range(wanted) for stretch in units.pop()]


def _take_parts(stretches: list[Stretch]) -> tuple[list[Stretch], list[Stretch]]:
    """Returns parts of every stretch, and the remaining stretches, whose windows do not reach back into them."""
    taken, left = [], []
    for s in stretches:
        tenth = (s.end - s.begin) // 10
        cuts = [(3, 4), (6, 7)] if tenth >= MIN_PART else [(4, 6)] if 2 * tenth >= MIN_PART else []
        begin, look_back = s.begin, s.look_back
        for first, last in cuts:
            left.append(Stretch(s.recording, begin, s.begin + first * tenth, look_back))
            taken.append(Stretch(s.recording, s.begin + first * tenth, s.begin + last * tenth, s.begin + first * tenth))
            begin = look_back = s.begin + last * tenth
        left.append(Stretch(s.recording, begin, s.end, look_back))
    return taken, left


def split_contacts(recordings: Sequence[Recording], test_is_apart: bool, seed: int) -> Split:
    """Splits as the paper (IV.A): 80 % for training and 20 % for the test, a fifth of the first for validation; by
    whole recordings if there are five or more, otherwise by whole contacts. Raises InputError: no contact."""
    contacts = find_contacts(recordings)
    if not contacts:
        raise InputError("the recordings contain no contact")
    by_recording = len({c.recording for c in contacts}) >= ENOUGH_RECORDINGS
    units: list[list[Stretch]] = []
    for contact in contacts:
        if by_recording and units and units[-1][0].recording == contact.recording:
            units[-1].append(contact)
        else:
            units.append([contact])
    random = MersenneTwister64(seed)
    for i in range(len(units), 1, -1):
        k = random() % i
        units[i - 1], units[k] = units[k], units[i - 1]

    def count(n: int) -> str:
        return f"{n} {'recording' if by_recording else 'contact'}{'' if n == 1 else 's'}"

    test: list[Stretch] = []
    test_text = "a separate set"
    test_by_unit = not test_is_apart and len(units) > 1
    if test_by_unit:
        before = len(units)
        test = _take_fifth(units)
        test_text = count(before - len(units))
    validate_by_unit = len(units) >= 3
    validation: list[Stretch] = []
    validation_text = "parts of the same"
    if validate_by_unit:
        before = len(units)
        validation = _take_fifth(units)
        validation_text = count(before - len(units))
    left = len(units)
    train = [stretch for unit in units for stretch in unit]
    if not test_by_unit and not test_is_apart:
        test, train = _take_parts(train)
        test_text = "parts of the same contact (there is only one: the errors are too small)"
    if not validate_by_unit:
        validation, train = _take_parts(train)
    how = (f"by whole {'recordings' if by_recording else 'contacts'}: train {count(left)}, validation {validation_text}, "
           f"test {test_text}")
    return Split(train, validation, test, how)


def windows_of(stretches: Sequence[Stretch], steps: int) -> Windows:
    """Returns n x 2: recording and last sample of every window of `steps` samples that ends in one of the stretches."""
    parts = [np.zeros((0, 2), np.int64)]
    for s in stretches:
        last = np.arange(max(s.begin, s.look_back + steps - 1), s.end)
        parts.append(np.stack([np.full(len(last), s.recording), last], axis=1))
    return np.concatenate(parts)


def last_samples(recordings: Sequence[Recording], windows: Windows) -> tuple[Array, Array]:
    """Returns signals (n x 21) and forces (n x 3) at the ends of the windows."""
    offsets = np.cumsum([0, *(len(r.t) for r in recordings)])
    rows = offsets[windows[:, 0]] + windows[:, 1]
    return np.concatenate([r.change for r in recordings])[rows], np.concatenate([r.force for r in recordings])[rows]
