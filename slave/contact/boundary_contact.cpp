#include "slave/contact/boundary_contact.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "slave/contact/box_tree.h"

namespace palpate {
namespace {

constexpr int kLeafElements = 2;
constexpr int kWatchedNeighbours = 4;    // on each side
constexpr double kSizeRounding = 1e-12;  // relative to the sizes involved
constexpr int kMaxSteps = 100;           // of the search for the first touch of a round end
constexpr double kTouches = 1e-6;        // distance that ends it, in radii
constexpr double kStartSlack = 1e-9;     // of the path: a start on the boundary, to rounding
// Largest distance of a tool in body sizes; beyond it fourth powers would overflow.
constexpr double kMaxDistance = 1e9;

Eigen::Vector2d Turned(const Eigen::Vector2d& axis) {
  return {-axis.y(), axis.x()};
}

}  // namespace

ObbTree::ObbTree(const BoundaryMesh& mesh) {
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
    elements_.push_back({a, b, -Turned(tangent), mesh.Next(i), mesh.Previous(i)});
    reach_ = std::max(reach_, a.stableNorm());
  }
  order_.resize(elements_.size());
  std::iota(order_.begin(), order_.end(), 0);
  boxes_.reserve(2 * elements_.size());
  Build(0, mesh.size());
}

// Splits the elements at their median along the box's longer axis.
int ObbTree::Build(int begin, int end) {
  const auto index = boxes_.size();
  boxes_.push_back(Fit(begin, end));
  if (end - begin > kLeafElements) {
    const Box& box = boxes_[index];
    const Eigen::Vector2d axis = box.half.x() >= box.half.y() ? box.axis : Turned(box.axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](int i, int j) { return axis.dot(At(i).a + At(i).b) < axis.dot(At(j).a + At(j).b); });
    const int left = Build(begin, middle);
    const int right = Build(middle, end);
    boxes_[index].left = left;
    boxes_[index].right = right;
  }
  return static_cast<int>(index);
}

// Axes along the principal directions of the end points.
ObbTree::Box ObbTree::Fit(int begin, int end) const {
  Eigen::Vector2d mean(0, 0);
  for (int k = begin; k < end; ++k) {
    const Element& e = At(order_[Index(k)]);
    mean += (e.a + e.b) / (2.0 * (end - begin));
  }
  double xx = 0, xy = 0, yy = 0;
  const auto visit = [&](const auto& action) {
    for (int k = begin; k < end; ++k) {
      const Element& e = At(order_[Index(k)]);
      action(Eigen::Vector2d(e.a - mean));
      action(Eigen::Vector2d(e.b - mean));
    }
  };
  visit([&](const Eigen::Vector2d& p) {
    xx += p.x() * p.x();
    xy += p.x() * p.y();
    yy += p.y() * p.y();
  });
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
  Eigen::Vector2d lower(0, 0), upper(0, 0);
  visit([&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q(axis.dot(p), Turned(axis).dot(p));
    lower = lower.cwiseMin(q);
    upper = upper.cwiseMax(q);
  });
  const Eigen::Vector2d middle = 0.5 * (lower + upper);
  return {mean + middle.x() * axis + middle.y() * Turned(axis), axis, 0.5 * (upper - lower), begin,
          end};
}

// Separating axes of a box and a segment: the box's two, and the segment's normal. Errs towards
// meeting.
bool ObbTree::MayMeet(const Box& box, const Eigen::Vector2d& from,
                      const Eigen::Vector2d& to) const noexcept {
  const Eigen::Vector2d half_path = 0.5 * (to - from);
  const Eigen::Vector2d apart = from + half_path - box.centre;
  const double slack = kSizeRounding * (reach_ + apart.norm() + half_path.norm());
  const auto overlap = [&](const Eigen::Vector2d& axis, double half) {
    return std::abs(axis.dot(apart)) <= half + std::abs(axis.dot(half_path)) + slack;
  };
  if (!overlap(box.axis, box.half.x()) || !overlap(Turned(box.axis), box.half.y())) return false;
  const Eigen::Vector2d normal = Turned(half_path);
  const double box_radius = box.half.x() * std::abs(normal.dot(box.axis)) +
                            box.half.y() * std::abs(normal.dot(Turned(box.axis)));
  return std::abs(normal.dot(apart)) <= box_radius + slack * half_path.norm();
}

double ObbTree::MinDistanceSquared(const Box& box, const Eigen::Vector2d& p) const noexcept {
  const Eigen::Vector2d apart = p - box.centre;
  const Eigen::Vector2d q(std::abs(box.axis.dot(apart)), std::abs(Turned(box.axis).dot(apart)));
  const double slack = kSizeRounding * (reach_ + q.maxCoeff());
  return ((q - box.half).array() - slack).max(0.0).matrix().squaredNorm();
}

