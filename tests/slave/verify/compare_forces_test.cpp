// Tests CompareForces on set-ups with a known fault. The test defines known loads, a matrix that
// the set-up applies to them, and errors of the size stated by sigma.
#include "slave/verify/compare_forces.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>
#include <sstream>
#include <string>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::Not;

// Camera: planar, presses along y with some x. Plate: along z only. Fingertips: every direction.
enum class Sensor { kCamera, kPlate, kFingertips };
constexpr std::array kSensors{Sensor::kCamera, Sensor::kPlate, Sensor::kFingertips};

struct Fault {
  Matrix3d map = Matrix3d::Identity();  // reported = map * known
  double position_scale = 1;
  double sigma_scale = 1;
  Vector3d offset = Vector3d::Zero();  // [N]
};

ForceSource SourceOf(Sensor sensor) {
  using Kind = ForceSource::Kind;
  if (sensor == Sensor::kCamera) return {Kind::kCamera, 127e3, 0.35e-3, "the scale of the pixels"};
  if (sensor == Sensor::kPlate) return {Kind::kCamera, 27e6, 0, "the encoders"};
  return {Kind::kFingertips, 0, 0, "the encoders or the poses of the fingertips"};
}

// Fourteen holds with loads, and three pauses without load. Errors: 2 % common to all loads, 2 % of
// each load, 1 % of each state, as sigma states them.
std::vector<ForceRow> Session(Sensor sensor, unsigned seed, const Fault& fault) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> size(0.3, 2.5);
  const auto noise = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    Vector3d n(x, y, sensor == Sensor::kCamera ? 0 : z);
    return sensor == Sensor::kFingertips ? Vector3d(n / std::sqrt(3.0)) : n;
  };
  const double common = 0.02 * normal(random);
  std::vector<ForceRow> session;
  for (int load = 0; load < 17; ++load) {
    Vector3d direction = Vector3d::UnitZ();
    if (sensor == Sensor::kCamera) direction = {0.5 * normal(random), 1, 0};
    if (sensor == Sensor::kFingertips) direction = noise();
    const Vector3d known =
        load % 6 == 0 ? Vector3d(0, 0, 0) : Vector3d(size(random) * direction.normalized());
    const double force = known.norm();
    const Vector3d of_load = 0.02 * force * noise();
    const Vector3d place(0.001 * load, -0.002 * force,
                         sensor == Sensor::kCamera ? 0 : 0.001 * force);
    for (int i = 0; i < 20; ++i) {
      ForceRow one;
      one.hold = load;
      one.measured = known;
      if (sensor == Sensor::kCamera) one.measured.z() = kUnknown;
      one.p_known = place;
      one.t = load + 0.05 * i;
      one.estimated =
          (1 + common) * (fault.map * known) + of_load + 0.01 * force * noise() + fault.offset;
      one.p_estimated = Vector3d(0.01, 0.02, 0) + fault.position_scale * place + 5e-6 * noise();
      // The loads have an uncertainty of 1 %.
      one.sigma = std::hypot(fault.sigma_scale * 0.03, 0.01) * force;
      session.push_back(one);
    }
  }
  return session;
}

ForceComparison CardOf(Sensor sensor, unsigned seed, const Fault& fault = {}) {
  return CompareForces(Session(sensor, seed, fault), SourceOf(sensor));
}

std::string Causes(const ForceComparison& card) {
  std::string all;
  for (const std::string& cause : card.causes) all += cause + "\n";
  return all;
}

std::string ToText(const ForceComparison& card) {
  std::string text;
  for (const ComparisonLine& line : card.lines) {
    text += line.key + ": " + std::string(ToString(line.finding)) + " " + line.value + " (" +
            line.remark + ")\n";
  }
  return text + Causes(card);
}

Judgement FindingOf(const ForceComparison& card, const char* key) {
  return card.line(key).finding;
}

// Tolerance: 5 % of the reports, which intervals of 95 % permit.
TEST(CompareForcesTest, ACorrectSetUpPassesWithEverySensor) {
  for (const Sensor sensor : kSensors) {
    constexpr unsigned kSeeds = 60;
    unsigned alarms = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const ForceComparison card = CardOf(sensor, seed);
      if (!card.passes()) ++alarms;
      if (!card.passes()) std::puts(ToText(card).c_str());
    }
    EXPECT_LE(alarms, kSeeds * 5 / 100) << static_cast<int>(sensor);
  }
}

Fault MappedForces(const Matrix3d& map, double position_scale = 1) {
  return {.map = map, .position_scale = position_scale};
}
Matrix3d Swap() {
  Matrix3d swap = Matrix3d::Zero();
  swap(0, 1) = swap(1, 0) = swap(2, 2) = 1;
  return swap;
}

// The lines of the report that a fault makes wrong, those that stay right, and a part of the named
// cause.
struct KnownFault {
  const char* name;
  std::vector<Sensor> sensors;
  Fault fault;
  const char* wrong;
  std::string right;
  const char* cause;
};
void PrintTo(const KnownFault& fault, std::ostream* out) {
  *out << fault.name;
}

