// A fake library as a test opens it.
#pragma once

#include <stdexcept>
#include <string>

#include <dlfcn.h>

#include "tests/master/device/fakes/fakes.h"
#include "tests/support/paths.h"

namespace palpate::fakes {

// Loads build/release/fakes/<folder>/<file>: the same instance that a driver gets from that path.
// Throws std::runtime_error where it is missing.
class Library {
 public:
  Library(const std::string& folder, const std::string& file)
      : handle_(
            dlopen(BinaryPath("/fakes/" + folder + "/" + file).c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw std::runtime_error(dlerror());
    reset();
  }
  ~Library() {
    reset();
    dlclose(handle_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  // The symbol `name`; nullptr where it is missing. Find<decltype(fake_step)>("fake_step").
  template <class Function>
  Function* Find(const char* name) const {
    return reinterpret_cast<Function*>(dlsym(handle_, name));
  }

 private:
  void* handle_;

 public:
  decltype(&fake_reset) const reset = Find<decltype(fake_reset)>("fake_reset");
  decltype(&fake_set_clock) const set_clock = Find<decltype(fake_set_clock)>("fake_set_clock");
  decltype(&fake_step) const step = Find<decltype(fake_step)>("fake_step");
  decltype(&fake_now) const now = Find<decltype(fake_now)>("fake_now");
  decltype(&fake_set_option) const set_option = Find<decltype(fake_set_option)>("fake_set_option");
  decltype(&fake_place) const place = Find<decltype(fake_place)>("fake_place");
  decltype(&fake_follow) const follow = Find<decltype(fake_follow)>("fake_follow");
  decltype(&fake_press) const press = Find<decltype(fake_press)>("fake_press");
  decltype(&fake_unplug) const unplug = Find<decltype(fake_unplug)>("fake_unplug");
  decltype(&fake_replug) const replug = Find<decltype(fake_replug)>("fake_replug");
  decltype(&fake_freeze) const freeze = Find<decltype(fake_freeze)>("fake_freeze");
  decltype(&fake_set_error) const set_error = Find<decltype(fake_set_error)>("fake_set_error");
  decltype(&fake_last_force) const last_force = Find<decltype(fake_last_force)>("fake_last_force");
  decltype(&fake_last_command) const last_command =
      Find<decltype(fake_last_command)>("fake_last_command");
  decltype(&fake_calls) const calls = Find<decltype(fake_calls)>("fake_calls");
};

}  // namespace palpate::fakes
