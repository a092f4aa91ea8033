// References: labels by hand of recorded clouds; scenes of simple shapes whose parts are known.
#include "slave/study/clouds/segmentation.h"

#include <array>
#include <filesystem>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/study/clouds/object_choice.h"
#include "slave/study/clouds/pcd_file.h"
#include "slave/study/clouds/support_plane.h"
#include "slave/study/shape/shape_score.h"
#include "slave/study/shape/virtual_depth_camera.h"
#include "tests/support/paths.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;
using Colour = std::array<std::uint8_t, 3>;
namespace fs = std::filesystem;

// Every labelled object, that is every label but 0 (not measured) and 1 (the table), with the same
// options for every cloud. Tolerance: the figure that is asked for.
TEST(SegmentationTest, LabelledObjectsOfRecordedCloudsAreFound) {
  const fs::path folder = fs::path(SourcePath()) / "../shared/data/pointclouds";
  if (!fs::exists(folder)) GTEST_SKIP() << "no recorded clouds here";
  int labelled = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".pcd") continue;
    const PointCloud cloud = ReadPcd(entry.path()).cloud;
    if (cloud.labels.empty()) continue;
    ++labelled;
    for (const LabelScore& row : ScoreLabels(cloud, Segment(cloud, {}))) {
      EXPECT_EQ(row.support, row.label == 1) << "label " << row.label;
      if (row.label < 2) continue;
      EXPECT_GE(row.iou, 0.8) << "label " << row.label;
    }
  }
  EXPECT_GT(labelled, 0);
}

// What a camera sees of bodies on a table, each point labelled with its body.
class TableScene {
 public:
  // Looks down at the origin from 0.9 m away; `tilt` [rad] above the table.
  TableScene() {
    const Vector3d from(0, -0.7, 0.6), look = (-from).normalized();
    const Vector3d right = look.cross(Vector3d::UnitZ()).normalized();
    camera_.X_SD.linear() << right, look.cross(right), look;
    camera_.X_SD.translation() = from;
    camera_.noise = 0.0015;
  }
  void Add(const SurfaceMesh& body, Colour colour) { bodies_.push_back({body, colour}); }
  // Each body is pictured with the others in the way.
  [[nodiscard]] PointCloud Cloud() const {
    PointCloud cloud;
    const Eigen::Isometry3d X_DS = camera_.X_SD.inverse();
    DepthCamera exact = camera_;
    exact.noise = 0;
    std::mt19937 generator(5);
    std::normal_distribution<double> shade(0, 3), along(0, camera_.noise);
    SurfaceMesh all;
    for (const auto& [body, colour] : bodies_) Join(body, &all);
    using Place = std::array<double, 3>;
    std::vector<std::set<Place>> alone(bodies_.size());
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      for (const Vector3d& p : ScanSurface(exact, bodies_[k].surface, {}, 1)) {
        alone[k].insert({p.x(), p.y(), p.z()});
      }
    }
    const auto seen = ScanSurface(exact, all, {}, 1);
    for (const auto& p : seen) {
      for (std::size_t k = 0; k < alone.size(); ++k) {
        if (!alone[k].contains({p.x(), p.y(), p.z()})) continue;
        const Vector3d p_D = X_DS * p;
        cloud.points.emplace_back(p_D + along(generator) * p_D.normalized());
        Colour colour = bodies_[k].colour;
        for (auto& c : colour) {
          c = static_cast<std::uint8_t>(std::clamp(c + shade(generator), 0.0, 255.0));
        }
        cloud.colours.push_back(colour);
        cloud.labels.push_back(static_cast<std::uint32_t>(k));
        break;
      }
    }
    return cloud;
  }
  [[nodiscard]] const DepthCamera& camera() const { return camera_; }

 private:
  struct Body {
    SurfaceMesh surface;
    Colour colour;
  };
  static void Join(const SurfaceMesh& part, SurfaceMesh* all) {
    const int first = static_cast<int>(all->nodes.size());
    all->nodes.insert(all->nodes.end(), part.nodes.begin(), part.nodes.end());
    for (const auto& [a, b, c] : part.triangles) {
      all->triangles.push_back({a + first, b + first, c + first});
    }
  }
  DepthCamera camera_;
  std::vector<Body> bodies_;
};

SurfaceMesh Box(const Vector3d& corner, const Vector3d& size) {
  SurfaceMesh box = SurfaceOf(MeshBox(size, {1, 1, 1}));
  for (auto& p : box.nodes) p += corner;
  return box;
}

