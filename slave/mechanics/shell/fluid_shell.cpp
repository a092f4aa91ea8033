#include "slave/mechanics/shell/fluid_shell.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kTool = 2, kHolder = 2;  // nodes that each of them moves
constexpr double kEven = 0.1;          // density of nodes in the middle, 1 at both edges: inverse
constexpr int kIterations = 40;
constexpr double kBalanced = 2e-10;  // largest component of the gradient
constexpr double kTangent = 1e-7;    // of the tool, to see what it changes
constexpr double kFirstStep = 0.25;  // of the wall
constexpr double kLeastStep = 1e-4;  // of the wall
constexpr double kMostMove = 0.02;   // of a node in one iteration, parts of R

void Require(bool good, const std::string& name, double value, const std::string& accepted) {
  if (good) return;
  throw std::invalid_argument(name + Formatted(" = %g", value) + ": accepted is " + accepted);
}

shell::Ends<double> EndsOf(const Vector2d& a, const Vector2d& b) {
  return {a.x(), a.y(), b.x(), b.y()};
}

shell::Triple<double> TripleOf(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  shell::Triple<double> x;
  x << a, b, c;
  return x;
}

}  // namespace

// Coordinates of node i, the unknowns' first; nodes of the tool and the holder have none.
struct FluidShell::System {
  VectorXd gradient;  // of the unknowns
  double tool = 0;    // of the tool's place along z
  std::vector<Eigen::Triplet<double>> entries;
  int nodes = 0;

  [[nodiscard]] int unknowns() const { return 2 * (nodes - kTool - kHolder) + 1; }
  [[nodiscard]] int First(int node) const {
    return node < kTool || node >= nodes - kHolder ? -1 : 2 * (node - kTool);
  }
  // What the unknowns must move by, as far as the energy is quadratic. False: nobody knows.
  [[nodiscard]] bool Newton(VectorXd* move) const {
    Eigen::SparseMatrix<double> H(gradient.size(), gradient.size());
    H.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(H);
    if (solver.info() != Eigen::Success) return false;
    *move = solver.solve(-gradient);
    return move->allFinite();
  }
  // Of nodes `node`, `node` + 1, ...
  template <int N>
  void Add(int node, const shell::Local<N>& local) {
    for (int i = 0; i < N; ++i) {
      const int first = First(node + i / 2);
      if (node + i / 2 < kTool && i % 2 == 1) tool += local.gradient(i);
      if (first < 0) continue;
      gradient(first + i % 2) += local.gradient(i);
      for (int k = 0; k < N; ++k) {
        const int other = First(node + k / 2);
        if (other >= 0) entries.emplace_back(first + i % 2, other + k % 2, local.hessian(i, k));
      }
    }
  }
};

FluidShell::FluidShell(const Params& params) : params_(params) {
  RequirePositive("radius", params.radius);
  RequirePositive("young_modulus", params.young_modulus);
  Require(params.wall > 0 && params.wall <= params.radius / 20, "wall", params.wall,
          "> 0, at most a twentieth of the radius");
  Require(params.poisson_ratio > -1 && params.poisson_ratio <= 0.5, "poisson_ratio",
          params.poisson_ratio, "-1 < nu <= 0.5");
  Require(params.tool_radius > 0 && params.tool_radius <= params.radius / 2, "tool_radius",
          params.tool_radius, "> 0, at most half the radius");
  Require(params.held_angle >= 0.05 && params.held_angle <= 2, "held_angle", params.held_angle,
          "0.05 to 2 rad");
  Require(params.pieces >= 20 && params.pieces <= 4000, "pieces", params.pieces, "20 to 4000");
  thin_ = params.wall / params.radius;
  LayOut();
  x_ = VectorXd::Zero(2 * (static_cast<Eigen::Index>(rest_.size()) - kTool - kHolder) + 1);
  for (std::size_t i = kTool; i + kHolder < rest_.size(); ++i) {
    x_.segment<2>(2 * static_cast<Eigen::Index>(i - kTool)) = rest_[i];
  }
  UpdateState(0);
}

// Nodes are dense where the wall bends: at the tool's edge and at the holder's.
void FluidShell::LayOut() {
  const double from = std::asin(params_.tool_radius / params_.radius);
  const double to = std::numbers::pi - params_.held_angle;
  const auto angle = [&](int i) {
    const double s = static_cast<double>(i) / params_.pieces;
    return from + (to - from) * (kEven * s + (1 - kEven) * s * s * (3 - 2 * s));
  };
  for (int i = -1; i <= params_.pieces + 1; ++i) {
    const int inside = std::clamp(i, 0, params_.pieces);
    const double mirrored = 2 * angle(inside) - angle(2 * inside - i);
    const double theta = i == inside ? angle(i) : mirrored;
    rest_.emplace_back(std::sin(theta), std::cos(theta));
  }
  for (std::size_t i = 0; i + 1 < rest_.size(); ++i) {
    const Vector2d along = rest_[i + 1] - rest_[i];
    const double r = 0.5 * (rest_[i].x() + rest_[i + 1].x());
    pieces_.push_back({along.norm(), r, shell::AlongParallel(along.x(), along.y(), r)});
    const bool is_free = i > 0 && i + 2 < rest_.size();
    if (is_free) volume_ += shell::VolumeWithin(EndsOf(rest_[i], rest_[i + 1]));
  }
  for (std::size_t i = 0; i + 2 < rest_.size(); ++i) {
    const auto x = TripleOf(rest_[i], rest_[i + 1], rest_[i + 2]);
    const double before = i > 0 ? pieces_[i].length : 0;
    const double after = i + 3 < rest_.size() ? pieces_[i + 1].length : 0;
    hinges_.push_back({shell::Turn(x), shell::Kappa2(x),
                       0.5 * (pieces_[i].length + pieces_[i + 1].length), 0.5 * (before + after),
                       rest_[i + 1].x()});
  }
}

