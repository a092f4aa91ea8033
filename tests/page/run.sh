#!/usr/bin/env bash
# Drives the station's page in Chromium: run.sh SCRATCH BIN_FOLDER TEST.mjs ... Screenshots stay in SCRATCH.
# Exit code 77: no browser, no packages of npm, or a palpate-master without 3D and charts.
set -euo pipefail

scratch=$1 bin=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)
skip() {
  echo "skipped: $1"
  exit 77
}

[ -x /usr/bin/chromium ] || skip "no /usr/bin/chromium (deploy/install.sh page)"
packages=$here/../../build/npm/page/node_modules
[ -d "$packages/playwright-core" ] || skip "no playwright-core (tests/npm.sh)"
grep -q "Three.js Authors" "$bin/palpate-master" || skip "palpate-master was built without three.js and uPlot (deploy/page.sh)"
mkdir -p "$scratch"
rm -rf "$scratch/node_modules"
ln -s "$(realpath "$packages")" "$scratch/node_modules"
cd "$here"
PALPATE_SCRATCH=$scratch PALPATE_BIN=$bin exec node --test --test-concurrency=1 --test-reporter=spec "$@"
