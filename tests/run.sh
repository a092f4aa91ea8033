#!/usr/bin/env bash
# Installs missing packages, builds and tests, cheapest first. The first failure prints the command to repeat it.
# usage: tests/run.sh [--fast | --full]
#   (nothing)  what every change must pass: the core tests. Parsers, network code and one run of each sensor type run under
#              the address and undefined-behaviour sanitizers, the rest in the release build. Link and haptic loop also run
#              under the thread sanitizer
#   --fast     without sanitizers
#   --full     everything: clang-tidy on changed files, slow tests, simulated environments, training, identification and studies in depth, all checks of
#              the sanitizers on everything that is not slow, thread sanitizer on all threaded code
# Where CI=true warnings are errors: these options compile again all that deploy/demo.sh has compiled.
set -euo pipefail
cd "$(dirname "$0")/.."

tier=push
case ${1:-} in
  "") ;;
  --fast | --full) tier=${1#--} ;;
  *) echo "usage: tests/run.sh [--fast | --full]" >&2; exit 2 ;;
esac

apart=OFF every=OFF
[ $tier != push ] || apart=ON
[ $tier != full ] || every=ON
werror=OFF
[ "${CI:-}" != true ] || werror=ON
jobs=$(($(nproc) + 1))  # because sessions sleep half of their time
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

# build PRESET TARGETS...
build() {
  local preset=$1; shift
  local options=(-DPALPATE_TESTS=ON -DPALPATE_VALIDATE=ON -DPALPATE_WERROR=$werror -DPALPATE_SANITIZED_APART=$apart -DPALPATE_FULL_TESTS=$every -DPALPATE_BENCHMARKS=$every)
  [ "$preset" != asan ] || options+=("-DPALPATE_RELEASED=$PWD/build/release")
  deploy/build.sh "$preset" "${options[@]}" -- "$@" || repeat "deploy/build.sh $preset ${options[*]} -- $*"
}

# run_ctest PRESET CTEST-ARGUMENTS...
run_ctest() {
  local preset=$1; shift
  logs+=("build/$preset/Testing/Temporary/LastTest.log")
  ctest --test-dir "build/$preset" --output-on-failure --output-log "build/ctest-$preset.log" --output-junit "$PWD/build/ctest-$preset.xml" "$@" ||
    repeat "ctest --test-dir build/$preset --rerun-failed --output-on-failure"
}

# Threads of BLAS wait by spinning. Beside other tests this made one test twenty times as slow.
export OPENBLAS_NUM_THREADS=1

# Programs with sanitizers are slower. Known findings in the libraries below are suppressed.
sanitized() { PALPATE_PATIENCE=600 run_ctest "$@"; }

step "install missing packages"
deploy/install.sh tests
[ $tier != full ] || deploy/install.sh packages bare
deploy/page.sh || echo "note: without three.js and uPlot the page tests are skipped"
tests/npm.sh || echo "note: tests that need packages of npm are skipped"

step "format"
formatted=$(git ls-files '*.h' '*.cpp' 2>/dev/null || true)
if [ -n "$formatted" ]; then
  # shellcheck disable=SC2086
  clang-format --dry-run -Werror $formatted || repeat "clang-format -i \$(git ls-files '*.h' '*.cpp')"
fi

[ -d ../shared ] || echo "note: ../shared is missing: tests that need its recordings and reference values are skipped"

step "build"
if [ $tier = full ]; then build release all campaigns; else build release all; fi

step "tests"
if [ $tier = full ]; then run_ctest release -j"$jobs"; else run_ctest release -j"$jobs" -LE slow; fi

case $tier in
  push)
    # Runs after the real-time tests, not in parallel.
    step "build with sanitizers"
    build asan sanitized_tests  # links libraries without sanitizer from build/release
    build tsan raced_tests
    step "parsers, network code and sensors under address and undefined-behaviour sanitizers"
    sanitized asan -j"$jobs" -L sanitize

    step "link and haptic loop under the thread sanitizer"
    sanitized tsan -j"$jobs" -L races
    ;;
  full)
    step "clang-tidy on changed sources"
    PALPATE_TIDY_SECONDS=100000 tests/tidy.sh || repeat "tests/tidy.sh"

    step "g++, each source alone, without precompiled headers"
    deploy/install.sh gcc
    build gcc all

    step "fuzzers of all readers"
    deploy/install.sh fuzz
    tests/fuzz/run.sh --seconds 20 || repeat "tests/fuzz/run.sh --seconds 20"

    step "everything under address and undefined-behaviour sanitizers, all checks"
    build asan-full all
    sanitized asan-full -j"$jobs" -LE 'slow|clients'

    step "threaded code under the thread sanitizer"
    build tsan threaded_tests
    sanitized tsan -j"$jobs" -L threads
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
echo
echo "== skipped"
skipped
echo
echo "== time per step"
printf '%s\n' "${times[@]}"
