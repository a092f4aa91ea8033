#!/usr/bin/env bash
# Builds the npm package for the tests: build_javascript.sh FOLDER. Exit code 77: npm is missing or has no network.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
command -v node >/dev/null && command -v npm >/dev/null || { echo "skipped: no node or no npm"; exit 77; }
rm -rf "$1"
"$here/../../deploy/javascript/build.sh" "$1" || {
  [[ -d $1/palpate/node_modules/typescript ]] && exit 1
  echo "skipped: npm could not install the packages"
  exit 77
}
