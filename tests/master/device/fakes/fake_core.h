// Common part of all fake devices: clock, handle, operator's script and faults. After the first
// call of each function, calls and steps allocate no memory, so that a test counts only the
// driver's allocations.
#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <Eigen/Core>

#include "tests/master/device/fakes/fakes.h"

#define FAKE_EXPORT extern "C" __attribute__((visibility("default")))

namespace palpate::fakes {

// The state of the handle as reported by the device, rounded to its resolution.
struct Sample {
  double t = 0;  // [s]
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  unsigned buttons = 0;  // bit = number
};

class Core {
 public:
  virtual ~Core() = default;

  // Guards all members; functions that must be called with it locked say so.
  std::recursive_mutex mutex;

  void Reset();
  void SetClock(double now);
  void Step(double seconds);
  // Moves the device to the present and returns the time. Locked.
  double Sync();
  bool SetOption(const std::string& name, const std::string& value);
  std::string Command(const std::string& line);
  void Plug(bool in);

  // Counts a call of the vendor's `function` and moves the device to the present. Returns the code
  // with which this call shall fail, or 0. Locked.
  int Enter(const char* function);
  // Locked, as all below.
  const Sample& Look();
  double Number(std::string_view name) const;
  const std::string& Text(std::string_view name) const;
  void Took(const Eigen::Vector3d& force);

  bool plugged = true;
  int frozen = 0;
  double time = 0;  // of the device [s]
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
  std::vector<FakeKnot> knots;
  double followed_since = 0;
  struct ButtonEvent {
    double at;
    int button;
    bool down;
  };
  std::vector<ButtonEvent> button_events;
  unsigned buttons = 0;
  struct Fault {
    int code, count;
  };
  std::map<std::string, Fault, std::less<>> faults;
  std::map<std::string, int, std::less<>> calls;
  Eigen::Vector3d command = Eigen::Vector3d::Zero();  // newest command that the device accepted [N]
  double command_at = 0;                              // [s]

  // The motors' force now; zero where they are off.
  virtual Eigen::Vector3d MotorForce() const { return Eigen::Vector3d::Zero(); }
  virtual bool MotorsOn() const { return false; }

  bool manual() const { return manual_; }

 protected:
  // Returns the options with their default values. An option whose default is a number accepts only
  // numbers.
  virtual std::map<std::string, std::string> Defaults() const = 0;
  virtual void OnReset() {}
  virtual void OnOption(const std::string&) {}
  virtual void OnPlug() {}
  // After each step of `h` seconds.
  virtual void OnStep(double) {}
  // Moves the injected clock to `t`. Not locked.
  virtual void StepTo(double t);
  void Advance(double until);
  std::atomic<double> manual_now_ = 0;

 private:
  struct Option {
    std::string text;
    double number;
    bool numeric;
  };
  void FollowKnots();

  std::map<std::string, Option, std::less<>> options_;
  std::atomic<bool> manual_ = false;
  Sample shown_;
};

// The device of this library.
Core& TheCore();

// Serves the control socket that the environment names while it lives; see fakes.h.
class Start {
 public:
  Start(Core& core, const char* name);
  ~Start();
  Start(const Start&) = delete;
  Start& operator=(const Start&) = delete;

 private:
  void Serve(Core& core);

  std::string path_;
  int listening_ = -1;
  std::atomic<int> client_ = -1;
  std::jthread server_;
};

}  // namespace palpate::fakes
