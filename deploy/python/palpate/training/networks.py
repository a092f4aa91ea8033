"""Force networks (paper B, figure 6, and two for comparison), their training, and the file network.json."""
from __future__ import annotations

import dataclasses
import json
import math
import os
import pathlib
from typing import Any, Callable, Sequence

import numpy as np
import torch
from scipy.signal import lfilter

from palpate.training.errors import ErrorLaw
from palpate.training.channels import ChannelPattern
from palpate.training.pattern import Kind, Pattern
from palpate.training.recordings import RATE, WINDOW, Array, InputError, Recording, Windows, last_samples

NETWORK_FILE = "network.json"
ARCHITECTURES = tuple(f"{kind}_{inputs}" for kind in ("rnn", "dnn", "tnn") for inputs in (21, 19))
LSTM_UNITS, DENSE_UNITS, TRACE_UNITS = 20, 38, 64  # per layer, two layers; 38: twice 19 (Su et al.)
FORGET_BIAS = 1.0
TRACE_TIMES = (0.02, 0.06, 0.3, 1.0, 3.0)  # time constants of the running means [s]
MIN_TRACE = 0.1  # below this size the features of traces include the size

QUIET_SIGNAL = 0.25  # smallest scale of an electrode, relative to the rms of all
QUIET_AXIS = 0.1  # smallest scale of a force axis, relative to the largest
# Relative to the largest force; below it the errors of all samples have nearly the same weight (networks of traces).
GENTLE = 0.02
MIN_APART, MIN_UNLIKE = 1e-4, 1e-4  # added to the variance of signals and of features

MAX_GRADIENT = 5.0  # longer gradients are clipped to this length
MAX_VALIDATION = 4096  # windows
EPOCH_WINDOWS, TRACED_PASSES = 16384, 8  # windows per epoch; passes per epoch for traces, whose windows cost a fiftieth
ADAM_RATE, SGD_RATE = 4e-3, 0.01


@dataclasses.dataclass
class Options:
    architecture: str = "rnn_21"
    optimiser: str = "adam"
    rate: float = 0.0  # 0: ADAM_RATE, falling along half a cosine, or SGD_RATE
    epochs: int = 60
    patience: int = 20
    batch: int = 128
    seed: int = 1


@dataclasses.dataclass
class Network:
    """The content of network.json."""
    architecture: str
    inputs: int
    window: int
    outputs: int
    input_mean: Array
    input_scale: Array
    output_mean: Array
    output_scale: Array
    lstm: list[tuple[Array, Array]]  # kernel (inputs + n) x 4 n, gates i, j, f, o; bias without the forget bias
    dense: list[tuple[Array, Array]]
    activation: str = "tanh"
    rate: float = RATE
    gain: float = 1.0
    sigma: Array = dataclasses.field(default_factory=lambda: np.zeros(3))
    rest_sigma: float = 0.0
    law: ErrorLaw = ErrorLaw()
    learnt_force: float = 0.0
    origin: str = ""
    training: dict[str, Any] = dataclasses.field(default_factory=dict)
    pattern: Pattern | None = None
    unit: str = ""  # of the channels of a sensor without electrodes
    noise: float = 1.0
    longest_constant: float = 0.0
    drift: float = 0.0
    channels: ChannelPattern | None = None


@dataclasses.dataclass
class Epoch:
    number: int
    loss: float  # mean squared error over axes of unit size, weighted
    validation_loss: float


@dataclasses.dataclass
class Scales:
    signals: Array
    forces: Array
    gentle: float
    weight: float

    def weight_of(self, force: Array) -> Array:
        weight: Array = self.weight / (1 + np.linalg.norm(force, axis=-1) / self.gentle)
        return weight


def inputs_of(architecture: str) -> int:
    return int(architecture[-2:]) if architecture in ARCHITECTURES else 0


