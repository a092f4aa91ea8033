"""Converts a force network to network.json: `python3 -m palpate.convert_network`."""
from __future__ import annotations

import argparse
import dataclasses
import importlib
import io
import json
import pathlib
import pickle
import sys
import zipfile
from typing import Any, Callable, Iterator, Sequence

import numpy as np
import torch

from palpate.formats import what_is
from palpate.training.networks import FORGET_BIAS, NETWORK_FILE, single_precision, write_document
from palpate.training.recordings import RATE, WINDOW, Array, InputError

TENSORS_FILE = "tensors.json"
INPUTS = (21, 19)
MAX_WINDOW = 1000
WINDOWS = 20  # random windows that are compared
MAX_DIFFERENCE = 1e-6  # largest difference of an output, relative to 1 + the largest output of the random windows
AUTHORS_FORCE = 1.0  # largest force that paper B's authors trained on, IV.A [N]
ACTIVATIONS: dict[type, str] = {torch.nn.Tanh: "tanh", torch.nn.ReLU: "relu", torch.nn.Sigmoid: "sigmoid", torch.nn.ELU: "elu",
                                torch.nn.LeakyReLU: "leaky_relu", torch.nn.Identity: "identity"}
PASSED_OVER = (torch.nn.Dropout, torch.nn.Flatten)
SENSOR_KEYS = ("unit", "noise", "drift", "longest_constant", "channels")  # of network.json, independent of the layers
FUNCTIONS: dict[str, Callable[[Array], Any]] = {"tanh": np.tanh, "relu": lambda y: np.maximum(y, 0), "sigmoid": lambda y: sigmoid(y),
             "elu": lambda y: np.where(y > 0, y, np.expm1(np.minimum(y, 0))), "leaky_relu": lambda y: np.where(y > 0, y, 0.01 * y),
             "identity": lambda y: y}

EPILOG = """SOURCE is one of
  FILE.pt             a module of PyTorch's own layers, written by torch.save(module, FILE.pt); no code of the file runs.
                      --trust also loads a module of another class, and runs the code that the file names
  PACKAGE.FILE:MAKE   a function or class that makes the module; --state FILE.pt holds its state_dict
  FOLDER              with tensors.json, the layout of the weights of paper B's authors
The module gets [1, window, n] (recurrent) or [1, n] counts minus baseline, scaled by --input-mean and --input-scale, with
n = 21 (E1 to E19, pac0, pdc) or 19. Its outputs begin with the force of the fingertip on the object, frame F [N].
With --sensor DIR it is the network of another sensor, of its channels minus their baseline. DIR is a network that
`palpate.train --unit` made of recordings of this sensor: unit, noise, drift and behaviour of the channels, which the slave's checks
need, are taken from it. --sigma states the errors of the forces.
Accepted are LSTM layers, followed by linear layers with activations: tanh, relu, sigmoid, elu, leaky_relu.
Activations that are functions of its forward pass are given by --activation. Before network.json is written, its forces are
compared with those of PyTorch in 20 random windows.

Examples:
  python3 -m palpate.convert_network finger.pt --window 50 --out build/finger
  python3 -m palpate.convert_network my_network:Finger --state weights.pt --input-scale 100 --out build/finger
  python3 -m palpate.convert_network skin.pt --sensor build/trained --sigma 0.1 0.1 0.2 --out build/skin
"""


@dataclasses.dataclass
class Layers:
    """Layers as network.json has them: kernels of inputs x outputs."""
    lstm: list[tuple[Array, Array]] = dataclasses.field(default_factory=list)
    dense: list[tuple[Array, Array]] = dataclasses.field(default_factory=list)
    activations: list[str] = dataclasses.field(default_factory=list)  # after each dense layer but the last

    @property
    def recurrent(self) -> bool:
        return bool(self.lstm)

    @property
    def inputs(self) -> int:
        if not self.recurrent:
            return len(self.dense[0][0])
        kernel = self.lstm[0][0]
        return len(kernel) - kernel.shape[1] // 4


