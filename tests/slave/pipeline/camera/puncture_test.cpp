// Simulated insertions into embryos, each with a hand, a world and a picture of its own: is the
// puncture told when it happens, and only then? The seeds from 100000 on were never used to tune
// the cue. `Long` ones run all 500.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "slave/pipeline/camera/estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/site/camera/simulated_site.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

constexpr int kFew = 16, kFewPresses = 12, kMany = 500;
constexpr std::uint32_t kUntouched = 100000;
constexpr int kSubsteps = 16;  // of the tool between two pictures

class Draw {
 public:
  explicit Draw(std::uint32_t seed) : random_(seed) {}
  double Between(double least, double most) {
    return least + (most - least) * static_cast<double>(random_()) / 4294967296.0;
  }

 private:
  std::mt19937 random_;
};

// The shipped embryo in the light, focus and place of `seed`, pressed at another place of its rim.
Scene EmbryoOf(std::uint32_t seed) {
  static const Scene shipped = LoadScene(SourcePath("/deploy/scenes/zebrafish-embryo.yaml"));
  Draw draw(seed);
  Scene scene = shipped;
  scene.site.seed = seed;
  scene.site.noise = draw.Between(1, 4);
  scene.site.flicker = draw.Between(0, 0.15);
  scene.site.lighting = draw.Between(0, 0.3);
  scene.site.blur = draw.Between(0.5, 1.1);
  scene.site.misplacement = {draw.Between(-4e-6, 4e-6), draw.Between(-4e-6, 4e-6)};
  scene.site.embryo->debris = static_cast<int>(draw.Between(0, 30));
  scene.site.embryo->defocus = draw.Between(0, 0.8);
  scene.manipulator.home = {0.64e-3, draw.Between(-60e-6, 60e-6), 0};
  return scene;
}

// One world, looked at picture by picture while the tool goes about in it.
class Bench {
 public:
  explicit Bench(const Scene& scene)
      : site_(scene), rate_(scene.sense.Find<Camera>()->rate), p_S_(scene.manipulator.home) {
    estimator_.emplace(scene, Take(), p_S_);
  }

  // The tool goes on at `velocity` [m/s] until the next picture.
  const ContactEstimate& Go(const Eigen::Vector3d& velocity) {
    for (int k = 0; k < kSubsteps; ++k) {
      p_S_ += velocity / (rate_ * kSubsteps);
      site_.MoveTool(p_S_);
    }
    return estimator_->Feel(Take());
  }
  [[nodiscard]] Truth truth() const { return site_.truth(); }
  [[nodiscard]] const Eigen::Vector3d& tip() const { return p_S_; }
  [[nodiscard]] Eigen::Vector3d goal() const { return site_.goal().value(); }

 private:
  Frame Take() {
    Frame frame;
    frame.image = site_.TakePicture();
    frame.sequence = ++pictures_;
    frame.sensed_at = Time{} + Seconds(static_cast<double>(pictures_) / rate_);
    return frame;
  }

  SimulatedSite site_;
  double rate_;
  Eigen::Vector3d p_S_;
  std::uint64_t pictures_ = 0;
  std::optional<Estimator> estimator_;
};

struct Outcome {
  int late = -1;  // pictures between the first that could show it and the one that told it
  bool false_alarm = false;
  bool is_zero = true;  // the force, from the state that told it on
  bool was_felt = false;
};

// Towards the target at 0.1 to 1.5 mm/s, with a pause in some; where the resistance is gone the
// hand surges forward before it stops.
Outcome Insert(std::uint32_t seed) {
  const Scene scene = EmbryoOf(seed);
  Bench bench(scene);
  Draw draw(seed + 7);
  const Eigen::Vector3d way = (bench.goal() - bench.tip()).normalized();
  const double speed = std::exp(draw.Between(std::log(0.15e-3), std::log(1.5e-3)));
  const double surge = draw.Between(0.5, 4);
  const int pause_from = static_cast<int>(draw.Between(4, 60)),
            pause = static_cast<int>(draw.Between(0, 8));
  Outcome outcome;
  int since = -1;
  for (int picture = 0; picture < 400 && since < 8; ++picture) {
    const bool pauses = picture >= pause_from && picture < pause_from + pause;
    const double pace = since >= 0 ? (since < 3 ? surge : 0.2) : (pauses ? 0.0 : 1.0);
    const ContactEstimate& felt = bench.Go(pace * speed * way);
    const Truth truth = bench.truth();
    since = truth.punctured ? since + 1 : since;
    if (felt.force && felt.force->norm() > 5e-3) outcome.was_felt = true;
    if (felt.events.Has(Event::kPuncture) && outcome.late < 0 && !outcome.false_alarm) {
      outcome.late = since;
      outcome.false_alarm = !truth.punctured;
    }
    // A tip that debris hides is an unknown force, not a wrong one.
    if (outcome.late >= 0 && felt.force && !felt.force->isZero(0)) outcome.is_zero = false;
  }
  return outcome;
}

