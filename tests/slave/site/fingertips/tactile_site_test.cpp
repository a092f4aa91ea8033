#include "slave/site/fingertips/tactile_site.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/site/fingertips/touch_scenes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using site::CubeScene;
using site::PinchScene;

// Forces on it are 10 to 30 % off, ladders are solved in a tenth of the time.
constexpr SiteResolution kCoarse{.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};

std::string Refusal(const Scene& scene) {
  try {
    const TactileSite site(scene, kCoarse);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

void PressBy(TactileSite* site, double depth, const Vector3d& beside = {0, 0, 0}) {
  site->MoveTool(site->home() + (site->gap() + depth) * site->approach() + beside);
}

TEST(TactileSite, PushesBackAgainstThePressAndLetsGo) {
  TactileSite site(CubeScene(), kCoarse);
  EXPECT_TRUE(site.approach().isApprox(Vector3d(0, 0, -1)));
  EXPECT_NEAR(site.gap(), 5e-3, 1e-6);  // a node lies right under the tip
  EXPECT_FALSE(site.truth().fingers[0].in_contact);
  double last = 0;
  for (const double depth : {0.3e-3, 0.8e-3, 1.5e-3, 2.5e-3}) {
    PressBy(&site, depth);
    const FingerTruth truth = site.truth().fingers[0];
    ASSERT_TRUE(truth.in_contact);
    EXPECT_GT(truth.force.z(), 1.2 * last);
    EXPECT_LT(truth.force.head<2>().norm(), 0.1 * truth.force.z());
    EXPECT_NEAR(truth.depth, depth, 0.02 * depth);
    EXPECT_LT((truth.p_S_contact - Vector3d(0.03, 0.03, 0.06 - depth)).norm(), 0.7e-3);
    last = truth.force.z();
  }
  // Hertz at 2.5 mm: 0.0542 N; see PressedBody's tests.
  EXPECT_NEAR(last, 0.0542, 0.014);
  PressBy(&site, -1e-3);
  EXPECT_FALSE(site.truth().fingers[0].in_contact);
  EXPECT_EQ(site.truth().fingers[0].force.norm(), 0);
}

// Reference: a press by two fingers that mirror each other in a plane of the body's symmetry, and
// so do the hexahedra. Tolerance: Newton's method stops at residuals of 1e-5.
TEST(TactileSite, PinchingFingersFeelOppositeForces) {
  TactileSite site(PinchScene(), kCoarse);
  EXPECT_TRUE(site.approach().isApprox(Vector3d(0, -1, 0)));
  PressBy(&site, 1.5e-3);
  const auto truth = site.truth().fingers;
  ASSERT_TRUE(truth[0].in_contact && truth[1].in_contact);
  EXPECT_GT(truth[0].force.y(), 0.03);
  const Vector3d mirrored = truth[1].force.cwiseProduct(Vector3d(1, -1, 1));
  EXPECT_LT((truth[0].force - mirrored).norm(), 1e-4 * truth[0].force.norm());
  EXPECT_NEAR(truth[1].X_SF.translation().y(), -0.012 + 6.5e-3, 1e-9);
}

TEST(TactileSite, AStandingFingerIsPressedByTheBodyThatGivesWay) {
  Scene scene = PinchScene();
  scene.sense.Find<Tactile>()->fingers[1].motion = Finger::Motion::kStands;
  scene.sense.Find<Tactile>()->fingers[1].X_SF.translation().y() = -7e-3;  // it touches
  TactileSite site(scene, kCoarse);
  PressBy(&site, 2.5e-3);
  const auto truth = site.truth().fingers;
  EXPECT_GT(truth[0].force.y(), 0.05);
  EXPECT_TRUE(truth[1].in_contact);
  EXPECT_LT(truth[1].force.y(), -0.005);
  EXPECT_LT(-truth[1].force.y(), truth[0].force.y());
  EXPECT_NEAR(truth[1].X_SF.translation().y(), -7e-3, 1e-12);
}

// Reference: Mindlin 1949, tangential over normal stiffness 2 (1 - nu) / (2 - nu), and no more than
// a friction of 1.
TEST(TactileSite, SidewaysMotionIsHeldUntilItSlips) {
  TactileSite site(CubeScene(), kCoarse);
  PressBy(&site, 1.95e-3);
  const double below = site.truth().fingers[0].force.z();
  PressBy(&site, 2e-3);
  const double normal = site.truth().fingers[0].force.z();
  const double across = site.truth().fingers[0].force.x();
  PressBy(&site, 2e-3, {0.1e-3, 0, 0});
  const double held = across - site.truth().fingers[0].force.x();
  const double stiffness = (normal - below) / 0.05e-3;
  EXPECT_NEAR(held, 2 * 0.85 / 1.85 * stiffness * 0.1e-3, 0.15 * held);
  PressBy(&site, 2e-3, {20e-3, 0, 0});
  EXPECT_NEAR(across - site.truth().fingers[0].force.x(), normal, 0.05 * normal);
  PressBy(&site, -1e-3);
  PressBy(&site, 2e-3);  // it stuck anew
  EXPECT_NEAR(site.truth().fingers[0].force.x(), across, 1e-9);
}

TEST(TactileSite, AnOppositeFingerOnTheSameSideTouchesNothingOnTheWay) {
  Scene scene = CubeScene();
  Finger other = scene.sense.Find<Tactile>()->fingers[0];
  other.name = "th";
  other.motion = Finger::Motion::kOpposite;
  other.X_SF.translation().y() = 0.01;
  scene.sense.Find<Tactile>()->fingers.push_back(other);
  TactileSite site(scene, kCoarse);
  EXPECT_NEAR(site.gap(), 5e-3, 1e-6);
  PressBy(&site, 1e-3);
  EXPECT_TRUE(site.truth().fingers[0].in_contact);
  EXPECT_FALSE(site.truth().fingers[1].in_contact);
}

TEST(TactileSite, SurfaceIsClosedAndDentsUnderTheFinger) {
  TactileSite site(CubeScene(), kCoarse);
  const SurfaceMesh rest = site.rest_surface();
  const auto volume = [&](const std::vector<Vector3d>& nodes) {
    double sum = 0;
    for (const auto& [a, b, c] : rest.triangles) {
      sum += nodes[static_cast<std::size_t>(a)].dot(
                 nodes[static_cast<std::size_t>(b)].cross(nodes[static_cast<std::size_t>(c)])) /
             6;
    }
    return sum;
  };
  EXPECT_NEAR(volume(rest.nodes), 0.06 * 0.06 * 0.06, 1e-9 * 2.16e-4);
  EXPECT_EQ(site.DeformedSurface(), rest.nodes);
  PressBy(&site, 2e-3);
  const auto deformed = site.DeformedSurface();
  ASSERT_EQ(deformed.size(), rest.nodes.size());
  EXPECT_LT(volume(deformed), volume(rest.nodes));
  double deepest = 0;
  for (std::size_t i = 0; i < deformed.size(); ++i) {
    deepest = std::max(deepest, rest.nodes[i].z() - deformed[i].z());
    if (rest.nodes[i].z() == 0) {
      EXPECT_EQ(deformed[i], rest.nodes[i]);  // glued
    }
  }
  EXPECT_NEAR(deepest, 2e-3, 0.02e-3);
}

TEST(TactileSite, PosesOfObjectAndHandTurnTheWholeWorld) {
  Scene scene = CubeScene();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(1.1, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.2, -0.1, 0.4);
  scene.object.X_SO = X;
  scene.sense.Find<Tactile>()->fingers[0].X_SF = X * scene.sense.Find<Tactile>()->fingers[0].X_SF;
  TactileSite turned(scene, kCoarse), plain(CubeScene(), kCoarse);
  PressBy(&turned, 1e-3);
  PressBy(&plain, 1e-3);
  const FingerTruth a = turned.truth().fingers[0], b = plain.truth().fingers[0];
  EXPECT_LT((a.force - X.linear() * b.force).norm(), 1e-6 * b.force.norm());
  EXPECT_LT((a.p_S_contact - X * b.p_S_contact).norm(), 1e-9);
  // The skin feels the same in its own frame.
  const TactileFrame fa = turned.TakeSample(Time{}), fb = plain.TakeSample(Time{});
  EXPECT_EQ(fa.fingers[0].electrodes, fb.fingers[0].electrodes);
}

TEST(TactileSite, MisplacedObjectIsMetEarlier) {
  Scene scene = PinchScene();
  scene.site.misplacement = {0, 1e-3};
  EXPECT_NEAR(TactileSite(scene, kCoarse).gap(), 4e-3, 1e-6);
}

TEST(TactileSite, SamplesTellOfTheTouchAndOfThePose) {
  TactileSite site(CubeScene(), kCoarse);
  float rest = 0;
  for (int i = 0; i < 50; ++i) rest += site.TakeSample(Time{}).fingers[0].pdc / 50;
  PressBy(&site, 4e-3);
  TactileFrame frame;
  for (int i = 0; i < 50; ++i) frame = site.TakeSample(Time{} + Seconds(1 + i));
  EXPECT_EQ(frame.sequence, 100U);
  EXPECT_EQ(frame.sensed_at, Time{} + Seconds(50));
  EXPECT_TRUE(frame.fingers[0].present);
  EXPECT_FALSE(frame.fingers[1].present);
  EXPECT_GT(frame.fingers[0].pdc, rest + 10);
  ASSERT_TRUE(frame.fingers[0].X_SF);
  EXPECT_TRUE(frame.fingers[0].X_SF->isApprox(site.truth().fingers[0].X_SF));
}

TEST(TactileSite, SameCallsGiveTheSameSamples) {
  TactileSite a(CubeScene(), kCoarse), b(CubeScene(), kCoarse);
  for (int i = 0; i < 120; ++i) {
    const double depth = 1e-3 * (i % 40 < 20 ? i % 20 : -5) / 10;
    PressBy(&a, depth, {0.02e-3 * i, 0, 0});
    if (i == 30) std::this_thread::sleep_for(std::chrono::milliseconds(200));
    PressBy(&b, depth, {0.02e-3 * i, 0, 0});
    const TactileFrame fa = a.TakeSample(Time{}), fb = b.TakeSample(Time{});
    ASSERT_EQ(fa.fingers[0].electrodes, fb.fingers[0].electrodes) << i;
    ASSERT_EQ(a.truth().fingers[0].force, b.truth().fingers[0].force);
  }
}

TEST(TactileSite, AnotherPlaceIsSolvedForItself) {
  TactileSite site(CubeScene(), kCoarse);
  const Vector3d beside(0, -0.026, 0);  // 4 mm from the edge, where less foam carries
  PressBy(&site, 1.5e-3);
  const double middle = site.truth().fingers[0].force.z();
  PressBy(&site, -2e-3, beside);
  PressBy(&site, 1.5e-3, beside);
  ASSERT_TRUE(site.truth().fingers[0].in_contact);
  EXPECT_LT(site.truth().fingers[0].force.z(), 0.97 * middle);
  PressBy(&site, -2e-3, {0.2, 0, 0});
  PressBy(&site, 30e-3, {0.2, 0, 0});  // past the object
  EXPECT_FALSE(site.truth().fingers[0].in_contact);
}

TEST(TactileSite, ImpossiblePlacesAreIgnored) {
  TactileSite site(CubeScene(), kCoarse);
  PressBy(&site, 1e-3);
  const FingerTruth before = site.truth().fingers[0];
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), inf, -inf, 1e300}) {
    site.MoveTool({0, bad, 0});
    EXPECT_EQ(site.truth().fingers[0].force, before.force);
    EXPECT_TRUE(site.TakeSample(Time{}).fingers[0].X_SF->matrix().allFinite());
  }
  PressBy(&site, 0.05);  // through nearly all of the cube, far beyond what is solved
  EXPECT_TRUE(site.truth().fingers[0].force.allFinite());
  EXPECT_GT(site.truth().fingers[0].force.z(), before.force.z());
}

