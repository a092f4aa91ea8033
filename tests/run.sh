#!/usr/bin/env bash
# Installs missing packages, builds and tests. The first failure prints the command to repeat it.
# usage: tests/run.sh [--changed | --sanitize | --full] [--no-install]
#   (nothing)     before each commit: format, the quick tests of every module, each sense once in real time
#   --changed     the same for what differs from the branch main, or from the last commit on main itself
#   --sanitize    what CI runs besides: parsers and network code under the address and undefined-behaviour sanitizers, link
#                 and haptic loop under the thread sanitizer
#   --full        everything: long mechanics, everything in real time, clang-tidy on changed files, g++, fuzzers, benchmarks
#                 and campaigns built, all tests under the sanitizers. It takes hours
#   --no-install  builds with the packages that are there
set -euo pipefail
cd "$(dirname "$0")/.."

tier=quick install=yes
for argument in "$@"; do
  case $argument in
    --changed | --sanitize | --full) tier=${argument#--} ;;
    --no-install) install= ;;
    *) echo "usage: tests/run.sh [--changed | --sanitize | --full] [--no-install]" >&2; exit 2 ;;
  esac
done

jobs=$(($(nproc) + 1))  # tests in real time sleep half of their time
times=() logs=()

step=
end_step() { [ -z "$step" ] || times+=("$((SECONDS - step_started)) s  $step"); }
# step NAME: begins the step NAME.
step() {
  end_step
  step=$1 step_started=$SECONDS
  echo
  echo "== $step"
}
repeat() { echo "FAILED. To repeat: $1" >&2; exit 1; }

# build PRESET TARGETS...   The options are those of deploy/demo.sh, whose objects are used again. In --full warnings are errors.
build() {
  local preset=$1; shift
  local options=(-DPALPATE_TESTS=ON -DPALPATE_VALIDATE=ON -DPALPATE_WERROR=OFF)
  [ $tier != full ] || options+=(-DPALPATE_WERROR=ON -DPALPATE_BENCHMARKS=ON)
  deploy/build.sh "$preset" "${options[@]}" -- "$@" || repeat "deploy/build.sh $preset ${options[*]} -- $*"
}

# run_ctest PRESET CTEST-ARGUMENTS...
run_ctest() {
  local preset=$1; shift
  logs+=("build/$preset/Testing/Temporary/LastTest.log")
  ctest --test-dir "build/$preset" -j"$jobs" --output-on-failure --output-log "build/ctest-$preset.log" --output-junit "$PWD/build/ctest-$preset.xml" "$@" ||
    repeat "ctest --test-dir build/$preset --rerun-failed --output-on-failure"
}

# Threads of BLAS wait by spinning. Beside other tests this made one test twenty times as slow.
export OPENBLAS_NUM_THREADS=1

# Programs with sanitizers are slower.
sanitized() { PALPATE_PATIENCE=600 run_ctest "$@"; }

if [ -n "$install" ]; then
  step "install missing packages"
  deploy/install.sh tests
  [ $tier != full ] || deploy/install.sh packages bare
  deploy/page.sh || echo "note: without three.js and uPlot the page tests are skipped"
  tests/npm.sh || echo "note: tests that need packages of npm are skipped"
fi

if [ $tier != sanitize ]; then
  step "format and names"
  tests/names.sh || repeat "tests/names.sh"
  mapfile -t formatted < <(git ls-files '*.h' '*.cpp' 2>/dev/null)
  if [[ $(clang-format --version) != *" 14."* ]]; then
    echo "note: the format is that of clang-format 14 and was not checked"  # Debian 13 has 19
  elif [ ${#formatted[@]} -gt 0 ]; then
    clang-format --dry-run -Werror "${formatted[@]}" || repeat "clang-format -i \$(git ls-files '*.h' '*.cpp')"
  fi
fi
[ -d ../shared ] || echo "note: ../shared is missing: tests that need its recordings and reference values are skipped"

case $tier in
  quick)
    step "build"
    build release quick_tests
    step "tests"
    run_ctest release -LE slow
    ;;
  changed)
    step "build"
    build release quick_tests
    step "tests of what has changed"
    tests=$(/usr/bin/python3 tests/changed.py build/release)
    if [ -n "$tests" ]; then run_ctest release -LE slow -R "$tests"; else echo "no test depends on what has changed"; fi
    ;;
  sanitize)
    step "build with sanitizers"
    build asan sanitize_tests
    build tsan races_tests
    step "parsers and network code under address and undefined-behaviour sanitizers"
    sanitized asan -L sanitize
    step "link and haptic loop under the thread sanitizer"
    sanitized tsan -L races
    ;;
  full)
    step "build"
    build release all campaigns
    step "tests"
    run_ctest release

    step "clang-tidy on changed sources"
    PALPATE_TIDY_SECONDS=100000 tests/tidy.sh || repeat "tests/tidy.sh"

    step "g++, each source alone, without precompiled headers"
    deploy/install.sh gcc
    build gcc all

    step "fuzzers of all readers"
    deploy/install.sh fuzz
    tests/fuzz/run.sh --seconds 20 || repeat "tests/fuzz/run.sh --seconds 20"

    step "everything quick under address and undefined-behaviour sanitizers"
    build asan quick_tests
    sanitized asan -LE slow

    step "threaded code under the thread sanitizer"
    build tsan threads_tests races_tests
    sanitized tsan -L 'threads|races'
    ;;
esac

end_step
# skipped: for each test that skipped something, how often and the first reason, from the logs of ctest.
skipped() {
  awk '/^[0-9]+\/[0-9]+ Testing: / { test = $3 }
       /^skipped[: ]/ || / \.\.\. skipped / || /^\[  SKIPPED \] .*\(/ || /^(Skipped|.*: Skipped)$/ {
         if (/: Skipped$/ || /^Skipped$/) { getline; if (!(test in why)) why[test] = $0; next }
         sub(/.*\.\.\. skipped /, ""); sub(/^skipped:? /, "")
         if (!/^\[/ && !(test in why)) why[test] = $0
         ++count[test] }
       END { for (test in count) printf "%s: %d skipped: %s\n", test, count[test], why[test] }' "${logs[@]}" | sort
}
if [ ${#logs[@]} -gt 0 ]; then
  echo
  echo "== skipped"
  skipped
fi
echo
echo "== time per step"
printf '%s\n' "${times[@]}"
