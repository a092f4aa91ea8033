#include "slave/reference/membrane/pressed_membrane.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "slave/reference/membrane/neo_hookean_disc.h"

namespace palpate::site {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNearlyIncompressible = 0.499;
constexpr double kDeepest = 0.5;     // of the radius
constexpr double kResidual = 1e-6;   // of the load
constexpr double kWorthwhile = 0.3;  // reduction of the residual by one step
constexpr double kNear = 0.5;        // of the load: a residual with which a factor may be kept
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
  constexpr double kWide = 0.1;  // a tool below which the membrane bends near its edge only
  const int across = resolution.across > 0 ? resolution.across : 8;
  const int inner = std::max(1, across / 5), rays = std::max(4, across * 4 / 5);
  return {circles.tool > kWide ? inner + 1 : inner, across - inner,
          circles.eccentricity == 0 ? (rays + 1) / 2 : rays,
          resolution.through > 0 ? resolution.through : 1};
}

}  // namespace

// Nondimensional: lengths by the radius a, stresses by E.
struct PressedMembrane::Continuation {
  struct State {
    double depth = 0, force = 0;  // both of the tool, along -z
    VectorXd u;
  };

  Continuation(const MembraneGeometry& geometry, const Material& material, double width,
               const Vector2d& p_O, const MembraneResolution& resolution, double prestress);
  bool Reach(double depth, int halvings);
  std::optional<State> Solve(double depth);
  bool Linearise(const VectorXd& u, VectorXd* by_load);
  [[nodiscard]] State Predict(double depth) const;
  void Record();

  double length, force_unit;
  DiscMesh mesh;
  NeoHookeanDisc solid;
  NeoHookeanDisc::Matrix stiffness;
  SparseLdlt<double> factor;
  VectorXd load;
  int touched;                // unknown: z of the outer face below the tool's centre
  std::vector<State> states;  // the last three, the newest at the end
  std::vector<MembraneFace::Source> sources;
  MembranePress press;
};

PressedMembrane::Continuation::Continuation(const MembraneGeometry& geometry,
                                            const Material& material, double width,
                                            const Vector2d& p_O,
                                            const MembraneResolution& resolution, double prestress)
    : length(geometry.radius),
      force_unit(material.young_modulus * length * length),
      mesh(CirclesOf(length, width, p_O), geometry.thickness / length,
           SizeOf(resolution, CirclesOf(length, width, p_O))),
      solid(mesh, std::min(material.poisson_ratio, kNearlyIncompressible),
            prestress / (material.young_modulus * geometry.thickness)),
      stiffness(solid.EmptyMatrix()),
      factor(stiffness),
      load(solid.ToolLoad()),
      touched(solid.unknown(mesh.column(0, 0), mesh.levels() - 1, 2)) {
  factor.Allocate(stiffness);
  states.push_back({0, 0, VectorXd::Zero(solid.size())});
  auto face = std::make_shared<MembraneFace>(mesh, p_O, length);
  sources = face->Sources();
  press.nodes_O = face->Nodes();
  press.triangles = face->Triangles();
  press.face = std::move(face);
  Record();
}

// Polynomial through the last states.
PressedMembrane::Continuation::State PressedMembrane::Continuation::Predict(double depth) const {
  State guess{depth, 0, VectorXd::Zero(solid.size())};
  for (const State& state : states) {
    double weight = 1;
    for (const State& other : states) {
      if (&other != &state) weight *= (depth - other.depth) / (state.depth - other.depth);
    }
    guess.force += weight * state.force;
    guess.u += weight * state.u;
  }
  return guess;
}

// Newton's method for displacements and the force that brings the tool to its depth. Forces cost a
// fiftieth of a factor, so a factor is kept as long as it brings the balance closer.
std::optional<PressedMembrane::Continuation::State> PressedMembrane::Continuation::Solve(
    double depth) {
  State state = Predict(depth);
  VectorXd residual, by_load;
  double last = 0;
  int factors = 0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    if (!solid.Forces(state.u, &residual)) return std::nullopt;
    residual = state.force * load - residual;
    const double norm = residual.norm() / load.norm(), applied = std::abs(state.force);
    if (step > 0 && norm <= kResidual * applied) return state;
    if (factors == 0 || norm > kWorthwhile * last || norm > kNear * applied) {
      if (++factors > kFactors || !Linearise(state.u, &by_load)) return std::nullopt;
    }
    last = norm;
    factor.Solve(&residual);
    const double force = (-depth - state.u[touched] - residual[touched]) / by_load[touched];
    state.force += force;
    state.u += residual + force * by_load;
    if (!state.u.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

// Also what a load of one does.
bool PressedMembrane::Continuation::Linearise(const VectorXd& u, VectorXd* by_load) {
  VectorXd forces;
  if (!solid.Linearise(u, &forces, &stiffness) || !factor.Factorize(stiffness, false)) return false;
  *by_load = load;
  factor.Solve(by_load);
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
  auto rung = std::make_shared<MembraneRung>();
  rung->depth = state.depth * length;
  rung->force = -state.force * force_unit;
  rung->displacements_O.reserve(sources.size());
  for (const auto& source : sources) {
    const int column = mesh.column(source.circle, source.ray);
    Vector3d u = Vector3d::Zero();
    if (column < mesh.free_columns()) u = state.u.segment<3>(solid.unknown(column, 0, 0));
    const Vector3d u_O = press.face->Turned({source.x * u.x(), source.y * u.y(), u.z()});
    rung->displacements_O.emplace_back((length * u_O).cast<float>());
  }
  press.rungs.push_back(std::move(rung));
}

PressedMembrane::PressedMembrane(const MembraneGeometry& geometry, const Material& material,
                                 double width, const Vector2d& p_O,
                                 const MembraneResolution& resolution, double prestress) {
  CheckParameters(geometry, material, width, p_O, resolution, prestress);
  continuation_ =
      std::make_unique<Continuation>(geometry, material, width, p_O, resolution, prestress);
}

PressedMembrane::~PressedMembrane() = default;

bool PressedMembrane::Deepen(double depth) {
  if (!(depth > continuation_->press.rungs.back()->depth &&
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

}  // namespace palpate::site
