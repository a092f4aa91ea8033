#!/usr/bin/env bash
# Converts a header for Doxygen: comment lines become /// (the first ones describe the file), comments behind a
# declaration become ///<.
awk -v file="$1" '
  NR == 1 && /^\/\/ / { print "/** @file"; in_head = 1 }
  in_head && /^\/\// { sub(/^\/\/ ?/, " * "); print; next }
  in_head { print " */"; in_head = 0 }
  /^[ \t]*\/\/( |$)/ { sub(/\/\//, "///"); print; next }
  { if (match($0, /[;,{}] +\/\/ /)) sub(/\/\/ /, "///< "); print }' "$1"
