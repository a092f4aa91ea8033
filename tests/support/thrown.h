// The message of an exception.
#pragma once

#include <string>

namespace palpate {

// The message of the Error that the action throws; empty: it throws none.
template <class Error, class Action>
std::string Thrown(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace palpate
