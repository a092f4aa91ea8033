// Metrics of a slave for long-term monitoring.
#pragma once

#include "shared/metrics/metrics_page.h"
#include "slave/live/slave.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

Metrics MetricsOf(const SlaveStatus& status, const Acceptor::Counts& connections);

}  // namespace palpate
