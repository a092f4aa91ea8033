#!/usr/bin/env bash
# Configures a preset and builds targets: deploy/build.sh PRESET [CMAKE -D OPTIONS ...] [-- TARGETS ...]. One line shows
# the progress. The output of the compilers is in build/PRESET.log, and is printed if they fail.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=progress.sh
source deploy/progress.sh

[ $# -ge 1 ] || { echo "usage: deploy/build.sh PRESET [-DOPTION=VALUE ...] [-- TARGETS ...]   PRESET: release, dev, bench, asan, tsan, fuzz or gcc" >&2; exit 2; }
[[ $PWD != *\"* ]] || { echo "build.sh: $PWD: CMake builds in no folder with \" in its name: rename it" >&2; exit 1; }
preset=$1
shift
options=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
[ "${1:-}" = -- ] && shift
targets=()
[ $# -gt 0 ] && targets=(--target "$@")

log=build/$preset.log
for made in . build "build/$preset" "$log"; do
  [ ! -e "$made" ] || [ -w "$made" ] || {
    made=$(realpath "$made")
    echo "build.sh: $made belongs to $(stat -c %U "$made"): $(id -un) may not write there. Run: sudo chown -R $(id -un) '$made'" >&2
    exit 1
  }
done
mkdir -p build
progress "build $preset: configuring"
cmake --preset "$preset" "${options[@]}" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }

status="build $preset: looking for changes"
follow() {  # follow LINE: keeps the compilers' output and shows the progress
  [ -z "$1" ] || echo "$1" >>"$log"
  [[ $1 =~ ^\[([0-9]+)/([0-9]+)\] ]] &&
    status="build $preset: [${BASH_REMATCH[1]}/${BASH_REMATCH[2]}] $((100 * BASH_REMATCH[1] / BASH_REMATCH[2])) %"
  progress "$status, $SECONDS s"
}
NINJA_STATUS='[%f/%t] ' cmake --build "build/$preset" "${targets[@]}" 2>&1 | each_line follow ||
  { progress_end "build $preset: failed" >&2; tail -n 60 "$log" >&2; exit 1; }
progress_end "build $preset: done in $SECONDS s"
