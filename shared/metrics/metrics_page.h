// http://HOST:PORT/metrics for Prometheus and its kin.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "shared/link/loopback.h"
#include "shared/metrics/metric.h"

namespace palpate {

// Where to answer, of `--metrics HOST:PORT`. Throws std::invalid_argument: not understood, or
// beyond loopback without `insecure`.
Endpoint MetricsEndpoint(const std::string& address, bool insecure);

class MetricsPage {
 public:
  // Answers on `address` (HOST:PORT; port 0: any free one) until it is destroyed, in a thread of
  // its own where `collect` is called: 16 who ask at once, each for a second, the eldest gives way,
  // so that nobody makes it grow or keeps others from it. In plain text and for whoever asks:
  // beyond loopback only if `insecure`. Boost.Beast, as for the station's page. Throws
  // std::runtime_error: not understood, not permitted, cannot be listened on.
  MetricsPage(const std::string& address, bool insecure, std::function<Metrics()> collect);
  ~MetricsPage();

  // That is really listened on.
  [[nodiscard]] const Endpoint& endpoint() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
