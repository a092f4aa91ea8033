// Receives scene, status, traces and observed states with the values of all checks. Uses the calls
// of an observer on a separate channel and threads.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "master/link/slave_link.h"
#include "shared/state/sample_trace.h"

namespace google::protobuf {
class Message;
}

namespace palpate {

// `message` as JSON with the field names of proto/palpate/v1; empty if that fails.
std::string JsonOf(const google::protobuf::Message& message);

class SlaveStatusPoller {
 public:
  // Texts in JSON with the field names of proto/palpate/v1; empty: not received yet.
  struct Words {
    std::uint64_t version = 0;  // rises with each change
    std::string scene, capabilities, status;
    std::string trouble;  // why nothing is received
  };

  // A state with the values of its checks as JSON.
  struct ObservedState {
    SlaveState state;  // sequence 0: none yet
    std::string details = "{}";
    Time received_at{};
  };

  // Queries at once and then every second. States arrive 30 times a second. Throws
  // std::invalid_argument for an invalid target, or one beyond loopback without `insecure`.
  explicit SlaveStatusPoller(const SlaveLink::Options& link);
  ~SlaveStatusPoller();

  [[nodiscard]] ObservedState felt() const;  // the newest; thread-safe
  // Trace of the sample that was sensed at this time, slave's clock. nullopt: not received, or
  // older than a second. Thread-safe.
  [[nodiscard]] std::optional<SampleTrace> TraceOf(Time sensed_at) const;
  // Events since the last call. Thread-safe.
  Events TakeEvents();
  [[nodiscard]] Words words() const;  // thread-safe

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
