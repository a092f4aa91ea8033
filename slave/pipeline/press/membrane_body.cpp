#include "slave/pipeline/press/membrane_body.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "slave/checks/load/load_checks.h"
#include "slave/checks/points/noise_limits.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Pressure of the air [Pa]. [by definition]
constexpr double kAtmosphere = 101'325;
// Number of rings of triangles around the top [-], and of triangles across the tool [-]. [tuned:
// domed_scene_test]
constexpr int kMinRings = 10, kMaxRings = 24;
constexpr double kTrianglesUnderTool = 3;  // [-] [tuned: domed_scene_test]
// Relative sigma of the force [-]: error of the membrane law, and error by the rotation of the
// surface at the deepest indentation that is not extrapolated. [recorded: membrane_press_rgbd,
// whose forces are 5 to 10 % low because its air responds sooner than enclosed air]
constexpr double kLawShare = 0.09, kTurningShare = 0.08;

// `seconds`: duration of the precomputation.
MembranePress MakePress(InflatedMembrane membrane, double patch, double* seconds) {
  MembranePress::Params params;
  params.patch = patch;
  const auto start = std::chrono::steady_clock::now();
  MembranePress press(std::move(membrane), params);
  *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return press;
}

}  // namespace

MembraneBody::MembraneBody(InflatedMembrane membrane, double patch,
                           const std::optional<Ellipsoid>& rest)
    : press_(MakePress(std::move(membrane), patch, &info_.precompute_s)),
      contact_(surface()),
      patch_(patch),
      checks_(MakeDomeChecks(rest)) {
  info_.kind = "membrane";
  info_.dof = 3 * (surface().nodes.size() - press_.membrane().held().size());
  info_.elements = static_cast<int>(surface().triangles.size());
  info_.memory_bytes = sizeof(double) * surface().nodes.size() * surface().nodes.size();
  info_.remark = "linear about the rest shape";
}

SurfaceLoad MembraneBody::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  const auto& estimate = press_.Fit(points_O);
  load_ = {};
  FitSample sample{.points_O = points_O, .load = load_, .sigma = estimate.sigma};
  if (!estimate.found) {
    load_.Set({Validity::kTrackingLost, FailedCheck::kNone,
               "too few points of the membrane are in view"});
    const Verdict& found = checks_.Examine(sample).verdict;
    load_.Add({Validity::kTrackingLost, found.check, found.reason});
    return load_;
  }
  load_.p_O = estimate.p_O;
  load_.n_O = estimate.n_O;
  load_.sigma_force = estimate.sigma_force;
  load_.sigma_place = estimate.sigma_place;
  load_.residual = estimate.residual;
  load_.validity = Validity::kValid;
  if (estimate.force > NoiseLimits::kSignificant * estimate.sigma_force) {
    load_.force = -estimate.force;
    load_.depth = estimate.depth;
    const double turning = kTurningShare * load_.depth / (patch_ / 2);
    const double own = std::max(1.0, estimate.residual) * estimate.sigma_force;
    load_.sigma_force = std::hypot(own, std::hypot(kLawShare, turning) * load_.force);
  }
  if (load_.depth > patch_ / 2) {
    sample.beyond_range = "the indentation is deeper than half the width of the tool's contact";
  }
  sample.deepest = load_.depth;
  load_.Take(checks_.Examine(sample));
  return load_;
}

LoadIdentifier::Press MembraneBody::PressAt(const Eigen::Vector3d& p_O, double depth) noexcept {
  Press press;
  if (!std::isfinite(depth)) return press;
  const auto place = contact_.Find(p_O, std::numeric_limits<double>::infinity());
  if (!place) return press;
  const double give =
      press_.compliance().At(surface().triangles[Index(place->triangle)], place->weights);
  if (!(give > 0)) return press;  // the compliance on the rim is zero
  press.stiffness = 1 / give;
  press.force = std::max(0.0, depth) / give;
  press.valid = true;
  return press;
}

void MembraneBody::Nearest(const Eigen::Vector3d& p_O_tip, Eigen::Vector3d* p_O,
                           Eigen::Vector3d* n_O) const noexcept {
  const auto place = contact_.Find(p_O_tip, std::numeric_limits<double>::infinity());
  *p_O = place ? place->p_O : surface().nodes.front();
  *n_O = Eigen::Vector3d::UnitZ();
  if (!place) return;
  n_O->setZero();
  const auto& corners = surface().triangles[Index(place->triangle)];
  for (int k = 0; k < 3; ++k) {
    *n_O += place->weights[k] * press_.membrane().normals()[Index(corners[Index(k)])];
  }
  n_O->normalize();
}

void MembraneBody::NodalForces(std::vector<Eigen::Vector3d>* f_O) {
  f_O->assign(surface().nodes.size(), Eigen::Vector3d::Zero());
  if (load_.force == 0) return;
  const SurfacePlace& place = press_.place();
  const auto& corners = surface().triangles[Index(place.triangle)];
  for (int k = 0; k < 3; ++k) {
    for (const auto& share : press_.compliance().shares(corners[Index(k)])) {
      const auto node = Index(share.node);
      (*f_O)[node] +=
          place.weights[k] * share.share * load_.force * press_.membrane().normals()[node];
    }
  }
}

namespace {

Ellipsoid EllipsoidOf(const DomeGeometry& dome) {
  Ellipsoid ellipsoid;
  ellipsoid.semi_axes = dome.semi_axes.asDiagonal();
  ellipsoid.centre.z() = dome.inflation - dome.semi_axes.z();
  return ellipsoid;
}

// Returns about half of the arc from rim to rim over the top.
double HalfArc(const DomeGeometry& dome) {
  const double down = 1 - dome.inflation / dome.semi_axes.z();
  const double rim = std::sqrt(1 - down * down) * dome.semi_axes.head<2>().maxCoeff();
  return std::hypot(rim, std::numbers::pi / 2 * dome.inflation);
}

}  // namespace

std::unique_ptr<LoadIdentifier> MakeMembraneBody(const Scene& scene) {
  const auto& dome = std::get<DomeGeometry>(scene.object.geometry);
  const double width = scene.tool ? scene.tool->width : 0;
  const double across = kTrianglesUnderTool * HalfArc(dome) / width;
  if (!(across <= 1.5 * kMaxRings)) {
    throw std::invalid_argument(
        fmt::format("tool.width = {:.3g} m: for a domed membrane of this size, expected {:.3g} m "
                    "or more, which its triangles resolve",
                    width, kTrianglesUnderTool * HalfArc(dome) / (1.5 * kMaxRings)));
  }
  const int rings = std::clamp(static_cast<int>(std::ceil(across)), kMinRings, kMaxRings);
  const Ellipsoid ellipsoid = EllipsoidOf(dome);
  const MembraneShape shape = MeshDomedMembrane(ellipsoid, Eigen::Vector3d::UnitZ(), 0, rings);
  const Material& material = scene.object.material;
  InflatedMembrane::Params params{.modulus = material.young_modulus * dome.thickness,
                                  .poisson_ratio = material.poisson_ratio,
                                  .tension = scene.model.prestress};
  if (dome.air > 0) {
    const double gauge = InflatedMembrane(shape, params).pressure();
    params.air_stiffness = (kAtmosphere + gauge) / dome.air;
  }
  return std::make_unique<MembraneBody>(InflatedMembrane(shape, params), width, ellipsoid);
}

void MembraneBody::Displacements(std::vector<Eigen::Vector3d>* u_O) {
  std::vector<Eigen::Vector3d> forces;
  NodalForces(&forces);
  press_.membrane().Displace(forces, u_O);
}

}  // namespace palpate