def scales_of(recordings: Sequence[Recording], windows: Windows, inputs: int) -> Scales:
    """RMS over the last samples of the windows. Raises InputError: constant or infinite data."""
    signals, forces = last_samples(recordings, windows)
    rms = np.sqrt((signals**2).mean(axis=0))
    squares = (forces**2).mean(axis=0)
    if not (np.isfinite(rms).all() and np.isfinite(squares).all()):
        raise InputError("signals or forces are not finite")
    if not forces.var(axis=0).sum() > 1e-12 * squares.sum():
        raise InputError("the force is the same in all training samples")
    electrodes = math.sqrt((rms[:19]**2).mean())
    if not electrodes > 0:
        raise InputError("the electrodes are constant in all training samples")
    scale = rms[:inputs].copy()
    scale[:19] = np.maximum(scale[:19], QUIET_SIGNAL * electrodes)
    scale[scale == 0] = 1  # a channel that was not recorded or never changed
    force_scale = np.maximum(np.sqrt(squares), QUIET_AXIS * np.sqrt(squares.max()))
    scales = Scales(scale, force_scale, GENTLE * float(np.linalg.norm(forces, axis=1).max()), 1.0)
    scales.weight = 1 / math.sqrt((scales.weight_of(forces)**2).mean())
    return scales


def traces(x: Array) -> tuple[Array, Array]:
    """Features n x 6 inputs of scaled signals n x inputs, and the size that they are relative to."""
    size = np.sqrt((x[:, :19]**2).mean(axis=1) + MIN_TRACE**2)
    shares = [1 - math.exp(-1 / (time * RATE)) for time in TRACE_TIMES]
    means = [lfilter([share], [1, share - 1], x, axis=0) for share in shares]
    return np.concatenate([x, *means], axis=1) / size[:, None], size


class Data:
    """Scaled inputs, forces and weights of all recordings in one tensor each."""

    def __init__(self, recordings: Sequence[Recording], scales: Scales, traced: bool) -> None:
        inputs = len(scales.signals)
        signals = [r.change[:, :inputs] / scales.signals for r in recordings]
        forces = [r.force / scales.forces for r in recordings]
        weights = [scales.weight_of(r.force) if traced else np.ones(len(r.t)) for r in recordings]
        self.mix = np.eye(inputs)
        if traced:
            self._replace_electrodes(signals)
            for k, signal in enumerate(signals):
                signals[k], size = traces(signal)
                signals[k] = signals[k].astype(np.float32)
                forces[k] = forces[k] / size[:, None]
                weights[k] = weights[k] * size
            # A sample and its running means are nearly equal, so without this rotation their difference would be learnt
            # last.
            values, vectors = np.linalg.eigh(self._covariance(signals, MIN_UNLIKE))
            self.mix = vectors @ np.diag(values**-0.5) @ vectors.T
            signals = [signal @ self.mix.astype(np.float32) for signal in signals]
        self.offsets = np.cumsum([0, *(len(signal) for signal in signals)])
        self.signals = torch.from_numpy(np.concatenate(signals).astype(np.float32))
        self.forces = torch.from_numpy(np.concatenate(forces).astype(np.float32))
        self.weights = torch.from_numpy(np.concatenate(weights).astype(np.float32))

    @staticmethod
    def _covariance(signals: Sequence[Array], floor: float) -> Array:
        total = sum(x.T.astype(float) @ x for x in signals)
        return np.asarray(total) / sum(len(x) for x in signals) + floor * np.eye(signals[0].shape[1])

    def _replace_electrodes(self, signals: list[Array]) -> None:
        """In every other recording one electrode is replaced by its prediction from the others, as the slave replaces a
        stuck one."""
        precision = np.linalg.inv(self._covariance(signals, MIN_APART))
        for k in range(1, len(signals), 2):
            e = k // 2 % 19
            shares = -precision[e] / precision[e, e]
            shares[e] = 0
            signals[k][:, e] = signals[k] @ shares

    def rows(self, windows: Windows) -> torch.Tensor:
        return torch.from_numpy(self.offsets[windows[:, 0]] + windows[:, 1])


class Dense(torch.nn.Module):
    def __init__(self, sizes: Sequence[int], activation: str = "tanh") -> None:
        super().__init__()
        self.layers = torch.nn.ModuleList(torch.nn.Linear(a, b) for a, b in zip(sizes, sizes[1:]))
        self.activation = torch.relu if activation == "relu" else torch.tanh
        for layer in self.layers:
            torch.nn.init.xavier_uniform_(layer.weight)
            torch.nn.init.zeros_(layer.bias)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        for layer in self.layers[:-1]:
            x = self.activation(layer(x))
        out: torch.Tensor = self.layers[-1](x)
        return out