TEST(TactileSite, MoversReadersAndSamplersMayBeDifferentThreads) {
  TactileSite site(CubeScene(), kCoarse);
  PressBy(&site, 0.5e-3);  // solved before the race begins
  std::atomic<bool> stop{false};
  std::jthread mover([&] {
    for (int i = 0; !stop; ++i) PressBy(&site, 1e-5 * (i % 50));
  });
  std::jthread reader([&] {
    while (!stop) EXPECT_TRUE(site.truth().fingers[0].force.allFinite());
  });
  for (int i = 0; i < 300; ++i) site.TakeSample(Time{});
  EXPECT_EQ(site.DeformedSurface().size(), site.rest_surface().nodes.size());
  stop = true;
}

TEST(TactileSite, RefusesWhatItCannotSimulateAndNamesTheKey) {
  const auto refused = [](const std::function<void(Scene*)>& change) {
    Scene scene = CubeScene();
    change(&scene);
    return Refusal(scene);
  };
  EXPECT_EQ(Refusal(CubeScene()), "");
  const auto names = [](const std::string& text, const char* key) {
    return text.find(key) != std::string::npos;
  };
  EXPECT_TRUE(names(refused([](Scene* s) { s->sense = {}; }), "sense.tactile"));
  EXPECT_TRUE(
      names(refused([](Scene* s) { s->sense.Find<Tactile>()->fingers.clear(); }), "fingers"));
  EXPECT_TRUE(
      names(refused([](Scene* s) { s->sense.Find<Tactile>()->fingers.resize(6); }), "fingers"));
  EXPECT_TRUE(names(refused([](Scene* s) { s->sense.Find<Tactile>()->rate = 0; }), "tactile.rate"));
  EXPECT_TRUE(
      names(refused([](Scene* s) { s->sense.Find<Tactile>()->finger_radius = -1; }), "radius"));
  EXPECT_TRUE(names(refused([](Scene* s) { s->object.fixed.clear(); }), "object.fixed"));
  EXPECT_TRUE(names(refused([](Scene* s) {
                      s->object.geometry = RectangleGeometry{0.1, 0.1, 0.01};
                    }),
                    "object.geometry"));
  EXPECT_TRUE(names(refused([](Scene* s) {
                      s->sense.Find<Tactile>()->fingers[0].motion = Finger::Motion::kStands;
                    }),
                    "fingers.ff.motion"));
  EXPECT_TRUE(
      names(refused([](Scene* s) { s->object.material.poisson_ratio = 0.5; }), "poisson_ratio"));
}

