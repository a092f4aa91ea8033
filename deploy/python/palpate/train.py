"""Trains the force network of a fingertip (paper B, III.A.1 and IV.A): `python3 -m palpate.train`."""
from __future__ import annotations

import argparse
import csv
import dataclasses
import math
import os
import pathlib
import signal
import sys
from typing import Any, Sequence

import numpy as np

from palpate.training import networks, pattern, quadratic
from palpate.training.errors import ErrorLaw, ForceErrors, compare_forces, force_table
from palpate.training.networks import ARCHITECTURES, NETWORK_FILE, Network, Options
from palpate.training.recordings import (WINDOW, Array, DataArgument, InputError, Recording, Sensor, Split, Stretch, Windows,
                                         last_samples, parse_arguments, read_recordings, refuse_repetitions,
                                         remarks_on, require_same_channels, split_contacts, windows_of)

MIN_WINDOWS = 100  # one second of samples
QUICK_TEST = 10_000  # windows that are tested after a stop
MIN_FORCE = 1e-6  # an fz that varies by less is constant [N]
MIN_CORRELATION = 0.5  # correlation of fz below which a gain is rejected
REST_TIME = 0.5  # time without contact at the beginning of a recording [s]

EPILOG = """DATA is one of
  TACTILE.csv              with force columns fx,fy,fz [N], or with their unit: fx_N, fx [mN], in N mN uN kN gf kgf lbf
  TACTILE.csv+WRENCH.csv   force from a second file, interpolated to the tactile times
  FOLDER                   all its CSV files, for example those of `palpate-simulator presses`
A file may end with @FROM:TO to use these seconds only. The force is that of the fingertip on the object, in the fingertip
frame: x points to the tip and a contact on the pad has fz < 0. The baseline is the mean of a recording's first samples.
The force offset is the mean of its first half second. Start every recording without contact.

A fifth of the contacts is used for the test. A fifth of the others is used for validation. With five or more recordings
the split is by whole recordings, otherwise by whole contacts. With --from only a gain is fitted.

With --unit the sensor is any other one: columns c1 to cN (or --channels PREFIX), 1 to 256 channels in this unit. Its
network is quadratic in the channels (qnn_N). Its errors are those of a fifth of the contacts (with five or more recordings
of the recordings) at a time, estimated from the others.

Examples:
  palpate-simulator presses --out build/presses
  python3 -m palpate.train build/presses --network all --out build/fingertip
  python3 -m palpate.train day1.csv day2.csv+wrench2.csv --finger rf --out build/rf
  python3 -m palpate.train rec.csv+wrench.csv@0:9.5 --test rec.csv+wrench.csv@9.5:15 --finger rf --out build/rf
  python3 -m palpate.train rec.csv@0:9.5 --test rec.csv@9.5:15 --from build/rf --out build/gain
"""


class Stop:
    """Ends the training early on Ctrl+C or SIGTERM. The weights learnt so far are kept."""

    def __init__(self) -> None:
        self.requested = False
        self.shown = -1
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: setattr(self, "requested", True))

    def progress(self, name: str, done: float) -> bool:
        if sys.stderr.isatty() and int(100 * done) != self.shown:
            self.shown = int(100 * done)
            print(f"\rtrain {name}: {self.shown} %", end="", file=sys.stderr, flush=True)
        return not self.requested

    def end_line(self) -> None:
        if sys.stderr.isatty() and self.shown >= 0:
            print(file=sys.stderr)
        self.shown = -1


@dataclasses.dataclass
class Data:
    recordings: list[Recording]
    test: list[Recording]
    split: Split

    @property
    def test_recordings(self) -> list[Recording]:
        return self.test or self.recordings


def remark(recordings: Sequence[Recording]) -> None:
    for line in remarks_on(recordings):
        print(f"train: {line}", file=sys.stderr)


def whole(recordings: Sequence[Recording]) -> list[Stretch]:
    return [Stretch(i, r.begin, r.end, 0) for i, r in enumerate(recordings)]


def require_signals(recordings: Sequence[Recording], name: str, inputs: int) -> None:
    for r in recordings:
        if inputs > 19 and r.missing:
            raise InputError(f"{r.name}: no column {r.missing}: network {name} takes E1 to E19, pac0 and pdc")


