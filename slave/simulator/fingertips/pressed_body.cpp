#include "slave/simulator/fingertips/pressed_body.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mesh/index.h"
#include "slave/reference/solid/neo_hookean_body.h"
#include "slave/simulator/fingertips/finger_hand.h"

namespace palpate::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kResidual = 1e-5;  // of the reactions
constexpr double kRoughly = 1e-2;   // the same while the touching nodes are still being determined
// Relative to the body: bonded nodes closer than this have reached their goal.
constexpr double kInPlace = 1e-12;
constexpr int kMaxSteps = 30;         // of Newton's method
constexpr int kMaxLineHalvings = 10;  // of one of them
constexpr double kLess = 1e-4;  // smallest decrease of the residual relative to the step's length
constexpr double kPenetration = 2e-3;  // penetration that still counts as touching [radii]
// Pull relative to the largest reaction above which a node is released.
constexpr double kPull = 1e-3;
constexpr int kMaxPasses = 12;  // rounds of determining the touching nodes

double LargerSide(const SiteMesh& mesh) {
  if (mesh.elements.empty()) throw std::invalid_argument("mesh: expected at least one element");
  Eigen::Array3d low = mesh.nodes.front(), high = low;
  for (const auto& p : mesh.nodes) low = low.min(p.array()), high = high.max(p.array());
  return (high - low).maxCoeff();
}

// Sorts the nodes and removes duplicates.
void SortOut(std::vector<int>* nodes) {
  std::ranges::sort(*nodes);
  nodes->erase(std::ranges::unique(*nodes).begin(), nodes->end());
}

std::vector<int> NodesOf(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<int> nodes;
  for (const auto& triangle : triangles) {
    nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  }
  SortOut(&nodes);
  return nodes;
}

// Returns the elements with renumbered nodes. The energy of each point is proportional to its
// modulus, hence its weight.
std::vector<PlacedElement> Placed(const SiteMesh& mesh, double unit, const std::vector<int>& number,
                                  const PressedBody::Modulus& modulus) {
  std::vector<PlacedElement> elements;
  Eigen::MatrixXd places(3, mesh.shape->nodes());
  for (std::vector<int> nodes : mesh.elements) {
    Eigen::Index column = 0;
    for (int& node : nodes) {
      places.col(column++) = mesh.nodes[Index(node)] / unit;
      node = number[Index(node)];
    }
    PlacedElement element(*mesh.shape, places, std::move(nodes));
    for (Eigen::Index q = 0; modulus && q < element.weights.size(); ++q) {
      element.weights[q] *= modulus(unit * (places * mesh.shape->values.col(q)));
    }
    elements.push_back(std::move(element));
  }
  return elements;
}

// Neighbours of every node, itself included.
std::vector<std::vector<int>> NeighboursOf(const SiteMesh& mesh) {
  std::vector<std::vector<int>> neighbours(mesh.nodes.size());
  for (const auto& nodes : mesh.elements) {
    for (const int node : nodes) {
      auto& list = neighbours[Index(node)];
      list.insert(list.end(), nodes.begin(), nodes.end());
    }
  }
  for (auto& list : neighbours) SortOut(&list);
  return neighbours;
}

// Numbering of nodes: movable nodes in the order of elimination, then the others.
struct Numbering {
  Numbering(const SiteMesh& mesh, const PressedBody::Held& held) : number(mesh.nodes.size()) {
    const auto stays = [&](int node) { return held[Index(node)] == std::array{true, true, true}; };
    std::vector<int> order = EliminationOrder(NeighboursOf(mesh));
    free_nodes = static_cast<int>(std::ranges::stable_partition(order, std::not_fn(stays)).begin() -
                                  order.begin());
    for (std::size_t i = 0; i < order.size(); ++i) number[Index(order[i])] = static_cast<int>(i);
  }
  std::vector<int> number;  // per node
  int free_nodes = 0;
};

// A node that sticks to a finger.
struct Bond {
  int finger = -1;  // -1: free
  Vector3d p_F{0, 0, 0};
  bool was_released = false;  // during this press
};

}  // namespace

