#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "slave/checks/load/load_checks.h"
#include "slave/checks/points/noise_limits.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/load/triangle_search.h"
#include "slave/pipeline/load/volume_limits.h"
#include "slave/pipeline/local_model/contact_stiffness.h"
#include "slave/program/precompute_progress.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Messages why the load is unknown, one per completed tenth of the visible points.
constexpr std::array<std::string_view, 10> kComputing{
    "the model of the points in view is being computed, 0 %",
    "the model of the points in view is being computed, 10 %",
    "the model of the points in view is being computed, 20 %",
    "the model of the points in view is being computed, 30 %",
    "the model of the points in view is being computed, 40 %",
    "the model of the points in view is being computed, 50 %",
    "the model of the points in view is being computed, 60 %",
    "the model of the points in view is being computed, 70 %",
    "the model of the points in view is being computed, 80 %",
    "the model of the points in view is being computed, 90 %"};

class VolumeLoadIdentifier final : public LoadIdentifier {
 public:
  VolumeLoadIdentifier(const Scene& scene, double width, const ObjectMesh& mesh,
                       SurfaceMesh surface, Progress* progress)
      : surface_(std::move(surface)),
        model_(MakeModel(scene, mesh, progress_.Listen(progress))),
        contact_(surface_),
        stiffness_(scene, surface_, std::get_if<SolidMesh>(&mesh)),
        young_modulus_(scene.object.material.young_modulus),
        larger_side_(LargerSide(surface_.nodes)),
        width_(std::max(width, VolumeLimits::kMinWidth * larger_side_)),
        linear_(IsLinear(scene)),
        search_(surface_, VolumeLimits::kLinearLoad * young_modulus_ * larger_side_ * larger_side_,
                width_) {
    progress_.Finish();
  }

  SurfaceLoad Fit(const std::vector<SurfacePoint>& points_O) noexcept override;
  Press PressAt(const Vector3d& p_O, double depth) noexcept override;
  void Nearest(const Vector3d& p_O_tip, Vector3d* p_O, Vector3d* n_O) const noexcept override;
  [[nodiscard]] const SurfaceMesh& surface() const override { return surface_; }
  void Displacements(std::vector<Vector3d>* u_O) override;
  void NodalForces(std::vector<Vector3d>* f_O) override {
    SpreadLoad(surface_, load_.p_O, load_.n_O, width_, load_.force * load_.n_O, f_O);
  }
  void Reset() override {
    model_->Reset();
    search_.Forget();
    load_ = {};
  }
  void TakeOver(LoadIdentifier* before) override;
  [[nodiscard]] const ModelInfo& info() const override { return model_->info(); }

 private:
  SurfaceLoad TryFit(const std::vector<SurfacePoint>& points_O);
  void Place(const TriangleLoad& best, SurfaceLoad* load);
  void Refine(TriangleLoad* best, SurfaceLoad* load) noexcept;
  void CheckFit(const std::vector<SurfacePoint>& points_O, const TriangleLoad& best,
                SurfaceLoad* load) noexcept;
  bool Respond(const SurfaceLoad& load) noexcept;
  bool Load(const SurfaceLoad& load) noexcept;  // also sets field_

  SurfaceMesh surface_;
  PrecomputeProgress progress_{true};
  std::unique_ptr<DeformationModel> model_;
  SurfaceContact contact_;
  ContactStiffness stiffness_;
  double young_modulus_;        // [Pa]
  double larger_side_, width_;  // [m]
  bool linear_;
  TriangleSearch search_;
  Solution solution_;
  std::vector<Vector3d> field_;   // of the nodes [m]
  bool unsolved_ = false;         // the model found no equilibrium under the load
  bool converged_ = true;         // whether the fit with a nonlinear model has converged
  std::string_view flag_reason_;  // reason why the model's last answer is flagged
  double bound_ = 0;              // error bound of the model for that answer, relative [-]
  SurfaceLoad load_;
  Checks<FitSample> checks_ = MakeVolumeChecks();
};

SurfaceLoad VolumeLoadIdentifier::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  try {
    load_ = TryFit(points_O);
  } catch (const std::exception&) {
    load_ = {};
    load_.reason = "out of memory";
  }
  return load_;
}