def read_data(arguments: argparse.Namespace, data: list[DataArgument], test: list[DataArgument]) -> Data:
    recordings = read_recordings(data, arguments.finger, arguments.rest)
    tested = read_recordings(test, arguments.finger, arguments.rest)
    remark(recordings + tested)
    split = split_contacts(recordings, bool(test), arguments.seed)
    split.test += [Stretch(i, r.begin, r.end, r.begin) for i, r in enumerate(tested)]
    return Data(recordings, tested, split)


def enough(stretches: Sequence[Stretch], part: str, fewest: int) -> Windows:
    windows = windows_of(stretches, WINDOW)
    if len(windows) < fewest:
        raise InputError(f"too few samples: {len(windows)} windows of {WINDOW} samples for {part}, needed are {fewest}")
    return windows


def measured(recordings: Sequence[Recording], windows: Windows) -> Array:
    return last_samples(recordings, windows)[1]


def axes(values: Array) -> list[float | None]:
    return [float(v) if math.isfinite(v) else None for v in values]


def train_one(arguments: argparse.Namespace, names: str, data: Data, architecture: str, folder: pathlib.Path,
              stop: Stop) -> ForceErrors:
    train = enough(data.split.train, "training", MIN_WINDOWS)
    validation = enough(data.split.validation, "validation", MIN_WINDOWS // 10)
    test = enough(data.split.test, "the test", 1)
    options = Options(architecture, arguments.optimiser, arguments.rate, arguments.epochs, arguments.patience, arguments.batch,
                      arguments.seed)
    network, epochs, best, stopped = networks.train(data.recordings, train, validation, options,
                                                    lambda done: stop.progress(architecture, done))
    stop.end_line()
    network.pattern = pattern.learn_pattern(data.recordings, train)
    network.origin = f"palpate.train {names} --network {architecture} --epochs {arguments.epochs} --seed {arguments.seed}"
    network.training = {"data": names, "split": data.split.how, "optimiser": arguments.optimiser, "rate": arguments.rate,
                        "batch": arguments.batch, "seed": arguments.seed, "epochs": len(epochs), "best_epoch": best,
                        "stopped": stopped, "train_windows": len(train), "validation_windows": len(validation)}
    folder.mkdir(parents=True, exist_ok=True)
    networks.write_network(folder, network)  # keeps the weights if the test is interrupted
    with open(folder / "training.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["epoch", "loss", "validation_loss"])
        writer.writerows((e.number, f"{e.loss:.9g}", f"{e.validation_loss:.9g}") for e in epochs)
    if stop.requested:
        test = test[:QUICK_TEST]
    estimated = networks.evaluate(network, data.test_recordings, test)
    truth = measured(data.test_recordings, test)
    errors = compare_forces(estimated, truth)
    if network.pattern is not None:
        pattern.learn_errors(network.pattern, data.test_recordings, test, estimated, truth)
    network.sigma, network.rest_sigma, network.law = errors.rmse, errors.at_rest, errors.law
    network.training |= {"test_windows": errors.count, "test_rmse_N": axes(errors.rmse), "test_smse": axes(errors.smse),
                         "test_correlation": axes(errors.correlation)}
    networks.write_network(folder, network)
    print(f"{architecture}: best of {len(epochs)} epochs is {best}{', stopped' if stopped else ''}, {errors.along_normal()}",
          flush=True)
    return errors


def sensor_of(arguments: argparse.Namespace) -> Sensor:
    if arguments.unit is None:
        return Sensor()
    normal = None
    if arguments.normal:
        name, _, factor = arguments.normal.partition("=")
        try:
            normal = name, float(factor)
        except ValueError:
            raise InputError(f"--normal {arguments.normal}: expected COLUMN=FACTOR, the factor in newtons") from None
    return Sensor(arguments.unit, arguments.channels, arguments.sample_rate, normal)


def train_channels(arguments: argparse.Namespace, names: str, data: list[DataArgument], test: list[DataArgument]) -> None:
    sensor = sensor_of(arguments)
    recordings = read_recordings(data, arguments.finger, arguments.rest, sensor)
    tested = read_recordings(test, arguments.finger, arguments.rest, sensor)
    require_same_channels(recordings + tested)
    remark(recordings + tested)
    network, errors, ridge = quadratic.train(recordings, tested, sensor)
    network.origin = f"palpate.train {names} --unit {arguments.unit}"
    network.training = {"data": names, "test": ", ".join(argument.name for argument in test), "ridge": ridge,
                        "test_samples": errors.count, "test_rmse_N": axes(errors.rmse)}
    arguments.out.mkdir(parents=True, exist_ok=True)
    networks.write_network(arguments.out, network)
    peak = max(float(np.linalg.norm(r.force, axis=1).max()) for r in tested or recordings)
    rms = float(np.linalg.norm(errors.rmse))
    print(f"{network.architecture} [{network.unit}]: rms error {1e3 * rms:.1f} mN of the vector, {100 * rms / peak:.2f} % of the "
          f"peak {peak:.3f} N, {errors.along_normal()}")


def train_networks(arguments: argparse.Namespace, names: str, data: Data, stop: Stop) -> None:
    print(data.split.how, flush=True)
    tested: list[tuple[str, ForceErrors]] = []
    for architecture in arguments.network:
        if tested and stop.requested:
            break
        folder = arguments.out if len(arguments.network) == 1 else arguments.out / architecture
        tested.append((architecture, train_one(arguments, names, data, architecture, folder, stop)))
    print(force_table(tested), end="")


def fit_gain(arguments: argparse.Namespace, names: str, data: list[DataArgument], test: list[DataArgument]) -> None:
    """Fits the gain of a known network: g that makes g fz closest to the measured fz, least squares through the origin."""
    network = networks.read_network(arguments.source)
    recordings = read_recordings(data, arguments.finger, arguments.rest)
    tested = read_recordings(test, arguments.finger, arguments.rest)
    require_signals(recordings + tested, str(arguments.source), network.inputs)
    remark(recordings + tested)
    fz = np.concatenate([r.force[r.begin:r.end, 2] for r in recordings])
    if not float(np.ptp(fz)) > MIN_FORCE:
        raise InputError("fz is the same in all samples: no gain can be fitted to it")

    def compare(some: list[Recording]) -> tuple[Array, Array]:
        windows = windows_of(whole(some), network.window)
        if not len(windows):
            raise InputError(f"too few samples: the network has a window of {network.window}")
        return networks.evaluate(network, some, windows), measured(some, windows)

    network.gain = 1.0
    estimated, truth = compare(recordings)
    gain = float(estimated[:, 2] @ truth[:, 2] / (estimated[:, 2] @ estimated[:, 2]))
    if not (math.isfinite(gain) and gain > 0):
        raise InputError(f"no gain makes the network's fz that of the recording ({gain:g}): expected contacts whose fz has the "
                         "network's sign, force of the fingertip on the object")
    network.gain = gain
    network.learnt_force = float(np.linalg.norm(truth, axis=1).max())
    own = compare_forces(gain * estimated, truth)
    if not own.correlation[2] >= MIN_CORRELATION:
        raise InputError(f"{names}: fz of the network and of the recording have correlation {own.correlation[2]:.2f}: expected "
                         f"{MIN_CORRELATION:g} or more. Check the finger, the sensor, and that the slice has rest around "
                         "its contacts")
    print(f"gain {gain:.4f}, trained up to {network.learnt_force:.3f} N\nfitted on {names}\n  {own.along_normal()}")
    errors = own
    test_names = ", ".join(argument.name for argument in test)
    if test:
        errors = compare_forces(*compare(tested))
        print(f"tested on {test_names}\n  {errors.along_normal()}")
    # Only the gain of fz was fitted, so the errors of the other axes are unknown.
    network.sigma, network.rest_sigma = np.array([0, 0, errors.rmse[2]]), 0.0
    network.law = ErrorLaw()
    for kind in network.pattern.kinds if network.pattern else []:
        kind.law = ErrorLaw()
    network.training["gain"] = {"data": names, "test": test_names, "rmse_fz_N": errors.rmse[2],
                                "correlation_fz": errors.correlation[2]}
    arguments.out.mkdir(parents=True, exist_ok=True)
    networks.write_network(arguments.out, network)


def at_least(least: int) -> Any:
    def convert(text: str) -> int:
        value = int(text)
        if value < least:
            raise ValueError
        return value
    convert.__name__ = f"number of {least} or more"
    return convert


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python3 -m palpate.train", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", metavar="DATA", nargs="+", help="recordings, see below")
    parser.add_argument("--network", nargs="+", metavar="NAME",
                        help=", ".join(ARCHITECTURES) + ", or all: rnn and dnn (default: rnn_21)")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="DIR",
                        help="folder for network.json and training.csv")
    parser.add_argument("--test", nargs="+", default=[], metavar="DATA", help="test on these, not on a fifth of DATA")
    parser.add_argument("--from", dest="source", type=pathlib.Path, metavar="DIR",
                        help="fit only the gain of this network, on the normal force fz")
    parser.add_argument("--finger", default="", help="finger of a recording with several fingers")
    parser.add_argument("--rest", type=at_least(1), help="first samples, without contact, whose mean is the baseline (default: half a second)")
    parser.add_argument("--unit", help="unit of the channels of a sensor without electrodes, for example kPa")
    parser.add_argument("--channels", default="c", metavar="PREFIX", help="its columns are PREFIX1 to PREFIXN (default: c)")
    parser.add_argument("--sample-rate", type=float, default=100.0, metavar="HZ", help="of its samples (default: 100)")
    parser.add_argument("--normal", metavar="COLUMN=FACTOR",
                        help="the only measured force: fz is the column times the factor [N]; empty cells are passed over")
    parser.add_argument("--optimiser", choices=("adam", "sgd"), default="adam", help="sgd as in paper B")
    parser.add_argument("--rate", type=float, default=0.0, help="learning rate; 0: 0.004 for adam, 0.01 for sgd")
    parser.add_argument("--epochs", type=at_least(1), default=60, help="largest number of epochs")
    parser.add_argument("--patience", type=at_least(1), default=20, help="epochs without a lower validation error before a stop")
    parser.add_argument("--batch", type=at_least(1), default=128, help="windows per optimiser step")
    parser.add_argument("--seed", type=at_least(0), default=1, help="the same seed gives the same weights")
    arguments = parser.parse_args(argv)
    if arguments.network and (arguments.unit is not None or arguments.source):
        parser.error("--network: not with --unit or --from, which train no network of this kind")
    if arguments.unit is not None and arguments.source:
        parser.error("--from: not with --unit: the gain is that of a network of electrodes")
    chosen: list[str] = []
    for name in arguments.network or ["rnn_21"]:
        if name != "all" and name not in ARCHITECTURES:
            parser.error(f"--network {name}: expected {', '.join(ARCHITECTURES)} or all")
        chosen += [each for each in (ARCHITECTURES[:4] if name == "all" else [name]) if each not in chosen]
    arguments.network = chosen
    if arguments.unit is not None and not 1 <= len(arguments.unit) <= 16:
        parser.error(f"--unit {arguments.unit}: expected 1 to 16 characters")
    if not 1 <= arguments.sample_rate <= 10_000:
        parser.error(f"--sample-rate {arguments.sample_rate:g}: expected 1 to 10000")
    if arguments.rest is None:
        arguments.rest = max(1, round(REST_TIME * arguments.sample_rate))
    if not 0 <= arguments.rate <= 1:
        parser.error(f"--rate {arguments.rate:g}: expected 0 to 1")
    return arguments


