// Includes CLI11 without optimisation, because its headers dominate the compile time and its speed
// does not matter.
#pragma once

#ifdef __clang__
#pragma clang optimize off
#endif
#include <CLI/CLI.hpp>  // IWYU pragma: export
#ifdef __clang__
#pragma clang optimize on
#endif
