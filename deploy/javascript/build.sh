#!/usr/bin/env bash
# Writes the npm package palpate with its .proto files, dependencies and types: deploy/javascript/build.sh FOLDER
# Node.js finds it with NODE_PATH=FOLDER. `npm pack` in FOLDER/palpate makes the file to publish. Needs npm.
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: deploy/javascript/build.sh FOLDER" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1/palpate/proto/palpate"
cp -r "$here"/{package.json,package-lock.json,tsconfig.json,.npmrc,lib} "$here/../../LICENSE" "$1/palpate/"
cp -r "$here/../../proto/palpate/v1" "$1/palpate/proto/palpate/"
cd "$1/palpate"
npm ci --ignore-scripts --silent
npm run --silent types
