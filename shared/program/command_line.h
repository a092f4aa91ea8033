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

namespace palpate {

// Adds an option whose help shows `type`, such as FILE or HOST:PORT.
template <class T>
CLI::Option* Add(CLI::App* command, const char* name, T* value, const char* type,
                 const char* text) {
  return command->add_option(name, *value, text)->type_name(type);
}
// Adds an option whose help shows the default.
template <class T>
CLI::Option* AddShown(CLI::App* command, const char* name, T* value, const char* text) {
  return command->add_option(name, *value, text)->capture_default_str();
}

}  // namespace palpate
