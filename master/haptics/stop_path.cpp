#include "master/haptics/stop_path.h"

#include <chrono>
#include <cstdint>
#include <utility>

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kGlance(5), kAgain(100), kLastChance(1000);

void Watch(const std::stop_token& stop, StopRequests& stops, const std::function<bool()>& asked) {
  while (!stop.stop_requested()) {
    if (asked()) stops.Request();
    std::this_thread::sleep_for(kGlance);
  }
}

void Call(const std::stop_token& stop, StopRequests& stops,
          const std::function<std::uint64_t()>& call) {
  std::uint32_t called = 0;
  while (!stop.stop_requested()) {
    const std::uint32_t asked = stops.asked();
    const bool is_wanted = asked != called && stops.is_wanted();
    const std::uint64_t number = is_wanted ? call() : 0;
    if (number != 0) stops.Act(called = asked, number);
    std::this_thread::sleep_for(is_wanted && number == 0 ? kAgain : kGlance);
  }
}

}  // namespace

StopPath::StopPath(StopRequests& stops, Ways ways)
    : stops_(stops), give_up_(std::move(ways.give_up)) {
  if (ways.asked) {
    watching_ = std::jthread([&stops, asked = std::move(ways.asked)](const std::stop_token& stop) {
      Watch(stop, stops, asked);
    });
  }
  if (!ways.call) return;
  calls_ = true;
  calling_ = std::jthread([this, call = std::move(ways.call)](const std::stop_token& stop) {
    Call(stop, stops_, call);
    calls_ = false;
  });
}

StopPath::~StopPath() {
  for (auto left = kLastChance; calls_ && stops_.is_wanted() && left.count() > 0; left -= kGlance) {
    std::this_thread::sleep_for(kGlance);
  }
  calling_.request_stop();
  while (calls_) {
    if (give_up_) give_up_();
    std::this_thread::sleep_for(kGlance);
  }
}

}  // namespace palpate
