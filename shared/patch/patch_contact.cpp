#include "shared/patch/patch_contact.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Least accepted compliance [m/N].
constexpr double kMinCompliance = 1e-9;
// A motion is extrapolated until its error is this part of the full depth.
constexpr double kTrustedMotion = 0.25;
constexpr double kMaxMotion = 10;  // [s]
constexpr double kMinFriction = 1e-3;

std::size_t At(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

void PatchContact::Take(const SurfacePatch& patch, const PatchLaw& law, double at,
                        double now) noexcept {
  if (patch.epoch == patch_.epoch) return TakeLaw(law, at, now);
  patch_ = patch;
  to_ = from_ = {law, at};
  since_ = now - kBlendTime;
  steepest_ratio_ = SteepestRatio();
  EndContact();
}

void PatchContact::TakeLaw(const PatchLaw& law, double at, double now) noexcept {
  if (law.epoch != patch_.epoch || law.revision <= to_.law.revision) return;
  // A third curve during a blend starts from the blended ratios.
  const double share = ShareOfNew(now);
  const Vector3d shift = ShiftAt(now, now);
  for (std::size_t i = 0; i < kLawPoints; ++i) {
    from_.law.ratios[i] += share * (to_.law.ratios[i] - from_.law.ratios[i]);
  }
  from_.law.offset = shift;
  from_.law.velocity = to_.law.velocity;
  from_.law.velocity_error = to_.law.velocity_error;
  from_.at = now;
  to_ = {law, at};
  since_ = now;
  steepest_ratio_ = SteepestRatio();
  for (int i = 0; i < patch_.tool_count; ++i) {
    if (touches_[At(i)].touching) touches_[At(i)].K = StiffnessAt(touches_[At(i)].place);
  }
}

void PatchContact::Resume(const PatchContact& before) noexcept {
  for (int i = 0; i < std::min(patch_.tool_count, before.patch_.tool_count); ++i) {
    const Touch& was = before.touches_[At(i)];
    Touch& touch = touches_[At(i)];
    touch.has_last = was.has_last;
    touch.last_centre = was.last_centre;
    touch.last_gap = was.last_gap;
    if (!was.touching) continue;
    touch.touching = true;
    StickAt(i, was.place.p);
  }
}

void PatchContact::EndContact() noexcept {
  for (Touch& touch : touches_) touch = Touch();
  depth_ = 0;
  serves_ = false;
}

Vector3d PatchContact::ForceAt(const Vector3d& p_S, double now, double then) noexcept {
  if (!patch_.known() || !p_S.allFinite()) return {0, 0, 0};
  capped_ = false;
  const Vector3d p_rest = p_S - ShiftAt(now, then);
  for (int i = 0; i < patch_.tool_count; ++i) {
    Vector3d centre = p_rest + patch_.tools[At(i)].centre;
    if (patch_.vertices_per_cell == 2)
      centre.z() = patch_.vertices[0].cast<double>().z();  // planar
    Move(i, centre);
  }
  SolveAll();
  const Touch& tool = touches_[0];
  if (!tool.touching) return {0, 0, 0};
  Vector3d force = RatioAt(depth_, now) * tool.linear;
  const Vector3d& n = tool.place.normal;
  return n.dot(force) > 0 ? force : Vector3d(0, 0, 0);
}

double PatchContact::ShareOfNew(double now) const noexcept {
  return std::clamp((now - since_) / kBlendTime, 0.0, 1.0);
}

Vector3d PatchContact::ShiftAt(double now, double then) const noexcept {
  const auto shift = [&](const TimedLaw& timed) -> Vector3d {
    const PatchLaw& law = timed.law;
    const double trusted = law.velocity_error > 0
                               ? kTrustedMotion * patch_.full_depth / law.velocity_error
                               : kMaxMotion;
    const double passed = std::clamp(then - timed.at, 0.0, std::min(trusted, kMaxMotion));
    return law.offset + passed * law.velocity;
  };
  const Vector3d old = shift(from_);
  return old + ShareOfNew(now) * (shift(to_) - old);
}

double PatchContact::RatioAt(double depth, double now) const noexcept {
  const auto ratio = [&](const PatchLaw& law) {
    const double at = std::clamp(depth / patch_.full_depth, 0.0, 1.0) * (kLawPoints - 1);
    const int below = std::min(static_cast<int>(at), kLawPoints - 2);
    const double low = law.ratios[At(below)];
    return low + (at - below) * (law.ratios[At(below + 1)] - low);
  };
  const double old = ratio(from_.law);
  return old + ShareOfNew(now) * (ratio(to_.law) - old);
}

// Returns the largest slope d (r d) / dd of both laws, relative to the linear force.
double PatchContact::SteepestRatio() const noexcept {
  double steepest = 1e-6;
  for (const PatchLaw* law : {&from_.law, &to_.law}) {
    for (int i = 0; i < kLawPoints; ++i) {
      const double r = law->ratios[At(i)];
      const double before = i > 0 ? (r - law->ratios[At(i - 1)]) * i : 0;
      const double after = i + 1 < kLawPoints ? (law->ratios[At(i + 1)] - r) * i : 0;
      steepest = std::max({steepest, r, r + before, r + after});
    }
  }
  return steepest;
}

void PatchContact::Move(int tool, const Vector3d& centre) noexcept {
  Touch& touch = touches_[At(tool)];
  const double radius = patch_.tools[At(tool)].radius;
  if (!touch.touching) {
    const PatchPlace nearest = NearestPlace(patch_, centre);
    const double gap = nearest.height - radius;
    const bool known = nearest.cell >= 0 || patch_.vertices_per_cell == 1;
    if (tool == 0) serves_ = known && !nearest.at_rim;
    if (tool == 0) depth_ = -gap;
    if (gap <= 0 && known && !nearest.at_rim) Enter(tool, centre, nearest);
    touch.last_gap = gap;
    if (!touch.touching) touch.place = nearest;
  } else if (patch_.directions == 1) {
    Slide(tool, centre);
  }
  touch.last_centre = centre;
  touch.has_last = true;
  if (!touch.touching) return;
  touch.d = touch.place.p - (centre - radius * touch.place.normal);
  const double depth = touch.place.normal.dot(touch.d);
  if (tool == 0) {
    depth_ = depth;
    serves_ = true;
  }
  touch.touching = depth > 0;
}

// Point where the path crossed the surface.
void PatchContact::Enter(int tool, const Vector3d& centre, const PatchPlace& nearest) noexcept {
  Touch& touch = touches_[At(tool)];
  const double radius = patch_.tools[At(tool)].radius, gap = nearest.height - radius;
  Vector3d crossing = centre;
  if (touch.has_last && touch.last_gap > 0) {
    crossing += gap / (touch.last_gap - gap) * (centre - touch.last_centre);
  }
  touch.touching = true;
  touch.linear.setZero();
  StickAt(tool, crossing);
  // Beside an edge or a corner the contact normal points from the edge to the sphere's centre.
  const Vector3d away = crossing - touch.place.p;
  if (radius > 0 && touch.place.height > 0.5 * radius) {
    touch.place.normal = away.stableNormalized();
    touch.K = StiffnessAt(touch.place);
  }
}

void PatchContact::StickAt(int tool, const Vector3d& p) noexcept {
  Touch& touch = touches_[At(tool)];
  touch.place = NearestPlace(patch_, p);
  touch.K = StiffnessAt(touch.place);
}

// Without friction the contact point is always below the tool.
void PatchContact::Slide(int tool, const Vector3d& centre) noexcept {
  const PatchPlace below = NearestPlace(patch_, centre);
  if (below.cell < 0 || below.at_rim) return;  // keeps the present plane
  touches_[At(tool)].place = below;
  touches_[At(tool)].K = StiffnessAt(below);
}

void PatchContact::SolveAll() noexcept {
  const bool alone = patch_.tool_count == 1 || !patch_.coupled;
  for (int sweep = 0; sweep < (alone ? 1 : kSweeps); ++sweep) {
    for (int i = 0; i < patch_.tool_count; ++i) {
      if (touches_[At(i)].touching) {
        Relax(i);
      } else {
        touches_[At(i)].linear.setZero();
      }
    }
  }
}

void PatchContact::Relax(int tool) noexcept {
  Touch& touch = touches_[At(tool)];
  Vector3d d = touch.d;
  if (patch_.coupled) {
    for (int other = 0; other < patch_.tool_count; ++other) {
      if (other != tool && touches_[At(other)].touching) d -= MovedBy(tool, other);
    }
  }
  const Vector3d& n = touch.place.normal;
  Vector3d f = touch.K * d;
  const double pressed = n.dot(f);
  if (!(pressed > 0) || !f.allFinite()) {
    touch.linear.setZero();
    return;
  }
  const std::optional<double>& mu = to_.law.friction;
  if (mu && patch_.directions == 3) {
    const Vector3d along = f - pressed * n;
    const double most = std::max(*mu, kMinFriction) * pressed;
    if (along.norm() > most) {
      // With a larger tangential displacement the anchor slides behind the tool.
      const double kept = most / along.norm();
      const Vector3d slip = (1 - kept) * (d - n.dot(d) * n);
      f = pressed * n + kept * along;
      const Vector3d normal = n;
      const PatchPlace moved = NearestPlace(patch_, touch.place.p - slip);
      if (!moved.at_rim && moved.normal.dot(normal) > 0) {
        touch.place = moved;
        touch.K = StiffnessAt(moved);
      }
    }
  }
  touch.linear = f;
}

Matrix3d PatchContact::BlockOf(int node, int other) const noexcept {
  Matrix3d block = Matrix3d::Zero();
  const int n = patch_.directions;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      block(i, j) = static_cast<double>(patch_.compliance(n * node + i, n * other + j));
    }
  }
  return block;
}

