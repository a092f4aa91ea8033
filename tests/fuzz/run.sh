#!/usr/bin/env bash
# Fuzzes the readers with libFuzzer of clang 16 (in clang 14 lambdas cannot capture structured bindings):
# deploy/install.sh fuzz. Inputs that crash, hang or exceed the limits are kept in build/fuzz/found; then the exit code
# is 1.
# usage: tests/fuzz/run.sh [--seconds N] [TARGET...]   (60 s for each target, all by default)
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=60
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --seconds) seconds=${2:?a number of seconds}; shift 2 ;;
    -*) echo "usage: tests/fuzz/run.sh [--seconds N] [TARGET...]" >&2; exit 2 ;;
    *) targets+=("$1"); shift ;;
  esac
done
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(sed -n 's/^palpate_fuzz(\([a-z]*\).*/\1/p' tests/fuzz/CMakeLists.txt)

[ -f build/fuzz/build.ninja ] || cmake --preset fuzz
cmake --build --preset fuzz --target "${targets[@]/#/fuzz_}"
python3 tests/fuzz/seeds.py build/fuzz/seeds
mkdir -p build/fuzz/found
failed=()
for target in "${targets[@]}"; do
  echo "== $target"
  corpus=build/fuzz/corpus/$target
  mkdir -p "$corpus"
  options=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=1500 -malloc_limit_mb=1000 -max_len=20000
    -print_final_stats=1 -artifact_prefix="build/fuzz/found/$target-")
  [ -f "build/fuzz/seeds/$target.dict" ] && options+=(-dict="build/fuzz/seeds/$target.dict")
  log=build/fuzz/found/$target.log
  # OpenCV's readers never free some memory. Leaks of Palpate are detected by the sanitized tests.
  nice ./build/fuzz/bin/"fuzz_$target" "${options[@]}" -detect_leaks=0 "$corpus" "build/fuzz/seeds/$target" >"$log" 2>&1 ||
    failed+=("$target")
  grep -E "^(SUMMARY|==.*ERROR|stat::(number_of_executed|peak_rss))|Test unit written" "$log" || true
done
[ ${#failed[@]} -eq 0 ] || { echo "found something: ${failed[*]}: see build/fuzz/found" >&2; exit 1; }
