#!/usr/bin/env bash
# Tests the examples of CONTRIBUTING: each patch applies to the present tree, changes only the files that its row
# permits, and the sources in its own folder compile with the flags of the existing build.
# usage: apply.sh BUILD_DIR SCRATCH_DIR [--build]   (--build: builds slave and master with all of them)
set -euo pipefail
build=$1 scratch=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$build" && pwd)

git -C "$root" rev-parse >/dev/null 2>&1 || { echo "skipped: not a clone"; exit 77; }
rm -rf "$scratch"
mkdir -p "$scratch"
(cd "$root" && git ls-files -z | tar --null --files-from=- --create) | tar --extract --directory "$scratch"
cd "$scratch"

# allowed PATCH: files outside of its own folder that it may change, apart from CMake's lists and tests
declare -A allowed=([model]=2 [state_field]=3)

# How_to_compile FILE.cpp: prints the compile command of a neighbouring source, adapted to this copy of the tree.
how_to_compile() {
  python3 - "$build" "$root" "$1" <<'PY'
import json, pathlib, shlex, sys
build, root, file = sys.argv[1:]
commands = json.load(open(build + "/compile_commands.json"))
folder = pathlib.Path(file).parent
def near(entry):
    place = entry["file"].removeprefix(build + "/").removeprefix(root + "/")
    return len([1 for a, b in zip(pathlib.Path(place).parts, folder.parts) if a == b])
words = shlex.split(max(commands, key=near)["command"])
compiler = next(i for i, word in enumerate(words) if pathlib.Path(word).name.startswith(("clang", "g++", "c++")))
kept = [word for before, word in zip(words[compiler:], words[compiler + 1:]) if "-o" not in (before, word)]
print(" ".join([words[compiler], "-I."] + kept[:kept.index("-c")]))
PY
}

failed=0
for name in model state_field; do
  patch --quiet -p1 <"$root/tests/contributing/$name.patch" || { echo "$name.patch does not apply"; exit 1; }
  changed=$(sed -n 's#^--- a/##p' "$root/tests/contributing/$name.patch" | grep -vE 'CMakeLists.txt|^tests/' || true)
  count=$(echo "$changed" | grep -c . || true)
  echo "$name: changes $count files outside of its room: $(echo $changed)"
  [ "$count" -le "${allowed[$name]}" ] || { echo "more than ${allowed[$name]}"; failed=1; }
done
[ $failed = 0 ] || exit 1

for file in $(cat "$root"/tests/contributing/*.patch | sed -n '\#^--- /dev/null#{n;s#^+++ b/##p}' | grep '\.cpp$' | sort -u); do
  # shellcheck disable=SC2046
  $(how_to_compile "$file") -fsyntax-only "$file" || { echo "$file does not compile"; exit 1; }
  echo "compiles: $file"
done

[ "${3:-}" = --build ] || exit 0
deploy/build.sh release -DPALPATE_TESTS=OFF -- palpate-slave palpate-master
build/release/bin/palpate-slave check deploy/scenes/foam-cube.yaml --override 'model={kind: half-space}'
