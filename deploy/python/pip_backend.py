"""Build backend of pyproject.toml: setuptools on the package that build.sh writes to build/pip, with the module of build/release."""
import pathlib
import shutil
import subprocess
import sysconfig
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import get_requires_for_build_wheel, prepare_metadata_for_build_wheel
from setuptools.dist import Distribution

__all__ = ["build_sdist", "build_wheel", "get_requires_for_build_wheel", "prepare_metadata_for_build_wheel"]

ROOT = pathlib.Path(__file__).parents[2]
MODULE = f"_core{sysconfig.get_config_var('EXT_SUFFIX')}"


def _has_ext_modules(_: Distribution) -> bool:
    return True  # the wheel contains a compiled module, so it is specific to this platform


Distribution.has_ext_modules = _has_ext_modules  # type: ignore[method-assign]
shutil.rmtree(ROOT / "build/pip", ignore_errors=True)
subprocess.run([ROOT / "deploy/python/build.sh", ROOT / "build/pip"], check=True)


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    # An existing build keeps its options.
    options = [] if (ROOT / "build/release/CMakeCache.txt").exists() else ["-DPALPATE_TESTS=OFF", "-DPALPATE_VALIDATE=OFF"]
    subprocess.run([ROOT / "deploy/build.sh", "release", *options, "--", "palpate_core"], check=True)
    built = ROOT / "build/release/python/palpate" / MODULE
    if not built.exists():
        raise RuntimeError(f"{built} is missing: expected a virtual environment of Debian's Python: /usr/bin/python3 -m venv "
                           "--system-site-packages DIR")
    shutil.copy(built, ROOT / "build/pip/palpate")
    return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory: str, config_settings: Any = None) -> str:
    raise RuntimeError("the package is built from the whole repository: pip install --no-build-isolation .")
