#include "slave/reference/membrane/pressed_membrane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "slave/reference/membrane/neo_hookean_disc.h"

namespace palpate::simulation {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNearlyIncompressible = 0.499;
constexpr double kDeepest = 0.5;    // of the radius
constexpr double kResidual = 1e-6;  // of the load
// Residual of thin sheets, of the load, from which rounding may prevent a further reduction.
// [measured: 1.4e-6 at a thickness of 1/390 of the radius]
constexpr double kRounded = 1e-5;
constexpr double kWorthwhile = 0.3;  // reduction of the residual by one step
constexpr double kTouching = 1e-9;   // tolerance relative to the depth and to the largest force
constexpr double kNear = 0.5;        // relative residual up to which a factor is reused
constexpr int kNewtonSteps = 60, kFactors = 12, kHalvings = 6;

void Require(bool good, const std::string& what) {
  if (!good) throw std::invalid_argument(what);
}

bool Within(double value, double low, double high) {
  return value >= low && value <= high;
}

void CheckParameters(const MembraneGeometry& geometry, const Material& material, double width,
                     const Vector2d& p_O, const MembraneResolution& resolution, double prestress) {
  const double a = geometry.radius, t = geometry.thickness;
  Require(a > 0 && std::isfinite(a),
          fmt::format("object.geometry.membrane.radius = {} m: expected > 0", a));
  Require(Within(t, a / 400, a / 10),
          fmt::format("object.geometry.membrane.thickness = {} m: expected {} to {} m (radius / "
                      "400 to radius / 10)",
                      t, a / 400, a / 10));
  Require(
      material.young_modulus > 0 && std::isfinite(material.young_modulus),
      fmt::format("object.material.young_modulus = {} Pa: expected > 0", material.young_modulus));
  Require(material.poisson_ratio > -1 && material.poisson_ratio <= 0.5,
          fmt::format("object.material.poisson_ratio = {}: expected -1 < nu <= 0.5",
                      material.poisson_ratio));
  Require(Within(width, std::max(t, a / 50), a),
          fmt::format("tool.width = {} m: expected {} to {} m (the thickness, at least radius / "
                      "50, to the radius)",
                      width, std::max(t, a / 50), a));
  Require(p_O.norm() + width / 2 <= 0.95 * a,
          fmt::format("a tool of width {} m at ({}, {}) m does not fit inside the rim: expected "
                      "a tool that stays within {} m of the centre",
                      width, p_O.x(), p_O.y(), 0.95 * a));
  const double most = 0.5 * material.young_modulus * t;
  Require(Within(prestress, 0, most),
          fmt::format("model.prestress = {} N/m: expected 0 to {} N/m (half of young_modulus times "
                      "thickness)",
                      prestress, most));
  Require(resolution.across == 0 || Within(resolution.across, 4, 40),
          fmt::format("across = {}: expected 0, or 4 to 40", resolution.across));
  Require(resolution.through == 0 || Within(resolution.through, 1, 4),
          fmt::format("through = {}: expected 0, or 1 to 4", resolution.through));
}

NestedCircles CirclesOf(double radius, double width, const Vector2d& p_O) {
  const double p = p_O.norm() / radius;
  return {1, width / (2 * radius), p > 1e-9 ? p : 0};
}

DiscMesh::Size SizeOf(const MembraneResolution& resolution, const NestedCircles& circles) {
  // Tool width above which the membrane bends only near the tool's edge.
  constexpr double kWide = 0.1;
  const int across = resolution.across > 0 ? resolution.across : 8;
  const int inner = std::max(1, across / 5), rays = std::max(4, across * 4 / 5);
  return {circles.tool > kWide ? inner + 1 : inner, across - inner,
          circles.eccentricity == 0 ? (rays + 1) / 2 : rays,
          resolution.through > 0 ? resolution.through : 1};
}

// Contact without adhesion: forces f >= 0 with C f >= missing, equal where f > 0. Minimises f^T C f
// / 2 - f^T missing: places are pushed one after another, those with the largest deficit first, and
// released if they would pull (Lawson and Hanson, Solving Least Squares Problems, ch. 23). False: C
// is not positive definite.
bool Push(const MatrixXd& C, const VectorXd& missing, VectorXd* forces) {
  const double slack = kTouching * missing.cwiseAbs().maxCoeff();
  std::vector<int> pushed;
  for (int k = 0; k < forces->size(); ++k) {
    if ((*forces)[k] > 0) pushed.push_back(k);
    (*forces)[k] = std::max(0.0, (*forces)[k]);
  }
  for (int round = 0; round < 10 * forces->size() + 10; ++round) {
    while (!pushed.empty()) {
      const Eigen::LLT<MatrixXd> factor(C(pushed, pushed));
      if (factor.info() != Eigen::Success) return false;
      const VectorXd wanted = factor.solve(missing(pushed));
      const VectorXd present = (*forces)(pushed);
      double way = 1;
      for (Eigen::Index i = 0; i < wanted.size(); ++i) {
        if (wanted[i] <= 0) way = std::min(way, present[i] / (present[i] - wanted[i]));
      }
      (*forces)(pushed) = present + way * (wanted - present);
      if (way == 1) break;
      std::erase_if(pushed, [&](int k) {
        const bool let_go = (*forces)[k] <= kTouching * forces->maxCoeff();
        if (let_go) (*forces)[k] = 0;
        return let_go;
      });
    }
    Eigen::Index next = 0;
    if (!((missing - C * *forces).maxCoeff(&next) > slack)) return true;
    pushed.push_back(static_cast<int>(next));
  }
  return false;
}

}  // namespace

