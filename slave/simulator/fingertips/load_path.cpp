#include "slave/simulator/fingertips/load_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>

namespace palpate::site {
namespace {

using Eigen::Vector3d;

// Slope at the middle one of three points, zero at an extremum (Fritsch and Carlson's harmonic
// mean, which keeps the cubic monotone).
double MonotoneSlope(double before, double h_before, double after, double h_after) {
  if (!(before * after > 0)) return 0;
  const double w1 = 2 * h_after + h_before, w2 = h_after + 2 * h_before;
  return (w1 + w2) / (w1 / before + w2 / after);
}

struct Bracket {
  std::size_t below = 0;  // rungs below and below + 1
  double part = 0;        // of the way between them
};

Bracket Around(const Rungs& rungs, double s) {
  const auto above = std::ranges::upper_bound(
      rungs, s, {}, [](const std::shared_ptr<const LoadStep>& rung) { return rung->s; });
  const auto index = static_cast<std::size_t>(above - rungs.begin());
  const std::size_t below = std::clamp<std::size_t>(index, 1, rungs.size() - 1) - 1;
  return {below, (s - rungs[below]->s) / (rungs[below + 1]->s - rungs[below]->s)};
}

const FingerTouch& At(const Rungs& rungs, std::size_t rung, int finger) {
  return rungs[rung]->touches[static_cast<std::size_t>(finger)];
}

// One component of the force over the rungs.
class ForceCurve {
 public:
  ForceCurve(const Rungs& rungs, int finger, int component)
      : rungs_(rungs), finger_(finger), component_(component) {}

  [[nodiscard]] double Value(const Bracket& at) const {
    const double f0 = F(at.below), f1 = F(at.below + 1), h = Step(at.below);
    if (at.part > 1) return f1 + (at.part - 1) * (f1 - f0);  // beyond the last rung
    const double t = at.part, u = 1 - t;
    return u * u * ((1 + 2 * t) * f0 + t * h * Slope(at.below)) +
           t * t * ((1 + 2 * u) * f1 - u * h * Slope(at.below + 1));
  }

 private:
  [[nodiscard]] double F(std::size_t i) const { return At(rungs_, i, finger_).force_O[component_]; }
  [[nodiscard]] double Step(std::size_t i) const { return rungs_[i + 1]->s - rungs_[i]->s; }
  [[nodiscard]] double Chord(std::size_t i) const { return (F(i + 1) - F(i)) / Step(i); }
  [[nodiscard]] double Slope(std::size_t i) const {
    if (i == 0) return 0;  // the first touch is soft
    if (i + 1 == rungs_.size()) return Chord(i - 1);
    return MonotoneSlope(Chord(i - 1), Step(i - 1), Chord(i), Step(i));
  }