SurfaceLoad VolumeLoadIdentifier::TryFit(const std::vector<SurfacePoint>& points_O) {
  SurfaceLoad load;
  search_.Read(*model_, contact_, points_O);
  unsolved_ = false;
  converged_ = true;
  if (const double done = search_.done(); done < 1) {
    load.Set({Validity::kFailed, FailedCheck::kNone,
              kComputing[static_cast<std::size_t>(done * kComputing.size())]});
    return load;
  }
  if (search_.usable() < VolumeLimits::kMinPoints) {
    load.Set({Validity::kTrackingLost, FailedCheck::kNone,
              "fewer than four points of the object are in view"});
    return load;
  }
  TriangleLoad best = search_.FindWithoutOutliers();
  if (best.triangle < 0) {
    load.reason = "no load explains the points";
    return load;
  }
  Place(best, &load);
  flag_reason_ = {};
  bound_ = 0;
  if (!linear_) {
    Refine(&best, &load);
  } else if (load.force != 0) {
    Respond(load);
  }
  load.sigma_force = std::hypot(load.sigma_force, bound_ * load.force);
  CheckFit(points_O, best, &load);
  return load;
}

void VolumeLoadIdentifier::Place(const TriangleLoad& best, SurfaceLoad* load) {
  const auto& nodes = surface_.triangles[Index(best.triangle)];
  load->force = best.forces.sum();
  load->n_O = search_.normal(best.triangle);
  if (load->force == 0) {  // all points are exactly at rest
    load->p_O = surface_.nodes[Index(nodes[0])];
    load->sigma_force = std::sqrt(best.covariance.sum());
    return;
  }
  load->p_O.setZero();
  for (std::size_t c = 0; c < 3; ++c) {
    load->p_O +=
        best.forces[static_cast<Eigen::Index>(c)] / load->force * surface_.nodes[Index(nodes[c])];
  }
  const double misfit = std::max(0.0, search_.measured() - best.explained);
  load->residual = std::sqrt(misfit / std::max(1, 3 * search_.kept() - 3));
  const double scatter = std::max(1.0, load->residual);
  load->sigma_force = scatter * std::sqrt(best.covariance.sum());
  double place = 0;
  for (const int axis : {0, 1, 2}) {
    Vector3d by;
    for (std::size_t c = 0; c < 3; ++c) {
      by[static_cast<Eigen::Index>(c)] =
          (surface_.nodes[Index(nodes[c])][axis] - load->p_O[axis]) / load->force;
    }
    place = std::max(place, by.dot(best.covariance * by));
  }
  load->sigma_place = scatter * std::sqrt(place);
  const Vector3d weights = best.forces / load->force;
  const Matrix3d K = stiffness_.At(best.triangle, weights, width_ / 2);
  load->depth = -load->force / load->n_O.dot(K * load->n_O);
}

void VolumeLoadIdentifier::CheckFit(const std::vector<SurfacePoint>& points_O,
                                    const TriangleLoad& best, SurfaceLoad* load) noexcept {
  const double noise_share = std::clamp(load->residual / VolumeLimits::kTrusted,
                                        VolumeLimits::kMinResidual / VolumeLimits::kTrusted, 1.0);
  load->validity = Validity::kValid;
  const double least = NoiseLimits::kSignificant * noise_share;
  if (best.explained < least * least) {
    load->force = load->depth = load->sigma_place = 0;
    return;
  }
  FitSample sample{.points_O = points_O,
                   .load = *load,
                   .points = search_.usable(),
                   .left_out = search_.usable() - search_.kept()};
  const double range = model_->info().range;
  if (range > 0 && std::abs(load->depth) > range * larger_side_) {
    sample.beyond_range = "the deflection is beyond the model's range";
  } else if (!flag_reason_.empty() &&
             // Coarse patches do not matter here, since few points are on them.
             flag_reason_ != kCoarsePatch) {
    sample.beyond_range = flag_reason_;
  } else if (unsolved_) {
    sample.beyond_range =
        "the model finds no equilibrium under this load: the small-strain solution is used";
  } else if (!converged_) {
    sample.beyond_range = "the load through the nonlinear model did not converge";
  }
  load->Take(checks_.Examine(sample));
}

