#!/usr/bin/env bash
# Writes reference pages of all public declarations to build/api (Debian package: doxygen).
set -euo pipefail
cd "$(dirname "$0")/.."
command -v doxygen >/dev/null || { echo "api_pages.sh: doxygen is missing: apt-get install doxygen" >&2; exit 1; }
mkdir -p build
doxygen deploy/Doxyfile
echo "build/api/index.html"
