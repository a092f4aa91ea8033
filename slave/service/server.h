// The gRPC server of a slave.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "shared/nats/nats_connection.h"
#include "slave/live/slave.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

class Server {
 public:
  // Listens on `address` (HOST:PORT, [V6]:PORT; port 0: any free one). Without `insecure` only
  // loopback addresses are served, and only they offer reflection. `tls`: folder of our
  // certificate; clients must present one and get its role; empty: plain text. `slave` must outlive
  // the server. The health service reports the sensing. Throws std::runtime_error: malformed
  // address, not loopback, port in use (no silent sharing).
  Server(Slave& slave, const std::string& address, bool insecure,
         const std::filesystem::path& tls = {});
  // Stops within a second: streams end with UNAVAILABLE.
  ~Server();

  // Publishes everything on a NATS server too, from now on until the stop. Called once. Throws
  // std::invalid_argument: unusable certificates.
  void PublishOn(const NatsServer& nats);
  // The HOST:PORT on which the server listens.
  [[nodiscard]] const std::string& address() const;
  // Shuts down: health reports NOT_SERVING and streams end before it returns. Calls have the time
  // `grace` to end by themselves. Idempotent.
  void Stop(std::chrono::milliseconds grace = std::chrono::milliseconds(300));

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
