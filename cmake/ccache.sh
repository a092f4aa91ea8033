#!/usr/bin/env bash
# ccache COMPILER ARGUMENTS... with paths relative to the build folder. CMake names precompiled headers by absolute
# paths, so without this another clone, or another build folder, would not share cached files. Precompiled headers
# contain the clone's paths: each clone makes its own, which its build folders with the same flags share.
set -euo pipefail
relative=("${@//"$PWD/"/}")
[[ " $* " == *" -emit-pch "* ]] || exec ccache "${relative[@]}"
[[ $PWD == */build/* ]] || exec "$@"  # outside of build folders nothing is shared

output='' dependencies=''
for ((i = 1; i < $#; ++i)); do
  case ${!i} in
    -o) j=$((i + 1)) output=${!j} ;;
    -MF) j=$((i + 1)) dependencies=${!j} ;;
  esac
done
shared=../precompiled/$(cat - "$output.sum" <<<"${relative[*]}" | sha256sum | cut -c -32)
is_fresh() {
  [ -e "$shared.pch" ] && [ -e "$shared.d" ] || return 1
  local headers
  headers=$(tr -d '\\' <"$shared.d" | tr ' ' '\n' | grep / | grep -vE ':$|^CMakeFiles/')
  # shellcheck disable=SC2086
  [ -z "$(find $headers -newer "$shared.pch" 2>&1)" ]  # a missing header is an error and counts as changed
}
if is_fresh; then
  cp "$shared.d" "$dependencies"
  exec cp "$shared.pch" "$output"
fi
"$@"
mkdir -p ../precompiled
find ../precompiled -type f -mtime +0 -delete  # each precompiled header has 0.2 GB
cp "$dependencies" "$shared.d"
ln -f "$output" "$shared.pch"
