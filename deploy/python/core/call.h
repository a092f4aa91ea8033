// A call of Python into the libraries: Ctrl+C interrupts it, OpenBLAS computes on one thread, and
// other threads of Python run while it computes.
#pragma once

#include <stop_token>
#include <string_view>

#include <pybind11/pybind11.h>

#include "slave/mechanics/linear/blas.h"
#include "slave/program/progress.h"

namespace palpate::python {

// Throws Interrupted where a handler of a signal raised.
inline void RequireNoSignal() {
  const pybind11::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw Interrupted();
}

// Stops the work where a handler of a signal raised.
class SignalProgress final : public Progress {
 public:
  bool Report(std::string_view /*stage*/, double /*done*/) override {
    const pybind11::gil_scoped_acquire python;
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

// `f` as work that uses no object of Python, whose lock is released meanwhile.
template <class F>
auto Computed(const F& f) {
  const pybind11::gil_scoped_release others_run;
  return f();
}

}  // namespace palpate::python
