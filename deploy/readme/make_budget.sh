#!/bin/sh
# Makes budget-block.svg, budget-membrane.svg and budget-fingertips.svg: the contributions to the error of the estimated force.
#
# usage: deploy/readme/make_budget.sh [palpate-slave]   (default build/release/bin/palpate-slave)
set -eu
cd "$(dirname "$0")/../.."
slave=${1:-build/release/bin/palpate-slave}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for pair in block:silicone-block membrane:rubber-membrane fingertips:foam-cube; do
    "$slave" study "deploy/scenes/${pair#*:}.yaml" --end-to-end --out "$out"
    cp "$out/end_to_end.svg" "deploy/readme/budget-${pair%:*}.svg"
done
