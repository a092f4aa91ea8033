#!/bin/sh
# Makes study-block.svg, the README's figure of accuracy against speed, from the shipped block.
#
# usage: deploy/readme/make_study.sh [palpate-slave]   (default build/release/bin/palpate-slave)
set -eu
cd "$(dirname "$0")/../.."
slave=${1:-build/release/bin/palpate-slave}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$slave" study deploy/scenes/silicone-block.yaml --out "$out" --budget 60
PYTHONPATH=build/release/python /usr/bin/python3 -m palpate.plot "$out/study.csv" --out deploy/readme/study-block.svg
