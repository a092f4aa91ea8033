"""Types of the module of the C++ libraries, deploy/python/core."""
from typing import Any

import numpy as np
from numpy.typing import NDArray

version: str

class Model:
    def nodes(self) -> NDArray[np.float64]: ...
    def fix(self, nodes: NDArray[np.int64]) -> None: ...
    def prepare(self) -> None: ...
    def remarks(self) -> list[str]: ...
    def info(self) -> dict[str, Any]: ...
    def solve(self, rows: NDArray[np.float64], are_loads: bool, path: bool) -> tuple[
        NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8], list[str]]: ...
    def update_us(self) -> float: ...
    def place_remark(self) -> str: ...

def model_of_text(scene: str, nodes: NDArray[np.float64] | None, elements: NDArray[np.int64] | None) -> Model: ...
def model_of_file(scene: str, overrides: list[str]) -> Model: ...

class ForceColumns:
    measured: str
    estimated: str
    time: str
    sigma: str
    validity: str
    measured_unit: str
    estimated_unit: str
    time_unit: str

def compare_arrays(measured: NDArray[np.float64], estimated: NDArray[np.float64], t: NDArray[np.float64] | None,
                 sigma: NDArray[np.float64] | None, hold: NDArray[np.int64] | None, valid: NDArray[np.int64] | None,
                 source: str) -> tuple[str, str, bool]: ...
def compare_table(file: str, columns: ForceColumns) -> tuple[str, str, bool]: ...

class IdentifyRequest:
    data: list[str]
    scene: str
    overrides: list[str]
    area: str
    diameter: str
    height: str
    ends: str
    stress_unit: str
    x: str
    y: str
    smallest: float
    largest: float
    poisson_ratio: float
    fit_poisson: bool
    width: float

def identify(request: IdentifyRequest) -> tuple[str, str]: ...
