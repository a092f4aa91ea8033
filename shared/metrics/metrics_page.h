// Serves http://HOST:PORT/metrics for Prometheus.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "shared/link/loopback.h"
#include "shared/metrics/metric.h"

namespace palpate {

// The endpoint of `--metrics HOST:PORT`. Throws std::invalid_argument if it is invalid, or beyond
// loopback without `insecure`.
Endpoint MetricsEndpoint(const std::string& address, bool insecure);

class MetricsPage {
 public:
  // Answers on `address` (HOST:PORT; port 0: a free one) until destruction, on a separate thread
  // that calls `collect`. Up to 16 connections of one second each are open, and a new one replaces
  // the oldest. Answers are plain text for anyone, beyond loopback only if `insecure`. Throws
  // std::runtime_error if the address is invalid, not permitted or in use.
  MetricsPage(const std::string& address, bool insecure, std::function<Metrics()> collect);
  ~MetricsPage();

  // The actual endpoint.
  [[nodiscard]] const Endpoint& endpoint() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