std::optional<ElementPlace> ObbTree::FirstEntry(const Eigen::Vector2d& from,
                                                const Eigen::Vector2d& to) const noexcept {
  const Eigen::Vector2d path = to - from;
  if (path.squaredNorm() == 0) return std::nullopt;
  // Side of a node as seen along the path. The same node gives the same number in both of its
  // elements, so no path slips through between them; a node on the path counts as left of it.
  const auto side = [&](const Eigen::Vector2d& p) { return Cross(path, p - from); };
  std::optional<ElementPlace> first;
  double first_t = 1;
  const auto visit = [&](int index) {
    const Element& e = At(index);
    const double side_a = side(e.a), side_b = side(e.b);
    // Inwards means crossing the element from left to right.
    if (!(side_a >= 0 && side_b < 0)) return;
    // The path goes through the node a: at a convex corner it enters only if it enters through both
    // elements there, else it only touches the corner.
    const Element& before = At(e.previous);
    const bool is_convex = Cross(before.b - before.a, e.b - e.a) > 0;
    if (side_a == 0 && is_convex && Cross(path, before.b - before.a) >= 0) return;
    const double s = side_a / (side_a - side_b);
    const Eigen::Vector2d p = e.a + s * (e.b - e.a);
    const double t = (p - from).dot(path) / path.squaredNorm();
    const bool is_on_path = t >= -kStartSlack && t < 1 && HeightOver(index, to) < 0;
    if (is_on_path && (!first || t < first_t)) {
      first = ElementPlace{index, s, p};
      first_t = t;
    }
  };
  BoxStack stack;
  for (stack.Push(0); !stack.empty();) {
    const Box& box = boxes_[Index(stack.Pop())];
    if (!MayMeet(box, from, to)) continue;
    if (box.left >= 0) {
      stack.Push(box.left);
      stack.Push(box.right);
      continue;
    }
    for (int k = box.begin; k < box.end; ++k) visit(order_[Index(k)]);
  }
  return first;
}

ObbTree::Candidate ObbTree::Project(int element, const Eigen::Vector2d& p) const noexcept {
  const Element& e = At(element);
  const Eigen::Vector2d edge = e.b - e.a;
  const double s = std::clamp((p - e.a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  // A node is met exactly, so that both of its elements are equally near.
  const Eigen::Vector2d q = s == 1 ? e.b : Eigen::Vector2d(e.a + s * edge);
  return {{element, s, q}, (p - q).squaredNorm(), (p - q).dot(e.normal)};
}

// Ties are resolved by the height or depth, then by the element that begins there, then by
// position, but never by number.
bool ObbTree::IsNearer(const Candidate& one, const Candidate& other) const noexcept {
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

ElementPlace ObbTree::Nearest(const Eigen::Vector2d& p, int near) const noexcept {
  Candidate best = Project(near >= 0 ? near : order_[0], p);
  const auto visit = [&](int element) {
    const Candidate candidate = Project(element, p);
    if (IsNearer(candidate, best)) best = candidate;
  };
  int ahead = best.place.element, behind = ahead;
  for (int k = 0; k < kWatchedNeighbours; ++k) {
    visit(ahead = At(ahead).next);
    visit(behind = At(behind).previous);
  }
  VisitNearest(
      boxes_, best.distance_squared, [&](const Box& box) { return MinDistanceSquared(box, p); },
      [&](int k) { visit(order_[Index(k)]); });
  return best.place;
}

// The element's normal; beside a corner, the direction from there to the centre of a round end.
Eigen::Vector2d BoundaryContact::NormalTo(const Eigen::Vector2d& centre,
                                          const ElementPlace& at) const noexcept {
  const Eigen::Vector2d way = centre - at.p_O;
  const bool is_outside = tree_.HeightOver(at.element, centre) > kSizeRounding * tree_.reach();
  return radius_ > 0 && is_outside ? way.normalized() : tree_.normal(at.element);
}

// Returns the fraction of `path` after which a round end touches; nullopt: it does not. It advances
// by steps that are certainly free of contact.
std::optional<double> BoundaryContact::WayToTouch(const Eigen::Vector2d& from,
                                                  const Eigen::Vector2d& path) const noexcept {
  double gone = 0;
  for (int step = 0; step < kMaxSteps && gone < 1; ++step) {
    const Eigen::Vector2d centre = from + gone * path;
    const ElementPlace near = tree_.Nearest(centre, place_.element);
    const double gap = (centre - near.p_O).norm() - radius_;
    if (gap < kTouches * radius_ || tree_.HeightOver(near.element, centre) < 0) return gone;
    gone += gap / path.norm();
  }
  return std::nullopt;
}

// Begins a contact at `at` with the tool at `tool`; the tool is now at `to`.
void BoundaryContact::Touch(const ElementPlace& at, const Eigen::Vector2d& tool,
                            const Eigen::Vector2d& to) noexcept {
  place_ = {at.element, at.s, at.p_O, NormalTo(tool, at), 0};
  place_.gap = GapOf(to);
  in_contact_ = place_.gap < 0;
}

// Called while out of contact, for a motion from `from` to `to`.
void BoundaryContact::Approach(const Eigen::Vector2d& from, const Eigen::Vector2d& to) noexcept {
  in_contact_ = false;
  if (radius_ == 0) {
    if (const auto entry = tree_.FirstEntry(from, to)) Touch(*entry, to, to);
  } else if (const auto way = WayToTouch(from, to - from)) {
    const Eigen::Vector2d centre = from + *way * (to - from);
    Touch(tree_.Nearest(centre, place_.element), centre, to);
  }
  // No entry was found, but the tool is inside, by rounding or from the start.
  if (!in_contact_) Touch(tree_.Nearest(to, place_.element), to, to);
}

const BoundaryPlace& BoundaryContact::Move(const Eigen::Vector2d& p_O) noexcept {
  const bool is_usable =
      p_O.allFinite() && p_O.cwiseAbs().maxCoeff() <= kMaxDistance * tree_.reach();
  if (!is_usable) return place_;
  const Eigen::Vector2d from = last_.value_or(p_O);
  last_ = p_O;
  if (!in_contact_) {
    Approach(from, p_O);
    return place_;
  }
  const double gap = GapOf(p_O);
  if (gap < 0) {
    place_.gap = gap;
    return place_;
  }
  // The tool has left through the plane; the rest of the path may enter at another position.
  const Eigen::Vector2d left_at = from + place_.gap / (place_.gap - gap) * (p_O - from);
  Approach(left_at, p_O);
  return place_;
}

void BoundaryContact::Reset() noexcept {
  place_ = BoundaryPlace();
  last_.reset();
  in_contact_ = false;
}

}  // namespace palpate
