#!/usr/bin/env bash
# Installs what is missing, builds, and tests, cheapest first. The first red prints the command to repeat.
# usage: tests/run.sh [--fast | --full]
#   (nothing)  what every change must pass: what sessions run on, and all of the rooms that were changed, each test once: what
#              parses or speaks, and a run of each sense, under address and undefined-behaviour sanitizers, the rest as it
#              is released; link and haptic loop under the thread sanitizer too
#   --fast     without sanitizers and without clang-tidy
#   --full     everything: slow tests, simulated worlds, training, identification and studies in depth, every check of the
#              sanitizers on everything that is not slow, threads everywhere
# PALPATE_CI_LIMIT=SECONDS: taking longer is a failure that names the step which grew.
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
base=$(tests/since.sh)
rooms() { [ -z "$base" ] || git diff --name-only "$base" -- slave shared master tests | xargs -r -n 1 dirname | sed 's#^tests/##' | sort -u; }
changed=$(rooms | paste -sd';')
few=6  # rooms; what changes more of the house is for --full
if [ "$(rooms | wc -l)" -gt $few ]; then changed=; fi
jobs=$(($(nproc) + 1))  # sessions sleep half of their time
started=$(date +%s)
summary=build/tests.txt
walls=build/walls.txt
mkdir -p build
: >"$summary"
: >"$walls"

step=
end_step() { [ -z "$step" ] || echo "$share $((SECONDS - step_started)) $step" >>"$walls"; }
# step NAME SHARE: what follows is NAME, which on two quiet cores takes no more than SHARE seconds.
step() {
  end_step
  step=$1 share=$2 step_started=$SECONDS
  echo
  echo "== $step"
}
repeat() { echo "FAILED. To repeat: $1" >&2; exit 1; }

# build PRESET TARGETS...
build() {
  local preset=$1; shift
  local options=(-DPALPATE_TESTS=ON -DPALPATE_WERROR=ON -DPALPATE_SANITIZED_APART=$apart -DPALPATE_FULL_TESTS=$every -DPALPATE_BENCHMARKS=$every "-DPALPATE_CHANGED=$changed")
  deploy/build.sh "$preset" "${options[@]}" -- "$@" || repeat "deploy/build.sh $preset ${options[*]} -- $*"
}

# run_ctest PRESET CTEST-ARGUMENTS...
run_ctest() {
  local preset=$1; shift
  ctest --test-dir "build/$preset" --output-on-failure --output-log "build/ctest-$preset.log" "$@" ||
    repeat "ctest --test-dir build/$preset --rerun-failed --output-on-failure"
  # Tests inside the executables, and those that were skipped and why.
  python3 tests/tally.py "build/$preset/Testing/Temporary/LastTest.log" >>"$summary"
}

# Threads of BLAS wait by spinning: beside other tests that took one of them twenty times as long.
export OPENBLAS_NUM_THREADS=1

# Under sanitizers programs are slower; what is known of the libraries below is not ours to mend.
sanitized() { PALPATE_PATIENCE=600 run_ctest "$@"; }

step "install what is missing" 120
deploy/install.sh tests
deploy/page.sh || echo "note: without three.js and uPlot the tests of the page are skipped"

step "format" 10
formatted=$(git ls-files '*.h' '*.cpp' 2>/dev/null || true)
if [ -n "$formatted" ]; then
  # shellcheck disable=SC2086
  clang-format --dry-run -Werror $formatted || repeat "clang-format -i \$(git ls-files '*.h' '*.cpp')"
fi

[ -z "$changed" ] || echo "changed, and tested in full: ${changed//;/, }"
[ "$(rooms | wc -l)" -le $few ] || echo "note: more than $few rooms were changed since ${base:0:8}: run tests/run.sh --full, too"
[ -d ../shared ] || echo "note: ../shared is absent: tests that need its recordings and reference values are skipped"

step "build" 480
build release all

step "tests" 300
if [ $tier = full ]; then run_ctest release -j"$jobs"; else run_ctest release -j"$jobs" -LE slow; fi

case $tier in
  push)
    step "clang-tidy on what changed" 60
    # Told, not yet demanded: sources changed before this was checked still have findings.
    tests/tidy.sh || echo "clang-tidy has something to say. To repeat: tests/tidy.sh"

    # After the tests in real time, not beside them.
    step "build with sanitizers" 240
    build asan sanitized_tests
    build tsan raced_tests
    step "what parses or speaks, and each sense, under them" 60
    sanitized asan -j"$jobs" -L sanitize

    step "link and haptic loop under the thread sanitizer" 30
    sanitized tsan -j"$jobs" -L races
    ;;
  full)
    step "clang-tidy on what changed" 0
    PALPATE_TIDY_SECONDS=100000 tests/tidy.sh || repeat "tests/tidy.sh"

    step "g++, each source by itself, nothing precompiled" 0
    deploy/install.sh gcc
    build gcc all

    step "fuzzers of every reader, each for a while" 0
    deploy/install.sh fuzz
    tests/fuzz/run.sh --seconds 20 || repeat "tests/fuzz/run.sh --seconds 20"

    step "everything under address and undefined-behaviour sanitizers, with every check" 0
    build asan-full all
    sanitized asan-full -j"$jobs" -LE 'slow|clients'

    step "everything that runs threads under the thread sanitizer" 0
    build tsan threaded_tests
    sanitized tsan -j"$jobs" -L threads
    ;;
esac

end_step
echo
echo "== what it cost"
python3 tests/costs.py --since "$started" --walls "$walls" || slow=yes
echo
echo "== summary"
python3 tests/tally.py --sum "$summary" || exit 1
[ -z "${slow:-}" ]