class KnownFaultTest : public testing::TestWithParam<KnownFault> {};

TEST_P(KnownFaultTest, IsFoundWithItsCauseAndNothingElse) {
  const KnownFault& known = GetParam();
  for (const Sensor sensor : known.sensors) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const ForceComparison card = CardOf(sensor, seed, known.fault);
      EXPECT_EQ(FindingOf(card, known.wrong), Judgement::kWrong) << ToText(card);
      std::istringstream right(known.right);
      for (std::string key; right >> key;) {
        EXPECT_EQ(FindingOf(card, key.c_str()), Judgement::kRight) << key << "\n" << ToText(card);
      }
      EXPECT_THAT(Causes(card), HasSubstr(known.cause));
      if (known.fault.position_scale != 1) {  // the force follows the depth, so that it is scaled
        EXPECT_THAT(Causes(card), Not(HasSubstr("young_modulus")));
      }
    }
  }
}

const std::vector<Sensor> kEvery(kSensors.begin(), kSensors.end());
const std::vector<Sensor> kWithModulus{Sensor::kCamera, Sensor::kPlate};
const std::vector<Sensor> kOneCamera{Sensor::kCamera};
const std::vector<Sensor> kSeveralAxes{Sensor::kCamera, Sensor::kFingertips};
const Matrix3d kOne = Matrix3d::Identity();
const KnownFault kFaults[] = {
    {"SoftModulus", kWithModulus, MappedForces(0.8 * kOne), "magnitude", "sign frame position",
     "object.material.young_modulus"},
    {"StiffModulus", kWithModulus, MappedForces(1.2 * kOne), "magnitude", "sign frame position",
     "object.material.young_modulus"},
    {"ReversedSign", kEvery, MappedForces(-kOne), "sign", "magnitude frame",
     "The sign is reversed on every axis"},
    {"SwappedAxes", kSeveralAxes, MappedForces(Swap()), "frame", "magnitude",
     "known x is reported as y, known y is reported as x"},
    {"SmallPixels", kOneCamera, MappedForces(0.97 * kOne, 0.97), "position", "",
     "sense.camera.pixel"},
    {"LargePixels", kOneCamera, MappedForces(1.03 * kOne, 1.03), "position", "",
     "sense.camera.pixel"},
};
INSTANTIATE_TEST_SUITE_P(Faults, KnownFaultTest, testing::ValuesIn(kFaults),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(CompareForcesTest, ASigmaThatIsTooSmallIsFound) {
  for (const Sensor sensor : kEvery) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const ForceComparison card = CardOf(sensor, seed, {.sigma_scale = 0.2});
      EXPECT_EQ(FindingOf(card, "sigma"), Judgement::kWrong) << ToText(card);
      EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kRight);
      EXPECT_THAT(Causes(card), HasSubstr("Only sigma is wrong"));
    }
  }
}

TEST(CompareForcesTest, APixelScaleAndAModulusAreFoundTogether) {
  const ForceComparison card =
      CardOf(Sensor::kCamera, 1, {.map = 1.3 * Matrix3d::Identity(), .position_scale = 1.03});
  EXPECT_THAT(Causes(card), HasSubstr("sense.camera.pixel"));
  EXPECT_THAT(Causes(card), HasSubstr("young_modulus"));
}

// The map of fingertips: a random permutation with random signs, and a gain for each axis.
TEST(CompareForcesTest, RandomPermutationsSignsAndGainsAreNamed) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    std::mt19937 random(1000 + seed);
    std::array<int, 3> axis{0, 1, 2}, sign{1, 1, 1};
    std::shuffle(axis.begin(), axis.end(), random);
    Matrix3d map = Matrix3d::Zero();
    Vector3d gain;
    for (int j = 0; j < 3; ++j) {
      const auto i = static_cast<std::size_t>(j);
      sign[i] = random() % 2 == 0 ? 1 : -1;
      gain(j) = std::array{0.7, 1.0, 1.35}[random() % 3];
      map(axis[i], j) = sign[i] * gain(j);
    }
    const ForceComparison card = CardOf(Sensor::kFingertips, seed, {.map = map});
    EXPECT_EQ(card.map.relation.axis, axis) << ToText(card) << map;
    EXPECT_EQ(card.map.relation.sign, sign) << ToText(card) << map;
    const bool is_flipped = std::accumulate(sign.begin(), sign.end(), 0) < 3;
    EXPECT_EQ(FindingOf(card, "sign") == Judgement::kWrong, is_flipped) << ToText(card) << map;
    EXPECT_EQ(FindingOf(card, "frame") == Judgement::kWrong, card.map.relation.is_permuted());
    for (int j = 0; j < 3; ++j) {
      const auto& of_axis = card.map.axis_gain[static_cast<std::size_t>(j)];
      ASSERT_TRUE(of_axis);
      EXPECT_NEAR(of_axis->forth.value, gain(j), 0.08 * gain(j)) << map;
    }
    const bool is_scaled = (gain.array() != 1).any();
    EXPECT_EQ(FindingOf(card, "magnitude") == Judgement::kWrong, is_scaled) << ToText(card) << map;
  }
}