TEST(TactileSite, RefusesAFingertipInsideTheObject) {
  for (const double height : {0.03, 0.055, 0.0665}) {  // in the middle, half in, half a mm in
    Scene scene = CubeScene();
    scene.sense.Find<Tactile>()->fingers[0].X_SF.translation().z() = height;
    EXPECT_NE(Refusal(scene).find("fingers.ff.pose"), std::string::npos) << height;
  }
  Scene scene = PinchScene();
  scene.sense.Find<Tactile>()->fingers[1].X_SF.translation().y() = 0.01;
  EXPECT_NE(Refusal(scene).find("fingers.th.pose"), std::string::npos);
}

TEST(ScriptedTouch, RestsPressesHoldsAndLetsGo) {
  Scene scene = CubeScene();
  TactileSite site(scene, kCoarse);
  ScriptedTouch touch(site, scene, 2);
  const std::stop_source never;
  std::uint64_t samples = 0, contacts = 0;
  double deepest = 0, at_deepest = 0;
  bool was_touching = false;
  while (const auto frame = touch.Next(never.get_token())) {
    ++samples;
    const double t = SecondsBetween(Time{}, frame->sensed_at);
    EXPECT_NEAR(t, static_cast<double>(samples - 1) / 100, 1e-8);
    const FingerTruth truth = site.truth().fingers[0];
    if (t < 0.7) {
      EXPECT_FALSE(truth.in_contact);
    }
    if (truth.in_contact && !was_touching) ++contacts;
    was_touching = truth.in_contact;
    if (truth.depth > deepest) deepest = truth.depth, at_deepest = t;
  }
  EXPECT_EQ(contacts, 2U);
  EXPECT_NEAR(deepest, scene.operator_options.press_depth, 1e-5);
  EXPECT_GT(at_deepest, touch.hold_begin() - 0.1);
  EXPECT_NEAR(static_cast<double>(samples), touch.duration() * 100, 2);
  EXPECT_FALSE(was_touching);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(ScriptedTouch(site, scene).Next(stop.get_token()));
}

TEST(ScriptedTouch, RefusesToPressNothing) {
  Scene scene = CubeScene();
  scene.operator_options.press_depth = 0;
  TactileSite site(scene, kCoarse);
  EXPECT_THROW(ScriptedTouch(site, scene), std::invalid_argument);
}

TEST(TactileSite, LiveSamplesEndAtOnceWhenStopped) {
  TactileSite site(CubeScene(), kCoarse);
  const auto fingers = site.OpenFingertips(CubeScene(), {});
  std::stop_source stop;
  const auto first = fingers->Next(stop.get_token()), second = fingers->Next(stop.get_token());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->sequence, first->sequence + 1);
  EXPECT_GT(second->sensed_at, first->sensed_at);
  stop.request_stop();
  EXPECT_FALSE(fingers->Next(stop.get_token()));
}

}  // namespace
}  // namespace palpate
