#!/usr/bin/env bash
# Makes the README's pictures from the present build, on a quiet machine: page.webp, a film of the operator's page while a recorded
# session is replayed; station, setup and replay at 1280 and 390 px; force.svg, estimated and true force; frames.svg, the frames.
# Needs deploy/install.sh page, deploy/page.sh, a build.
# usage: deploy/readme/make_pictures.sh [FOLDER]      FOLDER of the programs, build/release/bin by default
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$(realpath "${1:-build/release/bin}") scratch=$PWD/build/readme to=deploy/readme
rm -rf "$scratch/film"
tests/page/run.sh "$scratch" "$bin" ../../deploy/readme/page_pictures.mjs
images=() last= count=0
for image in "$scratch"/film/*.jpg; do
  [ $((count++ % 3)) -eq 0 ] || continue  # every third image is used, to keep the file small
  time=$((10#$(basename "$image" .jpg)))
  [ "${last:-$time}" -ge $time ] || images+=(-d $((time - last)) "$previous")
  last=$time previous=$image
done
img2webp -loop 0 -lossy -q 60 -m 4 "${images[@]}" -o $to/page.webp
for name in station setup replay; do
  for width in 1280 390; do cwebp -quiet -q 80 -m 6 "$scratch/$name-$width.png" -o $to/$name-$width.webp; done
done
$to/make_force_plot.py "$bin/palpate-slave"
$to/make_frames.py
ls -l $to/*.webp
