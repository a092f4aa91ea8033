// The page of a session that runs, and its terminal: gathers what haptic loop and slave tell, shows
// it 30 times a second, and carries out what pages and keys ask for. Reads the haptic loop's ticks
// behind its ring, on the session's slow thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "master/device/pointer.h"
#include "master/haptics/session.h"
#include "master/link/slave_link.h"
#include "master/station/moment_json.h"
#include "master/station/server/page_access.h"

namespace palpate {

class LiveStation {
 public:
  struct Options {
    std::optional<PagePlace> at;  // where a page is served; nothing: none is
    SlaveLink::Options line;      // to the slave
    StationHello hello;
    Pointer* pointer = nullptr;            // outlives the station; null: the page moves no hand
    OperatorRequests* requests = nullptr;  // outlives the station
    bool terminal = false;                 // shows it on the standard output, too
  };
  // What pages may do to the session; called by threads of the station's.
  struct Controls {
    std::function<void()> stop;   // the emergency stop; returns at once
    std::function<bool()> reset;  // true: it was done
    std::function<std::string(const SlaveLink::Mapping&)> set_mapping;  // empty: it was done
    std::function<std::string(const std::string& kind)> set_model;      // likewise
    std::function<std::string()> reinitialize_tracking;                 // likewise
    // The doctor's; takes seconds, or until it is stopped.
    std::function<Findings(const std::stop_token&)> examine;
    std::function<void(bool on)> record = {};         // empty: nothing can be recorded
    std::function<void()> quit = {};                  // by the terminal's key
    std::function<RecordingMoment()> recording = {};  // likewise
  };

  // Throws std::runtime_error: it cannot be listened at `at`.
  LiveStation(Options options, Controls controls);
  ~LiveStation();

  // As PageServer::address; empty: no page is served.
  [[nodiscard]] std::string address() const;
  // From the session's slow thread.
  void OnTick(const TickRecord& tick);
  void Update(const Status& status);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
