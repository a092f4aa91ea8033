// Serves http://HOST:PORT/metrics for Prometheus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "shared/link/loopback.h"

namespace palpate {

// Metrics of a program in the text format of Prometheus.
// Source: Prometheus text-based exposition format 0.0.4.
struct Metric {
  enum class Type : std::uint8_t { kGauge, kCounter };
  struct Sample {
    std::string label;  // made by Label; empty: none
    double value = 0;
  };

  std::string name;  // `palpate_ticks_total`; counters end in `_total`, others in their SI unit
  std::string help;  // one line of text
  Type type = Type::kGauge;
  std::vector<Sample> samples;
};
using Metrics = std::vector<Metric>;

// `name="value"`, with escapes.
std::string Label(std::string_view name, std::string_view value);
// Returns a metric with one number and no label.
Metric Gauge(std::string name, std::string help, double value);
Metric Counter(std::string name, std::string help, double value);

std::string ToText(const Metrics& metrics);

// Memory, processor time, descriptors and threads of this process, with their usual names. Values
// that the system does not provide are omitted.
Metrics MetricsOfThisProcess();

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