// Nondimensional: lengths are divided by the radius a, stresses by E.
struct PressedMembrane::Continuation {
  struct State {
    double depth = 0;  // of the tool, along -z
    VectorXd forces;   // of the tool, along -z, one per column of `loads`
    VectorXd u;
  };

  Continuation(const MembraneGeometry& geometry, const Material& material, double width,
               const Vector2d& p_O, const MembraneResolution& resolution, double prestress,
               ToolFace face);
  void PlaceLoads(ToolFace face);
  bool Reach(double depth, int halvings);
  std::optional<State> Solve(double depth);
  bool Linearise(const VectorXd& u);
  [[nodiscard]] State Predict(double depth) const;
  [[nodiscard]] VectorXd DepthsAt(const VectorXd& u) const;
  void Record();

  double length, force_unit;
  DiscMesh mesh;
  NeoHookeanDisc solid;
  NeoHookeanDisc::Matrix stiffness;
  SparseLdlt<double> factor;
  // Loads of the tool: one uniform load on the whole face, or one per node below a rigid tool.
  MatrixXd loads;  // one column per unit load, along -z
  std::vector<int>
      touched;          // for each load the unknown along z that moves with the tool in contact
  MatrixXd by_loads;    // stiffness^-1 loads
  MatrixXd compliance;  // depth at the row's place under the column's unit load
  std::vector<State> states;  // the last three, the newest at the end
  std::vector<MembraneFace::Source> sources;
  MembranePress press;
};

PressedMembrane::Continuation::Continuation(const MembraneGeometry& geometry,
                                            const Material& material, double width,
                                            const Vector2d& p_O,
                                            const MembraneResolution& resolution, double prestress,
                                            ToolFace face)
    : length(geometry.radius),
      force_unit(material.young_modulus * length * length),
      mesh(CirclesOf(length, width, p_O), geometry.thickness / length,
           SizeOf(resolution, CirclesOf(length, width, p_O))),
      solid(mesh, std::min(material.poisson_ratio, kNearlyIncompressible),
            prestress / (material.young_modulus * geometry.thickness)),
      stiffness(solid.EmptyMatrix()),
      factor(stiffness) {
  factor.Allocate(stiffness);
  PlaceLoads(face);
  states.push_back({0, VectorXd::Zero(loads.cols()), VectorXd::Zero(solid.size())});
  auto inner = std::make_shared<MembraneFace>(mesh, p_O, length);
  sources = inner->Sources();
  press.nodes_O = inner->Nodes();
  press.triangles = inner->Triangles();
  press.face = std::move(inner);
  Record();
}

// Each load acts on one of two or four equal sectors.
void PressedMembrane::Continuation::PlaceLoads(ToolFace face) {
  const int outer = mesh.levels() - 1;
  touched = {solid.unknown(mesh.column(0, 0), outer, 2)};
  if (face == ToolFace::kEven) {
    loads = solid.ToolLoad();
    return;
  }
  for (int circle = 1; circle <= DiscMesh::kAcross * mesh.inner_rings(); ++circle) {
    for (int ray = 0; ray < mesh.ray_lines(); ++ray) {
      touched.push_back(solid.unknown(mesh.column(circle, ray), outer, 2));
    }
  }
  loads.setZero(solid.size(), static_cast<Eigen::Index>(touched.size()));
  for (std::size_t k = 0; k < touched.size(); ++k) {
    loads(touched[k], static_cast<Eigen::Index>(k)) = mesh.is_quarter() ? -0.25 : -0.5;
  }
}

