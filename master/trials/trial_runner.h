// Runs the trials of a session one after the other, on a thread of its own.
//
//   wait until nobody is engaged -> open the clutch -> change the settings -> close the clutch
//   -> run for the trial's length -> next
//
// The ticks carry the label of the trial from its change of settings on; those before the first
// change have the label of the first. While the slave rejects a change, because something is
// touched, the clutch is closed so that the operator can retract, and the change is tried again.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "master/haptics/operator_requests.h"
#include "master/haptics/tick_record.h"
#include "master/link/slave_link.h"
#include "master/trials/trial_plan.h"

namespace palpate {

class TrialRunner {
 public:
  // Changes of the slave's settings. Return its reason on rejection, else an empty string.
  struct Slave {
    std::function<std::string(const SlaveLink::Mapping&)> set_mapping;
    std::function<std::string(const std::string& kind)> set_model;
  };

  // `trials` is not empty. `requests` must outlive the runner.
  TrialRunner(std::vector<Trial> trials, OperatorRequests* requests, Slave slave);

  [[nodiscard]] const std::vector<Trial>& trials() const { return trials_; }  // in their order
  // Takes each tick, on one thread.
  void See(const TickRecord& tick);
  // Sentences for the operator since the last call.
  [[nodiscard]] std::vector<std::string> TakeNotices();
  // All trials have ended, or the session cannot go on.
  [[nodiscard]] bool is_over() const { return over_; }
  // Why it cannot go on; empty: no problem.
  [[nodiscard]] std::string failure() const;

 private:
  void Run(const std::stop_token& stop);
  // Makes the settings of `trial` active; false: stopped, or failed.
  bool Prepare(const Trial& trial, const std::stop_token& stop);
  // The slave's reason, or empty.
  std::string Apply(const TrialCondition& condition);
  [[nodiscard]] bool IsActive(const TrialCondition& condition) const;
  // Whether `met` within `seconds`; false also if stopped.
  static bool WaitFor(const std::function<bool()>& met, double seconds,
                      const std::stop_token& stop);
  void Notify(const std::string& notice);

  const std::vector<Trial> trials_;
  OperatorRequests* const requests_;
  const Slave slave_;
  std::string model_;  // set last; used by the thread only
  std::atomic<bool> over_{false}, engaged_{true};
  // Of the newest tick.
  std::atomic<double> position_scale_{0}, force_scale_{0};
  std::atomic<RenderMode> render_{RenderMode::kLocal};
  std::atomic<bool> reads_settings_{true};
  mutable std::mutex mutex_;  // guards the next two
  std::vector<std::string> notices_;
  std::string failure_;
  std::jthread thread_;  // last: it uses the rest
};

}  // namespace palpate
