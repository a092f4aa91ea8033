#!/usr/bin/env bash
# ccache COMPILER ARGUMENTS..., where files of the build are named from its folder: CMake names precompiled headers from the
# root, and another clone, or another build of the same, would count as something else. Precompiled headers themselves are made
# anew in each clone: they name its files, and another clone could not read them.
for argument; do
  [ "$argument" = -emit-pch ] && exec "$@"
done
exec ccache "${@//"$PWD/"/}"
