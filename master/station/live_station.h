// The page of a session that runs: gathers what haptic loop and slave tell, puts it on the board 30
// times a second, and carries out what pages ask for. Reads the haptic loop's ticks behind its
// ring, on the session's slow thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "master/device/pointer.h"
#include "master/haptics/session.h"
#include "master/link/slave_link.h"
#include "master/station/moment_json.h"
#include "shared/link/loopback.h"

namespace palpate {

class LiveStation {
 public:
  struct Options {
    Endpoint at;              // where it is served; port 0: a free one
    SlaveLink::Options line;  // to the slave
    StationHello hello;
    Pointer* pointer = nullptr;  // outlives the station; null: the page moves no hand
  };
  // What pages may do to the session; called by threads of the station's.
  struct Controls {
    std::function<void()> stop;   // the emergency stop; returns at once
    std::function<bool()> reset;  // true: it was done
    std::function<std::string(const SlaveLink::Mapping&)> set_mapping;  // empty: it was done
    std::function<std::string(const std::string& kind)> set_model;      // likewise
  };

  // Throws std::runtime_error: it cannot be listened at `at`.
  LiveStation(Options options, Controls controls);
  ~LiveStation();

  // `http://HOST:PORT/`
  [[nodiscard]] std::string address() const;
  // From the session's slow thread.
  void SeeTick(const TickRecord& tick);
  void See(const Status& status);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// HOST:PORT of --view; empty: 127.0.0.1 and a free port. Throws std::invalid_argument: not
// understood, or beyond this machine.
Endpoint ViewEndpoint(const std::string& text);

}  // namespace palpate