constexpr Colour kWood{180, 160, 150}, kFoam{230, 220, 60}, kSkin{60, 60, 70};

double Iou(const std::vector<LabelScore>& rows, std::uint32_t label) {
  for (const auto& row : rows) {
    if (row.label == label) return row.iou;
  }
  return 0;
}

// Tolerance: what lies within the table's tolerance of 6 mm goes with it, of a cube of 60 mm about
// a tenth.
TEST(SegmentationTest, FoamCubeIsOneRegionAlthoughItsFacesMeetAtRightAngles) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.03, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  const PointCloud cloud = scene.Cloud();
  EXPECT_GT(Iou(ScoreLabels(cloud, Segment(cloud, {})), 1), 0.85);
}

// The higher one stands behind: its front rises from the other's top. Faces that are flush would
// stay one surface.
TEST(SegmentationTest, BoxesThatTouchAreToldApartByColourAndGroove) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.03, -0.06, 0}, {0.06, 0.06, 0.06}), kFoam);
  scene.Add(Box({-0.03, 0, 0}, {0.06, 0.06, 0.09}), kSkin);
  const PointCloud cloud = scene.Cloud();
  const auto rows = ScoreLabels(cloud, Segment(cloud, {}));
  EXPECT_GT(Iou(rows, 1), 0.8);
  EXPECT_GT(Iou(rows, 2), 0.8);
}

TEST(SegmentationTest, PrintedSurfaceStaysWholeByShapeAndFallsApartByColour) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.05, -0.03, 0}, {0.1, 0.06, 0.06}), kFoam);
  PointCloud cloud = scene.Cloud();
  const Eigen::Isometry3d X_SD = scene.camera().X_SD;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d p_S = X_SD * cloud.points[i];
    if (cloud.labels[i] == 1 && p_S.x() > 0) cloud.colours[i] = kSkin;
  }
  SegmentationOptions options;
  EXPECT_GT(Iou(ScoreLabels(cloud, Segment(cloud, options)), 1), 0.85);
  options.method = SegmentationOptions::Method::kColour;
  EXPECT_LT(Iou(ScoreLabels(cloud, Segment(cloud, options)), 1), 0.6);
}

TEST(SegmentationTest, FingerOnFoamDoesNotJoinIt) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.05, -0.05, 0}, {0.1, 0.1, 0.04}), kFoam);
  scene.Add(Box({-0.01, -0.01, 0.04}, {0.02, 0.02, 0.05}), kSkin);
  const PointCloud cloud = scene.Cloud();
  const auto rows = ScoreLabels(cloud, Segment(cloud, {}));
  EXPECT_GT(Iou(rows, 1), 0.8);
  EXPECT_GT(Iou(rows, 2), 0.6);  // its foot lies in the groove, which takes about a quarter of it
}

