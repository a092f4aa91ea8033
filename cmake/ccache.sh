#!/usr/bin/env bash
# ccache COMPILER ARGUMENTS..., where files of the build are named from its folder: CMake names precompiled headers from the
# root, and another clone, or another build of the same, would count as something else. Precompiled headers themselves name
# the clone's files: another clone makes them anew, and its own builds share those that are compiled alike.
set -euo pipefail
relative=("${@//"$PWD/"/}")
[[ " $* " == *" -emit-pch "* ]] || exec ccache "${relative[@]}"
[[ $PWD == */build/* ]] || exec "$@"  # elsewhere nobody would look for what is shared

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
  [ -z "$(find $headers -newer "$shared.pch" 2>&1)" ]  # one that is gone is an error, and no less a reason
}
if is_fresh; then
  cp "$shared.d" "$dependencies"
  exec cp "$shared.pch" "$output"
fi
"$@"
mkdir -p ../precompiled
find ../precompiled -type f -mtime +0 -delete  # each is 0.2 GB
cp "$dependencies" "$shared.d"
ln -f "$output" "$shared.pch"