struct PressedBody::Solver {
  Solver(const SiteMesh& site_mesh, const Held& held, double E, double nu, double finger_radius,
         const Modulus& modulus)
      : unit(LargerSide(site_mesh)),
        force_unit(E * unit * unit),
        nodes(site_mesh.nodes),
        numbering(site_mesh, held),
        body(Placed(site_mesh, unit, numbering.number, modulus), numbering.free_nodes,
             NeoHookean(nu, 0)),
        stiffness(body.EmptyMatrix()),
        factor(stiffness),
        finger{.radius = finger_radius},
        touchable(NodesOf(site_mesh.triangles)),
        scene_free(VectorXd::Ones(body.size())),
        bonds(nodes.size()) {
    factor.Allocate(stiffness);
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      if (!moves(static_cast<int>(node))) continue;
      for (int c = 0; c < 3; ++c) {
        if (held[node][Index(c)]) scene_free[first(static_cast<int>(node)) + c] = 0;
      }
    }
    std::erase_if(touchable,
                  [&](int node) { return !moves(node) || scene_free[first(node)] == 0; });
    x = forces = goal = VectorXd::Zero(body.size());
    free = scene_free;
  }

  [[nodiscard]] bool moves(int node) const {
    return numbering.number[Index(node)] < numbering.free_nodes;
  }
  [[nodiscard]] int first(int node) const { return 3 * numbering.number[Index(node)]; }
  [[nodiscard]] Vector3d Displacement(int node) const {  // frame O [m]
    if (!moves(node)) return Vector3d::Zero();
    return unit * x.segment<3>(first(node));
  }
  [[nodiscard]] Vector3d ForceOn(int node) const {  // of the finger [N]
    return force_unit * forces.segment<3>(first(node));
  }

  void Fix(std::span<const FingerPlacement> fingers);
  bool Balance(double residual);
  bool Step(const VectorXd& step, bool is_fixed_moving);
  bool Capture(std::span<const FingerPlacement> fingers);
  bool Release(std::span<const FingerPlacement> fingers);
  bool Settle(std::span<const FingerPlacement> fingers);

  double unit;        // [m]
  double force_unit;  // [N]
  std::vector<Vector3d> nodes;
  Numbering numbering;
  NeoHookeanBody body;
  NeoHookeanBody::Matrix stiffness;
  SparseLdlt<double> factor;
  RigidFinger finger;
  std::vector<int> touchable;
  // 0 for components that the scene (for `free` also a finger) fixes, else 1.
  VectorXd scene_free, free;
  VectorXd goal;            // prescribed displacements of nodes bonded to fingers
  VectorXd x, forces;       // displacements and forces
  std::vector<Bond> bonds;  // per node
  std::vector<FingerPlacement> placed;
};

// Prescribes the motion of nodes that are bonded to fingers.
void PressedBody::Solver::Fix(std::span<const FingerPlacement> fingers) {
  free = scene_free;
  for (const int node : touchable) {
    const Bond& bond = bonds[Index(node)];
    if (bond.finger < 0) continue;
    const Vector3d target = fingers[Index(bond.finger)].X_OF * bond.p_F;
    goal.segment<3>(first(node)) = (target - nodes[Index(node)]) / unit;
    free.segment<3>(first(node)).setZero();
  }
}

// Newton's method from x.
bool PressedBody::Solver::Balance(double residual) {
  for (int step = 0; step < kMaxSteps; ++step) {
    if (!body.Linearise(x, &forces, &stiffness)) return false;
    VectorXd move = (1 - free.array()) * scene_free.array() * (goal - x).array();
    const bool is_moving = !move.isZero(kInPlace);
    const VectorXd left = forces.cwiseProduct(free);
    if (!is_moving && left.norm() <= residual * (forces - left).norm()) return true;
    VectorXd right = -(forces + stiffness.selfadjointView<Eigen::Upper>() * move);
    right = right.cwiseProduct(free) + move;
    NeoHookeanBody::Hold(free, &stiffness);
    if (!factor.Factorize(stiffness, false)) return false;
    factor.Solve(&right);
    if (!right.allFinite() || !Step(right, is_moving)) return false;
  }
  return false;
}

// Shortens the step until no element is inverted and, once all prescribed nodes are in place, the
// residual falls.
bool PressedBody::Solver::Step(const VectorXd& step, bool is_fixed_moving) {
  const double before = forces.cwiseProduct(free).norm();
  double length = 1;
  for (int i = 0; i < kMaxLineHalvings; ++i, length *= 0.5) {
    const VectorXd trial = x + length * step;
    if (!body.Forces(trial, &forces)) continue;
    const double after = forces.cwiseProduct(free).norm();
    if (!is_fixed_moving && !(after <= (1 - kLess * length) * before)) continue;
    x = trial;
    return true;
  }
  return false;
}