class Recurrent(torch.nn.Module):
    """LSTM layers over a window, batch x steps x inputs; the last output goes through `head`."""

    def __init__(self, inputs: int, units: Sequence[int], head: Dense) -> None:
        super().__init__()
        sizes = [inputs, *units]
        self.layers = torch.nn.ModuleList(torch.nn.LSTM(a, b, batch_first=True) for a, b in zip(sizes, sizes[1:]))
        self.head = head
        for layer in self.layers:
            n = layer.hidden_size
            bound = math.sqrt(6 / (layer.input_size + 5 * n))  # Glorot and Bengio 2010
            torch.nn.init.uniform_(layer.weight_ih_l0, -bound, bound)
            torch.nn.init.uniform_(layer.weight_hh_l0, -bound, bound)
            torch.nn.init.zeros_(layer.bias_ih_l0)
            torch.nn.init.zeros_(layer.bias_hh_l0)
            layer.bias_hh_l0.data[n:2 * n] = FORGET_BIAS
            layer.bias_hh_l0.requires_grad = False  # only one of the two biases is learnt

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        for layer in self.layers:
            x, _ = layer(x)
        out: torch.Tensor = self.head(x[:, -1])
        return out


def make_module(architecture: str) -> torch.nn.Module:
    inputs = inputs_of(architecture)
    if architecture.startswith("rnn"):
        return Recurrent(inputs, (LSTM_UNITS, LSTM_UNITS), Dense((LSTM_UNITS, 3)))
    if architecture.startswith("tnn"):
        return Dense((inputs * (1 + len(TRACE_TIMES)), TRACE_UNITS, TRACE_UNITS, 3))
    return Dense((inputs, DENSE_UNITS, DENSE_UNITS, 3))


def _numpy(tensor: torch.Tensor) -> Array:
    values: Array = tensor.detach().double().numpy()
    return values


# PyTorch orders the gates i, f, j (g), o; the file orders them i, j, f, o.
def _reorder(gates: Array) -> Array:
    i, f, j, o = np.split(gates, 4, axis=0)
    return np.concatenate([i, j, f, o])


def _back(gates: Array) -> Array:
    i, j, f, o = np.split(gates, 4, axis=0)
    return np.concatenate([i, f, j, o])


def layers_of(module: torch.nn.Module) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array]]]:
    lstm = []
    head = module
    if isinstance(module, Recurrent):
        head = module.head
        for layer in module.layers:
            kernel = np.concatenate([_reorder(_numpy(layer.weight_ih_l0)).T, _reorder(_numpy(layer.weight_hh_l0)).T])
            bias = _reorder(_numpy(layer.bias_ih_l0 + layer.bias_hh_l0))
            n = layer.hidden_size
            bias[2 * n:3 * n] -= FORGET_BIAS
            lstm.append((kernel, bias))
    assert isinstance(head, Dense)
    return lstm, [(_numpy(layer.weight).T, _numpy(layer.bias)) for layer in head.layers]