// Presses that break nothing, as deep, as fast and as unsteady: pauses, retreats, slips to the
// side, steps of light. True: a puncture was told.
bool PressWithoutPuncture(std::uint32_t seed) {
  Scene scene = EmbryoOf(seed);
  scene.site.embryo->puncture = {1e-2, 1e-2};
  Bench bench(scene);
  Draw draw(seed + 13);
  const Eigen::Vector3d way = (bench.goal() - bench.tip()).normalized();
  const Eigen::Vector3d aside(-way.y(), way.x(), 0);
  const double speed = std::exp(draw.Between(std::log(0.15e-3), std::log(1.5e-3)));
  const double deepest = draw.Between(60e-6, 190e-6);
  bool alarm = false;
  double slip = 0;
  for (int picture = 0; picture < 50; ++picture) {
    const double depth = bench.truth().depth;
    const double choice = draw.Between(0, 1);
    double pace = depth < deepest ? 1 : 0;
    if (picture > 12 && choice < 0.15) pace = -draw.Between(0.2, 2);
    if (picture > 12 && choice > 0.9) slip = draw.Between(-0.3, 0.3);
    if (picture % 5 == 0) slip = 0;
    const ContactEstimate& felt = bench.Go(speed * (pace * way + slip * aside));
    alarm = alarm || felt.events.Has(Event::kPuncture);
  }
  return alarm;
}

struct Count {
  int told = 0, within_a_picture = 0, false_alarms = 0, not_zero = 0, felt = 0;
};

Count InsertMany(int count) {
  Count counted;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t seed = kUntouched + static_cast<std::uint32_t>(i);
    const Outcome one = Insert(seed);
    counted.told += one.late >= 0 && !one.false_alarm;
    counted.within_a_picture += one.late >= 0 && one.late <= 1 && !one.false_alarm;
    counted.false_alarms += one.false_alarm;
    counted.not_zero += !one.is_zero;
    counted.felt += one.was_felt;
    if (one.late < 0 || one.late > 1 || one.false_alarm) {
      std::printf("seed %u: late %d, false alarm %d\n", seed, one.late, one.false_alarm);
    }
  }
  std::printf("%d insertions: told %d, within a picture %d, false alarms %d\n", count, counted.told,
              counted.within_a_picture, counted.false_alarms);
  return counted;
}

int PressMany(int count) {
  int alarms = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t seed = 2 * kUntouched + static_cast<std::uint32_t>(i);
    const bool alarm = PressWithoutPuncture(seed);
    if (alarm) std::printf("seed %u: a puncture was told where none was\n", seed);
    alarms += alarm;
  }
  std::printf("%d presses without puncture: %d false alarms\n", count, alarms);
  return alarms;
}

// Reference: the simulated site, which alone knows. Tolerances: what was asked for, 99 % detected
// within a picture and one false alarm, of 500.
TEST(Long, FiveHundredPuncturesAreToldWithinAPicture) {
  const Count counted = InsertMany(kMany);
  EXPECT_GE(counted.told, 0.99 * kMany);
  EXPECT_GE(counted.within_a_picture, 0.99 * kMany);
  EXPECT_LE(counted.false_alarms, 1);
  EXPECT_EQ(counted.not_zero, 0);
}

TEST(Long, FiveHundredPressesWithoutPunctureTellNone) {
  EXPECT_LE(PressMany(kMany), 1);
}

TEST(PunctureTest, PuncturesAreToldWithinAPictureAndTheForceIsZeroFromThere) {
  const Count counted = InsertMany(kFew);
  EXPECT_EQ(counted.within_a_picture, kFew);
  EXPECT_EQ(counted.false_alarms, 0);
  EXPECT_EQ(counted.not_zero, 0);
  EXPECT_EQ(counted.felt, kFew) << "the force rises before";
}

TEST(PunctureTest, PressesWithoutPunctureTellNone) {
  EXPECT_EQ(PressMany(kFewPresses), 0);
}

// The cue by itself: each of its three conditions is needed.
class CueTest : public testing::Test {
 protected:
  CueTest() { cue_.Adopt(50e-6); }
  bool Look(double depth_um, double seen_part, bool known = true) {
    const double expected = depth_um / 3;
    return cue_.Broke({.depth = depth_um * 1e-6,
                       .expected_px = expected,
                       .dent_known = known,
                       .seen_px = seen_part * expected,
                       .sigma_px = 0.5});
  }
  PunctureCue cue_;
};

TEST_F(CueTest, ADentThatIsGoneWhileTheToolIsDrivenInIsAPuncture) {
  EXPECT_FALSE(Look(80, 1));
  EXPECT_TRUE(Look(90, 0.05));
}

TEST_F(CueTest, AboveTheDepthWhereMembranesBreakItIsNone) {
  EXPECT_FALSE(Look(40, 1));
  EXPECT_FALSE(Look(45, 0.05));
}

TEST_F(CueTest, ARetreatIsNone) {
  EXPECT_FALSE(Look(120, 1));
  EXPECT_FALSE(Look(95, 0.05));
}

TEST_F(CueTest, ADentThatIsHiddenTellsNothing) {
  EXPECT_FALSE(Look(120, 1));
  EXPECT_FALSE(Look(125, 0, false));
  EXPECT_TRUE(Look(130, 0.05)) << "seen again";
}

TEST_F(CueTest, WhereNoDentWasSeenBeforeTwoPicturesMustAgree) {
  EXPECT_FALSE(Look(80, 0.05));
  EXPECT_TRUE(Look(85, 0.05));
}

TEST_F(CueTest, NobodyLooksUnlessTheSceneSaysSo) {
  cue_.Adopt(0);
  EXPECT_FALSE(Look(80, 1));
  EXPECT_FALSE(Look(90, 0.05));
}

}  // namespace
}  // namespace palpate
