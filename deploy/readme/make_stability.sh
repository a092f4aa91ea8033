#!/bin/sh
# Makes stability.svg: stability by stiffness, delay, rate, scale and device, with the theoretical bounds.
#
# usage: deploy/readme/make_stability.sh [stability_map]   (default build/release/bin/stability_map)
set -eu
cd "$(dirname "$0")/../.."
table=$(mktemp)
trap 'rm -f "$table"' EXIT
"${1:-build/release/bin/stability_map}" --out "$table"
/usr/bin/python3 tests/campaigns/stability/draw.py "$table" deploy/readme/stability.svg
