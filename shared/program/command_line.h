// CLI11, unoptimised: its headers are most of what a program's main file costs to compile, and
// nobody waits for what it does.
#pragma once

#ifdef __clang__
#pragma clang optimize off
#endif
#include <CLI/CLI.hpp>  // IWYU pragma: export
#ifdef __clang__
#pragma clang optimize on
#endif
