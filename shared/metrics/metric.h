// Metrics of a program in the text format of Prometheus.
// Source: Prometheus text-based exposition format 0.0.4.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

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
// One number without a label.
Metric Gauge(std::string name, std::string help, double value);
Metric Counter(std::string name, std::string help, double value);

std::string ToText(const Metrics& metrics);

// Memory, processor time, descriptors and threads of this process, with their usual names. Values
// that the system does not provide are omitted.
Metrics MetricsOfThisProcess();

}  // namespace palpate
