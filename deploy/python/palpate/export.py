"""Writes a recording as files: python3 -m palpate.export FILE.mcap OUT

From a master's recording: one entry per tick in OUT/numpy (t, p_M, p_S, force, estimated, sigma, validity, check,
phase, reasons, state_sequence, age, sensed_age, marks), the same as OUT/ticks.csv, OUT/states.csv with a row per
received state, OUT/images.csv with OUT/images/NNNNNN.jpg, and OUT/meshes.pvd with OUT/meshes/NNNNNN.vtu for ParaView:
displacement [m] and, if known, traction [Pa]. From a slave's recording: one entry per estimate (t, sample), the same as
OUT/states.csv, with fingertips tactile (t, then 19 electrodes, dynamic and static pressure of each), the images as
OUT/left/NNNNNN.png and OUT/right/NNNNNN.png by the number of their sample, and the scene with its files in OUT/scene.
The other columns of states are the fields of SlaveState in state.proto. SI units; t [s] since the first entry. Unknown
numbers are NaN, in CSV empty.
"""
from __future__ import annotations

import argparse
import base64
import csv
import pathlib
import struct
import sys
import warnings
from typing import Any

import numpy as np

from palpate.recording import RecordingWarning, attachments, messages, parsed
from palpate.schemas_pb2 import CompressedImage
from palpate.state import seconds, vector
from palpate.v1 import recording_pb2, state_pb2

Columns = dict[str, list[Any]]
UNKNOWN = (np.nan, np.nan, np.nan)
ELECTRODES = 19


def export(file: pathlib.Path, out: pathlib.Path) -> tuple[int, int]:
    """Writes the arrays and tables; returns the numbers of ticks and of states. Raises ValueError: no recording."""
    ticks: Columns = {}
    states: Columns = {}
    sensed: Columns = {}
    tactile: list[list[float]] = []
    by_sequence: dict[int, state_pb2.SlaveState] = {}
    images, meshes = _Images(out), _Meshes(out)
    sample = 0
    first = None
    for topic, t, data in messages(file):
        first = t if first is None else first
        if topic == "/slave/state":
            state = parsed(state_pb2.SlaveState, data, file)
            by_sequence[state.sequence] = state
            images.offset = t - seconds(state.sent_at)
            _add(states, {"t": t - first, **_columns(state)})
        elif topic == "/master/tick":
            tick = parsed(recording_pb2.ForceTick, data, file)
            _add(ticks, _of_tick(t - first, tick, by_sequence.get(tick.state_sequence)))
        elif topic == "/slave/sense":
            step = parsed(recording_pb2.SenseStep, data, file)
            kind = step.WhichOneof("step")
            if kind == "estimate":
                state = step.estimate.state
                _add(sensed, {"t": seconds(state.sensed_at), "sample": np.uint64(step.estimate.sample), **_columns(state)})
            elif kind == "tactile":
                tactile.append(_of_tactile(step.tactile))
            elif kind == "images":
                sample = step.images.sequence
        elif topic == "/slave/image":
            images.add(parsed(CompressedImage, data, file), first)
        elif topic == "/slave/mesh":
            meshes.add(t - first, parsed(state_pb2.MeshState, data, file))
        elif topic in ("/slave/left", "/slave/right"):
            folder = _made(out / topic.rpartition("/")[2])
            (folder / f"{sample:06}.png").write_bytes(parsed(CompressedImage, data, file).data)
    for name, content in attachments(file).items():
        _write_attached(out / "scene", name, content)
    images.finish()
    meshes.finish()
    (out / "numpy").mkdir(parents=True, exist_ok=True)
    if ticks:
        _save(out / "numpy", ticks)
        _write(out / "ticks.csv", ticks)
        if states:
            _write(out / "states.csv", states)
    else:
        if sensed:
            begin = min([sensed["t"][0]] + [row[0] for row in tactile[:1]])
            sensed["t"] = [t - begin for t in sensed["t"]]
            _save(out / "numpy", sensed)
            _write(out / "states.csv", sensed)
            for row in tactile:
                row[0] -= begin
        if tactile:
            width = max(len(row) for row in tactile)
            np.save(out / "numpy/tactile.npy", np.array([row + [np.nan] * (width - len(row)) for row in tactile]))
    return len(ticks.get("t", [])), len((states or sensed).get("t", []))


