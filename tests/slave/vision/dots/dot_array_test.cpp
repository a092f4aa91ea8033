#include "slave/vision/dots/dot_array.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/dots/dot_images.h"
#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

const std::vector<Eigen::Vector2d>& Array31() {
  static const auto layout = LatticePlaces(31, {0.015, 0.010});
  return layout;
}

// A plane seen in perspective: shift [px], rotation, tilt about two axes.
struct View {
  Eigen::Vector2d shift{320, 240};
  double turn = 0, tilt_x = 0, tilt_y = 0, scale = 3200;  // [px/m]
  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d turned = Eigen::Rotation2Dd(turn) * p;
    const double depth = 1 + tilt_x * turned.x() + tilt_y * turned.y();
    return shift + scale * turned / depth;
  }
};

std::vector<Dot> SeenDots(const std::vector<Eigen::Vector2d>& layout, const View& view) {
  std::vector<Dot> dots;
  for (const Eigen::Vector2d& p : layout) {
    dots.emplace_back().centre = view(p);
    dots.back().area = 130;
  }
  return dots;
}

std::vector<Eigen::Vector2d> Places(const std::vector<Eigen::Vector2d>& layout, const View& view) {
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector2d& p : layout) places.push_back(view(p));
  return places;
}

// Returns the number of correctly identified dots if the dots are given in the order `order`.
int Right(const std::vector<int>& picks, const std::vector<int>& order) {
  int right = 0;
  for (std::size_t k = 0; k < picks.size(); ++k) {
    if (picks[k] >= 0 && order[static_cast<std::size_t>(picks[k])] == static_cast<int>(k)) ++right;
  }
  return right;
}

struct Shuffled {
  std::vector<Dot> dots;
  std::vector<int> order;  // identity; -1: spurious
};

Shuffled Shuffle(const std::vector<Dot>& dots, const std::set<int>& without, int spurious,
                 std::mt19937& random) {
  Shuffled shuffled;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    if (!without.contains(static_cast<int>(k))) shuffled.order.push_back(static_cast<int>(k));
  }
  for (int i = 0; i < spurious; ++i) shuffled.order.push_back(-1);
  std::shuffle(shuffled.order.begin(), shuffled.order.end(), random);
  std::uniform_real_distribution<double> x(0, 640), y(0, 480);
  for (const int k : shuffled.order) {
    if (k >= 0) {
      shuffled.dots.push_back(dots[static_cast<std::size_t>(k)]);
      continue;
    }
    Dot dot;
    dot.area = 130;
    do {  // away from the array's dots, since a spurious dot on one of them cannot be distinguished
      dot.centre = {x(random), y(random)};
    } while (std::any_of(dots.begin(), dots.end(), [&](const Dot& other) {
      return (other.centre - dot.centre).norm() < 12;
    }));
    shuffled.dots.push_back(dot);
  }
  return shuffled;
}

// Reference: g_vision.json, circle_centroid_bias; exact for a pinhole.
TEST(CircleBias, IsWhatTheReferenceSays) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "circle_centroid_bias");
  const auto& params = reference.at("params");
  Lens lens;
  lens.fx = lens.fy = params.at("f_px");
  lens.size = {640, 480};
  const double tilt = params.at("tilt_rad");
  const auto bias = CircleCentroidBias(lens, {0, 0, params.at("Z0_m")},
                                       {std::sin(tilt), 0, -std::cos(tilt)}, params.at("r_m"));
  ASSERT_TRUE(bias.has_value());
  EXPECT_NEAR(bias->x(), reference.at("expected").at("bias_px").get<double>(), 1e-10);
  EXPECT_NEAR(bias->y(), 0, 1e-12);
}

// Reference: the centre of the ellipse that is the disc's image, where the gradient of its conic
// vanishes. The conic comes from the renderer, which uses another derivation.
TEST(CircleBias, IsTheCentreOfTheConicForAnyPlaceAndTilt) {
  const Lens lens = SceneLens();
  const Eigen::Vector3d p_C(0.031, -0.022, 0.24);
  const Eigen::Vector3d n_C = Eigen::Vector3d(0.4, -0.3, -0.9).normalized();
  const Conic Q = DiscSeen(lens, p_C, n_C, 0.004);
  const Eigen::Vector2d centre = -Q.topLeftCorner<2, 2>().inverse() * Q.topRightCorner<2, 1>();
  const auto bias = CircleCentroidBias(lens, p_C, n_C, 0.004);
  ASSERT_TRUE(bias.has_value());
  EXPECT_LT((*Project(lens, p_C) + *bias - centre).norm(), 1e-8);
  EXPECT_GT(bias->norm(), 0.05);
  EXPECT_FALSE(CircleCentroidBias(lens, {0, 0, -0.2}, {0, 0, 1}, 0.004).has_value());
  EXPECT_FALSE(CircleCentroidBias(lens, {0, 0, std::nan("")}, {0, 0, 1}, 0.004).has_value());
}

const std::vector<double> kAnyArea(31, 0);

// Reference: the order in which the dots were shuffled. The expected positions are without rotation
// and tilt.
TEST(DotArray, IsIdentifiedTurnedShiftedAndTilted) {
  const DotArray array(Array31());
  std::mt19937 random(3);
  for (const double turn : {-0.15, 0.0, 0.1}) {
    for (const double tilt : {-3.0, 0.0, 3.0}) {
      const View view{{300, 260}, turn, tilt, -0.7 * tilt};
      const Shuffled seen = Shuffle(SeenDots(Array31(), view), {}, 0, random);
      std::vector<int> picks;
      EXPECT_EQ(array.Identify(seen.dots, Places(Array31(), {}), kAnyArea, &picks), 31)
          << turn << " " << tilt;
      EXPECT_EQ(Right(picks, seen.order), 31) << turn << " " << tilt;
    }
  }
}

// Up to five dots are missing, and there are ten spurious dots.
TEST(DotArray, MissingAndSpuriousDotsDoNotMixIdentities) {
  const DotArray array(Array31());
  std::mt19937 random(5);
  for (int trial = 0; trial < 60; ++trial) {
    std::set<int> without;
    while (static_cast<int>(without.size()) < trial % 6) {
      without.insert(static_cast<int>(random() % 31));
    }
    const View view{{320, 240}, 0.003 * (trial - 30), 1, -2};
    const Shuffled seen = Shuffle(SeenDots(Array31(), view), without, 10, random);
    std::vector<int> picks;
    array.Identify(seen.dots, Places(Array31(), {}), kAnyArea, &picks);
    const int there = 31 - static_cast<int>(without.size());
    EXPECT_EQ(Right(picks, seen.order), there) << trial;
  }
}

TEST(DotArray, TooManyDotsAndInvalidImagesGiveNoIdentity) {
  const DotArray array(Array31());
  const auto places = Places(Array31(), {});
  std::vector<int> picks;
  EXPECT_EQ(array.Identify({}, places, kAnyArea, &picks), 0);
  EXPECT_EQ(picks, std::vector<int>(31, DotArray::kNoDot));
  std::mt19937 random(6);
  const Shuffled crowd = Shuffle({}, {}, 1000, random);
  array.Identify(crowd.dots, places, kAnyArea, &picks);
  for (const int pick : picks) EXPECT_LT(pick, 1000);
  const std::vector<Eigen::Vector2d> nowhere(31, Eigen::Vector2d::Constant(std::nan("")));
  EXPECT_EQ(array.Identify(crowd.dots, nowhere, kAnyArea, &picks), 0);
  EXPECT_EQ(array.Identify(crowd.dots, {}, kAnyArea, &picks), 0);
}

}  // namespace
}  // namespace palpate
