#include "slave/pipeline/awaited_sense.h"

#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "slave/pipeline/offline/offline_report.h"
#include "slave/site/environment/simulated_environment.h"

namespace palpate {
namespace {

constexpr const char* kNothingYet = "no image received yet (FeedPictures)";

}  // namespace

AwaitedSense::AwaitedSense(const Scene& scene, Make make, SenseInfo awaited)
    : inbox_(scene), make_(std::move(make)), awaited_(std::move(awaited)), trouble_(kNothingYet) {}

bool AwaitedSense::Acquire(const std::stop_token& stop) {
  if (Made()) return Made()->Acquire(stop);
  while (inbox_.Wait(stop) && !stop.stop_requested()) {
    if (TryToMake(stop)) return true;
  }
  return false;
}

bool AwaitedSense::TryToMake(const std::stop_token& stop) {
  try {
    auto sense = make_({.pictures = &inbox_});
    if (!sense->Acquire(stop)) return false;
    sense_ = std::move(sense);
    made_ = sense_.get();
    ReportTrouble({});
    return true;
  } catch (const std::exception& error) {
    ReportTrouble(std::string("the received images cannot be used: ") + error.what());
    inbox_.Drop();
    return false;
  }
}

void AwaitedSense::ReportTrouble(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  if (!trouble.empty() && trouble != trouble_) spdlog::warn("{}", trouble);
  trouble_ = trouble;
}

std::unique_ptr<PreparedModel> AwaitedSense::Prepare(const Scene& changed,
                                                     Progress* progress) const {
  if (!Made())
    throw std::logic_error(std::string(kNothingYet) +
                           ": accepted is a change after the first image");
  return Made()->Prepare(changed, progress);
}

std::vector<StageTimes> AwaitedSense::Stages() const {
  return Made() ? Made()->Stages() : std::vector<StageTimes>();
}

std::unique_ptr<OfflineReport> AwaitedSense::OpenOfflineReport(
    const SimulatedEnvironment* environment) {
  return Made() ? Made()->OpenOfflineReport(environment) : nullptr;
}

std::optional<CameraHealth> AwaitedSense::health() const {
  CameraHealth health = inbox_.health();
  const std::lock_guard lock(mutex_);
  if (health.trouble.empty()) health.trouble = trouble_;
  return health;
}

}  // namespace palpate
