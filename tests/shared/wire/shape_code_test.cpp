#include "shared/wire/shape_code.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kUnit = 2e-5;  // of a body of 0.1 m: twice 1e-4 of its size [m]
constexpr std::size_t kBudget = 4'800'000 / 8 / 30;  // [bytes] of a message at 30 Hz
constexpr std::size_t kUnbounded = 1U << 30;

// A square of side 0.1 m, `side` nodes each way, at height 0.
std::vector<float> Square(int side) {
  std::vector<float> rest;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const auto at = [side](int k) {
        return 0.1F * static_cast<float>(k) / static_cast<float>(side - 1);
      };
      rest.insert(rest.end(), {at(i), at(j), 0.F});
    }
  }
  return rest;
}

// Pressed `depth` deep at (x, y), as a half-space is outside the load: all of it moves, as 1 / r,
// also sideways.
std::vector<float> Pressed(const std::vector<float>& rest, double x, double y, double depth) {
  std::vector<float> positions = rest;
  constexpr double kRadius = 4e-3;
  for (std::size_t i = 0; i < rest.size(); i += 3) {
    const double dx = rest[i] - x, dy = rest[i + 1] - y;
    const double share = kRadius / std::hypot(kRadius, dx, dy);
    positions[i] -= static_cast<float>(0.3 * depth * share * share * dx / kRadius);
    positions[i + 1] -= static_cast<float>(0.3 * depth * share * share * dy / kRadius);
    positions[i + 2] -= static_cast<float>(depth * share);
  }
  return positions;
}

// Both ends of a stream.
struct Line {
  explicit Line(std::vector<float> at_rest) : rest(std::move(at_rest)), units(rest.size(), 0) {
    encoder.Restart(rest.size() / 3, kUnit);
  }
  // Bytes that it took.
  std::size_t Send(const std::vector<float>& positions, std::size_t budget) {
    const auto code = encoder.Encode(rest, positions, budget);
    EXPECT_TRUE(code);
    EXPECT_TRUE(Decode(*code, &units));
    exponent = code->exponent;
    worst = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const double moved = static_cast<double>(positions[i]) - rest[i];
      worst = std::max(worst, std::abs(kUnit * units[i] - moved));
    }
    return code->moves.size();
  }
  [[nodiscard]] double stated() const { return encoder.error(); }

  std::vector<float> rest;
  ShapeUnits units;
  ShapeEncoder encoder;
  int exponent = 0;
  double worst = 0;  // [m]
};

constexpr double kRounding = 1 + 1e-9;

// Reference: the sum of what was sent against what was to be sent, coordinate by coordinate, over
// presses that wander. Rounding errors that added up would pass the stated one soon.
TEST(ShapeCodeTest, ACoordinateIsNeverOffByMoreThanStated) {
  Line line(Square(41));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 0.1), depth(0, 5e-3);
  for (int i = 0; i < 300; ++i) {
    line.Send(Pressed(line.rest, place(random), place(random), depth(random)), kUnbounded);
    ASSERT_EQ(line.exponent, 0);
    ASSERT_LE(line.worst, line.stated() * kRounding) << "message " << i;
  }
}

// A body of 100 352 triangles, pressed and stroked for 4 s at 30 Hz as a hand does it: 5 mm deep
// within a second, then sideways at 20 mm/s, then let go. Reference: 5 Mbit/s, of which 4.8 are the
// moves'; the error asked for is 1e-4 of the size.
TEST(ShapeCodeTest, AHundredThousandTrianglesThatArePressedTravelWithinFiveMegabitsASecond) {
  Line line(Square(225));
  for (int i = 0; i < 120; ++i) {
    const double t = i / 30.0;
    const double depth = 5e-3 * std::min({1.0, t, std::max(0.0, 4.0 - t)});
    const std::size_t size = line.Send(
        Pressed(line.rest, 0.03 + 0.02 * std::clamp(t - 1, 0.0, 2.0), 0.05, depth), kBudget);
    ASSERT_LE(size, kBudget);
    ASSERT_LE(line.worst, line.stated() * kRounding);
    ASSERT_LE(line.stated(), 4e-4 * 0.1) << "frame " << i;
  }
}

