"""The contact force of a soft body: `solve` once, or a `Model` that is prepared once and answers many times."""
from __future__ import annotations

import dataclasses
import json
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Callable, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from palpate import _core

Array = NDArray[np.float64]
Where = Union[Mapping[str, Any], Sequence[Mapping[str, Any]], ArrayLike, Callable[[Array], ArrayLike]]
VALIDITIES = np.array(["valid", "extrapolated", "punctured", "stale", "tracking_lost", "failed"])
READ_BY_PALPATE = (".node", ".ele", ".msh", ".stl", ".ply")


class ForceWarning(UserWarning):
    """Warns of implausible numbers, or of an answer that is not valid; the text states the reason."""


@dataclasses.dataclass(frozen=True)
class Answer:
    """The answers of n contacts: the leading shape of `contacts` without its last axis, here (n,).

    force         force of the tool on the body, (n, 3) [N]: a tool that pushes along -z has a force along -z.
                  NaN: no solution.
    displacement  displacement of the contact, (n, 3) [m], as it was given; under `loads`: the mean over the contact.
    error         stated error of the force [N], of a load's displacement [m], (n,): that of the iteration and of the mesh, not
                  that of young_modulus. NaN: this model has no estimate.
    validity      "valid", "extrapolated" (a number outside the range in which the model is known to be right) or "failed"
    why           why an answer is not valid, (n,); empty for valid ones
    """
    force: Array
    displacement: Array
    error: Array
    validity: NDArray[np.str_]
    why: NDArray[np.object_]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether each force is inside the range of the model, (n,)."""
        return np.asarray(self.validity == "valid")


class Model:
    """A soft body whose model is prepared once. `solve` then answers in microseconds to milliseconds.

    mesh           The body, in metres (see `unit`), frame O. One of:
                   (nodes, elements): arrays (n, 3) and (m, 4), tetrahedra; or (m, 3), the triangles of a closed surface,
                   which Gmsh or TetGen fills (Debian package `gmsh`). Node numbers begin at 0;
                   a file .msh, .node, .stl or .ply, with meshio also any that it reads;
                   an object of trimesh or meshio;
                   an array (n, 2), the outline of a plane body, with `thickness`;
                   a dict as `object.geometry` of a scene: {"box": {"size": [0.1, 0.1, 0.05], "cells": [8, 8, 4]}},
                   {"membrane": {"radius": 0.038, "thickness": 0.001}}, rectangle, disc, polygon.
    young_modulus  Young's modulus [Pa]. Every force is proportional to it: `palpate.identify` finds it.
    poisson_ratio  above -1, up to 0.5; soft tissue, silicone and rubber have 0.45 to 0.5
    tool           None: a contact at a point, whose force depends on the mesh;
                   {"shape": "flat", "width": 0.01}: a disc of 10 mm, or on a plane body a strip;
                   {"shape": "round", "radius": 0.005}: a ball. With a plane body "depth": "whole" or a length is the
                   extent through the thickness.
    fixed          What does not move. One of:
                   {"plane": {"axis": "z", "at": 0}}: the nodes in a plane; {"side": "bottom"} of a plane body;
                   numbers of nodes, or a mask (n,) of the nodes of a volume;
                   a function that gets the nodes (n, 3) [m] and returns a mask (n,): lambda p: p[:, 2] < 1e-3;
                   a list of dicts. A membrane is fixed at its rim.
    kind           "auto": by the body, "bem2d" of an outline, "plate" or "plate-large" of a membrane, "fem" of a volume.
                   "fem-green": small strains, microseconds. "fem": large strains, with an estimate of the error.
                   deploy/scenes/README.md describes all kinds.
    thickness      of an outline [m]
    unit           length of one unit of the mesh or outline: "mm", or a number [m]. All other lengths are in metres.
    resolution     edge of the tetrahedra that fill a surface [m]; a quarter of the tool's width or less. None: the program's choice
    model          other keys of a scene's `model`: {"element": "tet10", "law": "neo-hookean", "tolerance": 0.02}

    Raises ValueError: what is wrong, its value and what is expected; RuntimeError: no program fills the surface, or it failed.
    Warns (ForceWarning) of numbers that are hardly meant.
    """

    def __init__(self, mesh: Any, young_modulus: float | str, poisson_ratio: float, *, tool: Mapping[str, Any] | None = None,
                 fixed: Where | None = None, kind: str = "auto", thickness: float | str | None = None,
                 unit: float | str = "m", resolution: float | str | None = None, model: Mapping[str, Any] | None = None) -> None:
        geometry, nodes, elements = _geometry(mesh, thickness, unit)
        if resolution is not None:
            geometry["resolution"] = resolution
        held, by_node = _fixed(fixed, elements)
        if not isinstance(model or {}, Mapping):
            raise ValueError(f"model = {model}: expected a dict such as {{\"law\": \"neo-hookean\"}}")
        if model and "kind" in model:
            raise ValueError(f"model.kind = {model['kind']}: expected kind=\"{model['kind']}\", an argument of its own")
        scene: dict[str, Any] = {
            "name": "python",
            "object": {"geometry": geometry, "material": {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio}},
            "model": {**(model or {}), "kind": kind},
        }
        if held:
            scene["object"]["fixed"] = held
        if tool is not None:
            if not isinstance(tool, Mapping):
                raise ValueError(f"tool = {tool}: expected a dict such as {{\"shape\": \"flat\", \"width\": 0.01}}")
            scene["tool"] = _plain(tool, "tool")
        core = _core.model_of_text(_text(scene), nodes, elements)
        if by_node is not None:
            core.fix(_numbers_of(by_node, core.nodes()))
        self._take(core)

    @classmethod
    def from_scene(cls, file: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Model:
        """The model of a scene file. `overrides`: ["model.elements=60", ...]. `model.kind: auto` is chosen by rules.

        Raises ValueError: every mistake in the file, with its line.
        """
        if isinstance(overrides, str):
            raise ValueError(f"overrides = {overrides}: expected a list such as [\"model.elements=60\"]")
        model = cls.__new__(cls)
        model._take(_core.model_of_file(os.fspath(file), list(overrides)))
        return model

    def _take(self, core: _core.Model) -> None:
        core.prepare()
        self._core = core
        for remark in core.remarks():
            _warn(remark)

    @property
    def nodes(self) -> Array:
        """The nodes of a volume as they are computed with, frame O, (n, 3) [m]; of other bodies (0, 3)."""
        return self._core.nodes()

    @property
    def info(self) -> dict[str, Any]:
        """kind, degrees_of_freedom, elements, precompute_s [s], remark: what to know of this kind."""
        return self._core.info()

    @property
    def last_update_us(self) -> float:
        """The time that the model took for the last case, without Python [us]."""
        return self._core.update_us()

    def solve(self, contacts: ArrayLike | None = None, *, loads: ArrayLike | None = None, together: bool = False,
              path: bool = False) -> Answer:
        """The force of each contact: its place at rest and its displacement, x, y, z, dx, dy, dz, frame O [m].

        contacts  (6,) or (n, 6). Each row is a contact of its own, from rest, unless
        together  (n, 6): all rows act at the same time; (m, n, 6): m cases of n contacts each.
        loads     in place of contacts: x, y, z [m] and the force of the tool on the body fx, fy, fz [N]; the answer is the
                  displacement.
        path      each row, with `together` each case, continues from the one before instead of from rest. Friction, with
                  model={"contact": "friction"}, depends on it: press, drag and lift. A tool is the same one while its place x,
                  y, z stays the same, and its displacement is counted from there. It is gone in a case without it. After a
                  row without solution the others have none.

        A place is on the surface: a node, or at most half an edge of the nearest triangle away. On a plane body z and dz
        are 0, on a membrane dx and dy. Raises ValueError naming the contact.
        """
        if (contacts is None) == (loads is None):
            raise ValueError("solve: expected contacts or loads")
        name, given = ("contacts", contacts) if loads is None else ("loads", loads)
        rows = _floats(given, name)
        if rows.ndim < 1 + together or rows.shape[-1] != 6:
            raise ValueError(f"{name}: shape {rows.shape}: expected {'(n, 6) or (m, n, 6)' if together else '(6,) or (n, 6)'}: "
                             f"place x, y, z and {'force' if loads is not None else 'displacement'} along x, y, z")
        cases = rows.reshape(-1, rows.shape[-2] if together else 1, 6)
        force, displacement, error, validity, why = self._core.solve(cases, loads is not None, path)
        shape = rows.shape[:-1]
        return Answer(force.reshape(*shape, 3), displacement.reshape(*shape, 3), error.reshape(shape),
                      VALIDITIES[validity].reshape(shape), np.array(why, dtype=object).reshape(shape))


def solve(mesh: Any, young_modulus: float | str, poisson_ratio: float, contacts: ArrayLike | None = None, *,
          tool: Mapping[str, Any] | None = None, fixed: Where | None = None, kind: str = "auto", loads: ArrayLike | None = None,
          together: bool = False, path: bool = False, thickness: float | str | None = None, unit: float | str = "m",
          resolution: float | str | None = None, model: Mapping[str, Any] | None = None) -> Answer:
    """The contact force of a soft body, once: `Model` describes mesh, material, tool and fixed, `Model.solve` contacts.

        import palpate
        block = {"box": {"size": [0.06, 0.06, 0.03], "cells": [12, 12, 6]}}
        answer = palpate.solve(block, 20e3, 0.45, [0.03, 0.03, 0.03, 0, 0, -0.002],
                               tool={"shape": "flat", "width": 0.02}, fixed={"plane": {"axis": "z", "at": 0}},
                               kind="fem-green", model={"element": "tet10"})
        print(answer.force, answer.validity)   # [N], on the body

    Source: the models of palpate-slave, whose command `solve` gives the same digits. Warns (ForceWarning) if an answer is not
    valid.
    """
    prepared = Model(mesh, young_modulus, poisson_ratio, tool=tool, fixed=fixed, kind=kind, thickness=thickness, unit=unit,
                     resolution=resolution, model=model)
    answer = prepared.solve(contacts, loads=loads, together=together, path=path)
    for reason in dict.fromkeys(why for why, valid in zip(answer.why.flat, answer.valid.flat) if not valid):
        alike = answer.why == reason
        _warn(f"{np.sum(alike)} of {answer.why.size} answers are not valid ({answer.validity[alike][0]}): {reason}")
    if remark := prepared._core.place_remark():
        _warn(remark)
    return answer


def _warn(remark: str) -> None:
    """Warns at the line that called into this file."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename == __file__:
        level, frame = level + 1, frame.f_back
    warnings.warn(remark, ForceWarning, stacklevel=level)


