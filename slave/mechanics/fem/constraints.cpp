#include "slave/mechanics/fem/constraints.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

constexpr double kNoWeight = 1e-9;  // sum of squared weights of a point
constexpr int kMaxMotions = 24;
constexpr double kFreeMotionShift = 1e-5;  // keeps the factor definite
constexpr double kLiftRounding = 1e-14;    // [larger sides]

// Returns for component `c` the sum of squared weights, and the weighted sum of `x`.
std::pair<double, double> Weigh(const HeldComponents::Sum& sum, const NodeVector& x, int c) {
  double square = 0, value = 0;
  for (int a = 0; a < 3; ++a) {
    square += sum.weight[a].v[c] * sum.weight[a].v[c];
    value += sum.weight[a].v[c] * At(x, sum.node[a]).v[c];
  }
  return {square, value};
}

}  // namespace

Constraints::Constraints(const FemBody& body) : body_(body), taken_by_(Index(body.size()), 0) {
  held_.free = body.free();
}

void Constraints::Clear() {
  std::copy(body_.free().begin(), body_.free().end(), held_.free.begin());
  held_.sums.clear();
  held_.guides.clear();
  held_.shift = 0;
  touched_.clear();
  for (const int node : nodes_) taken_by_[Index(node)] = 0;
  nodes_.clear();
  contacts_.clear();
  motion_count_ = 0;
}

bool Constraints::Take(std::span<const PlaceWeight> nodes) {
  Contact& contact = contacts_.emplace_back();
  contact.begin = nodes_.size();
  const int number = static_cast<int>(contacts_.size());
  for (const auto& [node, weight] : nodes) {
    int& taken = taken_by_[Index(node)];
    if (taken != 0 && taken != number) return false;
    taken = number;
    nodes_.push_back(node);
  }
  contact.end = nodes_.size();
  return true;
}

bool Constraints::HoldNodes(std::span<const PlaceWeight> nodes) {
  if (!Take(nodes)) return false;
  for (const auto& [node, weight] : nodes) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (At(body_.free(), node).v[c] == 0) contacts_.back().blocked.v[c] = 1;
      At(held_.free, node).v[c] = 0;
    }
  }
  return true;
}

bool Constraints::HoldPoint(std::span<const PlaceWeight> nodes) {
  if (!Take(nodes)) return false;
  Contact& contact = contacts_.back();
  HeldComponents::Sum sum;
  for (std::size_t c = 0; c < 3; ++c) {
    double square = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto& [node, weight] = nodes[std::min(a, nodes.size() - 1)];
      sum.node[a] = node;
      sum.weight[a].v[c] = a < nodes.size() ? weight * At(body_.free(), node).v[c] : 0;
      square += sum.weight[a].v[c] * sum.weight[a].v[c];
    }
    if (square > kNoWeight) continue;
    contact.blocked.v[c] = 1;
    for (auto& weight : sum.weight) weight.v[c] = 0;
  }
  contact.sum = static_cast<int>(held_.sums.size());
  held_.sums.push_back(sum);
  return true;
}

void Constraints::ReserveTouched(std::size_t most) {
  touched_.reserve(most);
  held_.guides.reserve(most);
}

void Constraints::HoldTouched(std::span<const TouchedNode> nodes) {
  for (const TouchedNode& at : touched_) At(held_.free, at.node) = At(body_.free(), at.node);
  touched_.assign(nodes.begin(), nodes.end());
  held_.guides.clear();
  for (const TouchedNode& at : touched_) {
    if (at.sticks) {
      At(held_.free, at.node) = {};
    } else {
      const Vector3d free = Eigen::Map<const Vector3d>(At(body_.free(), at.node).v);
      held_.guides.push_back({at.node, free.cwiseProduct(at.normal).normalized()});
    }
  }
}

bool Constraints::Move(int k, const Vector3d& displacement) {
  Contact& contact = contacts_[Index(k)];
  contact.target = displacement;
  for (int c = 0; c < 3; ++c) {
    if (contact.blocked.v[c] > 0 && displacement[c] != 0) return false;
  }
  return true;
}

double Constraints::Lift(const NodeVector& u, double share, NodeVector& lift) const noexcept {
  SetZero(lift);
  double largest = 0;
  for (const auto& contact : contacts_) {
    for (int c = 0; c < 3; ++c) {
      if (contact.blocked.v[c] > 0) continue;
      if (contact.sum < 0) {
        for (std::size_t n = contact.begin; n < contact.end; ++n) {
          const double change = share * contact.target[c] - At(u, nodes_[n]).v[c];
          At(lift, nodes_[n]).v[c] = change;
          largest = std::max(largest, std::abs(change));
        }
        continue;
      }
      const auto& sum = held_.sums[Index(contact.sum)];
      const auto [square, value] = Weigh(sum, u, c);
      const double change = (share * contact.target[c] - value) / square;
      largest = std::max(largest, std::abs(change));
      for (int a = 0; a < 3; ++a) At(lift, sum.node[a]).v[c] += change * sum.weight[a].v[c];
    }
  }
  for (const TouchedNode& at : touched_) {
    Vector3d change = at.target - Eigen::Map<const Vector3d>(At(u, at.node).v);
    if (!at.sticks) change = at.normal.dot(change) * at.normal;
    change = change.cwiseProduct(Eigen::Map<const Vector3d>(At(body_.free(), at.node).v));
    Eigen::Map<Vector3d>(At(lift, at.node).v) = change;
    const double size = change.cwiseAbs().maxCoeff();
    if (size > at.slack) largest = std::max(largest, size);
  }
  RemoveMotions(lift);
  return largest > kLiftRounding ? largest : 0;
}

