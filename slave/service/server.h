// The gRPC face of a slave: listens, serves, stops.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "slave/pipeline/teleop/slave.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

class Server {
 public:
  // Listens on `address` (HOST:PORT, [V6]:PORT; port 0: any free one). Without `insecure` only
  // loopback addresses are served; reflection is for them alone. `tls`: the folder of our
  // certificate; whoever connects shows one, too, and may do what its role may; empty: plain text.
  // `slave` must outlive the server. Health of the service is that of what is sensed. `on_deaf`:
  // nobody answers at the door any more (empty: the process ends, to be started anew). Throws
  // std::runtime_error: address not understood, not loopback, port in use (no silent sharing).
  Server(Slave& slave, const std::string& address, bool insecure,
         const std::filesystem::path& tls = {}, std::function<void()> on_deaf = {});
  // Stops within a second: streams end with UNAVAILABLE.
  ~Server();

  // HOST:PORT really listened on.
  [[nodiscard]] const std::string& address() const;
  // Of the door, since it was opened. Thread-safe.
  [[nodiscard]] AcceptorCounts connections() const;
  // Begins to end: health says NOT_SERVING, streams end, then returns. Idempotent.
  void Stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
