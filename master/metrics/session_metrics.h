// Metrics of a session for Prometheus.
#pragma once

#include <mutex>

#include "master/session/session.h"
#include "shared/metrics/metrics_page.h"

namespace palpate {

Metrics MetricsOf(const SessionStatus& status);

// Passes the status from the session's slow thread to the metrics page.
class SessionMetrics {
 public:
  void Update(const SessionStatus& status) {
    const std::scoped_lock lock(mutex_);
    newest_ = status;
  }
  [[nodiscard]] Metrics Collect() const {
    const std::scoped_lock lock(mutex_);
    return MetricsOf(newest_);
  }

 private:
  mutable std::mutex mutex_;  // guards the next one
  SessionStatus newest_;
};

}  // namespace palpate