TEST(CompareForcesTest, ARotatedFrameIsFoundWithItsAngle) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Vector3d about = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Matrix3d turn = Eigen::AngleAxisd(0.35, about).matrix();
    const ForceComparison card = CardOf(Sensor::kFingertips, seed, {.map = turn});
    EXPECT_EQ(FindingOf(card, "frame"), Judgement::kWrong) << ToText(card);
    EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kRight) << ToText(card);
    EXPECT_EQ(FindingOf(card, "sign"), Judgement::kRight) << ToText(card);
    EXPECT_NEAR(card.map.turn.value, 0.35, 0.05);
  }
}

TEST(CompareForcesTest, AForceWithoutALoadIsFoundAndDoesNotCountAsAScale) {
  const ForceComparison card = CardOf(Sensor::kFingertips, 1, {.offset = {0.4, 0, 0.3}});
  EXPECT_EQ(FindingOf(card, "zero"), Judgement::kWrong);
  EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kRight) << ToText(card);
  EXPECT_THAT(Causes(card), HasSubstr("without a load"));
}

TEST(CompareForcesTest, ADeadSensorIsFound) {
  for (const Sensor sensor : kSensors) {
    auto session = Session(sensor, 1, {});
    for (auto& one : session) one.estimated.setZero();
    const ForceComparison card = CompareForces(session, SourceOf(sensor));
    EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kWrong) << ToText(card);
    EXPECT_THAT(Causes(card), HasSubstr("No force is reported under load"));
  }
}

TEST(CompareForcesTest, FewLoadsDecideNothing) {
  auto session = Session(Sensor::kFingertips, 1, {});
  std::erase_if(session, [](const ForceRow& one) { return one.hold > 3; });
  const ForceComparison card = CompareForces(session, SourceOf(Sensor::kFingertips));
  EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kOpen) << ToText(card);
  EXPECT_FALSE(card.passes());
}

// Numbers that are not finite are unknown, never a verdict.
TEST(CompareForcesTest, UnknownForcesAreLeftOut) {
  auto session = Session(Sensor::kCamera, 1, {});
  for (std::size_t i = 0; i < session.size(); i += 3) session[i].estimated = kUnknownVector3;
  EXPECT_TRUE(CompareForces(session, SourceOf(Sensor::kCamera)).passes());
  for (auto& one : session) one.estimated = kUnknownVector3;
  const ForceComparison card = CompareForces(session, SourceOf(Sensor::kCamera));
  EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kUntested);
  EXPECT_FALSE(card.passes());
}

// 127 kPa instead of 12.7 kPa, or the reverse.
TEST(CompareForcesTest, AModulusInTheWrongPowerOfTenIsNamed) {
  for (const double factor : {10.0, 0.1, 100.0, 1000.0}) {
    for (const Sensor sensor : kWithModulus) {
      for (unsigned seed = 1; seed <= 8; ++seed) {
        auto session = Session(sensor, seed, {});
        for (ForceRow& row : session) row.estimated *= factor, row.sigma *= factor;
        const ForceComparison card = CompareForces(session, SourceOf(sensor));
        EXPECT_FALSE(card.passes());
        EXPECT_THAT(Causes(card), HasSubstr("wrong power of ten")) << ToText(card);
        const bool is_unit = FindingOf(card, "unit") == Judgement::kWrong;
        const bool is_scaled = FindingOf(card, "magnitude") == Judgement::kWrong;
        EXPECT_NE(is_unit, is_scaled) << ToText(card);
        EXPECT_NEAR(card.map.gain.forth.value * card.unit, factor, 0.1 * factor);
      }
    }
  }
}

// A force that is ten times too large must not be explained by the unit kgf.
TEST(CompareForcesTest, AUnitIsNamedOnlyIfTheIntervalHasIt) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto session = Session(Sensor::kPlate, seed, MappedForces(10.4 * kOne));
    const ForceComparison card = CompareForces(session);
    EXPECT_NE(FindingOf(card, "unit"), Judgement::kWrong) << ToText(card);
    EXPECT_EQ(FindingOf(card, "magnitude"), Judgement::kWrong) << ToText(card);
    EXPECT_THAT(Causes(card), Not(HasSubstr("kgf")));
  }
}

TEST(CompareForcesTest, NoRowOrOneRowDecidesNothing) {
  EXPECT_FALSE(CompareForces({}).passes());
  ForceRow row;
  row.measured = row.estimated = Vector3d(0, 1, 0);
  EXPECT_FALSE(CompareForces({row}).passes());
  EXPECT_FALSE(CompareForces({row, row, row}).passes());
}

TEST(CompareForcesTest, TimesThatFallAreRefused) {
  std::vector<ForceRow> rows(3);
  rows[0].t = 0, rows[1].t = 1, rows[2].t = 0.5;
  EXPECT_THROW(CompareForces(rows), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