def _made(folder: pathlib.Path) -> pathlib.Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _write_attached(folder: pathlib.Path, name: str, content: bytes) -> None:
    """Raises ValueError: a path outside of the folder."""
    path = pathlib.PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts:
        raise ValueError(f"attached file {name[:60]}: expected a path inside its folder")
    _made((folder / path).parent)
    (folder / path).write_bytes(content)


class _Images:
    """The images that a master received. `offset`: of the recorder's clock against the slave's, within the delay [s]."""

    def __init__(self, out: pathlib.Path) -> None:
        self.out, self.offset = out, 0.0
        self.rows: list[list[Any]] = []

    def add(self, image: Any, first: float) -> None:
        name = f"{len(self.rows):06}.jpg"
        (_made(self.out / "images") / name).write_bytes(image.data)
        self.rows.append([len(self.rows), f"{seconds(image.timestamp) + self.offset - first:.9g}"])

    def finish(self) -> None:
        if self.rows:
            with open(self.out / "images.csv", "w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([["number", "t"], *self.rows])


class _Meshes:
    """The shapes that a master received, as VTK's unstructured grids and a collection with their times."""

    def __init__(self, out: pathlib.Path) -> None:
        self.out = out
        self.times: list[float] = []
        self.rest, self.cells = np.empty((0, 3), np.float32), np.empty((0, 3), np.int64)

    def add(self, t: float, mesh: state_pb2.MeshState) -> None:
        if mesh.rest:
            self.rest = np.array(mesh.rest, np.float32).reshape(-1, 3)
            self.cells = np.array(mesh.elements, np.int64).reshape(-1, max(mesh.nodes_per_element, 1))
        positions = np.array(mesh.positions, np.float32).reshape(-1, 3)
        if len(positions) != len(self.rest):
            raise ValueError(f"a mesh of {len(positions)} nodes: expected {len(self.rest)}")
        arrays = {"displacement": positions - self.rest}
        if mesh.traction:
            arrays["traction"] = np.array(mesh.traction, np.float32)
        (_made(self.out / "meshes") / f"{len(self.times):06}.vtu").write_text(_vtu(positions, self.cells, arrays), encoding="ascii")
        self.times.append(t)

    def finish(self) -> None:
        if self.times:
            sets = "".join(f'<DataSet timestep="{t:.9g}" file="meshes/{i:06}.vtu"/>\n' for i, t in enumerate(self.times))
            (self.out / "meshes.pvd").write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n<Collection>\n'
                                                 f"{sets}</Collection>\n</VTKFile>\n", encoding="ascii")


def _vtu(points: Any, cells: Any, arrays: dict[str, Any]) -> str:
    """An unstructured grid of lines (two nodes a cell) or triangles (three), arrays in base64."""
    def data(name: str, values: Any) -> str:
        raw = np.ascontiguousarray(values).tobytes()
        kind = {"float32": "Float32", "int64": "Int64", "uint8": "UInt8"}[values.dtype.name]
        columns = values.shape[1] if values.ndim == 2 and name != "connectivity" else 1
        return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{columns}" format="binary">'
                f'{base64.b64encode(struct.pack("<Q", len(raw)) + raw).decode()}</DataArray>\n')
    count, nodes = cells.shape
    types = np.full(count, 3 if nodes == 2 else 5, np.uint8)  # VTK_LINE, VTK_TRIANGLE
    return ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
            f'<UnstructuredGrid>\n<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">\n'
            f'<Points>\n{data("points", points)}</Points>\n'
            f'<Cells>\n{data("connectivity", cells)}{data("offsets", nodes * np.arange(1, count + 1))}{data("types", types)}</Cells>\n'
            f'<PointData>\n{"".join(data(name, values) for name, values in arrays.items())}</PointData>\n'
            "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _add(columns: Columns, row: dict[str, Any]) -> None:
    for name, value in row.items():
        columns.setdefault(name, []).append(value)


