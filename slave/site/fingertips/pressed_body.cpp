#include "slave/site/fingertips/pressed_body.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/site/fingertips/rigid_finger.h"

namespace palpate::site {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kResidual = 1e-5;     // of the reactions
constexpr double kPenetration = 2e-3;  // radii that count as touching, not as inside
constexpr double kPull = 1e-3;         // of the largest reaction that counts as pulling
constexpr int kMostPasses = 12;        // of who touches and who does not

double LargerSide(const SolidMesh& mesh) {
  if (mesh.nodes.empty()) throw std::invalid_argument("mesh: accepted is at least one tetrahedron");
  return palpate::LargerSide(mesh.nodes);
}

std::vector<int> NodesOf(const SurfaceMesh& surface) {
  std::vector<int> nodes;
  for (const auto& triangle : surface.triangles) {
    nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  }
  std::ranges::sort(nodes);
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
  return nodes;
}

Equilibrium::Options SolverOptions() {
  Equilibrium::Options options;
  options.residual = kResidual;
  return options;
}

// A node that sticks to a finger.
struct Bond {
  int finger = -1;  // -1: free
  Vector3d p_F{0, 0, 0};
  bool was_released = false;  // in this Press
};

}  // namespace

struct PressedBody::Solver {
  Solver(const SolidMesh& solid, const Held& held, double E, double nu, double finger_radius)
      : unit(LargerSide(solid)),
        mesh(MakeElementMesh(solid, FemOptions::Element::kTet4, unit)),
        layout(mesh, false),
        body(mesh, layout, MaterialLaw(FemOptions::Law::kNeoHookean, nu)),
        equilibrium(layout, body, SolverOptions()),
        finger{.radius = finger_radius},
        force_unit(E * unit * unit),
        touchable(NodesOf(mesh.surface)),
        bonds(solid.nodes.size()) {
    x = VectorXd::Zero(layout.size());
    balance.force = balance.given = x;
    balance.fixed.assign(Index(layout.size()), 0);
    for (int node = 0; node < mesh.node_count(); ++node) {
      for (int c = 0; c < 3; ++c) {
        balance.fixed[Index(layout.first(node) + c)] = held[Index(node)][Index(c)] ? 1 : 0;
      }
    }
    scene_fixed = balance.fixed;
    std::erase_if(touchable, [&](int node) { return scene_fixed[Index(layout.first(node))] != 0; });
    reactions = x;
  }

  [[nodiscard]] Vector3d Position(int node) const {  // deformed, frame O [m]
    return unit * (mesh.nodes[Index(node)] + x.segment<3>(layout.first(node)));
  }
  [[nodiscard]] Vector3d ForceOn(int node) const {  // of the finger [N]
    return force_unit * reactions.segment<3>(layout.first(node));
  }

  void Fix(std::span<const FingerPlacement> fingers);
  bool Solve(std::span<const FingerPlacement> fingers);
  bool Capture(std::span<const FingerPlacement> fingers);
  bool Release(std::span<const FingerPlacement> fingers);
  bool Settle(std::span<const FingerPlacement> fingers);

  double unit;  // [m]
  ElementMesh mesh;
  BlockLayout layout;
  ElasticBody body;
  Equilibrium equilibrium;
  RigidFinger finger;
  double force_unit;  // [N]
  std::vector<int> touchable;
  std::vector<char> scene_fixed;
  Balance balance;
  VectorXd x, reactions;
  std::vector<Bond> bonds;  // per node
  std::vector<FingerPlacement> placed;
  int factorisations = 0;
};

// Bonded nodes go with their fingers.
void PressedBody::Solver::Fix(std::span<const FingerPlacement> fingers) {
  balance.fixed = scene_fixed;
  for (const int node : touchable) {
    const Bond& bond = bonds[Index(node)];
    if (bond.finger < 0) continue;
    const int first = layout.first(node);
    const Vector3d target = fingers[Index(bond.finger)].X_OF * bond.p_F / unit;
    balance.given.segment<3>(first) = target - mesh.nodes[Index(node)];
    for (int c = 0; c < 3; ++c) balance.fixed[Index(first + c)] = 1;
  }
}

bool PressedBody::Solver::Solve(std::span<const FingerPlacement> fingers) {
  Fix(fingers);
  equilibrium.Changed();
  const bool solved = equilibrium.Solve(&balance, &x);
  factorisations += equilibrium.newton_steps();
  reactions = equilibrium.unbalanced();
  return solved;
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
      const Vector3d p_F = X_FO * Position(node);
      if (finger.Distance(p_F) > -kPenetration * finger.radius) continue;
      bond.finger = static_cast<int>(f);
      bond.p_F = finger.PushOut(p_F, direction_F);
      any = true;
    }
  }
  return any;
}

// Bonds that pull are given up, once: one that came back stays.
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
  if (!Solve(fingers)) return false;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const bool captured = Capture(fingers);
    if (captured && !Solve(fingers)) return false;
    const bool released = Release(fingers);
    if (released && !Solve(fingers)) return false;
    if (!captured && !released) break;
  }
  placed.assign(fingers.begin(), fingers.end());
  return true;
}

PressedBody::PressedBody(const SolidMesh& mesh, const Held& held, double young_modulus,
                         double poisson_ratio, double finger_radius)
    : solver_(std::make_unique<Solver>(mesh, held, young_modulus, poisson_ratio, finger_radius)) {}

PressedBody::~PressedBody() = default;

bool PressedBody::Press(std::span<const FingerPlacement> fingers) {
  Solver& s = *solver_;
  const VectorXd x = s.x, reactions = s.reactions;
  const std::vector<Bond> bonds = s.bonds;
  if (s.Settle(fingers)) return true;
  s.x = x;
  s.reactions = reactions;
  s.bonds = bonds;
  return false;
}

void PressedBody::Reset() {
  solver_->x.setZero();
  solver_->reactions.setZero();
  std::ranges::fill(solver_->bonds, Bond{});
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
    const Vector3d moved = s.unit * s.x.segment<3>(s.layout.first(node));
    touch.depth = std::max(touch.depth, moved.dot(R_OF * n_F));
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
  displacements.reserve(s.mesh.nodes.size());
  for (int node = 0; node < s.mesh.node_count(); ++node) {
    displacements.emplace_back(s.unit * s.x.segment<3>(s.layout.first(node)));
  }
  return displacements;
}

int PressedBody::factorisations() const {
  return solver_->factorisations;
}

}  // namespace palpate::site
