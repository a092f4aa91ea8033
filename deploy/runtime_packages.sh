#!/usr/bin/env bash
# The Debian packages that hold what the programs and modules below a folder load: deploy/runtime_packages.sh FOLDER
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: deploy/runtime_packages.sh FOLDER" >&2; exit 2; }
find "$1" -type f \( -path '*/bin/*' -o -name '*.so' -o -path '*/lib/palpate/*' \) -print0 | xargs -0 ldd |
  awk '$2 == "=>" {print $3} $1 ~ /^\// && $2 != "=>" && NF == 2 {print $1}' | sort -u |
  while read -r library; do
    file=$(realpath "$library")
    # Packages from before /lib became /usr/lib know their files by the older name.
    dpkg -S "$file" 2>/dev/null || dpkg -S "${file#/usr}" 2>/dev/null || { echo "$library: of no package" >&2; exit 1; }
  done | sed 's/:.*//' | sort -u