def _columns(state: state_pb2.SlaveState) -> dict[str, Any]:
    """The numbers, vectors and times of a state by the names of state.proto. Absent vectors and times are NaN."""
    row: dict[str, Any] = {}
    for field in state.DESCRIPTOR.fields:
        value = getattr(state, field.name)
        if field.label == field.LABEL_REPEATED:
            continue
        kind = field.message_type.name if field.message_type else ""
        if kind in ("Vec3", "Vec3f"):
            row[field.name] = vector(value) if state.HasField(field.name) else np.array(UNKNOWN)
        elif kind == "Timestamp":
            row[field.name] = seconds(value) if state.HasField(field.name) else np.nan
        elif not kind:
            row[field.name] = np.uint8(value) if field.enum_type else value
    for sigma, of in (("sigma", "force"), ("moment_sigma", "moment")):
        row[sigma] = row[sigma] if state.HasField(of) else np.nan
    return row


def _of_tick(t: float, tick: recording_pb2.ForceTick, state: state_pb2.SlaveState | None) -> dict[str, Any]:
    known = tick.HasField("estimated")
    reasons = sum(1 << (int(reason) - 1) for reason in tick.reasons)
    return {"t": t, "p_M": vector(tick.p_M), "p_S": vector(tick.p_S), "force": vector(tick.sent),
            "estimated": vector(tick.estimated) if known else np.array(UNKNOWN),
            "sigma": state.sigma if known and state is not None else np.nan,
            "validity": np.uint8(state.validity if state is not None else 0),
            "check": np.uint8(state.check if state is not None else 0), "phase": np.uint8(tick.phase),
            "reasons": np.uint64(reasons), "state_sequence": np.uint64(tick.state_sequence),
            "age": tick.state_age if tick.HasField("state_age") else np.nan,
            "sensed_age": tick.sensed_age if tick.HasField("sensed_age") else np.nan, "marks": np.uint64(tick.marks)}


def _of_tactile(frame: Any) -> list[float]:
    row = [seconds(frame.sensed_at)]
    last = max((i for i, finger in enumerate(frame.fingers) if finger.present), default=0)
    channels = len(frame.fingers[last].electrodes) or ELECTRODES
    for finger in frame.fingers[:last + 1]:
        row += [*finger.electrodes, finger.pac, finger.pdc] if finger.present else [np.nan] * (channels + 2)
    return row


def _save(folder: pathlib.Path, columns: Columns) -> None:
    for name, values in columns.items():
        np.save(folder / f"{name}.npy", np.array(values))


def _write(path: pathlib.Path, columns: Columns) -> None:
    header: list[str] = []
    cells: list[list[str]] = []
    for name, values in columns.items():
        array = np.array(values)
        parts: Any = array.T if array.ndim == 2 else [array]
        header += [f"{name}_{axis}" for axis in "xyz"] if array.ndim == 2 else [name]
        cells += [["" if part.dtype.kind == "f" and np.isnan(x) else f"{x:.9g}" if part.dtype.kind == "f" else str(x)
                   for x in part] for part in parts]
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *zip(*cells)])


def main() -> int:
    parser = argparse.ArgumentParser(prog="palpate.export", description="Writes a recording as NumPy arrays, tables, images and meshes")
    parser.add_argument("file", type=pathlib.Path, metavar="FILE.mcap")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT")
    arguments = parser.parse_args()
    try:
        with warnings.catch_warnings(record=True) as damage:
            warnings.simplefilter("always", RecordingWarning)
            ticks, states = export(arguments.file, arguments.out)
        for line in dict.fromkeys(str(warning.message) for warning in damage):
            print(f"palpate.export: {line}", file=sys.stderr)
    except (ValueError, OSError) as error:
        print(f"palpate.export: {error}", file=sys.stderr)
        return 2
    print(f"{ticks} ticks, {states} states")
    return 0


if __name__ == "__main__":
    sys.exit(main())
