// Metrics of a slave for long-term monitoring.
#pragma once

#include "shared/metrics/metric.h"
#include "slave/pipeline/teleop/slave.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

Metrics MetricsOf(const SlaveStatus& status, const Acceptor::Counts& connections);

}  // namespace palpate
