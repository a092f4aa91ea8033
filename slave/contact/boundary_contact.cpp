#include "slave/contact/boundary_contact.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

constexpr double kStartSlack = 1e-9;  // of the path: a start on the boundary, to rounding
// Farther away than this many times the body's reach there is no tool, and squares of squares would
// leave the numbers.
constexpr double kFarthest = 1e9;

}  // namespace

BoundarySearch::BoundarySearch(const BoundaryMesh& mesh) {
  if (mesh.size() < 3) {
    throw std::invalid_argument("a boundary of " + std::to_string(mesh.size()) +
                                " elements: expected three or more");
  }
  for (int i = 0; i < mesh.size(); ++i) {
    const auto& [a, b] = mesh.elements[Index(i)];
    if (!a.allFinite() || !b.allFinite() || a == b) {
      throw std::invalid_argument("element " + std::to_string(i) +
                                  ": expected a finite length > 0");
    }
    const Eigen::Vector2d tangent = (b - a).stableNormalized();
    elements_.push_back({a, b, {tangent.y(), -tangent.x()}, mesh.Previous(i)});
    reach_ = std::max(reach_, a.stableNorm());
  }
}

std::optional<ElementPlace> BoundarySearch::FirstEntry(const Eigen::Vector2d& from,
                                                       const Eigen::Vector2d& to) const noexcept {
  const Eigen::Vector2d path = to - from;
  if (path.squaredNorm() == 0) return std::nullopt;
  // Side of a node as seen along the path. The same node gives the same number in both of its
  // elements, so no path slips through between them; a node on the path counts as left of it.
  const auto side = [&](const Eigen::Vector2d& p) { return Cross(path, p - from); };
  std::optional<ElementPlace> first;
  double first_t = 1;
  for (int index = 0; index < size(); ++index) {
    const Element& e = At(index);
    const double side_a = side(e.a), side_b = side(e.b);
    if (!(side_a >= 0 && side_b < 0)) continue;  // inwards is across the element from left to right
    // Through the node a: at a convex corner the path enters only if it does so through both
    // elements there, else it just touches the tip of the corner.
    const Element& before = At(e.previous);
    const bool is_convex = Cross(before.b - before.a, e.b - e.a) > 0;
    if (side_a == 0 && is_convex && Cross(path, before.b - before.a) >= 0) continue;
    const double s = side_a / (side_a - side_b);
    const Eigen::Vector2d p = e.a + s * (e.b - e.a);
    const double t = (p - from).dot(path) / path.squaredNorm();
    const bool is_on_path = t >= -kStartSlack && t < 1 && HeightOver(index, to) < 0;
    if (is_on_path && (!first || t < first_t)) {
      first = ElementPlace{index, s, p};
      first_t = t;
    }
  }
  return first;
}

BoundarySearch::Candidate BoundarySearch::Project(int element,
                                                  const Eigen::Vector2d& p) const noexcept {
  const Element& e = At(element);
  const Eigen::Vector2d edge = e.b - e.a;
  const double s = std::clamp((p - e.a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  // A node is met exactly, so that both of its elements are equally near.
  const Eigen::Vector2d q = s == 1 ? e.b : Eigen::Vector2d(e.a + s * edge);
  return {{element, s, q}, (p - q).squaredNorm(), (p - q).dot(e.normal)};
}

// Ties go to the higher or deeper, then to the element that begins there, then by place: never by
// number.
bool BoundarySearch::IsNearer(const Candidate& one, const Candidate& other) const noexcept {
  if (one.distance_squared != other.distance_squared) {
    return one.distance_squared < other.distance_squared;
  }
  if (std::abs(one.height) != std::abs(other.height)) {
    return std::abs(one.height) > std::abs(other.height);
  }
  if (one.place.s != other.place.s) return one.place.s < other.place.s;
  const Eigen::Vector2d& a = At(one.place.element).a;
  const Eigen::Vector2d& b = At(other.place.element).a;
  return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
}

ElementPlace BoundarySearch::Nearest(const Eigen::Vector2d& p) const noexcept {
  Candidate best = Project(0, p);
  for (int element = 1; element < size(); ++element) {
    const Candidate candidate = Project(element, p);
    if (IsNearer(candidate, best)) best = candidate;
  }
  return best.place;
}

// Out of contact so far, on the way from `from` to `to`.
void BoundaryContact::Approach(const Eigen::Vector2d& from, const Eigen::Vector2d& to) noexcept {
  const auto entry = search_.FirstEntry(from, to);
  const ElementPlace at = entry ? *entry : search_.Nearest(to);
  place_ = {at.element, at.s, at.p_O, search_.normal(at.element), 0};
  place_.gap = GapOf(to);
  in_contact_ = place_.gap < 0;  // without an entry: inside all the same, by rounding or from start
}

const BoundaryPlace& BoundaryContact::MoveTip(const Eigen::Vector2d& p_O_tip) noexcept {
  const bool is_usable =
      p_O_tip.allFinite() && p_O_tip.cwiseAbs().maxCoeff() <= kFarthest * search_.reach();
  if (!is_usable) return place_;
  const Eigen::Vector2d from = last_tip_.value_or(p_O_tip);
  last_tip_ = p_O_tip;
  if (!in_contact_) {
    Approach(from, p_O_tip);
    return place_;
  }
  const double gap = GapOf(p_O_tip);
  if (gap < 0) {
    place_.gap = gap;
    return place_;
  }
  // Out through the plane: the rest of the way may already lead in elsewhere.
  const Eigen::Vector2d left_at = from + place_.gap / (place_.gap - gap) * (p_O_tip - from);
  Approach(left_at, p_O_tip);
  return place_;
}

void BoundaryContact::Reset() noexcept {
  place_ = BoundaryPlace();
  last_tip_.reset();
  in_contact_ = false;
}

}  // namespace palpate
