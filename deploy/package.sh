#!/usr/bin/env bash
# Builds the Debian packages palpate-slave, palpate-cameras, palpate-master, palpate-dev and python3-palpate.
# usage: deploy/package.sh [--out DIR] [--version VERSION] [--built]
#   --out DIR           folder of the packages, default build/packages; what else is there stays
#   --version VERSION   Debian version, default: from the tag vX.Y.Z, see below
#   --built             packs what build/release contains, without building
# It also writes DIR/SHA256SUMS and the software bill of materials DIR/palpate_VERSION.cdx.json (CycloneDX).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
out= version= built=
while [ $# -gt 0 ]; do
  case $1 in
    --out|--version)
      [ $# -ge 2 ] || { echo "package.sh: $1 needs a value" >&2; exit 2; }
      case $1 in --out) out=$2 ;; --version) version=$2 ;; esac
      shift 2 ;;
    --built) built=yes; shift ;;
    -h|--help) sed -n '2,7s/^# //p' "$0"; exit 0 ;;
    *) echo "package.sh: unknown option $1" >&2; exit 2 ;;
  esac
done
out=$(realpath -m "${out:-$root/build/packages}")
cd "$root"

# v0.2.0: 0.2.0; five commits later: 0.2.0+5.g1a2b3c4d; before the first tag 0.1.0~1660.1a2b3c4d, which is older than 0.1.0.
if [ -z "$version" ]; then
  release=$(sed -n 's/^palpate_release(\([0-9.]*\) .*/\1/p' CMakeLists.txt)
  if tag=$(git describe --tags --match 'v[0-9]*' --abbrev=8 2>/dev/null); then
    version=${tag#v}
    version=${version/-/+}
    version=${version/-/.}
  elif commits=$(git rev-list --count HEAD 2>/dev/null); then
    version=$release~$commits.$(git rev-parse --short=8 HEAD)
  else
    version=$release
  fi
fi
[[ $version =~ ^[0-9][0-9A-Za-z.+~]*$ ]] ||
  { echo "package.sh: --version $version: expected a digit, then digits, letters and . + ~" >&2; exit 2; }

if [ -z "$built" ]; then
  deploy/install.sh cameras clouds view packages
  deploy/page.sh || echo "the page will have no 3D view and no charts"
  deploy/build.sh release -DPALPATE_TESTS=OFF -DPALPATE_VALIDATE=OFF
fi
build=$root/build/release made=$root/build/release/package
for program in palpate-slave palpate-simulator palpate-master; do
  [ -x "$build/bin/$program" ] || { echo "package.sh: $build/bin/$program is missing: leave out --built" >&2; exit 1; }
done
rm -rf "$made" "$build/cpack"

python3 deploy/packages/manuals.py "$build/bin" "$made" "$version"
deploy/python/build.sh "$made/python"
cp "$build"/python/palpate/_core.*.so "$made/python/palpate/" 2>/dev/null ||
  { echo "package.sh: $build/python/palpate has no module: deploy/install.sh python, then leave out --built" >&2; exit 1; }
when=$(git log -1 --format=%ct 2>/dev/null || date +%s)
gzip -9n >"$made/changelog.gz" <<TEXT
palpate ($version) stable; urgency=medium

  * CHANGELOG.md of the sources lists the changes.

 -- Palpate developers <palpate@packages.invalid>  $(date -u -R -d "@$when")
TEXT

log=$build/package.log
cmake "$build" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
SOURCE_DATE_EPOCH=$when cpack --config "$build/CPackConfig.cmake" -B "$build/cpack" \
  -D CPACK_PACKAGE_VERSION="$version" >"$log" 2>&1 || { tail -n 40 "$log" >&2; exit 1; }
rm -rf "$build/cpack/_CPack_Packages"
(
  cd "$build/cpack"
  python3 "$root/deploy/packages/bill.py" "$version" ./*.deb >"palpate_$version.cdx.json"
  sha256sum ./* | sed 's# \./# #' >SHA256SUMS
  ls
)
mkdir -p "$out"
mv "$build"/cpack/* "$out/"
rmdir "$build/cpack"
