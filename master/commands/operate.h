// `palpate-master connect`: operates a slave.
#pragma once

#include <memory>
#include <optional>

#include "master/commands/arguments.h"
#include "master/commands/connect_recorder.h"
#include "master/device/device.h"
#include "master/link/slave_link.h"
#include "master/metrics/session_metrics.h"
#include "shared/metrics/metrics_page.h"

namespace palpate {

// The link and the slots that must outlive it.
struct Line {
  explicit Line(const SlaveLink::Options& options) : link(options) {}
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  LatestValue<ReceivedPatch> patches;
  SlaveLink link;
};

// The values of `--metrics` and their page, which exists before the session.
struct Health {
  SessionMetrics seen;
  std::optional<MetricsPage> page;
};

// Runs the session until its end. Null `device`: one for the scene; null `recorder`: no recording.
// The exit code; throws std::runtime_error where the slave cannot be reached.
int Operate(const Arguments& a, Line* line, std::unique_ptr<Device> device,
            ConnectRecorder* recorder, Health* health);

}  // namespace palpate
