#include "slave/simulator/camera/solutions_ahead.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>

#include "slave/reference/planar/round_touch.h"

namespace palpate::site {
namespace {

// Places closer than this part of the larger side share a solution (0.02 mm on the 88 mm block):
// there the stiffness changes by less than 1e-4.
constexpr double kRaster = 0.02 / 88;
constexpr std::size_t kKept = 8;

}  // namespace

SolutionsAhead::SolutionsAhead(const TrueBody& body, double poisson_ratio, Plane plane,
                               double width, double radius)
    : body_(body),
      poisson_ratio_(poisson_ratio),
      plane_(plane),
      width_(width),
      radius_(radius),
      raster_(kRaster * body.larger_side()),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

SolutionsAhead::~SolutionsAhead() = default;

SolutionsAhead::Key SolutionsAhead::KeyOf(const BoundaryPlace& place) const {
  return {place.loop, std::lround(place.s / raster_)};
}

const SolutionsAhead::Entry* SolutionsAhead::Find(const Key& key) const {
  const auto it =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  return it == entries_.end() ? nullptr : &*it;
}

void SolutionsAhead::Expect(const BoundaryPlace& place) {
  const Key key = KeyOf(place);
  {
    const std::lock_guard lock(mutex_);
    if (Find(key) != nullptr || wanted_ == key) return;
    wanted_ = key;
  }
  changed_.notify_all();
}

std::shared_ptr<const PatchSolution> SolutionsAhead::Await(const BoundaryPlace& place) {
  const Key key = KeyOf(place);
  std::unique_lock lock(mutex_);
  for (;;) {
    if (const Entry* entry = Find(key)) return entry->solution;
    wanted_ = key;
    changed_.notify_all();
    changed_.wait(lock);
  }
}

std::shared_ptr<const PatchSolution> SolutionsAhead::Solve(const Key& key) const noexcept {
  try {
    const auto place = body_.PlaceAt(key.first, static_cast<double>(key.second) * raster_);
    return std::make_shared<PatchSolution>(
        radius_ > 0 ? SolveUnderRound(body_, poisson_ratio_, plane_, place, {width_, radius_})
                    : SolvePatch(body_, poisson_ratio_, plane_, place, width_));
  } catch (const std::exception&) {
    return nullptr;  // kept as such, so that nobody waits for it again
  }
}

void SolutionsAhead::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wanted_.has_value(); })) {
    if (stop.stop_requested()) return;
    const Key key = *wanted_;
    if (Find(key) == nullptr) {
      lock.unlock();
      auto solution = Solve(key);
      lock.lock();
      entries_.push_front({key, std::move(solution)});
      if (entries_.size() > kKept) entries_.pop_back();
    }
    if (wanted_ == key) wanted_.reset();
    changed_.notify_all();
  }
}

}  // namespace palpate::site