// What jumps from end to end costs as much as it may, and is sent exactly soon after it rests.
TEST(ShapeCodeTest, WhatWasCoarseBecomesAsFineAsAskedForWhenItRests) {
  Line line(Square(225));
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 1e-3F);
  std::vector<float> shaken = line.rest;
  for (float& x : shaken) x += noise(random);
  ASSERT_LE(line.Send(shaken, kBudget), kBudget);
  EXPECT_GT(line.exponent, 0);
  EXPECT_LE(line.worst, line.stated() * kRounding);
  for (int i = 0; i < 120 && line.stated() > kUnit / 2; ++i) {
    ASSERT_LE(line.Send(shaken, kBudget), kBudget);
    ASSERT_LE(line.worst, line.stated() * kRounding);
  }
  EXPECT_EQ(line.stated(), kUnit / 2);
}

TEST(ShapeCodeTest, WhatCannotBeCodedIsRefused) {
  ShapeEncoder encoder;
  encoder.Restart(1, kUnit);
  EXPECT_FALSE(encoder.Encode({0, 0, 0}, {0, 0, NAN}, kUnbounded));
  EXPECT_FALSE(encoder.Encode({0, 0, 0}, {0, 0, 1e30F}, kUnbounded));
  EXPECT_FALSE(encoder.Encode({0, 0, 0}, {0, 0}, kUnbounded));
  EXPECT_TRUE(encoder.Encode({0, 0, 0}, {0, 1, 2}, kUnbounded));
}

// Each byte of a code changed, and each code cut short: taken as another one, or refused with
// everything as it was.
TEST(ShapeCodeTest, DamagedCodesAreRefusedOrAreCodes) {
  ShapeEncoder encoder;
  const auto rest = Square(9);
  encoder.Restart(rest.size() / 3, kUnit);
  const ShapeCode code = *encoder.Encode(rest, Pressed(rest, 0.05, 0.05, 3e-3), kUnbounded);
  const ShapeUnits before(rest.size(), 7);
  for (std::size_t i = 0; i < code.moves.size(); ++i) {
    ShapeCode cut = code, bent = code;
    cut.moves.resize(i);
    bent.moves[i] = static_cast<char>(bent.moves[i] ^ 0x55);
    ShapeUnits units = before;
    EXPECT_FALSE(Decode(cut, &units)) << i;
    EXPECT_EQ(units, before);
    const bool is_code = Decode(bent, &units);
    EXPECT_TRUE(is_code || units == before) << i;
    EXPECT_EQ(units.size(), before.size());
  }
  ShapeUnits other(rest.size() + 3, 0), units = before;
  EXPECT_FALSE(Decode(code, &other)) << "of another number of nodes";
  EXPECT_FALSE(Decode({21, code.moves}, &units));
  EXPECT_FALSE(Decode({-1, code.moves}, &units));
}

// Reference: the numbers themselves, at most half a step off. A contact patch on 50 625 nodes costs
// next to nothing; numbers without any order are sent in coarser steps, and still within half of
// what a message of 30 a second may take.
TEST(TractionCodeTest, ANodeIsNeverOffByMoreThanHalfAStepAndTheBudgetHolds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(0, 1e5);
  std::vector<double> patch(225 * 225, 0), noise(patch);
  for (std::size_t i = 25'000; i < 25'100; ++i) patch[i] = any(random);
  for (double& pascals : noise) pascals = any(random);
  for (const auto* pascals : {&patch, &noise}) {
    const NodeTraction quantised = Quantised(*pascals, kBudget / 2);
    const std::string packed = Packed(quantised);
    EXPECT_LE(packed.size(), kBudget / 2);
    const auto back = Unpacked(quantised.unit, packed, pascals->size());
    ASSERT_TRUE(back);
    double worst = 0;
    for (std::size_t i = 0; i < pascals->size(); ++i) {
      worst = std::max(worst, std::abs(back->steps[i] * back->unit - (*pascals)[i]));
    }
    EXPECT_LE(worst, quantised.unit / 2 * kRounding);
  }
  EXPECT_LE(Packed(Quantised(patch, kBudget / 2)).size(), 300U);
}

TEST(TractionCodeTest, DamagedTractionIsRefused) {
  const std::string packed = Packed({1, {1, 2, 3, 200}});
  EXPECT_TRUE(Unpacked(1, packed, 4));
  for (const double unit : {0.0, -1.0, 1e300, std::nan("")})
    EXPECT_FALSE(Unpacked(unit, packed, 4));
  EXPECT_FALSE(Unpacked(1, packed, 3));
  EXPECT_FALSE(Unpacked(1, packed, 5));
  for (std::size_t cut = 0; cut < packed.size(); ++cut) {
    EXPECT_FALSE(Unpacked(1, packed.substr(0, cut), 4)) << cut;
  }
}

}  // namespace
}  // namespace palpate
