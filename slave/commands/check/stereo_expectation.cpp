#include "slave/commands/check/stereo_expectation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include <Eigen/Eigenvalues>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/mechanics/plate/plate_surface.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Sighted {
  Vector2d left_I, right_I;
};

std::optional<Sighted> Sight(const Scene& scene, const StereoRig& rig, const Vector3d& p_O) {
  const Vector3d p_L = scene.sense.Find<StereoCameras>()->X_SL.inverse() * scene.object.X_SO * p_O;
  const auto left = Project(rig.left, p_L);
  const auto right = Project(rig.right, rig.X_RL * p_L);
  if (!left || !right) return std::nullopt;
  return Sighted{*left, *right};
}

// The covariance of a point at p_O, frame L [m^2].
std::optional<Matrix3d> Covariance(const Scene& scene, const StereoRig& rig, const Vector3d& p_O) {
  const auto seen = Sight(scene, rig, p_O);
  const auto point =
      seen ? Triangulate(rig, seen->left_I, seen->right_I, scene.sense.Find<PointTracking>()->sigma)
           : std::nullopt;
  return point ? std::optional(point->covariance) : std::nullopt;
}

bool IsInside(const Lens& lens, const Vector2d& p_I, double margin) {
  return p_I.x() >= margin && p_I.y() >= margin && p_I.x() <= lens.size[0] - 1 - margin &&
         p_I.y() <= lens.size[1] - 1 - margin;
}

double RadiusInImage(const Scene& scene, const StereoRig& rig) {
  const Vector3d p_L =
      scene.sense.Find<StereoCameras>()->X_SL.inverse() * scene.object.X_SO.translation();
  return rig.left.fx * scene.sense.Find<PointTracking>()->dot_radius / p_L.norm();
}

}  // namespace

std::optional<SightExpectation> ExpectedSight(const Scene& scene, const StereoRig& rig) {
  const auto covariance = Covariance(scene, rig, Vector3d::Zero());
  if (!covariance) return std::nullopt;
  const Vector3d p_L =
      scene.sense.Find<StereoCameras>()->X_SL.inverse() * scene.object.X_SO.translation();
  const Vector3d middle_L = 0.5 * rig.X_RL.inverse().translation();
  const Vector3d along = (p_L - middle_L).normalized();
  const Matrix3d across = Matrix3d::Identity() - along * along.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> spread(across * *covariance * across);
  return SightExpectation{(p_L - middle_L).norm(), std::sqrt(along.dot(*covariance * along)),
                          std::sqrt(std::max(0.0, spread.eigenvalues().maxCoeff()))};
}

std::vector<Vector2d> InBothImages(const Scene& scene, const StereoRig& rig,
                                   const std::vector<Vector2d>& places_O) {
  const double margin = RadiusInImage(scene, rig);
  std::vector<Vector2d> seen_O;
  std::ranges::copy_if(places_O, std::back_inserter(seen_O), [&](const Vector2d& p) {
    const auto seen = Sight(scene, rig, Vector3d(p.x(), p.y(), 0));
    return seen && IsInside(rig.left, seen->left_I, margin) &&
           IsInside(rig.right, seen->right_I, margin);
  });
  return seen_O;
}

std::optional<ForceExpectation> ExpectedForce(const Scene& scene, const StereoRig& rig,
                                              const std::vector<Vector2d>& places_O) {
  const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry);
  const Vector3d home_O = scene.object.X_SO.inverse() * scene.manipulator.home;
  if (membrane == nullptr || !(home_O.head<2>().norm() < membrane->radius)) return std::nullopt;
  const auto model = MakePlateModel(scene, {membrane->radius, membrane->thickness});
  PlateSurface& plate = *model;
  const PlateSurface::Tool tool{scene.tool->width, scene.tool->IsRigidFace()};
  const Contact press = PlateSurface::ToolContact(Contact::Kind::kDisplacement, home_O.head<2>(),
                                                  tool, -scene.operator_options.press_depth);
  Solution solution;
  plate.Solve({&press, 1}, &solution);
  const ContactResponse& response = solution.responses().front();
  if (response.validity == Validity::kFailed) return ForceExpectation{};
  std::vector<Vector2d> seen_O;
  std::vector<double> displacements, sigmas;
  const Vector3d n_L = scene.sense.Find<StereoCameras>()->X_SL.linear().transpose() *
                       scene.object.X_SO.linear().col(2);
  for (const Vector2d& p : places_O) {
    const auto covariance = Covariance(scene, rig, Vector3d(p.x(), p.y(), 0));
    if (!covariance || !(p.norm() < membrane->radius)) continue;
    seen_O.push_back(p);
    displacements.push_back(plate.Displacement(solution, p));
    sigmas.push_back(std::sqrt(n_L.dot(*covariance * n_L)));
  }
  LoadFitter fitter(plate, tool);
  const LoadFit fit = fitter.Fit(seen_O, displacements, sigmas);
  return ForceExpectation{std::abs(response.force_O.z()), std::sqrt(fit.covariance(2, 2)),
                          fit.validity};
}

}  // namespace palpate
