#!/bin/sh
# Makes stability.svg: stability by stiffness, delay, rate, scale and device, with the theoretical bounds.
#
# usage: deploy/readme/make_stability.sh [stability_map]   (default build/release/bin/stability_map)
set -eu
cd "$(dirname "$0")/../.."
"${1:-build/release/bin/stability_map}" --out deploy/readme/stability.svg