VectorXd PressedMembrane::Continuation::DepthsAt(const VectorXd& u) const {
  return -u(touched);
}

// Polynomial through the last states.
PressedMembrane::Continuation::State PressedMembrane::Continuation::Predict(double depth) const {
  State guess{depth, VectorXd::Zero(loads.cols()), VectorXd::Zero(solid.size())};
  for (const State& state : states) {
    double weight = 1;
    for (const State& other : states) {
      if (&other != &state) weight *= (depth - other.depth) / (state.depth - other.depth);
    }
    guess.forces += weight * state.forces;
    guess.u += weight * state.u;
  }
  return guess;
}

// Newton's method for displacements and the forces that bring the tool to its depth. Evaluating
// forces takes a fiftieth of a factorisation, so a factor is reused while it reduces the residual.
std::optional<PressedMembrane::Continuation::State> PressedMembrane::Continuation::Solve(
    double depth) {
  State state = Predict(depth);
  VectorXd residual;
  double last = 0;
  int factors = 0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    if (!solid.Forces(state.u, &residual)) return std::nullopt;
    const VectorXd applied = loads * state.forces;
    residual = applied - residual;
    const double norm = residual.norm(), whole = applied.norm();
    if (step > 0 && norm <= kResidual * whole) return state;
    if (step > 0 && norm <= kRounded * whole && norm > kWorthwhile * last) return state;
    if (factors == 0 || norm > kWorthwhile * last || norm > kNear * whole) {
      if (++factors > kFactors || !Linearise(state.u)) return std::nullopt;
    }
    last = norm;
    factor.Solve(&residual);
    state.u += residual - by_loads * state.forces;  // the right-hand side without the tool
    const VectorXd missing = depth - DepthsAt(state.u).array();
    if (!Push(compliance, missing, &state.forces)) return std::nullopt;
    state.u += by_loads * state.forces;
    if (!state.u.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

// Also computes the displacements under unit loads.
bool PressedMembrane::Continuation::Linearise(const VectorXd& u) {
  VectorXd forces;
  if (!solid.Linearise(u, &forces, &stiffness) || !factor.Factorize(stiffness, false)) return false;
  by_loads = loads;
  factor.Solve(by_loads);
  compliance = -by_loads(touched, Eigen::all);
  return true;
}

bool PressedMembrane::Continuation::Reach(double depth, int halvings) {
  if (auto state = Solve(depth)) {
    if (states.size() == 3) states.erase(states.begin());
    states.push_back(std::move(*state));
    return true;
  }
  if (halvings == 0) return false;
  const double middle = 0.5 * (states.back().depth + depth);
  return Reach(middle, halvings - 1) && Reach(depth, halvings - 1);
}

void PressedMembrane::Continuation::Record() {
  const State& state = states.back();
  auto depth_step = std::make_shared<MembraneDepthStep>();
  depth_step->depth = state.depth * length;
  depth_step->force = -state.forces.sum() * force_unit;
  depth_step->displacements_O.reserve(sources.size());
  for (const auto& source : sources) {
    const int column = mesh.column(source.circle, source.ray);
    Vector3d u = Vector3d::Zero();
    if (column < mesh.free_columns()) u = state.u.segment<3>(solid.unknown(column, 0, 0));
    const Vector3d u_O = press.face->Turned({source.x * u.x(), source.y * u.y(), u.z()});
    depth_step->displacements_O.emplace_back((length * u_O).cast<float>());
  }
  press.depth_steps.push_back(std::move(depth_step));
}

PressedMembrane::PressedMembrane(const MembraneGeometry& geometry, const Material& material,
                                 double width, const Vector2d& p_O,
                                 const MembraneResolution& resolution, double prestress,
                                 ToolFace face) {
  CheckParameters(geometry, material, width, p_O, resolution, prestress);
  continuation_ =
      std::make_unique<Continuation>(geometry, material, width, p_O, resolution, prestress, face);
}

PressedMembrane::~PressedMembrane() = default;

bool PressedMembrane::Deepen(double depth) {
  if (!(depth > continuation_->press.depth_steps.back()->depth &&
        depth <= kDeepest * continuation_->length)) {
    return false;
  }
  auto before = continuation_->states;
  if (!continuation_->Reach(depth / continuation_->length, kHalvings)) {
    continuation_->states = std::move(before);
    return false;
  }
  continuation_->Record();
  return true;
}

const MembranePress& PressedMembrane::press() const {
  return continuation_->press;
}

}  // namespace palpate::simulation
