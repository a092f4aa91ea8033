#!/usr/bin/env bash
# Writes the Python package palpate with its generated stubs: deploy/python/build.sh FOLDER
# Python finds it with PYTHONPATH=FOLDER. Needs protoc and grpc_python_plugin (Debian: protobuf-compiler-grpc).
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: deploy/python/build.sh FOLDER" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
proto=$here/../../proto
plugin=$(command -v grpc_python_plugin) ||
  { echo "build.sh: grpc_python_plugin is missing: apt-get install protobuf-compiler-grpc" >&2; exit 1; }
mkdir -p "$1/palpate/v1" "$1/palpate/training"
cp "$here"/palpate/*.py "$here"/palpate/_core.pyi "$here"/palpate/py.typed "$1/palpate/"
cp "$here"/palpate/training/*.py "$1/palpate/training/"
protoc -I"$proto" --python_out="$1" --pyi_out="$1" "$proto"/palpate/v1/*.proto
protoc -I"$proto/foxglove" --python_out="$1/palpate" --pyi_out="$1/palpate" schemas.proto
protoc -I"$proto" --grpc_out="$1" --plugin=protoc-gen-grpc="$plugin" palpate/v1/teleoperation.proto
touch "$1/palpate/v1/__init__.py"