def require_other_folder(arguments: argparse.Namespace, inputs: list[DataArgument]) -> None:
    folders = [arguments.out, *(arguments.out / name for name in arguments.network)]
    written = {(folder / name).resolve() for folder in folders for name in (NETWORK_FILE, "training.csv")}
    read = [file for data in inputs for file in (data.tactile, data.wrench) if file]
    if arguments.source:
        read.append(arguments.source / NETWORK_FILE)
    for file in read:
        if file.resolve() in written:
            raise InputError(f"--out {arguments.out}: would write over {file}: expected another folder")


def main(argv: Sequence[str] | None = None) -> int:
    """Returns 0: trained, or stopped with a result; 1: no result; 2: unusable arguments or data."""
    arguments = parse(argv)
    stop = Stop()
    try:
        data, test = parse_arguments(arguments.data), parse_arguments(arguments.test)
        require_other_folder(arguments, data + test)
        refuse_repetitions(data + test)  # a test on samples of the training would understate the errors
        names = ", ".join(argument.name for argument in data) if len(data) <= 4 else f"{data[0].name} and {len(data) - 1} more"
        if arguments.unit is not None:
            train_channels(arguments, names, data, test)
            return 0
        if arguments.source:
            fit_gain(arguments, names, data, test)
            return 0
        read = read_data(arguments, data, test)
        for architecture in arguments.network:
            require_signals(read.recordings + read.test, architecture, networks.inputs_of(architecture))
        train_networks(arguments, names, read, stop)
        return 0
    except InputError as error:
        print(f"train: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("train: stopped before the end of the first epoch: nothing written", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"train: {error.filename}: {os.strerror(error.errno or 0)}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
