// Disturbances that two cameras must tolerate, and those under which they may flag a force.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <variant>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/scene/scene_loader.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/stereo/pair_rig.h"
#include "slave/vision/stereo/rig.h"
#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/severities.h"
#include "tests/support/paths.h"

namespace palpate::robustness {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// The cameras of the shipped membrane, to project points in space into images.
struct CameraPair {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/rubber-membrane.yaml"));
  StereoRig rig = SimulatedRig(scene);
  Isometry3d X_SL = scene.sense.Find<StereoCameras>()->X_SL;

  [[nodiscard]] const Lens& lens(int side) const { return side == 0 ? rig.left : rig.right; }
  // S -> the camera of this side.
  [[nodiscard]] Isometry3d X_CS(int side) const {
    return side == 0 ? X_SL.inverse() : rig.X_RL * X_SL.inverse();
  }
  [[nodiscard]] Vector2d ImageOf(int side, const Vector3d& p_S) const {
    return Project(lens(side), X_CS(side) * p_S).value_or(Vector2d(-100, -100));
  }
};
const CameraPair& TheCameraPair() {
  static const CameraPair cameras;
  return cameras;
}

// The membrane bulges as a paraboloid by `height` [m] towards -z at its centre. Each pixel shows
// the point where its ray meets the plane, displaced by the bulge there.
Paint Dome(double height) {
  return [height, maps = std::make_shared<std::array<cv::Mat, 2>>()](const View& view,
                                                                     cv::Mat& image) {
    cv::Mat& from = (*maps)[static_cast<std::size_t>(view.side)];
    if (from.size() != image.size()) {
      const CameraPair& cameras = TheCameraPair();
      const double radius = std::get<MembraneGeometry>(cameras.scene.object.geometry).radius;
      const Isometry3d X_SC = cameras.X_CS(view.side).inverse();
      from.create(image.size(), CV_32FC2);
      for (int y = 0; y < image.rows; ++y) {
        for (int x = 0; x < image.cols; ++x) {
          const auto ray = RayOf(cameras.lens(view.side), {x, y});
          const Vector3d d = X_SC.linear() * Vector3d(ray->x(), ray->y(), 1);
          const Vector3d p = X_SC.translation() - X_SC.translation().z() / d.z() * d;
          const double bulge =
              height * std::fmax(0, 1 - p.head<2>().squaredNorm() / (radius * radius));
          const Vector2d moved = cameras.ImageOf(view.side, p - bulge * Vector3d::UnitZ()) -
                                 cameras.ImageOf(view.side, p);
          from.at<cv::Point2f>(y, x) = {static_cast<float>(x - moved.x()),
                                        static_cast<float>(y - moved.y())};
        }
      }
    }
    cv::Mat bulged;
    cv::remap(image, bulged, from, cv::Mat(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    image = bulged;
  };
}

// Five of the dots, or of the places where they would be, behind plain discs.
Paint CoveredDots(int count) {
  return [count](const View& view, cv::Mat& image) {
    const CameraPair& cameras = TheCameraPair();
    const auto layout = DotPlaces(*cameras.scene.sense.Find<PointTracking>());
    std::vector<Vector2d> at;
    for (int i = 0; i < count; ++i) {
      const Vector2d& p_O = layout[static_cast<std::size_t>(i) * 6 % layout.size()];
      at.push_back(
          cameras.ImageOf(view.side, cameras.scene.object.X_SO * Vector3d(p_O.x(), p_O.y(), 0)));
    }
    Patches(at, 14)(view, image);
  };
}

void AddImages(CaseTable* table) {
  table->Add("flicker", "%", {10, 20}, {40}, [](double s) { return Flicker(s / 100); });
  table->Add("vignette", "%", {20}, {50}, [](double s) { return Vignette(s / 100); });
  table->Add("one eye darker", "%", {20}, {50},
             [](double s) { return OnSide(1, Gain(1 - s / 100)); });
  table->Add("shadow", "%", {30}, {60}, [](double s) { return Shadow(s / 100); });
  table->Add("noise", "grey levels", {8, 15}, {30}, [](double s) { return Noise(s); });
  table->Add("JPEG", "quality", {50, 20}, {5}, [](double s) { return Jpeg(static_cast<int>(s)); });
  table->Add("defocus", "px", {1}, {2, 4}, [](double s) { return Defocus(s); });
  table->Add("one eye out of focus", "px", {1}, {2, 4},
             [](double s) { return OnSide(1, Defocus(s)); });
  table->Add("motion blur", "px", {3}, {7, 15}, [](double s) { return MotionBlur(s, 30); });
  table->Add("dots covered", "of 31", {2, 5}, {12},
             [](double s) { return CoveredDots(static_cast<int>(s)); });
  table->Add("dots covered in one eye", "of 31", {5}, {12},
             [](double s) { return OnSide(1, CoveredDots(static_cast<int>(s))); });
  table->Add("glint at the contact", "px", {4}, {12, 30}, [](double s) {
    return [s](const View& view, cv::Mat& image) { Patches({view.tip_I}, s, 255)(view, image); };
  });
  table->Add("wire in front", "px", {2}, {6}, [](double s) { return Wire(s, 35, 0); });
}

void AddMotion(CaseTable* table) {
  table->Add("rig bumped at rest", "px", {3, 10}, {40}, [](double s) {
    return Bump({0.6 * s, 0.8 * s}, When::kAtRest);
  });
  table->Add("rig bumped while pressed", "px", {3, 10}, {40}, [](double s) {
    return Bump({0.6 * s, 0.8 * s}, When::kPressed);
  });
  table->Add("one camera bumped at rest - across", "px", {}, {0.5, 2, 10}, [](double s) {
    return OnSide(1, Bump({0, s}, When::kAtRest));
  });
  table->Add("one camera bumped at rest - along", "px", {}, {0.5, 2, 10}, [](double s) {
    return OnSide(1, Bump({s, 0}, When::kAtRest));
  });
  table->Add("one camera bumped while pressed - along", "px", {}, {0.5, 2, 10}, [](double s) {
    return OnSide(0, Bump({s, 0}, When::kPressed));
  });
  table->Add("one camera turned at rest", "deg", {}, {0.5, 2},
             [](double s) { return OnSide(1, Turn(s, When::kAtRest)); });
  table->Add("rig shakes", "px", {0.5}, {3}, [](double s) {
    return [s](const View& view, cv::Mat& image) {  // the same in both cameras
      View left = view;
      left.side = 0;
      Shake(s)(left, image);
    };
  });
  table->Add("cameras shake - each for itself", "px", {}, {0.5, 2},
             [](double s) { return Shake(s); });
  table->Add("zoom of one camera changed at rest", "%", {}, {0.5, 2},
             [](double s) { return OnSide(1, Zoom(1 + s / 100, When::kAtRest)); });
  table->Add("domed", "mm", {}, {-2, -0.5, 0.5, 2}, [](double s) { return Dome(1e-3 * s); });
  table->Add("bulges from rest on", "mm", {}, {0.5, 2},
             [](double s) { return From(When::kAtRest, Dome(1e-3 * s)); });
}

void AddTime(CaseTable* table) {
  table->Add("right image late", "pairs", {}, {1, 5},
             [](double s) { return Shows(Late(static_cast<std::size_t>(s), 1)); });
  table->Add("left image late", "pairs", {}, {1, 5},
             [](double s) { return Shows(Late(static_cast<std::size_t>(s), 0)); });
  table->Add("right camera frozen from rest on", Demand::kFlag, Shows([](const Moment& moment) {
               return moment.side == 1 ? Frozen(When::kAtRest)(moment) : moment.index;
             }));
  table->Add("right camera frozen while pressed", Demand::kFlag, Shows([](const Moment& moment) {
               return moment.side == 1 ? Frozen(When::kPressed)(moment) : moment.index;
             }));
  table->Add("both frozen from rest on", Demand::kFlag, Shows(Frozen(When::kAtRest)));
  table->Add("pairs come twice", Demand::kFlag, Shows(Doubled()));
  table->Add("sides swapped", Demand::kFlag, {.swapped = When::kAlways});
}

void AddGeometry(CaseTable* table) {
  table->Add("baseline wrong", "%", {}, {-5, 5}, [](double s) {
    return AlterScene(
        [s](Scene& scene) { scene.sense.Find<StereoCameras>()->baseline *= 1 + s / 100; });
  });
  table->Add("focal length wrong", "%", {}, {-5, 5}, [](double s) {
    return AlterScene(
        [s](Scene& scene) { scene.sense.Find<StereoCameras>()->focal *= 1 + s / 100; });
  });
  table->Add("rig turned against the scene", "deg", {}, {1, 5}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.sense.Find<StereoCameras>()->X_SL.rotate(
          Eigen::AngleAxisd(Radians(s), Vector3d::UnitX()));
    });
  });
  table->Add("rig elsewhere than stated", "mm", {}, {1, 5}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.sense.Find<StereoCameras>()->X_SL.translation().x() += 1e-3 * s;
    });
  });
  table->Add("prestress stated - there is none", "N/m", {}, {300, 3000},
             [](double s) { return AlterScene([s](Scene& scene) { scene.model.prestress = s; }); });
  table->Add("radius wrong", "%", {}, {-10, 10}, [](double s) {
    return AlterScene([s](Scene& scene) {
      std::get<MembraneGeometry>(scene.object.geometry).radius *= 1 + s / 100;
    });
  });
  table->Add("distance of the dots wrong", "%", {}, {-3, 3}, [](double s) {
    return AlterScene(
        [s](Scene& scene) { scene.sense.Find<PointTracking>()->spacing *= 1 + s / 100; });
  });
}

