#!/usr/bin/env bash
# Builds and runs the campaigns, one table each: build/campaigns/NAME.txt.
# usage: tests/campaigns/run.sh [NAME...]   robustness coverage model_selection stability; all of them by default
set -euo pipefail
cd "$(dirname "$0")/../.."

names=("$@")
[ $# -gt 0 ] || names=(robustness coverage model_selection stability)
out=build/campaigns
bin=build/release/bin
mkdir -p "$out"
deploy/build.sh release -DPALPATE_TESTS=ON -- campaigns

campaign() {
  case $1 in
    robustness) "$bin/robustness" --quick --known tests/campaigns/robustness/known.txt --out "$out/robustness" ;;
    coverage) for sense in camera pairs fingertips; do "$bin/coverage" --sense "$sense" --seed 7301 --scenes 400; done ;;
    model_selection) "$bin/model_selection" --scenes 20 --seed 101 ;;
    stability) "$bin/stability_map" --out "$out/stability.csv" ;;
    *) echo "tests/campaigns/run.sh: unknown campaign $1" >&2; return 2 ;;
  esac
}

failed=0
for name in "${names[@]}"; do
  echo "== $name"
  campaign "$name" 2>&1 | tee "$out/$name.txt" || failed=1
done
exit $failed
