#!/usr/bin/env bash
# Fails if two headers or sources define a class of one name in one namespace: if one program contains both, the linker
# keeps one of their functions. usage: tests/names.sh
set -euo pipefail
cd "$(dirname "$0")/.."
command -v ctags >/dev/null || { echo "note: names were not compared: no ctags (deploy/install.sh tests)"; exit 0; }
git rev-parse >/dev/null 2>&1 || { echo "note: names were not compared: not a clone"; exit 0; }
# Programs of their own: users' examples, and the client of the installed packages.
git ls-files '*.h' '*.cpp' | grep -vE '^(deploy/examples|tests/packages)/' |
  ctags -L - --languages=C++ --kinds-C++=cgsu --fields=+s -x --_xformat='%{scope}::%N %F' 2>/dev/null |
  grep -v __anon | sort -u | awk '
    { files[$1] = files[$1] " " $2; ++count[$1] }
    END { for (name in count) if (count[name] > 1) { print "defined twice: " name ":" files[name]; twice = 1 }
          exit twice }'
