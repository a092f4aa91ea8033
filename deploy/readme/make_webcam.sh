#!/usr/bin/env bash
# Makes the figures of the guide "A webcam in fifteen minutes": images of the page's steps, and the page to print. Needs
# deploy/install.sh page, deploy/page.sh, a build.
# usage: deploy/readme/make_webcam.sh [FOLDER]      FOLDER of the programs, build/release/bin by default
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$(realpath "${1:-build/release/bin}") scratch=$PWD/build/readme to=deploy/guides/webcam
tests/page/run.sh "$scratch" "$bin" ../../deploy/readme/webcam_steps.mjs
tests/page/run.sh "$scratch" "$bin" --test-name-pattern=kitchen setup_page_test.mjs
mkdir -p $to
for image in "$scratch"/step-*.png; do
  cwebp -quiet -q 60 -m 6 "$image" -o "$to/$(basename "$image" .png).webp"
done
cwebp -quiet -q 60 -m 6 -crop 0 80 1280 720 -resize 976 0 "$scratch/setup-identify.png" -o $to/scale.webp
deploy/readme/make_board.py
ls -l $to
