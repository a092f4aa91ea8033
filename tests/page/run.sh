#!/usr/bin/env bash
# Drives the station's page in Chromium: run.sh SCRATCH BIN_FOLDER TEST.mjs ... Screenshots stay in SCRATCH.
# Exit code 77: no browser, no npm, or a palpate-master without 3D and charts.
set -euo pipefail

scratch=$1 bin=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)
skip() {
  echo "skipped: $1"
  exit 77
}

[ -x /usr/bin/chromium ] || skip "no /usr/bin/chromium (deploy/install.sh page)"
command -v npm >/dev/null || skip "no npm (deploy/install.sh page)"
grep -q "Three.js Authors" "$bin/palpate-master" || skip "palpate-master was built without three.js and uPlot (deploy/page.sh)"
mkdir -p "$scratch"
cp "$here"/package.json "$here"/package-lock.json "$here"/.npmrc "$scratch"/
if [ ! -d "$scratch/node_modules/playwright-core" ]; then
  (cd "$scratch" && timeout 120 npm ci --ignore-scripts >npm.log 2>&1) || skip "npm could not install: $(tail -n 1 "$scratch/npm.log")"
fi
cd "$here"
PALPATE_SCRATCH=$scratch PALPATE_BIN=$bin exec node --test --test-concurrency=1 --test-reporter=spec "$@"
