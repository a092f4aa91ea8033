#!/usr/bin/env bash
# ccache COMPILER ARGUMENTS..., where files of the build are named from its folder: CMake names precompiled headers from the
# root, and another clone, or another build of the same, would count as something else.
exec ccache "${@//"$PWD/"/}"
