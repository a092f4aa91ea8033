#include "master/metrics/session_metrics.h"

#include <string>

namespace palpate {
namespace {

constexpr double kMicro = 1e-6;

Metric StateOf(const SessionStatus& status) {
  Metric metric{"palpate_master_state", "State of the operator.", Metric::Type::kGauge, {}};
  for (std::size_t i = 0; i < kOperatorStateCount; ++i) {
    const auto state = static_cast<OperatorState>(i);
    metric.samples.push_back(
        {Label("state", ToString(state)), state == status.tick.state ? 1.0 : 0.0});
  }
  return metric;
}

Metric RoundTripOf(const LinkStats& link) {
  return {"palpate_master_round_trip_seconds",
          "Round-trip time of commands since the start.",
          Metric::Type::kGauge,
          {{Label("quantile", "0.5"), kMicro * link.rtt_p50_us},
           {Label("quantile", "0.99"), kMicro * link.rtt_p99_us}}};
}

}  // namespace

Metrics MetricsOf(const SessionStatus& status) {
  const LinkStats& link = status.link;
  const auto number = [](std::uint64_t count) { return static_cast<double>(count); };
  return {
      StateOf(status),
      Gauge("palpate_master_tick_rate_hertz", "Recent rate of the haptic loop.", status.rate),
      Gauge("palpate_master_force_newtons", "Force on the device.", status.tick.chain.sent.norm()),
      Gauge("palpate_master_force_limit_newtons", "Force limit on the device.", status.force_limit),
      Gauge("palpate_master_state_age_seconds", "Age of the newest state.", status.tick.state_age),
      Gauge("palpate_master_connected", "1 while states are received.", link.connected ? 1 : 0),
      RoundTripOf(link),
      Gauge("palpate_master_clock_offset_seconds", "Clock of the slave minus clock of the master.",
            link.clock_offset),
      Counter("palpate_master_states_total", "States received.", number(link.states)),
      Counter("palpate_master_states_by_datagram_total", "States received first by datagram.",
              number(link.states_by_datagram)),
      Counter("palpate_master_states_refused_total", "States rejected as invalid.",
              number(link.refused)),
      Counter("palpate_master_commands_total", "Commands sent.", number(link.commands)),
      Counter("palpate_master_reconnects_total", "Streams opened after the first.",
              number(link.reconnects)),
  };
}

}  // namespace palpate
