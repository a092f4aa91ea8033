#include "slave/precompute/precompute.h"

namespace palpate {

void ReportTogether(const Ranks& ranks, Progress* progress, std::string_view stage, double done) {
  if (ranks.Any(progress != nullptr && !progress->Report(stage, done))) throw Interrupted();
}

}  // namespace palpate