Matrix3d PatchContact::OwnCompliance(const PatchPlace& place) const noexcept {
  Matrix3d own = Matrix3d::Zero();
  const int corners = place.cell < 0 ? 1 : patch_.vertices_per_cell;
  for (int k = 0; k < corners; ++k) {
    const int node = patch_.node_of[At(VertexOf(patch_, place.cell, k))];
    own += place.weights[k] * BlockOf(node, node);
  }
  return own;
}

Matrix3d PatchContact::StiffnessAt(const PatchPlace& place) noexcept {
  const Vector3d& n = place.normal;
  const Matrix3d own = OwnCompliance(place);
  Matrix3d K = patch_.directions == 1
                   ? Matrix3d(n * n.transpose() / (own(0, 0) + kMinCompliance))
                   : Matrix3d((own + kMinCompliance * Matrix3d::Identity()).inverse());
  if (!K.allFinite()) return Matrix3d::Zero();
  const Matrix3d shown = NearestSpring(K, stiffest_ / steepest_ratio_);
  capped_ = capped_ || (shown - K).norm() > 0.01 * K.norm();
  return shown;
}

// Returns the displacement of the surface below `tool` by the force on `other` [m], as in Relax.
Vector3d PatchContact::MovedBy(int tool, int other) const noexcept {
  const Touch &to = touches_[At(tool)], &by = touches_[At(other)];
  const int corners = patch_.vertices_per_cell;
  Vector3d moved(0, 0, 0);
  for (int k = 0; k < corners; ++k) {
    for (int m = 0; m < corners; ++m) {
      const int node = patch_.node_of[At(VertexOf(patch_, to.place.cell, k))];
      const int source = patch_.node_of[At(VertexOf(patch_, by.place.cell, m))];
      const double weight = to.place.weights[k] * by.place.weights[m];
      if (weight == 0) continue;
      const Matrix3d block = BlockOf(node, source);
      moved +=
          weight * (patch_.directions == 1
                        ? Vector3d(block(0, 0) * by.place.normal.dot(by.linear) * to.place.normal)
                        : Vector3d(block * by.linear));
    }
  }
  return moved;
}