// --- depth images: 16 bit, 0 is no measurement
constexpr const char* kDepth = "rubber-membrane-depth";

// Removes measurements in discs of 20 px that cover a fraction `share` of the image. The discs are
// at new positions in each image unless they are fixed.
Paint Holes(double share, bool standing) {
  return [=](const View& view, cv::Mat& image) {
    constexpr double kRadius = 20;
    std::mt19937_64 random(standing ? 1 : view.index + 1);
    const double area = std::numbers::pi * kRadius * kRadius;
    const auto count = static_cast<int>(share * static_cast<double>(image.total()) / area);
    std::uniform_real_distribution<double> x(0, image.cols), y(0, image.rows);
    for (int i = 0; i < count; ++i) {
      const cv::Point at(static_cast<int>(x(random)), static_cast<int>(y(random)));
      cv::circle(image, at, static_cast<int>(kRadius), cv::Scalar(0), -1);
    }
  };
}

// Multiplies each depth by `factor` and adds `offset` [counts].
Paint Rescaled(double factor, double offset, When when) {
  return From(when,
              [=](const View&, cv::Mat& image) { image.convertTo(image, CV_16U, factor, offset); });
}

Paint NoisyDepth(double counts) {
  return [counts](const View& view, cv::Mat& image) {
    cv::Mat noise(image.size(), CV_32F), noisy;
    cv::RNG(view.index + 1).fill(noise, cv::RNG::NORMAL, 0, counts);
    image.convertTo(noisy, CV_32F);
    noisy += noise;
    noisy.convertTo(image, CV_16U);
  };
}

