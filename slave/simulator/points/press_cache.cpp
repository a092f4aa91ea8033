#include "slave/simulator/points/press_cache.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <tuple>
#include <utility>

#include <spdlog/spdlog.h>
#include <sys/resource.h>

namespace palpate::site {
namespace {

constexpr std::array kFirstRungs{0.05, 0.1};  // in press depths, beside every fifth
constexpr double kEvery = 0.2;
constexpr double kLinear = 0.1;       // of the thickness: so far the first rung may be
constexpr double kSameRadius = 0.02;  // of the raster: radii nearer than this are one
constexpr double kAhead = 1.5;        // rasters around the tool in which presses are solved
constexpr int kElsewhere = 7;         // elements across, where the tool is not at home
constexpr int kNice = 5;              // of the thread that solves what nobody asked for yet

std::vector<double> Depths(const PressCache::Plan& plan) {
  const double first = kLinear * plan.geometry.thickness;
  const double deepest =
      std::min(PressCache::kDeeper * plan.press_depth, PressCache::kDeepest * plan.geometry.radius);
  std::vector<double> depths{first, std::max(deepest, 3 * first)};
  const auto add = [&](double part) {
    const double depth = part * plan.press_depth;
    if (depth > 1.01 * first && depth < 0.99 * depths[1]) depths.push_back(depth);
  };
  for (const double part : kFirstRungs) add(part);
  for (int k = 1; kEvery * k < PressCache::kDeeper; ++k) add(kEvery * k);
  std::ranges::sort(depths);
  return depths;
}

// Every raster from the centre on as far as the tool keeps away from the rim, and home.
std::vector<double> Radii(const PressCache::Plan& plan) {
  const double rim = plan.geometry.radius, raster = PressCache::kRaster * rim;
  const double farthest = std::max(0.0, std::min(PressCache::kFarthest * rim, rim - plan.width));
  std::vector<double> radii{0};
  for (int k = 1; k * raster < farthest - kSameRadius * raster; ++k) radii.push_back(k * raster);
  if (farthest > 0) radii.push_back(farthest);
  if (!(plan.home_radius < farthest)) return radii;
  std::erase_if(radii, [&](double radius) {
    return std::abs(radius - plan.home_radius) < kSameRadius * raster && radius < farthest;
  });
  radii.push_back(plan.home_radius);
  std::ranges::sort(radii);
  return radii;
}

double DepthOf(const MembranePress& press) {
  return press.rungs.empty() ? 0 : press.rungs.back()->depth;
}

bool IsOn(double radius, double line, double rim) {
  return std::abs(radius - line) <= 1e-6 * rim;
}

}  // namespace

PressCache::PressCache(const Plan& plan) : plan_(plan), depths_(Depths(plan)) {
  for (const double radius : Radii(plan)) {
    auto& ladder = ladders_.emplace_back(std::make_unique<Ladder>());
    ladder->radius = radius;
    ladder->press = std::make_shared<MembranePress>();
  }
  focus_ = std::min(plan.home_radius, farthest());
  Ladder& first = *Next();
  first.membrane = Make(first.radius);
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

PressCache::~PressCache() = default;

std::unique_ptr<PressedMembrane> PressCache::Make(double radius) const {
  MembraneResolution resolution = plan_.resolution;
  if (resolution.across == 0 && radius != plan_.home_radius) resolution.across = kElsewhere;
  return std::make_unique<PressedMembrane>(plan_.geometry, plan_.material, plan_.width,
                                           Eigen::Vector2d(radius, 0), resolution, plan_.prestress);
}

PressCache::Around PressCache::FindAround(double radius) const {
  const auto above = std::ranges::lower_bound(ladders_, radius, {},
                                              [](const auto& ladder) { return ladder->radius; });
  const std::size_t last = ladders_.size() - 1;
  const auto index = std::min(static_cast<std::size_t>(above - ladders_.begin()), last);
  const double rim = plan_.geometry.radius;
  if (IsOn(radius, ladders_[index]->radius, rim) || index == 0) return {index, index};
  if (IsOn(radius, ladders_[index - 1]->radius, rim)) return {index - 1, index - 1};
  return {index - 1, index};
}

void PressCache::Expect(double radius) {
  const std::lock_guard lock(mutex_);
  if (radius == focus_) return;
  focus_ = radius;
  changed_.notify_all();
}

// Two rungs lie beyond the one above `depth`: ForceAt uses them, and answers must not depend on how
// far the thread has come.
bool PressCache::Reaches(const Ladder& ladder, double depth) const {
  const auto& rungs = ladder.press->rungs;
  return ladder.complete || (rungs.size() > 3 && rungs[rungs.size() - 3]->depth >= depth);
}

void PressCache::SolveEverywhere() {
  const std::lock_guard lock(mutex_);
  everywhere_ = true;
  changed_.notify_all();
}

bool PressCache::is_solved_everywhere() const {
  const std::lock_guard lock(mutex_);
  return std::ranges::all_of(ladders_, [](const auto& ladder) { return ladder->complete; });
}

PressCache::Presses PressCache::Between(const Ladder& below, const Ladder& above,
                                        double radius) const {
  const double way = above.radius - below.radius;
  const double part = way > 0 ? std::clamp((radius - below.radius) / way, 0.0, 1.0) : 0;
  return {{Dent::Part{below.press, below.radius, 1 - part},
           Dent::Part{above.press, above.radius, part}}};
}

PressCache::Presses PressCache::Await(double radius, double depth) {
  Expect(radius);
  const Around around = FindAround(radius);
  const Ladder &below = *ladders_[around.below], &above = *ladders_[around.above];
  const auto is_solved = [&] { return Reaches(below, depth) && Reaches(above, depth); };
  std::unique_lock lock(mutex_);
  if (!is_solved()) ++waits_;
  changed_.wait(lock, is_solved);
  return Between(below, above, radius);
}

PressCache::Presses PressCache::Find(double radius, double depth) {
  Expect(radius);
  const Around around = FindAround(radius);
  Ladder &below = *ladders_[around.below], &above = *ladders_[around.above];
  const std::lock_guard lock(mutex_);
  bool is_solved = true;
  for (Ladder* ladder : {&below, &above}) {
    if (Reaches(*ladder, depth)) continue;
    ladder->missed = true;
    is_solved = false;
  }
  return is_solved ? Between(below, above, radius) : Nearest(around, radius, depth);
}

PressCache::Presses PressCache::Nearest(const Around& around, double radius, double depth) const {
  const Ladder *below = nullptr, *above = nullptr, *deepest = ladders_.front().get();
  for (std::size_t k = 0; k < ladders_.size(); ++k) {
    const Ladder& ladder = *ladders_[k];
    if (DepthOf(*ladder.press) > DepthOf(*deepest->press)) deepest = &ladder;
    if (!Reaches(ladder, depth)) continue;
    if (k <= around.below) below = &ladder;
    if (k >= around.above && !above) above = &ladder;
  }
  if (!below) below = above ? above : deepest;
  if (!above) above = below;
  Presses presses = Between(*below, *above, radius);
  presses.solved = false;
  return presses;
}

// The two around the tool, the less deep one first; then the others near it; then, if asked for,
// all others. None but the one under the tool if it is exactly over it.
PressCache::Ladder* PressCache::Next() const {
  const Around around = FindAround(focus_);
  const bool is_on_one = around.below == around.above;
  const double reach = is_on_one ? 0 : kAhead * kRaster * plan_.geometry.radius;
  Ladder* next = nullptr;
  std::tuple<bool, bool, double> first;
  for (std::size_t k = 0; k < ladders_.size(); ++k) {
    Ladder& ladder = *ladders_[k];
    const double distance = std::abs(ladder.radius - focus_);
    const bool is_around = k == around.below || k == around.above;
    const bool is_near = is_around || distance <= reach;
    if (ladder.complete || !(is_near || everywhere_)) continue;
    const std::tuple rank(!is_around, !is_near,
                          is_around ? DepthOf(*ladder.press)
                          : is_near ? distance
                                    : std::abs(ladder.radius - plan_.home_radius));
    if (next && rank >= first) continue;
    next = &ladder;
    first = rank;
  }
  return next;
}

// The press with one rung more; the same one: the membrane takes no deeper press.
std::shared_ptr<const MembranePress> PressCache::Grow(Ladder* ladder) const noexcept {
  try {
    if (!ladder->membrane) ladder->membrane = Make(ladder->radius);
    const double reached = DepthOf(*ladder->press);
    const auto next = std::ranges::upper_bound(depths_, reached * (1 + 1e-9));
    if (next == depths_.end()) return ladder->press;
    ladder->membrane->Deepen(*next);
    return std::make_shared<const MembranePress>(ladder->membrane->press());
  } catch (const std::exception&) {
    return ladder->press;
  }
}

void PressCache::Announce(const Ladder& ladder) {
  spdlog::info(
      "the simulator computes a contact {:.3g} mm from the membrane's axis; until it is done, its "
      "images there are approximate and the true force is absent",
      1e3 * ladder.radius);
}

void PressCache::Run(const std::stop_token& stop) {
  bool is_nice = false;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return Next() != nullptr; })) {
    if (stop.stop_requested()) return;
    // 0: the calling thread (setpriority(2), Linux).
    if (everywhere_ && !is_nice) is_nice = setpriority(PRIO_PROCESS, 0, kNice) == 0;
    Ladder* const ladder = Next();
    const bool announces = ladder->missed && !ladder->announced;
    lock.unlock();  // before the log, which may wait for a terminal
    if (announces) {
      Announce(*ladder);
      ladder->announced = true;
    }
    auto press = Grow(ladder);
    lock.lock();
    const bool deeper = DepthOf(*press) > DepthOf(*ladder->press);
    ladder->complete = !deeper || DepthOf(*press) >= depths_.back() * (1 - 1e-9);
    ladder->press = std::move(press);
    if (ladder->complete) ladder->membrane.reset();
    changed_.notify_all();
  }
}

}  // namespace palpate::site