void PatchRender::Take(const SurfacePatch& patch, const PatchLaw& law, double at,
                       double now) noexcept {
  if (patch.epoch == newest_.patch().epoch) {
    newest_.TakeLaw(law, at, now);
    return;
  }
  const bool first = !known();
  before_ = newest_;
  newest_.Take(patch, law, at, now);
  newest_.Resume(before_);
  if (!first) since_ = now;
}

void PatchRender::EndContact() noexcept {
  newest_.EndContact();
  before_.EndContact();
}

void PatchRender::Forget() noexcept {
  EndContact();
  newest_.Forget();
  since_ = -1e9;
}

Eigen::Vector3d PatchRender::ForceAt(const Eigen::Vector3d& p_S, double now, double then) noexcept {
  const Eigen::Vector3d force = newest_.ForceAt(p_S, now, then);
  if (!IsBlending(now)) return force;
  const double share = (now - since_) / kBlendTime;
  const Eigen::Vector3d before = before_.ForceAt(p_S, now, then);
  return before + share * (force - before);
}

void PatchRender::set_stiffest(double stiffest) noexcept {
  newest_.set_stiffest(stiffest);
  before_.set_stiffest(stiffest);
}

Eigen::Matrix3d NearestSpring(const Eigen::Matrix3d& K, double most) noexcept {
  const Eigen::Matrix3d symmetric = 0.5 * (K + K.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(symmetric);
  const Eigen::Vector3d& k = modes.eigenvalues();
  const double rounding = 1e-12 * k.cwiseAbs().maxCoeff();
  if (symmetric == K && k.minCoeff() >= -rounding && k.maxCoeff() <= most) return K;
  const Eigen::Vector3d kept = k.cwiseMax(0).cwiseMin(most);
  return modes.eigenvectors() * kept.asDiagonal() * modes.eigenvectors().transpose();
}

}  // namespace palpate