FluidShell::Points FluidShell::At(const VectorXd& x, double depth) const {
  Points points = rest_;
  for (std::size_t i = 0; i < kTool; ++i) points[i].y() -= depth;
  for (std::size_t i = kTool; i + kHolder < points.size(); ++i) {
    points[i] = x.segment<2>(2 * static_cast<Eigen::Index>(i - kTool));
  }
  return points;
}

// Of W - p (V - V0).
void FluidShell::Assemble(const Points& points, double pressure, System* system) const {
  const double nu = params_.poisson_ratio;
  system->nodes = static_cast<int>(points.size());
  const int count = system->unknowns(), p = count - 1;
  system->gradient = VectorXd::Zero(count);
  system->tool = 0;
  system->entries.clear();
  double volume = 0;
  for (std::size_t i = 1; i + 2 < points.size(); ++i) {
    const auto ends = EndsOf(points[i], points[i + 1]);
    const shell::Piece& piece = pieces_[i];
    const auto wall = shell::Derive<4>(ends, [&](const auto& x) {
      using T = typename std::decay_t<decltype(x)>::Scalar;
      const T inside = shell::VolumeWithin<T>(x);
      return T(shell::Stretching<T>(x, piece, nu) - pressure * inside);
    });
    system->Add<4>(static_cast<int>(i), wall);
    if (!params_.filled) continue;
    volume += shell::VolumeWithin(ends);
    const auto liquid = shell::Derive<4>(ends, [](const auto& x) {
      using T = typename std::decay_t<decltype(x)>::Scalar;
      return shell::VolumeWithin<T>(x);
    });
    for (int k = 0; k < 4; ++k) {
      const int first = system->First(static_cast<int>(i) + k / 2);
      if (first < 0) continue;
      system->entries.emplace_back(first + k % 2, p, -liquid.gradient(k));
      system->entries.emplace_back(p, first + k % 2, -liquid.gradient(k));
    }
  }
  for (std::size_t i = 0; i < hinges_.size(); ++i) {
    const auto bend =
        shell::Derive<6>(TripleOf(points[i], points[i + 1], points[i + 2]), [&](const auto& x) {
          using T = typename std::decay_t<decltype(x)>::Scalar;
          return shell::Bending<T>(x, hinges_[i], nu, thin_);
        });
    system->Add<6>(static_cast<int>(i), bend);
  }
  if (params_.filled) {
    system->gradient(p) = volume_ - volume;
  } else {
    system->entries.emplace_back(p, p, 1.0);
  }
}

// By Newton's method; first along the tangent of the last equilibrium, as a wall that stood while
// the tool's edge moved by more than a piece would be folded.
bool FluidShell::Solve(double depth) {
  const Eigen::Index p = x_.size() - 1;
  const double last = state_.depth / params_.radius;
  VectorXd x = x_, move;
  System system;
  if (depth != last) {
    Assemble(At(x, last + kTangent), x(p), &system);
    if (!system.Newton(&move)) return false;
    x += (depth - last) / kTangent * move;
  }
  for (int i = 0; i < kIterations; ++i) {
    Assemble(At(x, depth), x(p), &system);
    if (!system.gradient.allFinite()) return false;
    if (system.gradient.cwiseAbs().maxCoeff() < kBalanced) {
      x_ = x;
      return true;
    }
    if (!system.Newton(&move)) return false;
    x += std::min(1.0, kMostMove / move.head(p).cwiseAbs().maxCoeff()) * move;
  }
  return false;
}

bool FluidShell::PressTo(double depth) {
  const double to = depth / params_.radius;
  double at = state_.depth / params_.radius, step = kFirstStep * thin_;
  while (at != to) {
    const double next = std::abs(to - at) <= step ? to : at + std::copysign(step, to - at);
    if (Solve(next)) {
      at = next;
      step *= 1.5;
      UpdateState(at);
    } else if ((step *= 0.5) < kLeastStep * thin_) {
      return false;
    }
  }
  return true;
}

void FluidShell::UpdateState(double depth) {
  const double R = params_.radius, stiffness = params_.young_modulus * params_.wall;
  const Points points = At(x_, depth);
  System system;
  Assemble(points, x_(x_.size() - 1), &system);
  state_.depth = R * depth;
  state_.force = -stiffness * R * system.tool;
  state_.pressure = stiffness / R * x_(x_.size() - 1);
  state_.meridian.clear();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) state_.meridian.push_back(R * points[i]);
}

double FluidShell::Volume() const {
  double volume = 0;
  for (std::size_t i = 0; i + 1 < state_.meridian.size(); ++i) {
    volume += shell::VolumeWithin(EndsOf(state_.meridian[i], state_.meridian[i + 1]));
  }
  return volume;
}

}  // namespace palpate