def finite(name: str, values: torch.Tensor) -> Array:
    array = np.asarray(values.detach().cpu().numpy(), float)
    if not np.isfinite(array).all():
        index = ", ".join(str(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name}[{index}] is not a finite number")
    return array


def recurrent_layers(name: str, module: torch.nn.LSTM, layers: Layers) -> None:
    for flag in ("bidirectional", "proj_size"):
        if getattr(module, flag, 0):
            raise InputError(f"{name}: {flag} = {getattr(module, flag)} is not accepted")
    if layers.dense:
        raise InputError(f"{name}: expected LSTM layers first, and then linear layers")
    n = module.hidden_size
    for k in range(module.num_layers):
        own, other = (finite(f"{name}.weight_{part}_l{k}", getattr(module, f"weight_{part}_l{k}")) for part in ("ih", "hh"))
        biases = [finite(f"{name}.bias_{part}_l{k}", getattr(module, f"bias_{part}_l{k}")) if module.bias else np.zeros(4 * n)
                  for part in ("ih", "hh")]
        kernel = np.concatenate([own.T, other.T])
        # PyTorch orders the gates i, f, j, o.
        order = np.concatenate([np.arange(part * n, (part + 1) * n) for part in (0, 2, 1, 3)])
        bias = (biases[0] + biases[1])[order]
        bias[2 * n:3 * n] -= FORGET_BIAS
        layers.lstm.append((kernel[:, order], bias))


def leaves(module: torch.nn.Module, name: str = "") -> Iterator[tuple[str, torch.nn.Module]]:
    children = list(module.named_children())
    if not children:
        yield name or "module", module
    for child, part in children:
        yield from leaves(part, f"{name}.{child}" if name else child)


def layers_of(module: torch.nn.Module, activation: str, sensor: dict[str, Any] | None = None) -> Layers:
    """`activation`: between linear layers without a module for it. `sensor`: a network of another sensor; None: electrodes. Raises
    InputError naming the layer."""
    layers = Layers()
    width, before = 0, ""  # width of the last layer's output, and its name
    for name, part in leaves(module):
        if isinstance(part, (torch.nn.LSTM, torch.nn.Linear)):
            takes, gives = ((part.input_size, part.hidden_size) if isinstance(part, torch.nn.LSTM)
                            else (part.in_features, part.out_features))
            if width and takes != width:
                raise InputError(f"{name} takes {takes} inputs and {before} gives {width}: the forward pass is not the sequence of "
                                 "the layers")
            width, before = gives, name
        if isinstance(part, torch.nn.LSTM):
            recurrent_layers(name, part, layers)
        elif isinstance(part, torch.nn.Linear):
            if len(layers.activations) < len(layers.dense):
                layers.activations.append(activation)
            bias = finite(f"{name}.bias", part.bias) if part.bias is not None else np.zeros(part.out_features)
            layers.dense.append((finite(f"{name}.weight", part.weight).T, bias))
        elif type(part) in ACTIVATIONS:
            if len(layers.activations) + 1 != len(layers.dense):
                raise InputError(f"{name}: an activation is accepted behind a linear layer only")
            if getattr(part, "alpha", 1.0) != 1.0 or getattr(part, "negative_slope", 0.01) != 0.01:
                raise InputError(f"{name}: {part} is not accepted: expected PyTorch's default slope")
            layers.activations.append(ACTIVATIONS[type(part)])
        elif not isinstance(part, PASSED_OVER):
            raise InputError(f"{name}: {type(part).__name__} is not accepted: expected LSTM, Linear, Dropout, Flatten or "
                             f"one of {', '.join(kind.__name__ for kind in ACTIVATIONS)}")
    if not layers.dense:
        raise InputError("the module has no linear layer that gives the force")
    if len(layers.activations) == len(layers.dense):
        raise InputError("the module ends with an activation: expected a linear layer that gives the force")
    if sensor is None and layers.inputs not in INPUTS:
        raise InputError(f"the network takes {layers.inputs} inputs: a fingertip has 21 signals or 19; that of another sensor is "
                         "converted with --sensor DIR")
    if sensor is not None and layers.inputs != sensor["inputs"]:
        raise InputError(f"--sensor: the network takes {layers.inputs} inputs, and the sensor has {sensor['inputs']} channels")
    if len(layers.dense[-1][1]) < 3:
        raise InputError(f"the network has {len(layers.dense[-1][1])} outputs: expected 3 or more, the force first")
    return in_single_precision(layers)


def in_single_precision(layers: Layers) -> Layers:
    """Rounds the weights to single precision, as they are in network.json."""
    def rounded(arrays: tuple[Array, ...]) -> Any:
        return tuple(array.astype(np.float32).astype(float) for array in arrays)
    return Layers([rounded(layer) for layer in layers.lstm], [rounded(layer) for layer in layers.dense], layers.activations)


def sigmoid(x: Array) -> Array:
    return np.asarray(1 / (1 + np.exp(-x)))


def forward(layers: Layers, x: Array) -> Array:
    """Output of the scaled window x, window x inputs, by the formulas of FORMAT.md."""
    for kernel, bias in layers.lstm:
        n = kernel.shape[1] // 4
        h, c, states = np.zeros(n), np.zeros(n), []
        for row in x:
            i, j, f, o = np.split(np.concatenate([row, h]) @ kernel + bias, 4)
            c = c * sigmoid(f + FORGET_BIAS) + sigmoid(i) * np.tanh(j)
            h = np.tanh(c) * sigmoid(o)
            states.append(h)
        x = np.array(states)
    y = x[-1]
    for k, (kernel, bias) in enumerate(layers.dense):
        y = y @ kernel + bias
        if k + 1 < len(layers.dense):
            y = FUNCTIONS[layers.activations[k]](y)
    return np.asarray(y)


def output_of(module: torch.nn.Module, layers: Layers, x: Array) -> Array:
    """Returns PyTorch's output for one window: the last row if it returns one per sample."""
    rows = torch.from_numpy(x)
    batch_first = all(part.batch_first for part in module.modules() if isinstance(part, torch.nn.RNNBase))
    given = rows[-1:] if not layers.recurrent else rows[None] if batch_first else rows[:, None]
    with torch.no_grad():
        y = module(given)
    y = y[0] if isinstance(y, tuple) else y
    if y.dim() == 3:
        y = y[:, -1] if batch_first else y[-1]
    return np.asarray(y.reshape(-1).numpy())


def compare(module: torch.nn.Module, layers: Layers, window: int) -> float:
    """Largest difference from PyTorch in random windows. Raises InputError where they do not agree."""
    random = np.random.default_rng(1)
    module = module.double().eval()
    windows = random.normal(size=(WINDOWS, window if layers.recurrent else 1, layers.inputs))
    try:
        expected = np.array([output_of(module, layers, x) for x in windows])
    except Exception as error:  # the module's own code may raise any exception
        shape = (1, window, layers.inputs) if layers.recurrent else (1, layers.inputs)
        raise InputError(f"the forward pass fails for an input of {list(shape)}: {type(error).__name__}: {error}") from error
    got = np.array([forward(layers, x) for x in windows])
    if expected.shape != got.shape:
        raise InputError(f"PyTorch gives {expected.shape[1]} numbers per window, the layers give {got.shape[1]}: "
                         "the forward pass is not the sequence of its layers")
    difference = float(np.abs(got - expected).max())
    if not difference <= MAX_DIFFERENCE * (1 + np.abs(expected).max()):
        raise InputError(f"the converted network differs from PyTorch by {difference:.3g}: the forward pass is not the sequence "
                         "of its layers, or an activation is a function (--activation)")
    return difference


def authors_module(file: pathlib.Path) -> torch.nn.Module:
    """The weights in tensors.json as a module. Raises InputError naming file and tensor."""
    try:
        root = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: {error}") from error

    def tensor(layer: str, kind: str, rank: int) -> torch.Tensor:
        found = [name for name in root if name.startswith(f"{layer}/") and name.endswith(f"/{kind}")]
        if not found:
            raise InputError(f"{file}: tensor {layer}/.../{kind} is missing")
        try:
            values = torch.tensor(root[found[0]]["data"], dtype=torch.float32).reshape(root[found[0]]["shape"])
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise InputError(f"{file}: tensor {found[0]}: {error}") from error
        if values.dim() != rank:
            raise InputError(f"{file}: tensor {found[0]} has {values.dim()} extents, expected {rank}")
        return values

    recurrent: list[torch.nn.Module] = []
    while not recurrent or any(name.startswith(f"layer{len(recurrent) + 1}/") for name in root):
        layer = f"layer{len(recurrent) + 1}"
        kernel, bias = tensor(layer, "Matrix", 2), tensor(layer, "Bias", 1)
        n = len(bias) // 4
        if kernel.shape[1] != 4 * n or len(kernel) <= n:
            raise InputError(f"{file}: tensor {layer}/.../Matrix is {tuple(kernel.shape)}, expected (inputs + {n}) x {4 * n}")
        order = torch.cat([torch.arange(part * n, (part + 1) * n) for part in (0, 2, 1, 3)])
        made = torch.nn.LSTM(len(kernel) - n, n, batch_first=True).double()
        own = bias.double()
        own[2 * n:3 * n] += FORGET_BIAS
        made.weight_ih_l0.data = kernel[:-n, order].T.double().contiguous()
        made.weight_hh_l0.data = kernel[-n:, order].T.double().contiguous()
        made.bias_ih_l0.data, made.bias_hh_l0.data = own[order], torch.zeros(4 * n, dtype=torch.float64)
        recurrent.append(made)
    weight, bias = tensor("output_layer", "W", 2), tensor("output_layer", "b", 1)
    head = torch.nn.Linear(*weight.shape).double()
    head.weight.data, head.bias.data = weight.T.double().contiguous(), bias.double()
    return Chain(recurrent, head)


class Chain(torch.nn.Module):
    """LSTM layers, with a linear layer on the last state."""

    def __init__(self, recurrent: list[torch.nn.Module], head: torch.nn.Module) -> None:
        super().__init__()
        self.recurrent, self.head = torch.nn.ModuleList(recurrent), head

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        for layer in self.recurrent:
            x, _ = layer(x)
        y: torch.Tensor = self.head(x[:, -1])
        return y


class OwnLayers(pickle.Unpickler):
    """Unpickler for files of torch.save (the archive of PyTorch 1.6 and later). It makes only tensors, containers and
    PyTorch's own layers, so no code from the file runs."""

    def __init__(self, archive: zipfile.ZipFile, name: str) -> None:
        super().__init__(io.BytesIO(archive.read(name)), encoding="utf-8")
        self.archive, self.folder = archive, name.rpartition("/")[0]

    def find_class(self, module: str, name: str) -> Any:
        is_tensor = module == "torch._utils" and name.startswith("_rebuild_") or module == "torch" and name.endswith("Storage")
        if is_tensor or (module, name) in (("collections", "OrderedDict"), ("torch", "Size")):
            return super().find_class(module, name)
        if name == "set" and module in ("builtins", "__builtin__"):
            return set
        if module.startswith("torch.nn.modules."):
            found = super().find_class(module, name)
            if isinstance(found, type) and issubclass(found, torch.nn.Module):
                return found
        raise InputError(f"holds {module}.{name}, whose forward pass is code: expected PACKAGE.FILE:MAKE --state FILE.pt, or "
                         "--trust if you trust the file")

    def persistent_load(self, pid: Any) -> Any:
        _, storage, key, _, _ = pid
        return storage.from_buffer(self.archive.read(f"{self.folder}/data/{key}"), byte_order="little")


def whole_file(source: str, trust: bool) -> Any:
    """Reads a file of torch.save. Raises InputError for TorchScript, and for a file with code unless `trust` is set."""
    if trust:
        sys.path.insert(0, "")
        return torch.load(source, map_location="cpu", weights_only=False)
    with zipfile.ZipFile(source) as archive:
        names = archive.namelist()
        if any("/code/" in name for name in names):
            raise InputError("a TorchScript module: expected one that torch.save wrote, or PACKAGE.FILE:MAKE --state FILE.pt")
        pickled = [name for name in names if name.endswith("/data.pkl")]
        if len(pickled) != 1:
            raise InputError(what_is(source) or "no archive that torch.save wrote")
        return OwnLayers(archive, pickled[0]).load()


def made_by(source: str, package: str, make: str) -> torch.nn.Module:
    try:
        module: torch.nn.Module = getattr(importlib.import_module(package), make)()
        return module
    except Exception as error:  # the user's code may raise any exception
        raise InputError(f"{source}: {type(error).__name__}: {error}") from error


def load(source: str, state: str | None, trust: bool = False) -> torch.nn.Module:
    try:
        if ":" in source and not pathlib.Path(source).exists():
            sys.path.insert(0, "")
            package, make = source.split(":", 1)
            module = made_by(source, package, make)
            if state is None:
                raise InputError(f"{source}: --state FILE.pt is missing")
            module.load_state_dict(torch.load(state, map_location="cpu", weights_only=True))
        elif pathlib.Path(source).is_dir():
            return authors_module(pathlib.Path(source) / TENSORS_FILE)
        else:
            module = whole_file(source, trust)
    except InputError as error:
        if str(error).startswith(source):
            raise
        raise InputError(f"{source}: {error}") from error
    except Exception as error:  # an unpickler may raise any exception
        failed = state if state is not None and ":" in source else source
        foreign = what_is(failed)
        if foreign:
            raise InputError(f"{failed}: {foreign}") from error
        if isinstance(error, zipfile.BadZipFile):
            raise InputError(f"{failed}: no archive that torch.save wrote, or cut off; one of PyTorch before 1.6 is read with "
                             "--trust") from error
        raise InputError(f"{failed}: cannot be loaded by PyTorch: {error}") from error
    if isinstance(module, dict):
        names = ", ".join(str(name) for name in list(module)[:4])
        if not all(isinstance(value, torch.Tensor) for value in module.values()):
            raise InputError(f"{source}: holds a checkpoint ({names}): expected a module; write the state_dict in it to a file of its own "
                             "for --state")
        raise InputError(f"{source}: holds a state_dict ({names}), no module: expected PACKAGE.FILE:MAKE --state {source}, with the "
                         "function or class that makes the module")
    if not isinstance(module, torch.nn.Module):
        raise InputError(f"{source}: expected a module written by torch.save, found {type(module).__name__}")
    return module


def scaling(text: str, size: int, option: str) -> Array:
    try:
        values = np.array([float(part) for part in text.split(",")])
    except ValueError as error:
        raise InputError(f"{option} {text}: expected numbers separated by commas") from error
    if len(values) not in (1, size) or not np.isfinite(values).all():
        raise InputError(f"{option} {text}: expected one number or {size}")
    return np.broadcast_to(values, size)


def document_of(layers: Layers, options: argparse.Namespace, authors: bool, sensor: dict[str, Any] | None) -> dict[str, Any]:
    inputs, outputs = layers.inputs, len(layers.dense[-1][1])
    scales = {option: scaling(getattr(options, option), inputs if option.startswith("input") else outputs,
                              "--" + option.replace("_", "-"))
              for option in ("input_mean", "input_scale", "output_mean", "output_scale")}
    for option in ("input_scale", "output_scale"):
        if (scales[option] == 0).any():
            raise InputError(f"--{option.replace('_', '-')}: expected numbers other than 0")
    origin = options.origin or ("weights by the authors of paper B, trained on forces of 0.1 to 1.0 N (IV.A)" if authors else
                                f"converted from {pathlib.Path(options.source).name}")
    dense: list[dict[str, Any]] = [{"kernel": single_precision(kernel), "bias": single_precision(bias)}
                                   for kernel, bias in layers.dense]
    for layer, activation in zip(dense, layers.activations):
        layer["activation"] = activation
    of_sensor = {key: sensor[key] for key in SENSOR_KEYS if key in sensor} if sensor else {}
    return {
        "palpate_force_network": 1, "architecture": f"{'rnn' if layers.recurrent else 'dnn'}_{inputs}", "inputs": inputs, **of_sensor,
        "window": options.window if layers.recurrent else 1, "outputs": outputs, "rate": options.rate,
        "learnt_force": options.learnt_force if options.learnt_force is not None else AUTHORS_FORCE if authors else 0.0,
        "sigma": options.sigma, "origin": origin,
        "input": {"mean": single_precision(scales["input_mean"]), "scale": single_precision(scales["input_scale"])},
        "lstm": [{"kernel": single_precision(kernel), "bias": single_precision(bias)} for kernel, bias in layers.lstm],
        "dense": dense,
        "output": {"mean": single_precision(scales["output_mean"]), "scale": single_precision(scales["output_scale"])}}


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python3 -m palpate.convert_network", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", metavar="SOURCE", help="module or folder, see below")
    parser.add_argument("--out", required=True, type=pathlib.Path, metavar="DIR", help="folder of network.json")
    parser.add_argument("--state", metavar="FILE.pt", help="state_dict of the module")
    parser.add_argument("--trust", action="store_true", help="run the code that FILE.pt names")
    parser.add_argument("--sensor", type=pathlib.Path, metavar="DIR", help="network of palpate.train --unit for this sensor, see below")
    parser.add_argument("--window", type=int, default=WINDOW, metavar="N", help="samples of a recurrent network (default: %(default)s)")
    parser.add_argument("--rate", type=float, default=RATE, metavar="HZ", help="samples per second (default: %(default)s)")
    parser.add_argument("--activation", choices=sorted(FUNCTIONS), default="identity",
                        help="between linear layers, where the forward pass calls a function (default: none)")
    for option, default in (("input-mean", "0"), ("input-scale", "1"), ("output-mean", "0"), ("output-scale", "1")):
        parser.add_argument(f"--{option}", default=default, metavar="X[,X...]",
                            help=f"{option.replace('-', ' ')}, one number or one per signal (default: %(default)s)")
    parser.add_argument("--sigma", type=float, nargs=3, default=[0.0] * 3, metavar="N", help="rms errors of fx, fy, fz [N]")
    parser.add_argument("--learnt-force", type=float, metavar="N", help="largest force that it was trained on [N]")
    parser.add_argument("--origin", default="", metavar="TEXT", help="where the network comes from")
    return parser.parse_args(arguments)