// Subtracts the nonlinear part of the model's response from the measured displacements and fits the
// load again, until the load no longer changes (secant method, from the first fit).
void VolumeLoadIdentifier::Refine(TriangleLoad* best, SurfaceLoad* load) noexcept {
  double last = 0, last_change = load->force;
  converged_ = load->force == 0;
  for (int round = 0; round < VolumeLimits::kRounds && load->force != 0 && !converged_; ++round) {
    if (!Load(*load)) {
      unsolved_ = true;
      break;
    }
    for (std::size_t i = 0; i < search_.rest().size(); ++i) {
      const auto place = contact_.Find(search_.rest()[i], std::numeric_limits<double>::infinity());
      if (!search_.IsKept(i) || !place) continue;
      Vector3d u = Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        u += place->weights[static_cast<Eigen::Index>(c)] *
             field_[Index(surface_.triangles[Index(place->triangle)][c])];
      }
      search_.SubtractMotion(i, u - search_.Displacement(*best, i));
    }
    const double tried = load->force;
    *best = search_.Find();
    if (best->triangle < 0) return;
    Place(*best, load);
    const double change = load->force - tried;
    converged_ = std::abs(change) <= std::max(VolumeLimits::kRefined * std::abs(tried),
                                              VolumeLimits::kOfSigma * load->sigma_force);
    const double slope = (change - last_change) / (tried - last);
    last = tried;
    last_change = change;
    if (converged_ || load->force == 0 || !(slope < -VolumeLimits::kMinSlope)) continue;
    const double most = VolumeLimits::kMaxChange * std::abs(tried);
    best->forces *= (tried + std::clamp(-change / slope, -most, most)) / load->force;
    Place(*best, load);
  }
}

// Displacements under a force are in inverse proportion to the modulus.
void VolumeLoadIdentifier::TakeOver(LoadIdentifier* before) {
  auto* other = dynamic_cast<VolumeLoadIdentifier*>(before);
  if (other == nullptr || other->width_ != width_ || other->surface_.nodes != surface_.nodes ||
      other->surface_.triangles != surface_.triangles) {
    return;
  }
  search_.TakeOver(&other->search_, other->young_modulus_ / young_modulus_, *model_, contact_);
}

bool VolumeLoadIdentifier::Respond(const SurfaceLoad& load) noexcept {
  const Contact contact{.kind = Contact::Kind::kForce,
                        .p_O = load.p_O,
                        .width = width_,
                        .prescribed_O = load.force * load.n_O};
  model_->Solve({&contact, 1}, &solution_);
  const ContactResponse& response = solution_.responses().front();
  if (response.validity == Validity::kFailed) return false;
  flag_reason_ = response.flag_reason;
  const double moved = response.displacement_O.norm();
  bound_ = moved > 0 ? response.displacement_error / moved : 0;
  return true;
}

bool VolumeLoadIdentifier::Load(const SurfaceLoad& load) noexcept {
  if (!Respond(load)) return false;
  try {
    model_->Displacements(solution_, &field_);
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

LoadIdentifier::Press VolumeLoadIdentifier::PressAt(const Vector3d& p_O, double depth) noexcept {
  const auto place = contact_.Find(p_O, std::numeric_limits<double>::infinity());
  if (!place || !std::isfinite(depth)) return {};
  Press press;
  try {
    const Matrix3d K = stiffness_.At(place->triangle, place->weights, width_ / 2);
    press.stiffness = place->n_O.dot(K * place->n_O);
  } catch (const std::exception&) {
    return {};
  }
  press.force = press.stiffness * std::max(0.0, depth);
  const double range = model_->info().range;
  press.valid = !(range > 0) || depth <= range * larger_side_;
  return press;
}

void VolumeLoadIdentifier::Nearest(const Vector3d& p_O_tip, Vector3d* p_O,
                                   Vector3d* n_O) const noexcept {
  const auto place = contact_.Find(p_O_tip, std::numeric_limits<double>::infinity());
  *p_O = place ? place->p_O : surface_.nodes.front();
  *n_O = place ? place->n_O : Vector3d::UnitZ();
}

void VolumeLoadIdentifier::Displacements(std::vector<Vector3d>* u_O) {
  if (load_.force != 0 && Load(load_)) {
    *u_O = field_;
  } else {
    u_O->assign(surface_.nodes.size(), Vector3d::Zero());
  }
}

}  // namespace

std::unique_ptr<LoadIdentifier> MakeVolumeLoadIdentifier(const Scene& scene, double width,
                                                         Progress* progress) {
  if (!IsVolume(scene.object.geometry)) {
    throw std::invalid_argument(
        "object.geometry: for a stereo pair or depth camera, expected a membrane or a volume: "
        "box or mesh");
  }
  if (MovesInTime(scene)) {
    throw std::invalid_argument(
        "model.time = dynamic, or material.relaxation: for points measured by cameras, expected "
        "a "
        "model at rest");
  }
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  return std::make_unique<VolumeLoadIdentifier>(scene, width, mesh, SurfaceOf(mesh), progress);
}

}  // namespace palpate