  const Rungs& rungs_;
  int finger_, component_;
};

constexpr std::size_t kKept = 8;  // ladders
// Rungs beyond the first touch, in finger radii: force grows there like depth^1.5, so they begin
// near each other; then one every kEvery.
constexpr std::array kFirstRungs{0.02, 0.05, 0.09, 0.14, 0.20, 0.28, 0.38, 0.50};
constexpr double kEvery = 0.14;    // radii
constexpr int kMostHalvings = 4;   // of a step that finds no equilibrium
constexpr double kSameWay = 1e-6;  // radii: rungs nearer than this are one

// Two unit vectors across `axis`.
std::array<Vector3d, 2> Across(const Vector3d& axis) {
  const Vector3d first = axis.unitOrthogonal();
  return {first, axis.cross(first)};
}

}  // namespace

TouchBetween TouchAt(const Rungs& rungs, int finger, double s) noexcept {
  if (rungs.size() < 2 || !(s > rungs.front()->s)) return {};
  const Bracket at = Around(rungs, s);
  const FingerTouch& a = At(rungs, at.below, finger);
  const FingerTouch& b = At(rungs, at.below + 1, finger);
  if (!a.touching && !b.touching) return {};
  TouchBetween result;
  FingerTouch& touch = result.touch;
  touch.touching = true;
  for (int c = 0; c < 3; ++c) touch.force_O[c] = ForceCurve(rungs, finger, c).Value(at);
  const auto between = [&](const auto& from, const auto& to, double part) {
    return from + part * (to - from);
  };
  const double part = std::min(at.part, 1.0);
  touch.p_F = !a.touching ? b.p_F : !b.touching ? a.p_F : Vector3d(between(a.p_F, b.p_F, part));
  touch.radius = between(a.radius, b.radius, part);
  touch.depth = between(a.depth, b.depth, at.part);
  result.slope =
      (b.force_O.norm() - a.force_O.norm()) / (rungs[at.below + 1]->s - rungs[at.below]->s);
  return result;
}

void DisplacementsAt(const Rungs& rungs, double s, std::vector<Vector3d>* displacement_O) {
  if (rungs.empty()) return;
  const std::size_t count = rungs.front()->displacements_O.size();
  displacement_O->assign(count, Vector3d::Zero());
  if (rungs.size() < 2 || !(s > rungs.front()->s)) return;
  const Bracket at = Around(rungs, s);
  const auto part = static_cast<float>(std::min(at.part, 1.0));
  const auto& a = rungs[at.below]->displacements_O;
  const auto& b = rungs[at.below + 1]->displacements_O;
  for (std::size_t i = 0; i < count; ++i) {
    (*displacement_O)[i] = (a[i] + part * (b[i] - a[i])).cast<double>();
  }
}

LoadPathCache::LoadPathCache(const TrueObject& object, double deepest)
    : object_(object),
      deepest_(deepest),
      beside_O_(Across(object.hand().approach_O)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

LoadPathCache::~LoadPathCache() = default;

LoadPathCache::Key LoadPathCache::KeyOf(const Vector3d& h_O) const {
  constexpr double kFarthest = 1e6;
  const auto multiple = [&](const Vector3d& across) {
    return static_cast<int>(
        std::lround(std::clamp(h_O.dot(across) / kRaster, -kFarthest, kFarthest)));
  };
  return {multiple(beside_O_[0]), multiple(beside_O_[1])};
}

Vector3d LoadPathCache::LateralOf(const Key& key) const {
  return kRaster * (key.first * beside_O_[0] + key.second * beside_O_[1]);
}

// Every finger's first touch is a rung of its own: forces have a kink there.
std::vector<double> LoadPathCache::WaysOf(const Key& key, const RestBody& body) const {
  const FingerHand& hand = object_.hand();
  std::vector<double> ways;
  for (std::size_t f = 0; f < hand.fingers.size(); ++f) {
    const double touch = hand.FirstTouch(f, LateralOf(key), body.touchable_O);
    // What an opposite finger met before home lies behind it.
    const bool is_behind = hand.fingers[f].sense < 0 && touch < 0;
    if (std::isfinite(touch) && !is_behind) ways.push_back(touch);
  }
  if (ways.empty()) return ways;
  const double radius = hand.shape.radius;
  const double first = *std::ranges::min_element(ways);
  std::erase_if(ways, [&](double way) { return way > first + deepest_; });
  for (const double part : kFirstRungs) ways.push_back(first + part * radius);
  for (double depth = (kFirstRungs.back() + kEvery) * radius; depth < deepest_ + kEvery * radius;
       depth += kEvery * radius) {
    ways.push_back(first + depth);
  }
  std::ranges::sort(ways);
  const auto same = [&](double a, double b) { return b - a < kSameWay * radius; };
  ways.erase(std::ranges::unique(ways, same).begin(), ways.end());
  return ways;
}

std::shared_ptr<LoadPathCache::Ladder> LoadPathCache::Find(const Key& key) const {
  const auto it = std::ranges::find_if(ladders_, [&](const auto& l) { return l->key == key; });
  return it == ladders_.end() ? nullptr : *it;
}

// Moves the ladder to the front.
std::shared_ptr<LoadPathCache::Ladder> LoadPathCache::Wanted(const Key& key) {
  std::shared_ptr<Ladder> ladder = Find(key);
  if (ladder && ladders_.front() == ladder) return ladder;
  if (ladder) {
    std::erase(ladders_, ladder);
  } else {
    ladder = std::make_shared<Ladder>();
    ladder->key = key;
    ladder->solved.body = object_.BodyFor(LateralOf(key));
    ladder->ways = WaysOf(key, *ladder->solved.body);
    ladder->complete = ladder->ways.empty();
  }
  ladders_.push_front(ladder);
  if (ladders_.size() > kKept) ladders_.pop_back();
  changed_.notify_all();
  return ladder;
}

double LoadPathCache::Expect(const Key& key) {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<Ladder> ladder = Wanted(key);
  return ladder->ways.empty() ? std::numeric_limits<double>::infinity() : ladder->ways.front();
}

SolvedPress LoadPathCache::Await(const Key& key, double s) {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<Ladder> ladder = Wanted(key);
  changed_.wait(lock, [&] {
    const Rungs& rungs = *ladder->solved.rungs;
    // One rung more than `s` lies below: the cubics use it, and answers must not depend on how far
    // the thread has come.
    return ladder->complete || (rungs.size() > 2 && rungs[rungs.size() - 2]->s >= s);
  });
  return ladder->solved;
}

std::shared_ptr<LoadPathCache::Ladder> LoadPathCache::Next() const {
  const auto it = std::ranges::find_if(ladders_, [](const auto& l) { return !l->complete; });
  return it == ladders_.end() ? nullptr : *it;
}

bool LoadPathCache::Press(const Ladder& ladder, double from, double to, int halvings) const {
  if (ladder.body->Press(object_.hand().Placements(LateralOf(ladder.key), to))) return true;
  if (halvings == 0) return false;
  const double middle = 0.5 * (from + to);
  return Press(ladder, from, middle, halvings - 1) && Press(ladder, middle, to, halvings - 1);
}

// nullptr: the body takes no deeper press.
std::shared_ptr<const LoadStep> LoadPathCache::Grow(Ladder* ladder,
                                                    std::size_t rung) const noexcept {
  try {
    const RestBody& body = *ladder->solved.body;
    auto grown = std::make_shared<LoadStep>();
    grown->s = ladder->ways[rung];
    if (rung == 0) {
      const Object& object = object_.object();
      ladder->body = std::make_unique<PressedBody>(
          body.mesh, body.held, object.material.young_modulus, object.material.poisson_ratio,
          object_.hand().shape.radius,
          [&](const Vector3d& p_O) { return RelativeModulus(object, p_O); });
      grown->displacements_O.assign(body.mesh.nodes.size(), Eigen::Vector3f::Zero());
      return grown;
    }
    if (!Press(*ladder, ladder->ways[rung - 1], grown->s, kMostHalvings)) return nullptr;
    for (std::size_t f = 0; f < object_.hand().fingers.size(); ++f) {
      grown->touches[f] = ladder->body->TouchOf(static_cast<int>(f));
    }
    for (const Vector3d& u : ladder->body->Displacements()) {
      grown->displacements_O.emplace_back(u.cast<float>());
    }
    return grown;
  } catch (const std::exception&) {
    return nullptr;
  }
}

void LoadPathCache::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return Next() != nullptr; })) {
    if (stop.stop_requested()) return;
    const std::shared_ptr<Ladder> ladder = Next();
    const std::size_t rung = ladder->solved.rungs->size();
    lock.unlock();
    const auto grown = Grow(ladder.get(), rung);
    lock.lock();
    if (grown) {
      auto rungs = std::make_shared<Rungs>(*ladder->solved.rungs);
      rungs->push_back(grown);
      ladder->solved.rungs = std::move(rungs);
    }
    ladder->complete = !grown || ladder->solved.rungs->size() == ladder->ways.size();
    if (ladder->complete) ladder->body.reset();
    changed_.notify_all();
  }
}

}  // namespace palpate::site