// Free nodes that are inside a finger stick to it.
bool PressedBody::Solver::Capture(std::span<const FingerPlacement> fingers) {
  bool any = false;
  for (std::size_t f = 0; f < fingers.size(); ++f) {
    const Isometry3d X_FO = fingers[f].X_OF.inverse();
    const Vector3d direction_F = X_FO.linear() * fingers[f].approach_O;
    for (const int node : touchable) {
      Bond& bond = bonds[Index(node)];
      if (bond.finger >= 0) continue;
      const Vector3d p_F = X_FO * (nodes[Index(node)] + Displacement(node));
      if (finger.Distance(p_F) > -kPenetration * finger.radius) continue;
      bond.finger = static_cast<int>(f);
      bond.p_F = finger.PushOut(p_F, direction_F);
      any = true;
    }
  }
  return any;
}

// Releases bonds that pull, each at most once; a bond that was restored remains.
bool PressedBody::Solver::Release(std::span<const FingerPlacement> fingers) {
  double largest = 0;
  for (const int node : touchable) {
    if (bonds[Index(node)].finger >= 0) largest = std::max(largest, ForceOn(node).norm());
  }
  bool any = false;
  for (const int node : touchable) {
    Bond& bond = bonds[Index(node)];
    if (bond.finger < 0 || bond.was_released) continue;
    const Vector3d n_O = fingers[Index(bond.finger)].X_OF.linear() * finger.Normal(bond.p_F);
    if (ForceOn(node).dot(n_O) >= -kPull * largest) continue;
    bond.finger = -1;
    bond.was_released = true;
    any = true;
  }
  return any;
}

bool PressedBody::Solver::Settle(std::span<const FingerPlacement> fingers) {
  for (Bond& bond : bonds) bond.was_released = false;
  placed.assign(fingers.begin(), fingers.end());
  const auto balance = [&](double residual) {
    Fix(fingers);
    return Balance(residual);
  };
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (!balance(kRoughly)) return false;
    if (Capture(fingers)) continue;
    if (!balance(kResidual)) return false;
    const bool captured = Capture(fingers), released = Release(fingers);
    if (!captured && !released) return true;
  }
  return balance(kResidual);
}

PressedBody::PressedBody(const SiteMesh& mesh, const Held& held, double young_modulus,
                         double poisson_ratio, double finger_radius, const Modulus& modulus)
    : solver_(std::make_unique<Solver>(mesh, held, young_modulus, poisson_ratio, finger_radius,
                                       modulus)) {}

PressedBody::~PressedBody() = default;

bool PressedBody::Press(std::span<const FingerPlacement> fingers) {
  Solver& s = *solver_;
  const VectorXd x = s.x, forces = s.forces;
  const std::vector<Bond> bonds = s.bonds;
  const std::vector<FingerPlacement> placed = s.placed;
  if (s.Settle(fingers)) return true;
  s.x = x;
  s.forces = forces;
  s.bonds = bonds;
  s.placed = placed;
  return false;
}

FingerTouch PressedBody::TouchOf(int finger) const {
  const Solver& s = *solver_;
  FingerTouch touch;
  Vector3d middle(0, 0, 0);
  double weight = 0, spread = 0;
  const auto each = [&](const auto& visit) {
    for (const int node : s.touchable) {
      const Bond& bond = s.bonds[Index(node)];
      if (bond.finger == finger) visit(node, bond, s.finger.Normal(bond.p_F));
    }
  };
  each([&](int node, const Bond& bond, const Vector3d& n_F) {
    const Eigen::Matrix3d R_OF = s.placed[Index(finger)].X_OF.linear();
    const double push = std::max(s.ForceOn(node).dot(R_OF * n_F), 0.0);
    touch.force_O += s.ForceOn(node);
    middle += push * bond.p_F;
    weight += push;
    touch.depth = std::max(touch.depth, s.Displacement(node).dot(R_OF * n_F));
  });
  if (!(weight > 0)) return touch;
  touch.touching = true;
  middle /= weight;
  each([&](int node, const Bond& bond, const Vector3d& n_F) {
    const Eigen::Matrix3d R_OF = s.placed[Index(finger)].X_OF.linear();
    const double push = std::max(s.ForceOn(node).dot(R_OF * n_F), 0.0);
    spread += push / weight * (bond.p_F - middle).squaredNorm();
  });
  // A sphere's pressure over a disc of radius a (Hertz) has the mean square distance 2/5 a^2.
  touch.radius = std::sqrt(2.5 * spread);
  touch.p_F = middle - s.finger.Distance(middle) * s.finger.Normal(middle);
  return touch;
}

std::vector<Vector3d> PressedBody::Displacements() const {
  const Solver& s = *solver_;
  std::vector<Vector3d> displacements;
  displacements.reserve(s.nodes.size());
  for (int node = 0; node < static_cast<int>(s.nodes.size()); ++node) {
    displacements.push_back(s.Displacement(node));
  }
  return displacements;
}

}  // namespace palpate::simulation
