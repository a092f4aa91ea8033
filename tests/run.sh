#!/usr/bin/env bash
# Installs missing packages, builds and tests, cheapest first. The first failure prints the command to repeat it.
# usage: tests/run.sh [--fast | --full]
#   (nothing)  what every change must pass: the core tests and all tests of changed modules. Parsers, network code and one run
#              of each sensor type run under the address and undefined-behaviour sanitizers, the rest in the release build.
#              Link and haptic loop also run under the thread sanitizer
#   --fast     without sanitizers and without clang-tidy
#   --full     everything: slow tests, simulated environments, training, identification and studies in depth, all checks of
#              the sanitizers on everything that is not slow, thread sanitizer on all threaded code
# PALPATE_CI_LIMIT=SECONDS: a longer run fails and names the step that grew most.
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
# step NAME SHARE: begins the step NAME, which takes at most SHARE seconds on two idle cores.
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

step "install missing packages" 120
deploy/install.sh tests
[ $tier != full ] || deploy/install.sh packages bare studies
deploy/page.sh || echo "note: without three.js and uPlot the page tests are skipped"

step "format" 10
formatted=$(git ls-files '*.h' '*.cpp' 2>/dev/null || true)
if [ -n "$formatted" ]; then
  # shellcheck disable=SC2086
  clang-format --dry-run -Werror $formatted || repeat "clang-format -i \$(git ls-files '*.h' '*.cpp')"
fi

[ -z "$changed" ] || echo "changed modules, tested in full: ${changed//;/, }"
[ "$(rooms | wc -l)" -le $few ] || echo "note: more than $few modules changed since ${base:0:8}: run tests/run.sh --full as well"
[ -d ../shared ] || echo "note: ../shared is missing: tests that need its recordings and reference values are skipped"

step "build" 480
build release all

step "tests" 300
if [ $tier = full ]; then run_ctest release -j"$jobs"; else run_ctest release -j"$jobs" -LE slow; fi

case $tier in
  push)
    step "clang-tidy on changed sources" 60
    # Told, not yet demanded: sources changed before this was checked still have findings.
    tests/tidy.sh || echo "clang-tidy has findings. To repeat: tests/tidy.sh"

    # After the tests in real time, not beside them.
    step "build with sanitizers" 240
    build asan sanitized_tests
    build tsan raced_tests
    step "parsers, network code and sensors under address and undefined-behaviour sanitizers" 60
    sanitized asan -j"$jobs" -L sanitize

    step "link and haptic loop under the thread sanitizer" 30
    sanitized tsan -j"$jobs" -L races
    ;;
  full)
    step "clang-tidy on changed sources" 0
    PALPATE_TIDY_SECONDS=100000 tests/tidy.sh || repeat "tests/tidy.sh"

    step "g++, each source alone, without precompiled headers" 0
    deploy/install.sh gcc
    build gcc all

    step "fuzzers of all readers" 0
    deploy/install.sh fuzz
    tests/fuzz/run.sh --seconds 20 || repeat "tests/fuzz/run.sh --seconds 20"

    step "everything under address and undefined-behaviour sanitizers, all checks" 0
    build asan-full all
    sanitized asan-full -j"$jobs" -LE 'slow|clients'

    step "threaded code under the thread sanitizer" 0
    build tsan threaded_tests
    sanitized tsan -j"$jobs" -L threads
    ;;
esac

end_step
echo
echo "== time per step"
python3 tests/costs.py --since "$started" --walls "$walls" || slow=yes
echo
echo "== summary"
python3 tests/tally.py --sum "$summary" || exit 1
[ -z "${slow:-}" ]
