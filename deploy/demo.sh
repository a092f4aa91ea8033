#!/usr/bin/env bash
# Runs the whole system with one command: installs missing packages, builds, and runs the demo, deploy/palpate-demo.
# usage: deploy/demo.sh [--no-install] [--duration S] [--scene NAME] [--out DIR] [--view]   (--help explains them; --out is build/demo)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
bin=$root/build/release/bin out=$root/build/demo

more_options="
  --no-install                Build with the packages that are there, on any system"
install=yes words=()
for word in "$@"; do
  if [ "$word" = --no-install ]; then install=; else words+=("$word"); fi
done
set -- "${words[@]}"

prepare() {
  local parts=()
  echo "== install and build (several minutes the first time)"
  [ -z "$insertion" ] || parts+=(insertion)
  [ -z "$view" ] || parts+=(view)
  [ -z "$install" ] || "$root/deploy/install.sh" "${parts[@]}"
  [ -z "$view" ] || "$root/deploy/page.sh" || echo "the page will have no 3D view and no charts"
  "$root/deploy/build.sh" release -DPALPATE_TESTS=OFF -DPALPATE_VALIDATE=ON -DPALPATE_WERROR=OFF -- palpate-slave palpate-simulator palpate-master
}
# shellcheck source=palpate-demo
source "$root/deploy/palpate-demo"
