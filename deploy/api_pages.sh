#!/usr/bin/env bash
# Makes pages of all public declarations from the headers (Debian: doxygen) in build/api.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v doxygen >/dev/null || { echo "api_pages.sh: doxygen is missing: apt-get install doxygen" >&2; exit 1; }
mkdir -p build
doxygen deploy/Doxyfile
echo "build/api/index.html"
