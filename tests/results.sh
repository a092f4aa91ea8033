#!/usr/bin/env bash
# Measures rows of RESULTS.md again.
# usage: tests/results.sh            lists the rows
#        tests/results.sh ROW...     runs the commands of these rows, and writes date and commit into RESULTS.md
# A row is the figures above a block of commands. The line after the block names the row. What the commands print is kept
# in build/results/ROW.txt. The figures are entered by hand.
set -euo pipefail
cd "$(dirname "$0")/.."
page=tests/RESULTS.md

case ${1:-} in
  "") sed -n 's/^Row `\(.*\)`: \(.*\)\.$/\1: \2/p' $page; exit 0 ;;
  -*) sed -n '2,6s/^# //p' "$0"; exit 2 ;;
esac
for row in "$@"; do
  # The last block before the line of the row.
  commands=$(awk -v row="Row \`$row\`: " '/^```/ { if (inside = !inside) block = ""; next }
    inside { block = block $0 "\n" }
    index($0, row) == 1 { printf "%s", block; exit }' $page)
  [ -n "$commands" ] || { echo "$row: expected a row that tests/results.sh lists" >&2; exit 2; }
  changed=$(git status --porcelain -- . ":!$page")
  [ -z "$changed" ] || { echo "uncommitted changes: expected a commit to measure"; echo "$changed"; exit 1; } >&2
  mkdir -p build/results
  echo "$row: build/results/$row.txt"
  echo "$commands"
  bash -ec "$commands" >"build/results/$row.txt" 2>&1 || { echo "$row: a command failed, see build/results/$row.txt" >&2; exit 1; }
  sed -i "s/^Row \`$row\`: .*/Row \`$row\`: $(date +%F), commit $(git rev-parse --short=8 HEAD)./" $page
  echo "$row: enter its figures in $page by hand"
done
