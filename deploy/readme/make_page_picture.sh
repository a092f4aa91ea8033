#!/usr/bin/env bash
# Makes README's picture of the operator's page: the real page in Chromium while the simulated operator presses the block.
# usage: deploy/readme/make_page_picture.sh [SCENE]      needs deploy/install.sh page, deploy/page.sh and a build
set -euo pipefail
cd "$(dirname "$0")/../.."
PALPATE_PICTURE_SCENE=${1:-silicone-block} tests/page/run.sh "$PWD/build/release/page" "$PWD/build/release/bin" ../../deploy/readme/page_picture.mjs
cp build/release/page/page-picture.png deploy/readme/page.png
