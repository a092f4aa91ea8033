#!/usr/bin/env bash
# Installs what tests need from npm into build/npm, once for all of them. It ends with exit code 77 at the first package
# that npm cannot install within five minutes. Tests whose packages are missing are skipped.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v npm >/dev/null || { echo "npm.sh: no npm (deploy/install.sh tests)" >&2; exit 77; }
for from in tests/page tests/e2e/recordings; do
  to=build/npm/${from##*/}
  cmp -s "$from/package.json" "$to/installed.json" && continue
  mkdir -p "$to"
  cp "$from/package.json" "$to"
  command=install
  if [ -e "$from/package-lock.json" ]; then
    cp "$from/package-lock.json" "$from/.npmrc" "$to"
    command=ci
  fi
  (cd "$to" && timeout 300 npm $command --ignore-scripts --no-audit --no-fund >npm.log 2>&1) ||
    { echo "npm.sh: npm could not install the packages of $from: $(grep -m 1 -E '^npm (ERR!|error) [A-Za-z]+ .* ' "$to/npm.log" || tail -n 1 "$to/npm.log")" >&2; exit 77; }
  cp "$from/package.json" "$to/installed.json"
done
