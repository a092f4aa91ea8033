// A call of Python into the libraries: Ctrl+C interrupts it, and OpenBLAS computes on one thread.
#pragma once

#include <stop_token>
#include <string_view>

#include <pybind11/pybind11.h>

#include "slave/mechanics/linear/blas.h"
#include "slave/program/progress.h"

namespace palpate::python {

// Throws Interrupted where a handler of a signal raised.
inline void RequireNoSignal() {
  if (PyErr_CheckSignals() != 0) throw Interrupted();
}

// Stops the work where a handler of a signal raised.
class SignalProgress final : public Progress {
 public:
  bool Report(std::string_view /*stage*/, double /*done*/) override {
    if (PyErr_CheckSignals() == 0) return true;
    stop_.request_stop();
    return false;
  }
  [[nodiscard]] std::stop_token stop() const override { return stop_.get_token(); }

 private:
  std::stop_source stop_;
};

// `f` as member function or function of Python's arguments.
template <class F>
auto Called(const F& f) {
  const blas::OneThread one;
  try {
    return f();
  } catch (const Interrupted&) {
    if (PyErr_Occurred() != nullptr) throw pybind11::error_already_set();
    throw;
  }
}

}  // namespace palpate::python
