#!/usr/bin/env bash
# The commit since which the tree counts as changed: where this branch left main, or on main itself the one before; nothing
# where that is not known.
set -euo pipefail
cd "$(dirname "$0")/.."
for main in origin/main main; do
  base=$(git merge-base HEAD "$main" 2>/dev/null) && break || base=
done
[ -n "$base" ] && [ "$base" != "$(git rev-parse HEAD)" ] || base=$(git rev-parse -q --verify HEAD~1 2>/dev/null) || base=
echo "$base"
