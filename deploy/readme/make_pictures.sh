#!/usr/bin/env bash
# Makes the README's pictures from the present build: page.webp, the operator's page in Chromium while a recorded
# session is replayed; force.svg, estimated and true force; frames.svg, the frames. Needs deploy/install.sh page, deploy/page.sh, a build.
# usage: deploy/readme/make_pictures.sh [FOLDER]      FOLDER of the programs, build/release/bin by default
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$(realpath "${1:-build/release/bin}") scratch=$PWD/build/readme
rm -rf "$scratch/film"
tests/page/run.sh "$scratch" "$bin" ../../deploy/readme/page_film.mjs
images=() last=
for image in "$scratch"/film/*.jpg; do
  time=$((10#$(basename "$image" .jpg)))
  [ "${last:-$time}" -ge $time ] || images+=(-d $((time - last)) "$previous")
  last=$time previous=$image
done
img2webp -loop 0 -lossy -q 85 -m 4 "${images[@]}" -o deploy/readme/page.webp
deploy/readme/make_force_plot.py "$bin/palpate-slave"
deploy/readme/make_frames.py
ls -l deploy/readme/page.webp
