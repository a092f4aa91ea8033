#include "slave/simulator/points/press_cache.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <spdlog/spdlog.h>
#include <sys/resource.h>

namespace palpate::simulation {
namespace {

// In press depths; further steps are every fifth of one.
constexpr std::array kFirstDepthSteps{0.05, 0.1};
constexpr double kEvery = 0.2;
constexpr double kLinear = 0.1;       // largest first depth step relative to the thickness
constexpr double kSameRadius = 0.02;  // relative to the raster: radii closer than this are one
constexpr int kElsewhere = 7;         // elements across the tool at positions other than home
constexpr int kNice = 5;              // nice value of the thread that solves in advance

std::vector<double> Depths(const PressCache::Plan& plan) {
  const double first = kLinear * plan.geometry.thickness;
  const double deepest =
      std::min(PressCache::kDeeper * plan.press_depth, PressCache::kDeepest * plan.geometry.radius);
  std::vector<double> depths{first, std::max(deepest, 3 * first)};
  const auto add = [&](double part) {
    const double depth = part * plan.press_depth;
    if (depth > 1.01 * first && depth < 0.99 * depths[1]) depths.push_back(depth);
  };
  for (const double part : kFirstDepthSteps) add(part);
  for (int k = 1; kEvery * k < PressCache::kDeeper; ++k) add(kEvery * k);
  std::ranges::sort(depths);
  return depths;
}

// Returns the raster radii from the centre as far as the tool can go without touching the rim, and
// the radius of home.
std::vector<double> Radii(const PressCache::Plan& plan) {
  const double rim = plan.geometry.radius, raster = PressCache::kRaster * rim;
  const double farthest = std::max(0.0, std::min(PressCache::kMaxPlace * rim, rim - plan.width));
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

bool IsOn(double radius, double line, double rim) {
  return std::abs(radius - line) <= 1e-6 * rim;
}

}  // namespace

PressCache::PressCache(const Plan& plan)
    : plan_(plan),
      depths_(Depths(plan)),
      all_series_(MakeAllSeries()),
      focus_(std::min(plan.home_radius, farthest())),
      solved_([this] { return Next(); }) {}

std::unique_ptr<PressedMembrane> PressCache::Make(double radius) const {
  MembraneResolution resolution = plan_.resolution;
  if (resolution.across == 0 && radius != plan_.home_radius) resolution.across = kElsewhere;
  return std::make_unique<PressedMembrane>(plan_.geometry, plan_.material, plan_.width,
                                           Eigen::Vector2d(radius, 0), resolution, plan_.prestress,
                                           plan_.face);
}

std::vector<std::shared_ptr<PressCache::DepthSeries>> PressCache::MakeAllSeries() const {
  std::vector<std::shared_ptr<DepthSeries>> all_series;
  for (const double radius : Radii(plan_)) {
    all_series.push_back(std::make_shared<DepthSeries>(*this, radius));
    if (radius == plan_.home_radius) all_series.back()->membrane = Make(radius);
  }
  return all_series;
}

PressCache::Around PressCache::FindAround(double radius) const {
  const auto above = std::ranges::lower_bound(all_series_, radius, {},
                                              [](const auto& series) { return series->radius; });
  const std::size_t last = all_series_.size() - 1;
  const auto index = std::min(static_cast<std::size_t>(above - all_series_.begin()), last);
  const double rim = plan_.geometry.radius;
  if (IsOn(radius, all_series_[index]->radius, rim) || index == 0) return {index, index};
  if (IsOn(radius, all_series_[index - 1]->radius, rim)) return {index - 1, index - 1};
  return {index - 1, index};
}

void PressCache::Expect(double radius) {
  if (radius != focus_) solved_.Change([&] { focus_ = radius; });
}

void PressCache::SolveEverywhere() {
  solved_.Change([&] { everywhere_ = true; });
}

PressCache::Presses PressCache::Between(const DepthSeries& below, const DepthSeries& above,
                                        double radius) {
  const double way = above.radius - below.radius;
  const double part = way > 0 ? std::clamp((radius - below.radius) / way, 0.0, 1.0) : 0;
  return {{Indentation::Part{below.press, below.radius, 1 - part},
           Indentation::Part{above.press, above.radius, part}}};
}

PressCache::Presses PressCache::Await(double radius, double depth) {
  Expect(radius);
  const Around around = FindAround(radius);
  const DepthSeries &below = *all_series_[around.below], &above = *all_series_[around.above];
  return solved_.Await([&] { return below.Reaches(depth) && above.Reaches(depth); },
                       [&] { return Between(below, above, radius); });
}

PressCache::Presses PressCache::Find(double radius, double depth) {
  Expect(radius);
  const Around around = FindAround(radius);
  DepthSeries &below = *all_series_[around.below], &above = *all_series_[around.above];
  return solved_.Now([&] {
    if (below.Reaches(depth) && above.Reaches(depth)) return Between(below, above, radius);
    for (DepthSeries* series : {&below, &above}) {
      if (!series->Reaches(depth)) series->missed = true;
    }
    return Nearest(around, radius, depth);
  });
}

PressCache::Presses PressCache::Nearest(const Around& around, double radius, double depth) const {
  const DepthSeries *below = nullptr, *above = nullptr, *deepest = all_series_.front().get();
  for (std::size_t k = 0; k < all_series_.size(); ++k) {
    const DepthSeries& series = *all_series_[k];
    if (series.depth() > deepest->depth()) deepest = &series;
    if (!series.Reaches(depth)) continue;
    if (k <= around.below) below = &series;
    if (k >= around.above && !above) above = &series;
  }
  if (!below) below = above ? above : deepest;
  if (!above) above = below;
  Presses presses = Between(*below, *above, radius);
  presses.solved = false;
  return presses;
}

// Returns the next series to extend: the two around the tool, the less deep one first; then, if
// requested, the others outwards from there.
std::shared_ptr<PressCache::DepthSeries> PressCache::Next() {
  // The argument 0 is the calling thread (setpriority(2), Linux).
  if (everywhere_ && !is_nice_) is_nice_ = setpriority(PRIO_PROCESS, 0, kNice) == 0;
  const Around around = FindAround(focus_);
  std::shared_ptr<DepthSeries> next;
  std::pair<bool, double> first;
  for (std::size_t k = 0; k < all_series_.size(); ++k) {
    const DepthSeries& series = *all_series_[k];
    const bool is_around = k == around.below || k == around.above;
    if (series.complete || !(is_around || everywhere_)) continue;
    const std::pair rank(!is_around, is_around ? series.depth() : std::abs(series.radius - focus_));
    if (next && rank >= first) continue;
    next = all_series_[k];
    first = rank;
  }
  return next;
}

// Returns whether two depth steps beyond `depth` are solved: ForceAt uses them, and answers must
// not depend on the progress of the thread.
bool PressCache::DepthSeries::Reaches(double depth) const {
  return complete || (press->depth_steps.size() > 3 &&
                      press->depth_steps[press->depth_steps.size() - 3]->depth >= depth);
}

// Returns the press with one more depth step, or the same one if the membrane cannot be pressed
// deeper.
PressCache::Press PressCache::DepthSeries::Solve() noexcept {
  try {
    if (missed && !announced) {
      spdlog::info(
          "the simulator computes a contact {:.3g} mm from the membrane's axis; until it is done, "
          "its images there are approximate and the true force is absent",
          1e3 * radius);
      announced = true;
    }
    if (!membrane) membrane = of.Make(radius);
    const auto next = std::ranges::upper_bound(of.depths_, depth() * (1 + 1e-9));
    if (next == of.depths_.end()) return press;
    membrane->Deepen(*next);
    return std::make_shared<const MembranePress>(membrane->press());
  } catch (const std::exception&) {
    return press;
  }
}

void PressCache::DepthSeries::Add(Press deeper) {
  const double before = depth();
  press = std::move(deeper);
  complete = depth() <= before || depth() >= of.depths_.back() * (1 - 1e-9);
  if (complete) membrane.reset();
}

}  // namespace palpate::simulation
