#!/usr/bin/env bash
# Prints the Debian packages of the libraries that programs and modules below a folder load: deploy/runtime_packages.sh FOLDER
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: deploy/runtime_packages.sh FOLDER" >&2; exit 2; }
loaded=$(find "$1" -type f \( -path '*/bin/*' -o -path '*/lib/palpate/*' \) -print0 | xargs -0 ldd |
         awk '$2 == "=>" {print $3} /^\t\// {print $1}' | sort -u | xargs realpath | sort -u)
# Packages from before /lib became /usr/lib know their files by the older name.
owned=$(sed 'p; s#^/usr##' <<<"$loaded" | xargs dpkg -S 2>/dev/null || true)
while read -r library; do
  grep -q "/${library##*/}\$" <<<"$owned" || { echo "$library: belongs to no package" >&2; exit 1; }
done <<<"$loaded"
sed 's/:.*//' <<<"$owned" | sort -u
