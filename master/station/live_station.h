// Page of a running session: collects data of haptic loop and slave, shows them
// 30 times a second, and executes commands of pages and keys. It receives ticks on the session's
// slow thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "master/device/pointer.h"
#include "master/link/observer.h"
#include "master/link/setup_calls.h"
#include "master/session/session.h"
#include "master/station/moment_json.h"
#include "master/station/server/page_access.h"

namespace palpate {

class LiveStation {
 public:
  struct Options {
    PagePlace at;  // address of the page
    StationHello hello;
    // These pointers must outlive this object.
    Observer* observer = nullptr;  // with `health`
    Pointer* pointer = nullptr;    // null: the page cannot move the tool
    OperatorRequests* requests = nullptr;
  };
  // Data about the link that the page shows, and actions that pages and keys may trigger. Called on
  // threads of the station.
  struct Controls {
    std::function<StateRecord()> state;   // the newest of the slave
    std::function<Events()> take_events;  // of the slave since the last call
    std::function<void()> stop;           // emergency stop; returns at once
    // Resets the emergency stop of this number.
    std::function<std::string(std::uint64_t stops)> reset;  // empty: done, else the reason
    std::function<std::string(const SlaveLink::Mapping&)>
        set_mapping;                                                // empty: done, else the reason
    std::function<std::string(const std::string& kind)> set_model;  // empty: done
    std::function<std::string()> reinitialize_tracking;             // empty: done
    // A call of the set-up with its request in JSON, see SetupCalls. May take a minute.
    std::function<SetupCalls::Answer(const std::string& call, const std::string& json,
                                     const std::stop_token& stop)>
        set_up;
    std::function<void(bool on)> record = {};  // starts or ends recording; empty: not offered
    // State of the recording, for the page; empty: not offered.
    std::function<RecordingMoment()> recording = {};
  };

  // Throws std::runtime_error if the address cannot be used.
  LiveStation(Options options, Controls controls);
  ~LiveStation();

  // Returns the address of the page, see PageServer::address; empty: no page.
  [[nodiscard]] std::string address() const;
  // Called on the session's slow thread.
  void OnTick(const TickRecord& tick);
  void Update(const SessionStatus& status);
  // Adds a sentence to the list of events.
  void Notify(const std::string& notice);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
