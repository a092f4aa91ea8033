#include "slave/service/slave_metrics.h"

#include <utility>

#include "palpate/v1/state.pb.h"

#include "shared/wire/enum_names.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

// Adds one metric per value of an enumeration: 1 for the present value, 0 for the others.
Metric OneOf(std::string name, std::string help, const char* label,
             const google::protobuf::EnumDescriptor& kinds, int is) {
  Metric metric{std::move(name), std::move(help), Metric::Type::kGauge, {}};
  for (int i = 1; i < kinds.value_count(); ++i) {  // 0: unspecified
    const auto& value = *kinds.value(i);
    metric.samples.push_back({Label(label, ProtoNameOf(value)), value.number() == is ? 1.0 : 0.0});
  }
  return metric;
}

Metric StagesOf(const SlaveStatus& status) {
  constexpr double kMicro = 1e-6;
  Metric metric{"palpate_slave_stage_seconds",
                "Time of each stage from a sample to its force.",
                Metric::Type::kGauge,
                {}};
  for (const StageTimes& stage : status.stages) {
    const std::string label = Label("stage", stage.stage) + ",";
    metric.samples.push_back({label + Label("quantile", "0.5"), kMicro * stage.p50_us});
    metric.samples.push_back({label + Label("quantile", "0.99"), kMicro * stage.p99_us});
  }
  return metric;
}

Metric TurnedAwayOf(const Acceptor::Counts& connections) {
  Metric metric{"palpate_slave_connections_turned_away_total",
                "Connections that were closed by the slave.",
                Metric::Type::kCounter,
                {}};
  for (std::size_t i = 0; i < kTurnedAwayNames.size(); ++i) {
    metric.samples.push_back(
        {Label("why", kTurnedAwayNames[i]), static_cast<double>(connections.turned_away[i])});
  }
  return metric;
}

}  // namespace

Metrics MetricsOf(const SlaveStatus& status, const Acceptor::Counts& connections) {
  const auto number = [](std::uint64_t count) { return static_cast<double>(count); };
  return {
      OneOf("palpate_slave_phase", "State of the operator connection.", "phase",
            *v1::Phase_descriptor(), ToProto(status.phase)),
      OneOf("palpate_slave_validity", "Validity of the newest state.", "validity",
            *v1::Validity_descriptor(), ToProto(status.validity)),
      Counter("palpate_slave_samples_total", "Samples processed.", number(status.frames)),
      Gauge("palpate_slave_sample_rate_hertz", "Samples per second over the last second.",
            status.frame_rate),
      Counter("palpate_slave_commands_total", "Commands accepted.", number(status.commands)),
      Counter("palpate_slave_commands_refused_total", "Commands rejected.",
              number(status.commands_refused)),
      Gauge("palpate_slave_alarms", "Number of alarms that GetStatus reports.",
            static_cast<double>(status.alarms.size())),
      StagesOf(status),
      Gauge("palpate_slave_connections", "Connections that are open now.",
            number(connections.open)),
      Counter("palpate_slave_connections_total", "Connections accepted.",
              number(connections.accepted)),
      TurnedAwayOf(connections),
  };
}

}  // namespace palpate