def read_sensor(options: argparse.Namespace) -> dict[str, Any] | None:
    """Returns the network of --sensor; None without it. Raises InputError: it does not describe a sensor."""
    if options.sensor is None:
        return None
    file = options.sensor / NETWORK_FILE
    try:
        sensor: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: {error}: expected a network of palpate.train --unit") from None
    missing = [key for key in ("inputs", "unit", "noise", "channels") if key not in sensor]
    if missing:
        raise InputError(f"{file}: {missing[0]} is missing: expected a network of palpate.train --unit")
    if not max(options.sigma) > 0 or min(options.sigma) < 0:
        raise InputError("--sensor: expected --sigma X Y Z, the errors of the forces, which a slave needs of such a network")
    return sensor


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    try:
        if not 1 <= options.window <= MAX_WINDOW:
            raise InputError(f"--window {options.window}: expected 1 to {MAX_WINDOW}")
        sensor = read_sensor(options)
        module = load(options.source, options.state, options.trust)
        layers = layers_of(module, options.activation, sensor)
        document = document_of(layers, options, pathlib.Path(options.source).is_dir(), sensor)
        difference = compare(module, layers, options.window)
        options.out.mkdir(parents=True, exist_ok=True)
        write_document(options.out, document)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: {options.out}: {error.strerror}", file=sys.stderr)
        return 1
    print(f"{options.out / NETWORK_FILE}: {document['architecture']}, {document['outputs']} outputs; "
          f"differs from PyTorch by at most {difference:.1e} in {WINDOWS} random windows")
    return 0


if __name__ == "__main__":
    sys.exit(main())
