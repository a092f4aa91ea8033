#!/usr/bin/env bash
# clang-tidy on changed sources, for at most PALPATE_TIDY_SECONDS (45). Sources that were not reached are listed.
# usage: tests/tidy.sh [BASE]     BASE: where this branch left main, or on main itself the commit before
set -euo pipefail
cd "$(dirname "$0")/.."
command -v clang-tidy >/dev/null || { echo "tidy.sh: clang-tidy is missing: apt-get install clang-tidy" >&2; exit 1; }

base=${1:-$(git merge-base HEAD origin/main 2>/dev/null || true)}
[ "$base" != "$(git rev-parse HEAD)" ] || base=
[ -n "$base" ] || base=$(git rev-parse -q --verify HEAD~1 || true)
[ -n "$base" ] || { echo "there is no earlier commit: no source was checked"; exit 0; }
mapfile -t files < <(git diff --numstat --no-renames --diff-filter=d "$base" -- 'shared/*.cpp' 'slave/*.cpp' 'master/*.cpp' |
  sort -rn | cut -f 3)  # sources with most changes first
[ ${#files[@]} -gt 0 ] || { echo "no source has changed since $(git rev-parse --short "$base")"; exit 0; }

# Each source is checked separately, without unity build, with the message headers of the release build.
messages=$PWD/build/release/proto
[ -e "$messages/palpate" ] || { echo "tidy.sh: run deploy/build.sh release first" >&2; exit 1; }
cmake --preset dev -B build/tidy -DPALPATE_TESTS=OFF >build/tidy.log 2>&1 || { cat build/tidy.log >&2; exit 1; }

end=$(($(date +%s) + ${PALPATE_TIDY_SECONDS:-45}))
checked=$(mktemp)
export end messages checked
check() {
  local left=$((end - $(date +%s))) status=0
  [ $left -gt 0 ] || return 0
  timeout $left clang-tidy -p build/tidy --extra-arg="-isystem$messages" --quiet --warnings-as-errors='*' "$1" \
    2> >(grep -v ' warnings generated' >&2) || status=$?
  [ $status -eq 124 ] && return 0  # the time is over, so this source was not checked
  [ $status -ne 0 ] || echo "$1" >>"$checked"
  return $status
}
export -f check
result=0
printf '%s\0' "${files[@]}" | xargs -0 -P "$(nproc)" -I {} bash -c 'check "$1"' check {} || result=1
done=$(wc -l <"$checked")
echo "checked: $done of ${#files[@]} changed sources"
if [ $result -eq 0 ] && [ "$done" -lt ${#files[@]} ]; then
  echo "not checked within the time limit (for all of them: PALPATE_TIDY_SECONDS=3600 tests/tidy.sh ${1:-}):"
  printf '%s\n' "${files[@]}" | grep -vxFf "$checked" | sed 's/^/  /' | head -n 20
  [ $((${#files[@]} - done)) -le 20 ] || echo "  and $((${#files[@]} - done - 20)) more"
fi
rm -f "$checked"
exit $result
