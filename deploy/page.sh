#!/usr/bin/env bash
# Installs three.js and uPlot of the operator's page, in fixed versions, from npm into build/page. The next build includes
# them in palpate-master. Without npm: exit 77, and the page is built without them.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v npm >/dev/null || { echo "page.sh: no npm (deploy/install.sh page): the page is built without 3D and charts" >&2; exit 77; }
mkdir -p build/page
from=master/station/page
if ! cmp -s $from/package-lock.json build/page/taken.json || [ ! -d build/page/node_modules/three ]; then
  cp $from/package.json $from/package-lock.json $from/.npmrc build/page/
  (cd build/page && timeout 300 npm ci --ignore-scripts >npm.log 2>&1) ||
    { echo "page.sh: npm could not install: $(grep -m 1 -E '^npm (ERR!|error) [A-Za-z]+ .* ' build/page/npm.log || tail -n 1 build/page/npm.log)" >&2; exit 77; }
  cp $from/package-lock.json build/page/taken.json
fi
