#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test, cheapest first. The first red prints the command to repeat.
# usage: tests/run.sh [--fast]   (--fast: without the sanitizer build)
set -euo pipefail
cd "$(dirname "$0")/.."

fast=no
case ${1:-} in
  "") ;;
  --fast) fast=yes ;;
  *) echo "usage: tests/run.sh [--fast]" >&2; exit 2 ;;
esac

step() { echo; echo "== $1"; }
repeat() { echo "FAILED. To repeat: $1" >&2; exit 1; }

step "install what is missing"
deploy/install.sh tests

step "format"
formatted=$(git ls-files '*.h' '*.cpp' 2>/dev/null || true)
if [ -n "$formatted" ]; then
  # shellcheck disable=SC2086
  clang-format --dry-run -Werror $formatted || repeat "clang-format -i \$(git ls-files '*.h' '*.cpp')"
fi

step "build"
deploy/build.sh release -DPALPATE_TESTS=ON -DPALPATE_WERROR=ON || repeat "deploy/build.sh release -DPALPATE_TESTS=ON -DPALPATE_WERROR=ON"

[ -d ../shared ] || echo "note: ../shared is absent: tests that need its recordings and reference values are skipped"

summary=build/tests.txt
: >"$summary"
run_ctest() {  # run_ctest PRESET CTEST-ARGUMENTS...
  local preset=$1; shift
  local log=build/ctest-$preset.log
  ctest --test-dir "build/$preset" --output-on-failure --output-log "$log" "$@" ||
    repeat "ctest --test-dir build/$preset --rerun-failed --output-on-failure"
  # Tests inside the executables, and those that were skipped and why.
  python3 tests/tally.py "build/$preset/Testing/Temporary/LastTest.log" >>"$summary"
}

step "tests"
run_ctest release -j2

if [ $fast = no ]; then
  step "the same under address and undefined-behaviour sanitizers, without the slow ones"
  deploy/build.sh asan -DPALPATE_TESTS=ON -- sanitized_tests || repeat "deploy/build.sh asan -- sanitized_tests"
  run_ctest asan -j2 -L sanitize
fi

step "summary"
python3 tests/tally.py --sum "$summary"
