#!/usr/bin/env bash
# clang-tidy over the sources changed since BASE (default: the commit before this one). Half a minute a file.
# usage: tests/tidy.sh [BASE]     needs the release build's compile commands
set -euo pipefail
cd "$(dirname "$0")/.."
command -v clang-tidy >/dev/null || { echo "tidy.sh: clang-tidy is missing: apt-get install clang-tidy" >&2; exit 1; }
[ -e build/release/compile_commands.json ] || { echo "tidy.sh: run tests/run.sh --fast first" >&2; exit 1; }
mapfile -t files < <(git diff --name-only --diff-filter=d "${1:-HEAD~1}" -- 'shared/*.cpp' 'slave/*.cpp' 'master/*.cpp')
[ ${#files[@]} -eq 0 ] && { echo "nothing changed"; exit 0; }
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/release --quiet --warnings-as-errors='*'
