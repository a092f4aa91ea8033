// A press that two cameras see, or a depth camera.
#include <memory>
#include <random>
#include <utility>

#include <opencv2/core.hpp>

#include "slave/simulator/points/stereo_site.h"
#include "slave/vision/stereo/pair_rig.h"
#include "slave/vision/stereo/rig.h"
#include "tests/campaigns/robustness/stages.h"
#include "tests/support/normal_noise.h"

namespace palpate::robustness {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class PairStage final : public Stage {
 public:
  PairStage(const std::string& name, Scene scene, const Counts& counts)
      : Stage(name, "pairs", std::move(scene)), rig_(SimulatedRig(this->scene())) {
    script_ = counts.script();
    const Eigen::Isometry3d X_SO = TruePose(this->scene());
    const Vector3d home = this->scene().manipulator.home;
    const Vector3d home_O = X_SO.inverse() * home;
    const double depth = this->scene().operator_options.press_depth;
    StereoSite site(this->scene());
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < script_.count; ++i) {
      const double z = home_O.z() - counts.WayAt(i) * (home_O.z() + depth);
      site.MoveTool(X_SO * Vector3d(home_O.x(), home_O.y(), z));
      StereoImages images = site.TakeImages();
      shots.push_back({images.left, images.right, {}, site.truth()});
    }
    pressed_S_ = X_SO * Vector3d(home_O.x(), home_O.y(), 0);
    Keep(std::move(shots));
  }

  [[nodiscard]] View ViewOf(const Moment& moment) const override {
    View view;
    static_cast<Moment&>(view) = moment;
    const Eigen::Isometry3d& X_SL = scene().sense.Find<StereoCameras>()->X_SL;
    Vector3d p = X_SL.inverse() * pressed_S_;
    if (moment.side == 1) p = rig_.X_RL * p;
    const Lens& lens = moment.side == 0 ? rig_.left : rig_.right;
    view.tip_I = view.pressed_I = Project(lens, p).value_or(Vector2d(0, 0));
    view.width = scene().tool->width * lens.fx / p.z();
    return view;
  }
  [[nodiscard]] double pixel() const override { return 0.25 / rig_.left.fx; }

 private:
  StereoRig rig_;
  Vector3d pressed_S_{0, 0, 0};
};

// The image of a depth camera of the same membrane's inner side, from the true surface.
class DepthStage final : public Stage {
 public:
  DepthStage(const std::string& name, Scene scene, Scene site_scene, const Counts& counts)
      : Stage(name, "pairs", std::move(scene)), camera_(*this->scene().sense.Find<DepthImages>()) {
    script_ = counts.script();
    const double depth = site_scene.operator_options.press_depth;
    const Vector3d home = site_scene.manipulator.home;
    StereoSite site(site_scene);
    std::mt19937 random(site_scene.site.seed);
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < script_.count; ++i) {
      site.MoveTool({home.x(), home.y(), home.z() - counts.WayAt(i) * (home.z() + depth)});
      shots.push_back({Image(site, &random), {}, {}, site.truth()});
    }
    Keep(std::move(shots));
  }

  [[nodiscard]] View ViewOf(const Moment& moment) const override {
    View view;
    static_cast<Moment&>(view) = moment;
    view.tip_I = view.pressed_I = {camera_.cx, camera_.cy};
    return view;
  }
  [[nodiscard]] double pixel() const override { return kDistance / camera_.fx; }

  static constexpr double kDistance = 0.25;  // in front of the membrane [m]
  static constexpr int kWidth = 320, kHeight = 240;

 private:
  [[nodiscard]] cv::Mat Image(const StereoSite& site, std::mt19937* random) const {
    NormalNoise noise;
    cv::Mat image(kHeight, kWidth, CV_16U);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Vector2d ray((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy);
        double z = kDistance;
        for (int k = 0; k < 2; ++k) z = kDistance + site.TrueDisplacement(z * ray).z();
        image.at<std::uint16_t>(y, x) =
            cv::saturate_cast<std::uint16_t>((z + camera_.sigma * noise(*random)) / camera_.unit);
      }
    }
    return image;
  }

  const DepthImages& camera_;
};

}  // namespace

std::unique_ptr<Stage> MakePairStage(Scene scene, const Counts& counts) {
  const std::string name = scene.name;
  return std::make_unique<PairStage>(name, std::move(scene), counts);
}

std::unique_ptr<Stage> MakePairStage(const std::string& name, const Overrides& overrides,
                                     Extent extent) {
  const Counts counts =
      extent == Extent::kQuick ? Counts{16, 8, 3, 4, 2} : Counts{20, 60, 15, 30, 10};
  return std::make_unique<PairStage>(name, Shipped("rubber-membrane", overrides), counts);
}

std::unique_ptr<Stage> MakeDepthStage(Scene scene, const Counts& counts) {
  const Scene site_scene = scene;
  DepthImages camera;
  camera.unit = 0.02e-3;
  camera.sigma = 0.2e-3;
  camera.fx = camera.fy = 400;
  camera.cx = 0.5 * (DepthStage::kWidth - 1);
  camera.cy = 0.5 * (DepthStage::kHeight - 1);
  camera.X_SD.translation().z() = -DepthStage::kDistance;
  PointTracking points;
  points.track = PointTracking::Track::kSurface;
  scene.sense.Set(PointsOptions{camera, points});
  return std::make_unique<DepthStage>(site_scene.name, scene, site_scene, counts);
}

std::unique_ptr<Stage> MakeDepthStage(const std::string& name, Extent extent) {
  const Counts counts =
      extent == Extent::kQuick ? Counts{6, 8, 3, 4, 2} : Counts{8, 60, 15, 30, 10};
  Scene scene = Shipped("rubber-membrane", {});
  scene.name = name;
  return MakeDepthStage(std::move(scene), counts);
}

}  // namespace palpate::robustness
