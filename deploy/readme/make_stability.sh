#!/bin/sh
# Makes stability.svg: where a hand stays calm, by stiffness, delay, rate, scale and device, beside theory.
#
# usage: deploy/readme/make_stability.sh [stability_map]   (default build/release/bin/stability_map)
set -eu
cd "$(dirname "$0")/../.."
"${1:-build/release/bin/stability_map}" --out deploy/readme/stability.svg