void Constraints::HeldPart(const NodeVector& u, NodeVector& held) const noexcept {
  held = u;
  ProjectMotion(held);
  ScaleAndAdd(-1, u, held);
}

void Constraints::ProjectSums(NodeVector& x) const noexcept {
  for (const auto& sum : held_.sums) {
    for (int c = 0; c < 3; ++c) {
      const auto [square, value] = Weigh(sum, x, c);
      if (square == 0) continue;
      for (int a = 0; a < 3; ++a) At(x, sum.node[a]).v[c] -= value / square * sum.weight[a].v[c];
    }
  }
  for (const Guide& guide : held_.guides) {
    Eigen::Map<Vector3d> of(At(x, guide.row).v);
    of -= guide.normal.dot(of) * guide.normal;
  }
}

void Constraints::ProjectMotion(NodeVector& change) const noexcept {
  for (std::size_t i = 0; i < change.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) change[i].v[c] *= held_.free[i].v[c];
  }
  ProjectSums(change);
  RemoveMotions(change);
}

void Constraints::RemoveMotions(NodeVector& x) const noexcept {
  for (int m = 0; m < motion_count_; ++m) {
    Add(-Dot(weighted_motions_[Index(m)], x), motions_[Index(m)], x);
  }
}

void Constraints::ProjectForce(NodeVector& force) const noexcept {
  for (int m = 0; m < motion_count_; ++m) {
    Add(-Dot(motions_[Index(m)], force), weighted_motions_[Index(m)], force);
  }
  for (std::size_t i = 0; i < force.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) force[i].v[c] *= held_.free[i].v[c];
  }
  ProjectSums(force);
}

Vector3d Constraints::Sum(int k, const NodeVector& force) const noexcept {
  const Contact& contact = contacts_[Index(k)];
  Vector3d sum = Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    if (contact.sum >= 0 && contact.blocked.v[c] == 0) {
      // Uses the free nodes only, because the force on fixed nodes includes that of supports.
      const auto [square, value] = Weigh(held_.sums[Index(contact.sum)], force, c);
      sum[c] = value / square;
      continue;
    }
    for (std::size_t n = contact.begin; n < contact.end; ++n) {
      sum[c] += At(force, nodes_[n]).v[c];
    }
  }
  return sum;
}

double Constraints::Imbalance(const NodeVector& force) const noexcept {
  double worst = 0;
  for (int m = 0; m < motion_count_; ++m) {
    const NodeVector& motion = motions_[Index(m)];
    double sum = 0, size = 0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum += motion[i].v[c] * force[i].v[c];
        size += std::abs(motion[i].v[c] * force[i].v[c]);
      }
    }
    if (size > 0) worst = std::max(worst, std::abs(sum) / size);
  }
  return worst;
}

// Collects the motions of a part that supports and contacts prevent.
void Constraints::HoldMotions(int part, HeldMotions* motions) const {
  for (int i = 0; i < body_.size(); ++i) {
    if (body_.part()[Index(i)] != part) continue;
    for (int c = 0; c < 3; ++c) {
      if (At(held_.free, i).v[c] == 0) motions->Hold(motions->Row(body_.points()[Index(i)], c));
    }
  }
  for (const auto& sum : held_.sums) {
    if (body_.part()[Index(sum.node[0])] != part) continue;
    for (int c = 0; c < 3; ++c) {
      HeldMotions::Motion row = HeldMotions::Motion::Zero();
      for (int a = 0; a < 3; ++a) {
        row += sum.weight[a].v[c] * motions->Row(body_.points()[Index(sum.node[a])], c);
      }
      motions->Hold(row);
    }
  }
}

bool Constraints::FindFreeMotions() {
  motion_count_ = 0;
  std::vector<Eigen::AlignedBox3d> box(Index(body_.parts()));
  for (int i = 0; i < body_.size(); ++i) {
    const int part = body_.part()[Index(i)];
    if (part >= 0) box[Index(part)].extend(body_.points()[Index(i)]);
  }
  for (int part = 0; part < body_.parts(); ++part) {
    HeldMotions motions(box[Index(part)]);
    HoldMotions(part, &motions);
    const HeldMotions::Motions free = motions.Free();
    for (const auto& motion : free.colwise()) {
      if (!AddMotion(part, motions, motion)) return false;
    }
  }
  held_.shift = motion_count_ > 0 ? kFreeMotionShift : 0;
  return true;
}

bool Constraints::AddMotion(int part, const HeldMotions& motions,
                            const HeldMotions::Motion& motion) {
  if (motion_count_ == kMaxMotions) return false;
  const auto m = Index(motion_count_);
  if (motions_.size() <= m) {
    motions_.emplace_back(Index(body_.size()));
    weighted_motions_.emplace_back(Index(body_.size()));
  }
  NodeVector &z = motions_[m], &weighted = weighted_motions_[m];
  SetZero(z);
  for (int i = 0; i < body_.size(); ++i) {
    if (body_.part()[Index(i)] != part) continue;
    for (int c = 0; c < 3; ++c) {
      At(z, i).v[c] = motions.Row(body_.points()[Index(i)], c).dot(motion) * At(held_.free, i).v[c];
    }
  }
  for (std::size_t k = 0; k < m; ++k) Add(-Dot(weighted_motions_[k], z), motions_[k], z);
  body_.MultiplyMass(z, weighted);
  const double size = std::sqrt(Dot(z, weighted));
  for (std::size_t i = 0; i < z.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) z[i].v[c] /= size, weighted[i].v[c] /= size;
  }
  ++motion_count_;
  return true;
}

}  // namespace palpate::fem
