#!/usr/bin/env bash
# Configures a preset and builds targets: deploy/build.sh PRESET [CMAKE -D OPTIONS ...] [-- TARGETS ...]. Quiet unless it fails.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
options=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
[ "${1:-}" = -- ] && shift
targets=()
[ $# -gt 0 ] && targets=(--target "$@")

log=build/$preset.log
mkdir -p build
cmake --preset "$preset" "${options[@]}" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
if [ -t 1 ]; then
  NINJA_STATUS='[%f/%t] ' cmake --build "build/$preset" "${targets[@]}"
else
  cmake --build "build/$preset" "${targets[@]}" >>"$log" 2>&1 || { tail -n 60 "$log" >&2; exit 1; }
fi
