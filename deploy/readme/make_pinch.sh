#!/bin/sh
# Makes pinch.png, the README's picture of the pinched foam cube, from the shipped scene. Needs rsvg-convert (librsvg2-bin).
#
# usage: deploy/readme/make_pinch.sh
set -eu
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
./deploy/demo.sh --scene foam-cube --duration 10 --out "$out"
rsvg-convert -w 960 "$out/shape-deepest.svg" -o deploy/readme/pinch.png