def module_of(network: Network) -> torch.nn.Module:
    """The network's layers in double precision, for evaluation."""
    head = Dense([len(network.dense[0][0]), *(len(bias) for _, bias in network.dense)], network.activation)
    for layer, (kernel, bias) in zip(head.layers, network.dense):
        layer.weight.data, layer.bias.data = torch.from_numpy(kernel.T.copy()), torch.from_numpy(bias)
    module: torch.nn.Module = head
    if network.lstm:
        units = [len(bias) // 4 for _, bias in network.lstm]
        module = Recurrent(network.inputs, units, head)
        for layer, (kernel, bias), n in zip(module.layers, network.lstm, units):
            own = _back(bias)
            own[n:2 * n] += FORGET_BIAS
            layer.weight_ih_l0.data = torch.from_numpy(_back(kernel[:-n].T).copy())
            layer.weight_hh_l0.data = torch.from_numpy(_back(kernel[-n:].T).copy())
            layer.bias_ih_l0.data, layer.bias_hh_l0.data = torch.from_numpy(own), torch.zeros(4 * n, dtype=torch.float64)
    return module.double()


def evaluate(network: Network, recordings: Sequence[Recording], windows: Windows) -> Array:
    """Returns the forces at the ends of `windows`, n x 3 [N]. The input is the window, or for traces all samples since
    its start."""
    module = module_of(network)
    forces = np.empty((len(windows), 3))
    with torch.no_grad():
        for r in np.unique(windows[:, 0]):
            own = np.flatnonzero(windows[:, 0] == r)
            last = windows[own, 1]
            x = (recordings[r].change[:, :network.inputs] - network.input_mean) / network.input_scale
            size = np.ones(len(x))
            if network.architecture.startswith("tnn"):
                x, size = traces(x)
            for part in np.array_split(np.arange(len(own)), len(own) // 4096 + 1):
                at = last[part]
                rows = x[at[:, None] - np.arange(network.window - 1, -1, -1)] if network.lstm else x[at]
                y = _numpy(module(torch.from_numpy(rows)))
                y = network.gain * (network.output_mean + network.output_scale * y) * size[at][:, None]
                forces[own[part]] = y[:, :3]
    return forces


class Deck:
    """Draws windows in random order, and reorders them when all have been drawn."""

    def __init__(self, rows: torch.Tensor, generator: torch.Generator) -> None:
        self.rows, self.generator, self.at = rows, generator, len(rows)

    def draw(self, count: int) -> torch.Tensor:
        if self.at == len(self.rows):
            self.rows = self.rows[torch.randperm(len(self.rows), generator=self.generator)]
            self.at = 0
        drawn = self.rows[self.at:self.at + count]
        self.at += len(drawn)
        return drawn


def train(recordings: Sequence[Recording], train_windows: Windows, validation_windows: Windows, options: Options,
          progress: Callable[[float], bool]) -> tuple[Network, list[Epoch], int, bool]:
    """Returns network, epochs, best epoch and whether it was stopped by `progress`, which gets the share done and returns
    False to stop. Raises KeyboardInterrupt when stopped within the first epoch."""
    torch.manual_seed(options.seed)
    architecture = options.architecture
    inputs = inputs_of(architecture)
    recurrent, traced = architecture.startswith("rnn"), architecture.startswith("tnn")
    scales = scales_of(recordings, train_windows, inputs)
    data = Data(recordings, scales, traced)
    module = make_module(architecture)
    back = torch.arange(-WINDOW + 1, 1) if recurrent else None

    def loss_of(rows: torch.Tensor) -> torch.Tensor:
        x = data.signals[rows[:, None] + back] if back is not None else data.signals[rows]
        error = data.weights[rows, None] * (module(x) - data.forces[rows])
        return (error**2).mean()

    trained = [p for p in module.parameters() if p.requires_grad]
    rate = options.rate or (ADAM_RATE if options.optimiser == "adam" else SGD_RATE)
    optimiser: torch.optim.Optimizer = (torch.optim.Adam(trained, lr=rate) if options.optimiser == "adam"
                                        else torch.optim.SGD(trained, lr=rate))
    deck = Deck(data.rows(train_windows), torch.Generator().manual_seed(options.seed))
    validation = data.rows(validation_windows[::-(-len(validation_windows) // MAX_VALIDATION)])
    per_epoch = min(len(train_windows), EPOCH_WINDOWS * (TRACED_PASSES if traced else 1))
    epochs: list[Epoch] = []
    best, best_state, stopped = 0, module.state_dict(), False
    for number in range(1, options.epochs + 1):
        seen, loss_sum = 0, 0.0
        while seen < per_epoch and not stopped:
            done = (number - 1 + seen / per_epoch) / options.epochs
            stopped = not progress(done)
            if options.optimiser == "adam":
                optimiser.param_groups[0]["lr"] = rate * 0.5 * (1 + math.cos(math.pi * done))
            rows = deck.draw(min(options.batch, per_epoch - seen))
            optimiser.zero_grad()
            loss = loss_of(rows)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(trained, MAX_GRADIENT)
            optimiser.step()
            loss_sum += float(loss) * len(rows) / per_epoch
            seen += len(rows)
        if stopped:
            break
        with torch.no_grad():
            validation_loss = float(sum(loss_of(rows) * len(rows) for rows in validation.split(512)) / len(validation))
        epochs.append(Epoch(number, loss_sum, validation_loss))
        if best == 0 or validation_loss < epochs[best - 1].validation_loss:
            best, best_state = number, {name: value.clone() for name, value in module.state_dict().items()}
        if number - best >= options.patience:
            break
    if best == 0:
        raise KeyboardInterrupt
    module.load_state_dict(best_state)
    lstm, dense = layers_of(module)
    if traced:
        dense[0] = (data.mix @ dense[0][0], dense[0][1])
    learnt_force = float(np.linalg.norm(last_samples(recordings, train_windows)[1], axis=1).max())
    network = Network(architecture, inputs, 1 if architecture.startswith("dnn") else WINDOW, 3, np.zeros(inputs),
                      scales.signals, np.zeros(3), scales.forces, lstm, dense, learnt_force=learnt_force)
    return network, epochs, best, stopped


def single_precision(values: Array) -> Any:
    """Returns nested lists of single-precision numbers with the fewest digits that identify them."""
    if values.ndim > 1:
        return [single_precision(row) for row in values]
    return [float(str(np.float32(value))) for value in values]


def of_channels(network: Network) -> dict[str, Any]:
    if not network.unit:
        return {}
    content: dict[str, Any] = {"unit": network.unit, "noise": network.noise, "longest_constant": network.longest_constant,
                               "drift": network.drift}
    if network.channels is not None:
        content["channels"] = {key: single_precision(values) for key, values in network.channels.arrays().items()}
        if len(network.channels.baseline):
            content["channels"] |= {"baseline": single_precision(network.channels.baseline),
                                    "baseline_force": network.channels.baseline_force}
    return content


def document(network: Network) -> dict[str, Any]:
    content: dict[str, Any] = {
        "palpate_force_network": 1, "architecture": network.architecture, "inputs": network.inputs, "window": network.window,
        "outputs": network.outputs, **of_channels(network), "rate": network.rate, "gain": network.gain, "sigma": network.sigma.tolist(),
        "rest_sigma": network.rest_sigma, "growing_variance": network.law.growing, "relative_sigma": network.law.relative,
        "learnt_force": network.learnt_force, "origin": network.origin, "training": network.training,
        "input": {"mean": single_precision(network.input_mean), "scale": single_precision(network.input_scale)},
        "lstm": [{"kernel": single_precision(kernel), "bias": single_precision(bias)} for kernel, bias in network.lstm],
        "dense": [{"kernel": single_precision(kernel), "bias": single_precision(bias)} for kernel, bias in network.dense],
        "activation": network.activation,
        "output": {"mean": single_precision(network.output_mean), "scale": single_precision(network.output_scale)}}
    if network.pattern is not None:
        content["pattern"] = {
            "kinds": [{"share": kind.share, "shape": single_precision(kind.shape), "growing_variance": kind.law.growing,
                       "relative_sigma": kind.law.relative} for kind in network.pattern.kinds],
            "force": single_precision(network.pattern.force)}
    return content


def write_network(folder: pathlib.Path, network: Network) -> None:
    write_document(folder, document(network))


def write_document(folder: pathlib.Path, content: dict[str, Any]) -> None:
    """Replaces FOLDER/network.json as a whole."""
    file = folder / NETWORK_FILE
    partial = file.with_suffix(".partial")
    partial.write_text(json.dumps(content, allow_nan=False, separators=(",", ":")) + "\n", encoding="utf-8")
    os.replace(partial, file)


def read_network(folder: pathlib.Path) -> Network:
    """Reads FOLDER/network.json. Raises InputError naming the file and the key."""
    file = folder / NETWORK_FILE
    try:
        root = json.loads(file.read_text(encoding="utf-8"))
        if any("activation" in layer for layer in root["dense"]):
            raise InputError(f"{file}: a converted network is not trained further: train it in PyTorch, and convert it again")
        pattern = None
        if "pattern" in root:
            kinds = [Kind(k["share"], np.array(k["shape"]), ErrorLaw(k.get("growing_variance", 0), k.get("relative_sigma", 0)))
                     for k in root["pattern"]["kinds"]]
            pattern = Pattern(kinds, np.array(root["pattern"]["force"]))

        def layers(key: str) -> list[tuple[Array, Array]]:
            return [(np.array(layer["kernel"], float), np.array(layer["bias"], float)) for layer in root.get(key, [])]

        def scaling(key: str, size: int) -> tuple[Array, Array]:
            given = root.get(key, {})
            return np.array(given.get("mean", [0.0] * size)), np.array(given.get("scale", [1.0] * size))

        return Network(root["architecture"], root["inputs"], root["window"], root["outputs"], *scaling("input", root["inputs"]),
                       *scaling("output", root["outputs"]), layers("lstm"), layers("dense"), root.get("activation", "tanh"),
                       root["rate"], root.get("gain", 1.0), np.array(root.get("sigma", [0.0] * 3)), root.get("rest_sigma", 0.0),
                       ErrorLaw(root.get("growing_variance", 0.0), root.get("relative_sigma", 0.0)),
                       root.get("learnt_force", 0.0), root.get("origin", ""), root.get("training", {}), pattern)
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror}") from error
    except KeyError as error:
        raise InputError(f"{file}: key {error} is missing") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{file}: {error}") from error