def _floats(values: Any, name: str) -> Array:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers: {error}") from None


def _plain(value: Any, name: str) -> Any:
    """Converts a value of a scene to types of JSON."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one, f"{name}.{key}") for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), name)
    if isinstance(value, (list, tuple)):
        return [_plain(one, name) for one in value]
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError(f"{name}: {type(value).__name__}: expected a number, a text, a list or a dict")


def _text(scene: Mapping[str, Any]) -> str:
    """Writes a scene as JSON, which is YAML. NaN is written as such and rejected with its key."""
    return json.dumps(_plain(scene, "scene"))


def _geometry(mesh: Any, thickness: float | str | None, unit: float | str) -> tuple[dict[str, Any], Array | None, Any]:
    """Returns the geometry of the scene, and nodes and elements of a mesh in memory."""
    given = _mesh_or_dict(mesh, unit)
    if given is None:
        return _outline(mesh, thickness, unit), None, None
    if thickness is not None:
        raise ValueError(f"thickness = {thickness}: expected with an outline of shape (n, 2) only")
    return given


def _outline(mesh: Any, thickness: float | str | None, unit: float | str) -> dict[str, Any]:
    points = _floats(mesh, "mesh")
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"mesh: shape {points.shape}: expected (nodes, elements), a file, an outline of shape (n, 2), or a "
                         "dict such as {\"box\": ...}")
    if thickness is None:
        raise ValueError("thickness = (missing): expected the thickness of the plane body [m]")
    if isinstance(unit, str):
        return {"polygon": {"points": [[f"{x:.17g} {unit}" for x in point] for point in points], "thickness": thickness}}
    metres = _floats(unit, "unit")
    if metres.shape != () or not metres > 0:
        raise ValueError(f"unit = {unit}: expected a unit such as \"mm\", or a length > 0 [m]")
    return {"polygon": {"points": (metres * points).tolist(), "thickness": thickness}}


def _mesh_or_dict(mesh: Any, unit: float | str) -> tuple[dict[str, Any], Array | None, Any] | None:
    if isinstance(mesh, Mapping):
        if unit != "m":
            raise ValueError(f"unit = {unit}: expected with a mesh or an outline; a length in a dict has its own: \"60 mm\"")
        return dict(mesh), None, None
    if isinstance(mesh, (str, os.PathLike)):
        name = os.fspath(mesh)
        if name.lower().endswith((".yaml", ".yml")):
            raise ValueError(f"mesh = {name}: a scene: expected palpate.Model.from_scene(file)")
        if name.lower().endswith(READ_BY_PALPATE) or not os.path.isfile(name):
            return {"mesh": os.path.abspath(name), "unit": unit}, None, None
        try:
            import meshio
        except ImportError:
            raise ValueError(f"mesh = {name}: expected {' '.join(READ_BY_PALPATE)}; meshio, which is not installed, reads others") \
                from None
        mesh = meshio.read(name)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):  # trimesh
        return _in_memory(mesh.vertices, mesh.faces, unit)
    if hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):  # meshio
        cells = mesh.cells_dict
        for kind, corners in (("tetra", 4), ("tetra10", 4), ("triangle", 3)):
            if kind in cells:
                return _in_memory(mesh.points, np.asarray(cells[kind])[:, :corners], unit)
        raise ValueError(f"mesh: cells {', '.join(cells) or 'none'}: expected tetra or triangle")
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2 and np.ndim(mesh[0]) == 2:
        return _in_memory(mesh[0], mesh[1], unit)
    return None


def _in_memory(nodes: Any, elements: Any, unit: float | str) -> tuple[dict[str, Any], Array, Any]:
    points = _floats(nodes, "mesh: nodes")
    try:
        corners = np.asarray(elements)
    except ValueError as error:
        raise ValueError(f"mesh: elements: expected rows of equal length: {error}") from None
    if corners.dtype.kind not in "iu":
        raise ValueError(f"mesh: elements of type {corners.dtype}: expected whole numbers of nodes")
    return {"mesh": "mesh", "unit": unit}, points, corners.astype(np.int64)


def _fixed(fixed: Any, elements: Any) -> tuple[Any, Any]:
    """Splits `fixed` into the part for the scene and the part that needs the nodes of the body: a function, a mask or
    numbers."""
    if fixed is None:
        return None, None
    if isinstance(fixed, Mapping):
        return _plain(fixed, "fixed"), None
    if callable(fixed):
        return None, fixed
    if isinstance(fixed, (list, tuple)) and fixed and all(isinstance(one, Mapping) for one in fixed):
        return _plain(fixed, "fixed"), None
    numbers = np.asarray(fixed)
    if numbers.shape == (0,):
        raise ValueError("fixed: no node: expected one or more of the body")
    if numbers.dtype.kind not in "biu" or numbers.ndim != 1:
        raise ValueError(f"fixed: {numbers.dtype} of shape {numbers.shape}: expected a dict such as {{\"plane\": ...}}, numbers of "
                         "nodes, a mask, or a function of the nodes")
    if elements is not None and elements.ndim == 2 and elements.shape[1] == 3:
        raise ValueError("fixed: numbers of a surface's vertices: expected a dict or a function of the nodes, because the surface "
                         "is filled with new nodes: fixed=lambda p: p[:, 2] < 1e-3")
    return None, numbers


def _numbers_of(fixed: Any, nodes: Array) -> NDArray[np.int64]:
    """Returns the numbers of the fixed nodes of a volume."""
    if len(nodes) == 0:
        raise ValueError("fixed: nodes: expected a volume; a plane body takes {\"side\": \"bottom\"}, and a membrane is fixed at its rim")
    chosen = np.asarray(fixed(nodes) if callable(fixed) else fixed)
    if chosen.dtype.kind == "b":
        if chosen.shape != (len(nodes),):
            raise ValueError(f"fixed: a mask of shape {chosen.shape}: expected ({len(nodes)},), one for each node")
        chosen = np.flatnonzero(chosen)
    if chosen.dtype.kind not in "iu" or chosen.ndim != 1:
        raise ValueError(f"fixed: {chosen.dtype} of shape {chosen.shape}: expected a mask ({len(nodes)},) or numbers of nodes")
    if len(chosen) == 0:
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        raise ValueError(f"fixed: no node: expected one or more of the body, which reaches from {low} to {high} m")
    return chosen.astype(np.int64)
