#include "slave/vision/calibration/lens_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <opencv2/calib3d.hpp>

#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/registration_checks.h"

namespace palpate {
namespace {

// Places about their middle: from afar, turns and shifts of the camera are hard to tell apart.
struct PnpProblem {
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> pictures;
  cv::Matx33d K;
  cv::Mat D;
};

PnpProblem ProblemOf(const Lens& lens, const std::vector<TipPlace>& places, const Indices& which,
                     const Eigen::Vector3d& middle_S) {
  PnpProblem problem{{}, {}, CameraMatrixOf(lens), DistortionOf(lens)};
  for (const std::size_t i : which) {
    const TipPlace& at = places[i];
    const Eigen::Vector3d p = at.p_S - middle_S;
    problem.objects.emplace_back(p.x(), p.y(), p.z());
    problem.pictures.emplace_back(at.left_I.x(), at.left_I.y());
  }
  return problem;
}

// X_CS, S about the places' middle, with the places' plane tilted to the other side of the line of
// sight.
Eigen::Isometry3d TurnedOver(const Eigen::Isometry3d& X_CS, const Eigen::Vector3d& normal_S) {
  const Eigen::Vector3d middle_C = X_CS.translation(), sight = middle_C.normalized();
  const Eigen::Vector3d normal_C = X_CS.linear() * normal_S;
  const Eigen::Vector3d other_C = 2 * sight.dot(normal_C) * sight - normal_C;
  Eigen::Isometry3d out = X_CS;
  out.linear() =
      Eigen::Quaterniond::FromTwoVectors(normal_C, other_C).toRotationMatrix() * X_CS.linear();
  return out;
}

}  // namespace

double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place) {
  const auto at = Project(lens, X_SC.inverse() * place.p_S);
  return at ? (*at - place.left_I).norm() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which) {
  std::vector<LensPose> poses;
  const PlaceCloud cloud = CloudOf(which, places);
  const PnpProblem problem = ProblemOf(lens, places, which, cloud.mean);
  const auto keep = [&](cv::Mat rotation, cv::Mat translation) {
    cv::solvePnPRefineLM(problem.objects, problem.pictures, problem.K, problem.D, rotation,
                         translation);
    const Eigen::Isometry3d X_SC =
        Eigen::Translation3d(cloud.mean) * PoseOf(rotation, translation).inverse();
    LensPose pose{{X_SC, 0}, 0};
    for (const std::size_t i : which) {
      const double miss = LensMiss(lens, pose.guess.X_SC, places[i]);
      pose.sum_of_squares += std::isfinite(miss) ? miss * miss : HUGE_VAL;
    }
    poses.push_back(pose);
  };
  try {
    cv::Mat rotation, translation;
    if (!cv::solvePnP(problem.objects, problem.pictures, problem.K, problem.D, rotation,
                      translation, false, cv::SOLVEPNP_SQPNP)) {
      return poses;
    }
    const Eigen::Isometry3d other_CS = TurnedOver(PoseOf(rotation, translation), cloud.normal);
    keep(rotation, translation);
    const Eigen::AngleAxisd turn(other_CS.linear());
    const Eigen::Vector3d r = turn.angle() * turn.axis(), t = other_CS.translation();
    keep(cv::Mat(cv::Vec3d(r.x(), r.y(), r.z())), cv::Mat(cv::Vec3d(t.x(), t.y(), t.z())));
  } catch (const std::exception&) {  // cv::Exception or no finite pose: what there is, is kept
  }
  if (poses.size() == 2 && poses[1].sum_of_squares < poses[0].sum_of_squares) {
    std::swap(poses[0], poses[1]);
  }
  return poses;
}

}  // namespace palpate
