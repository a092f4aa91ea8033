// What the slave says beside the force that the hand needs: what its sense's checks measured, how
// sure it is, its health, and its scene in full. Observers' streams and calls, on a channel and
// threads of their own.
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

// As JSON with the field names of proto/palpate/v1, for people. Empty: it cannot be written so.
std::string JsonOf(const google::protobuf::Message& message);

class SlaveStatusPoller {
 public:
  // As JSON with the field names of proto/palpate/v1, for people; empty: not told yet.
  struct Words {
    std::uint64_t version = 0;  // rises with each change
    std::string scene, capabilities, status;
    std::string trouble;  // why it is not told at the moment
  };

  // What was felt, and what the sense's checks measured then, as JSON.
  struct ObservedState {
    SlaveState state;  // sequence 0: none yet
    std::string details = "{}";
    Time received_at{};
  };

  // Asks at once and then every second; states come 30 times a second. Throws
  // std::invalid_argument: target not understood, or not loopback without `insecure`.
  explicit SlaveStatusPoller(const SlaveLink::Options& link);
  ~SlaveStatusPoller();

  [[nodiscard]] ObservedState felt() const;  // the newest; thread-safe
  // Of the sample that was taken then, slave's clock. nullopt: it is not told (yet), or was a
  // second ago and more. Thread-safe.
  [[nodiscard]] std::optional<SampleTrace> TraceOf(Time sensed_at) const;
  // What happened since the last call. Thread-safe.
  Events TakeEvents();
  [[nodiscard]] Words words() const;  // thread-safe

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
