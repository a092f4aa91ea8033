"""Build backend of pyproject.toml: setuptools on the package that build.sh writes to build/pip."""
import pathlib
import subprocess
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import get_requires_for_build_wheel, prepare_metadata_for_build_wheel

__all__ = ["build_sdist", "build_wheel", "get_requires_for_build_wheel", "prepare_metadata_for_build_wheel"]

subprocess.run([pathlib.Path(__file__).parent / "build.sh", "build/pip"], check=True)


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory: str, config_settings: Any = None) -> str:
    raise RuntimeError("the package is built from the whole repository: pip install --no-build-isolation .")
