#include "slave/simulator/fingertips/load_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>

namespace palpate::simulation {
namespace {

using Eigen::Vector3d;

// Returns the slope at the central one of three points, zero at an extremum (Fritsch and Carlson's
// harmonic mean, which keeps the cubic monotone).
double MonotoneSlope(double before, double h_before, double after, double h_after) {
  if (!(before * after > 0)) return 0;
  const double w1 = 2 * h_after + h_before, w2 = h_after + 2 * h_before;
  return (w1 + w2) / (w1 / before + w2 / after);
}

struct Bracket {
  std::size_t below = 0;  // depth steps below and below + 1
  double part = 0;        // position between them, 0 to 1
};

Bracket Around(const DepthSteps& depth_steps, double s) {
  const auto above = std::ranges::upper_bound(
      depth_steps, s, {},
      [](const std::shared_ptr<const LoadStep>& depth_step) { return depth_step->s; });
  const auto index = static_cast<std::size_t>(above - depth_steps.begin());
  const std::size_t below = std::clamp<std::size_t>(index, 1, depth_steps.size() - 1) - 1;
  return {below, (s - depth_steps[below]->s) / (depth_steps[below + 1]->s - depth_steps[below]->s)};
}

const FingerTouch& At(const DepthSteps& depth_steps, std::size_t depth_step, int finger) {
  return depth_steps[depth_step]->touches[static_cast<std::size_t>(finger)];
}

// One component of the force over the depth steps.
class ForceCurve {
 public:
  ForceCurve(const DepthSteps& depth_steps, int finger, int component)
      : depth_steps_(depth_steps), finger_(finger), component_(component) {}

  [[nodiscard]] double Value(const Bracket& at) const {
    const double f0 = F(at.below), f1 = F(at.below + 1), h = Step(at.below);
    if (at.part > 1) return f1 + (at.part - 1) * (f1 - f0);  // beyond the last depth step
    const double t = at.part, u = 1 - t;
    return u * u * ((1 + 2 * t) * f0 + t * h * Slope(at.below)) +
           t * t * ((1 + 2 * u) * f1 - u * h * Slope(at.below + 1));
  }

 private:
  [[nodiscard]] double F(std::size_t i) const {
    return At(depth_steps_, i, finger_).force_O[component_];
  }
  [[nodiscard]] double Step(std::size_t i) const {
    return depth_steps_[i + 1]->s - depth_steps_[i]->s;
  }
  [[nodiscard]] double Chord(std::size_t i) const { return (F(i + 1) - F(i)) / Step(i); }
  [[nodiscard]] double Slope(std::size_t i) const {
    if (i == 0) return 0;  // the stiffness at the first contact is zero
    if (i + 1 == depth_steps_.size()) return Chord(i - 1);
    return MonotoneSlope(Chord(i - 1), Step(i - 1), Chord(i), Step(i));
  }