TEST(SegmentationTest, CloudWithoutColoursIsCutByShapeAlone) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.1, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  scene.Add(Box({0.04, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  PointCloud cloud = scene.Cloud();
  cloud.colours.clear();
  const auto rows = ScoreLabels(cloud, Segment(cloud, {}));
  EXPECT_GT(Iou(rows, 1), 0.85);
  EXPECT_GT(Iou(rows, 2), 0.85);
}

// Cameras give strays at the edges of what they see. A cube alone, without a table: none of its
// faces may pass for one because of points far out that happen to lie in its plane, or because the
// tolerance grew with the depth of those.
TEST(SegmentationTest, StraysAreNoReasonToTakeAFaceForASupport) {
  TableScene scene;
  scene.Add(Box({-0.03, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  struct Strays {
    int count;
    double reach;  // [m]
  };
  for (const auto& [count, reach] : {Strays{20, 100}, {100, 20}, {500, 3}}) {
    PointCloud cloud = scene.Cloud();
    std::mt19937 generator(8);
    std::uniform_real_distribution<double> place(-reach, reach);
    for (int i = 0; i < count; ++i) {
      cloud.points.emplace_back(place(generator), place(generator), place(generator));
      cloud.colours.push_back(kFoam);
      cloud.labels.push_back(1);
    }
    const auto rows = ScoreLabels(cloud, Segment(cloud, {}));
    EXPECT_FALSE(rows[0].support) << reach;
    EXPECT_GT(rows[0].iou, 0.95) << count << " strays within " << reach << " m";
  }
}

// The strays alone, as the planes see them: 40 mm of a face, and points in its plane up to 100 m
// away.
TEST(SupportPlaneTest, FarPointsInItsPlaneDoNotMakeAFaceLarge) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) points.emplace_back(2e-3 * (i % 20), 2e-3 * (i / 20.0), 0.5);
  for (int i = 0; i < 20; ++i) points.emplace_back(5.0 * i - 50, 90.0 - 9 * i, 0.5);
  EXPECT_EQ(std::ranges::count(InSupportPlanes(points, {}), true), 0);
  for (auto& p : points) p.head<2>() *= 20;  // a table of 0.8 m
  EXPECT_GE(std::ranges::count(InSupportPlanes(points, {}), true), 400);
}

TEST(SegmentationTest, LabelOfTheTableIsToldAsSupportAndNotScored) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.03, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  const PointCloud cloud = scene.Cloud();
  const auto rows = ScoreLabels(cloud, Segment(cloud, {}));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(rows[0].support);
  EXPECT_EQ(rows[0].region, -1);
  EXPECT_FALSE(rows[1].support);
}

TEST(SegmentationTest, OnePointFewPointsAndAllInOnePlaceGiveNoRegion) {
  EXPECT_TRUE(Segment({}, {}).size.empty());
  EXPECT_TRUE(Segment({{{0, 0, 1}}, {}, {}}, {}).size.empty());
  EXPECT_TRUE(Segment({std::vector<Vector3d>(5000, Vector3d(0, 0, 1)), {}, {}}, {}).size.empty());
  const Segmentation two = Segment({{{0, 0, 1}, {0, 0, 100}}, {}, {}}, {});
  EXPECT_EQ(two.region_of, (std::vector<int>{-1, -1}));
}

TEST(ObjectChoiceTest, PointColourAndPlaceEachChooseTheirRegion) {
  TableScene scene;
  scene.Add(Box({-0.5, -0.4, -0.02}, {1, 0.8, 0.02}), kWood);
  scene.Add(Box({-0.1, -0.03, 0}, {0.06, 0.06, 0.06}), kFoam);
  scene.Add(Box({0.04, -0.03, 0}, {0.06, 0.06, 0.06}), kSkin);
  const PointCloud cloud = scene.Cloud();
  const Segmentation segmentation = Segment(cloud, {});
  const auto share_of = [&](const ObjectHint& hint, std::uint32_t label) {
    const ObjectChoice choice = ChooseObject(cloud, segmentation, hint);
    const PointCloud chosen = Chosen(cloud, segmentation, choice.regions);
    const auto of_label = std::ranges::count(chosen.labels, label);
    return static_cast<double>(of_label) /
           static_cast<double>(std::max<std::size_t>(1, chosen.size()));
  };
  ObjectHint hint;
  hint.at = scene.camera().X_SD.inverse() * Vector3d(0.07, 0, 0.06);
  EXPECT_GT(share_of(hint, 2), 0.95);
  hint.at.reset();
  hint.colour = Colour{255, 255, 0};
  EXPECT_GT(share_of(hint, 1), 0.95);
  hint.colour.reset();
  hint.X_BD = scene.camera().X_SD;
  hint.box = {Vector3d(0.02, -0.05, -0.02), Vector3d(0.12, 0.05, 0.08)};
  EXPECT_GT(share_of(hint, 2), 0.95);
  EXPECT_TRUE(ChooseObject(cloud, segmentation, hint).sure);
  hint.box = {Vector3d(-0.4, -0.05, 0.2), Vector3d(-0.3, 0.05, 0.3)};  // nothing there
  EXPECT_FALSE(ChooseObject(cloud, segmentation, hint).sure);
  EXPECT_GT(share_of(hint, 1), 0.95);
  EXPECT_TRUE(ChooseObject({}, {}, hint).regions.empty());
}

TEST(ObjectChoiceTest, PointOffEveryObjectAndColourOfACloudWithoutAreRefused) {
  const PointCloud cloud{{{0, 0, 1}, {0.01, 0, 1}}, {}, {}};
  const Segmentation segmentation{{0, 0}, {2}, 0, {}};
  ObjectHint hint;
  hint.at = Vector3d(0, 0.049, 1);
  EXPECT_EQ(ChooseObject(cloud, segmentation, hint).regions, std::vector<int>{0});
  hint.at = Vector3d(0, 0.12, 1);
  EXPECT_THAT([&] { ChooseObject(cloud, segmentation, hint); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("0.12 m away")));
  hint.at.reset();
  hint.colour = kFoam;
  EXPECT_THAT([&] { ChooseObject(cloud, segmentation, hint); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("--colour")));
}

}  // namespace
}  // namespace palpate::study
