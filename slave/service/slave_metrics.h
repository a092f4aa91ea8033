// A slave's health in numbers, for whoever watches it over weeks.
#pragma once

#include "shared/metrics/metric.h"
#include "slave/pipeline/teleop/slave.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

Metrics MetricsOf(const SlaveStatus& status, const AcceptorCounts& connections);

}  // namespace palpate