void AddDepth(CaseTable* table) {
  table->Only(kDepth);
  table->Add("depth undisturbed", Demand::kRight, {});
  table->Add("depth with holes", "%", {10}, {40}, [](double s) { return Holes(s / 100, false); });
  table->Add("depth with standing holes", "%", {10}, {40},
             [](double s) { return Holes(s / 100, true); });
  table->Add("depth noisier", "mm", {0.4}, {2}, [](double s) { return NoisyDepth(s / 0.02); });
  table->Add("depth scaled", "%", {}, {-3, 3},
             [](double s) { return Rescaled(1 + s / 100, 0, When::kAlways); });
  table->Add("depth warms up at rest", "mm", {}, {0.3, 2},
             [](double s) { return Rescaled(1, s / 0.02, When::kAtRest); });
  table->Add("depth camera bumped at rest", "px", {}, {3, 10, 20}, [](double s) {
    return Bump({s, 0}, When::kAtRest);
  });
  table->Add("depth late", "images", {}, {1, 5},
             [](double s) { return Shows(Late(static_cast<std::size_t>(s))); });
  table->Add("depth frozen from rest on", Demand::kFlag, Shows(Frozen(When::kAtRest)));
  table->Add("depth frozen while pressed", Demand::kFlag, Shows(Frozen(When::kPressed)));
  table->Only({});
}

}  // namespace

std::vector<Case> PairCases() {
  CaseTable table;
  table.Add("undisturbed", Demand::kRight, {});
  AddImages(&table);
  AddMotion(&table);
  AddTime(&table);
  AddGeometry(&table);
  AddPairDamage(&table);
  AddDepth(&table);
  return table.Take();
}

}  // namespace palpate::robustness