  const DepthSteps& depth_steps_;
  int finger_, component_;
};

constexpr std::size_t kMaxKept = 8;  // series
// Depth steps beyond the first touch, in finger radii: at first they are close, because the force
// grows as depth^1.5; then one every kEvery.
constexpr std::array kFirstDepthSteps{0.02, 0.05, 0.09, 0.14, 0.20, 0.28, 0.38, 0.50};
constexpr double kEvery = 0.14;      // radii
constexpr int kMaxStepHalvings = 4;  // of a step that finds no equilibrium
constexpr double kSameWay = 1e-6;    // depth steps closer than this are one [radii]

// Returns two unit vectors normal to `axis`.
std::array<Vector3d, 2> Across(const Vector3d& axis) {
  const Vector3d first = axis.unitOrthogonal();
  return {first, axis.cross(first)};
}

}  // namespace

TouchBetween TouchAt(const DepthSteps& depth_steps, int finger, double s) noexcept {
  if (depth_steps.size() < 2 || !(s > depth_steps.front()->s)) return {};
  const Bracket at = Around(depth_steps, s);
  const FingerTouch& a = At(depth_steps, at.below, finger);
  const FingerTouch& b = At(depth_steps, at.below + 1, finger);
  if (!a.touching && !b.touching) return {};
  TouchBetween result;
  FingerTouch& touch = result.touch;
  touch.touching = true;
  for (int c = 0; c < 3; ++c) touch.force_O[c] = ForceCurve(depth_steps, finger, c).Value(at);
  const auto between = [&](const auto& from, const auto& to, double part) {
    return from + part * (to - from);
  };
  const double part = std::min(at.part, 1.0);
  touch.p_F = !a.touching ? b.p_F : !b.touching ? a.p_F : Vector3d(between(a.p_F, b.p_F, part));
  touch.radius = between(a.radius, b.radius, part);
  touch.depth = between(a.depth, b.depth, at.part);
  result.slope = (b.force_O.norm() - a.force_O.norm()) /
                 (depth_steps[at.below + 1]->s - depth_steps[at.below]->s);
  return result;
}

void DisplacementsAt(const DepthSteps& depth_steps, double s,
                     std::vector<Vector3d>* displacement_O) {
  if (depth_steps.empty()) return;
  const std::size_t count = depth_steps.front()->displacements_O.size();
  displacement_O->assign(count, Vector3d::Zero());
  if (depth_steps.size() < 2 || !(s > depth_steps.front()->s)) return;
  const Bracket at = Around(depth_steps, s);
  const auto part = static_cast<float>(std::min(at.part, 1.0));
  const auto& a = depth_steps[at.below]->displacements_O;
  const auto& b = depth_steps[at.below + 1]->displacements_O;
  for (std::size_t i = 0; i < count; ++i) {
    (*displacement_O)[i] = (a[i] + part * (b[i] - a[i])).cast<double>();
  }
}

LoadPathCache::LoadPathCache(const TrueObject& object, double deepest)
    : object_(object),
      deepest_(deepest),
      beside_O_(Across(object.hand().approach_O)),
      all_series_(kMaxKept) {}

LoadPathCache::Key LoadPathCache::KeyOf(const Vector3d& h_O) const {
  constexpr double kMaxMultiple = 1e6;
  const auto multiple = [&](const Vector3d& across) {
    return static_cast<int>(
        std::lround(std::clamp(h_O.dot(across) / kRaster, -kMaxMultiple, kMaxMultiple)));
  };
  return {multiple(beside_O_[0]), multiple(beside_O_[1])};
}

// Adds a depth step at every finger's first contact, where the force curve has a kink.
std::vector<double> LoadPathCache::WaysOf(const Vector3d& lateral_O, const RestBody& body) const {
  const FingerHand& hand = object_.hand();
  std::vector<double> ways;
  for (std::size_t f = 0; f < hand.fingers.size(); ++f) {
    const double touch = hand.FirstTouch(f, lateral_O, body.touchable_O);
    // A contact of an opposite finger before home has already ended.
    const bool is_behind = hand.fingers[f].sense < 0 && touch < 0;
    if (std::isfinite(touch) && !is_behind) ways.push_back(touch);
  }
  if (ways.empty()) return ways;
  const double radius = hand.shape.radius;
  const double first = *std::ranges::min_element(ways);
  std::erase_if(ways, [&](double way) { return way > first + deepest_; });
  for (const double part : kFirstDepthSteps) ways.push_back(first + part * radius);
  for (double depth = (kFirstDepthSteps.back() + kEvery) * radius;
       depth < deepest_ + kEvery * radius; depth += kEvery * radius) {
    ways.push_back(first + depth);
  }
  std::ranges::sort(ways);
  const auto same = [&](double a, double b) { return b - a < kSameWay * radius; };
  ways.erase(std::ranges::unique(ways, same).begin(), ways.end());
  return ways;
}

std::shared_ptr<LoadPathCache::DepthSeries> LoadPathCache::Wanted(const Key& key) {
  return all_series_.Want([&](const DepthSeries& series) { return series.key == key; },
                          [&] { return std::make_shared<DepthSeries>(*this, key); });
}

double LoadPathCache::Distance(const DepthSeries& series, const Key& key) {
  return std::hypot(series.key.first - key.first, series.key.second - key.second);
}

const LoadPathCache::DepthSeries& LoadPathCache::Known(
    const DepthSeries& wanted, const std::deque<std::shared_ptr<DepthSeries>>& all_series) {
  if (wanted.is_known()) return wanted;
  const DepthSeries* nearest = &wanted;
  for (const std::shared_ptr<DepthSeries>& series : all_series) {
    if (!series->is_known()) continue;
    if (!nearest->is_known() || Distance(*series, wanted.key) < Distance(*nearest, wanted.key)) {
      nearest = series.get();
    }
  }
  return *nearest;
}

double LoadPathCache::Expect(const Key& key) {
  const std::shared_ptr<DepthSeries> series = Wanted(key);
  return all_series_.Await([&] { return series->is_known() || series->complete; },
                           [&] { return series->first(); });
}

double LoadPathCache::ExpectNow(const Key& key) {
  const std::shared_ptr<DepthSeries> wanted = Wanted(key);
  return all_series_.NowOfAll(
      [&](const auto& all_series) { return Known(*wanted, all_series).first(); });
}

SolvedPress LoadPathCache::Await(const Key& key, double s) {
  const std::shared_ptr<DepthSeries> series = Wanted(key);
  return all_series_.Await([&] { return series->Reaches(s); }, [&] { return series->At(s, true); });
}

SolvedPress LoadPathCache::Find(const Key& key, double s) {
  const std::shared_ptr<DepthSeries> wanted = Wanted(key);
  return all_series_.NowOfAll([&](const auto& all_series) {
    if (wanted->Reaches(s)) return wanted->At(s, true);
    const DepthSeries& known = Known(*wanted, all_series);
    const double depth = s - known.first();
    const DepthSeries *nearest = nullptr, *deepest = &known;
    for (const std::shared_ptr<DepthSeries>& series : all_series) {
      if (series->depth() > deepest->depth()) deepest = series.get();
      if (!(series->depth() >= depth)) continue;
      if (!nearest || Distance(*series, key) < Distance(*nearest, key)) nearest = series.get();
    }
    const DepthSeries& used = nearest ? *nearest : *deepest;
    return used.At(used.first() + depth, false);
  });
}

LoadPathCache::DepthSeries::DepthSeries(const LoadPathCache& cache, const Key& place)
    : of(cache),
      object(cache.object_),
      key(place),
      lateral_O(kRaster * (place.first * cache.beside_O_[0] + place.second * cache.beside_O_[1])) {}

double LoadPathCache::DepthSeries::first() const {
  return ways.empty() ? std::numeric_limits<double>::infinity() : ways.front();
}

bool LoadPathCache::DepthSeries::Reaches(double s) const {
  const DepthSteps& depth_steps = *solved.depth_steps;
  return complete || (depth_steps.size() > 2 && depth_steps[depth_steps.size() - 2]->s >= s);
}

double LoadPathCache::DepthSeries::depth() const {
  const DepthSteps& depth_steps = *solved.depth_steps;
  return depth_steps.size() < 2 ? -1 : depth_steps.back()->s - depth_steps.front()->s;
}

SolvedPress LoadPathCache::DepthSeries::At(double s, bool is_solved) const {
  return {solved.body, solved.depth_steps, s, is_solved};
}

bool LoadPathCache::DepthSeries::Press(double from, double to, int halvings) {
  if (body->Press(object.hand().Placements(lateral_O, to))) return true;
  if (halvings == 0) return false;
  const double middle = 0.5 * (from + to);
  return Press(from, middle, halvings - 1) && Press(middle, to, halvings - 1);
}

LoadPathCache::Step LoadPathCache::DepthSeries::Solve() noexcept {
  try {
    if (is_known()) return SolveDepthStep();
    const auto rest = object.BodyFor(lateral_O);
    return {rest, of.WaysOf(lateral_O, *rest), nullptr};
  } catch (const std::exception&) {
    return {};
  }
}

LoadPathCache::Step LoadPathCache::DepthSeries::SolveDepthStep() {
  const SiteMesh& mesh = solved.body->mesh;
  const std::size_t depth_step = solved.depth_steps->size();  // only this thread changes them
  auto grown = std::make_shared<LoadStep>();
  grown->s = ways[depth_step];
  if (depth_step == 0) {
    const Material& material = object.material();
    body = std::make_unique<PressedBody>(
        mesh, solved.body->held, material.young_modulus, material.poisson_ratio,
        object.hand().shape.radius,
        [&](const Vector3d& p_O) { return RelativeModulus(object.object(), p_O); });
    grown->displacements_O.assign(mesh.nodes.size(), Eigen::Vector3f::Zero());
    return {nullptr, {}, grown};
  }
  if (!Press(ways[depth_step - 1], grown->s, kMaxStepHalvings)) return {};
  for (std::size_t f = 0; f < object.hand().fingers.size(); ++f) {
    grown->touches[f] = body->TouchOf(static_cast<int>(f));
  }
  for (const Vector3d& u : body->Displacements()) {
    grown->displacements_O.emplace_back(u.cast<float>());
  }
  return {nullptr, {}, grown};
}

void LoadPathCache::DepthSeries::Add(const Step& step) {
  if (step.body) {
    solved.body = step.body;
    ways = step.ways;
    complete = ways.empty();
    return;
  }
  if (step.depth_step) {
    auto depth_steps = std::make_shared<DepthSteps>(*solved.depth_steps);
    depth_steps->push_back(step.depth_step);
    solved.depth_steps = std::move(depth_steps);
  }
  complete = !step.depth_step || solved.depth_steps->size() == ways.size();
  if (complete) body.reset();
}

}  // namespace palpate::simulation
