// Tests CompareForces on records with a known corruption. Each case has independent random signals
// and errors.
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/verify/compare_forces.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kRows = 1200;
constexpr double kStep = 0.01;       // between rows [s]
constexpr double kAxisNoise = 0.02;  // standard deviation of each axis of the estimate [N]
constexpr unsigned kCaseSeeds = 4;   // independent signals of each case

// Sums of sines: presses along -z of up to some 3 N, with tangential forces.
class Signal {
 public:
  explicit Signal(unsigned seed) : random_(seed) {
    std::uniform_real_distribution<double> rate(1.2, 4.5), phase(0, 6.3), size(0.3, 0.6);
    for (auto& axis : waves_) {
      for (Wave& wave : axis) wave = {size(random_), rate(random_), phase(random_)};
    }
  }
  [[nodiscard]] Vector3d At(double t) const {
    Vector3d force(0, 0, -1.5);
    for (int axis = 0; axis < 3; ++axis) {
      for (const Wave& wave : waves_[static_cast<std::size_t>(axis)]) {
        force(axis) += wave.size * std::sin(wave.rate * t + wave.phase);
      }
    }
    return force;
  }
  Vector3d Noise() {
    std::normal_distribution<double> normal(0, kAxisNoise);
    const double x = normal(random_), y = normal(random_), z = normal(random_);
    return {x, y, z};
  }

 private:
  struct Wave {
    double size = 0, rate = 0, phase = 0;  // [N], [rad/s], [rad]
  };
  std::mt19937 random_;
  std::array<std::array<Wave, 3>, 3> waves_;
};

// The estimate is the true force at `time(t)`, with errors.
std::vector<ForceRow> Record(
    unsigned seed, const std::function<double(double)>& time = [](double t) { return t; }) {
  Signal signal(seed);
  std::vector<ForceRow> rows;
  for (int i = 0; i < kRows; ++i) {
    ForceRow row;
    row.t = kStep * i;
    row.measured = signal.At(row.t);
    row.estimated = signal.At(time(row.t)) + signal.Noise();
    row.sigma = kAxisNoise;
    rows.push_back(row);
  }
  return rows;
}

std::string WrongOf(const ForceComparison& comparison) {
  std::string wrong;
  for (const ComparisonLine& line : comparison.lines) {
    if (line.finding == Judgement::kWrong) wrong += (wrong.empty() ? "" : " ") + line.key;
  }
  return wrong;
}

std::string TextOf(const ForceComparison& comparison) {
  std::string text;
  for (const ComparisonLine& line : comparison.lines) {
    text += line.key + ": " + std::string(ToString(line.finding)) + " " + line.value + " (" +
            line.remark + ")\n";
  }
  for (const std::string& cause : comparison.causes) text += cause + "\n";
  return text;
}

// A corruption of a record, the lines that must be wrong (other lines may be wrong only if they are
// sigma or `permitted`), and the size of the first line with its relative tolerance.
struct Corruption {
  const char* name;
  std::function<std::vector<ForceRow>(unsigned seed)> record;
  const char* wrong;
  const char* permitted = "";
  double value = std::nan("");
  double tolerance = 0.05;
  const char* cause = "";
};
void PrintTo(const Corruption& corruption, std::ostream* out) {
  *out << corruption.name;
}

using Change = std::function<void(ForceRow*)>;
auto Each(const Change& change) {
  return [change](unsigned seed) {
    std::vector<ForceRow> rows = Record(seed);
    for (ForceRow& row : rows) change(&row);
    return rows;
  };
}
auto Scaled(double factor) {
  return Each([factor](ForceRow* row) { row->estimated *= factor; });
}
auto Mapped(const Matrix3d& map) {
  return Each([map](ForceRow* row) { row->estimated = map * row->estimated; });
}
auto Shifted(const Vector3d& by) {
  return Each([by](ForceRow* row) { row->estimated += by; });
}
auto Drifting(const Vector3d& rate) {
  return Each([rate](ForceRow* row) { row->estimated += row->t * rate; });
}
auto Delayed(double delay) {
  return [delay](unsigned seed) { return Record(seed, [delay](double t) { return t - delay; }); };
}
auto Clocked(double factor) {
  return Each([factor](ForceRow* row) { row->t *= factor; });
}
auto WithSigma(double factor) {
  return Each([factor](ForceRow* row) { row->sigma *= factor; });
}
// From `begin` on, the estimate keeps its value on these axes.
auto Stuck(double begin, std::set<int> axes) {
  return [begin, axes](unsigned seed) {
    std::vector<ForceRow> rows = Record(seed);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      for (const int axis : axes) {
        if (rows[i].t > begin) rows[i].estimated(axis) = rows[i - 1].estimated(axis);
      }
    }
    return rows;
  };
}
// A new value only every `count` rows.
std::vector<ForceRow> Resampled(unsigned seed, std::size_t count) {
  std::vector<ForceRow> rows = Record(seed);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].estimated = rows[i / count * count].estimated;
  }
  return rows;
}
// A low-pass filter of first order.
std::vector<ForceRow> Filtered(unsigned seed, double time_constant) {
  std::vector<ForceRow> rows = Record(seed);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    rows[i].estimated = rows[i - 1].estimated + kStep / (kStep + time_constant) *
                                                    (rows[i].estimated - rows[i - 1].estimated);
  }
  return rows;
}

Matrix3d Axes(int x, int y, int z) {
  Matrix3d map = Matrix3d::Zero();
  map(0, x) = map(1, y) = map(2, z) = 1;
  return map;
}
Matrix3d Turn(double degrees, const Vector3d& axis) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).matrix();
}
Matrix3d Diagonal(double x, double y, double z) {
  return Vector3d(x, y, z).asDiagonal();
}

constexpr double kG = 9.80665, kPound = 4.4482216;  // [N] of 1 kgf and of 1 lbf
const Corruption kCorruptions[] = {
    {"Gain06", Scaled(0.6), "magnitude", "", 0.6},
    {"Gain08", Scaled(0.8), "magnitude", "", 0.8},
    {"Gain115", Scaled(1.15), "magnitude", "", 1.15},
    {"Gain15", Scaled(1.5), "magnitude", "", 1.5},
    {"Gain3", Scaled(3), "magnitude", "", 3},
    {"GainOfX", Mapped(Diagonal(0.7, 1, 1)), "magnitude", "frame", NAN, 0, "differs between"},
    {"GainOfZ", Mapped(Diagonal(1, 1, 1.3)), "magnitude", "frame zero", NAN, 0, "differs between"},
    {"MilliNewton", Scaled(1000), "unit", "", NAN, 0, "reported in mN"},
    {"Gram", Scaled(1000 / kG), "unit", "", NAN, 0, "reported in g"},
    {"KilogramForce", Scaled(1 / kG), "unit", "", NAN, 0, "reported in kgf"},
    {"PoundForce", Scaled(1 / kPound), "unit", "", NAN, 0, "reported in lbf"},
    {"KnownInKilogramForce", Scaled(kG), "unit", "", NAN, 0, "known in kgf"},
    {"KnownInPoundForce", Scaled(kPound), "unit", "", NAN, 0, "known in lbf"},
    {"KnownInGram", Scaled(kG / 1000), "unit", "", NAN, 0, "known in g"},
    {"KiloNewton", Scaled(0.001), "unit", "", NAN, 0, "reported in kN"},
    {"TenTimes", Scaled(10), "magnitude", "", 10},
    {"ATenth", Scaled(0.1), "magnitude", "", 0.1},
    {"HundredTimes", Scaled(100), "magnitude", "", 100},
    {"SignOfAll", Scaled(-1), "sign", "", NAN, 0, "reversed on every axis"},
    {"SignOfX", Mapped(Diagonal(-1, 1, 1)), "sign", "", NAN, 0, "reversed along x"},
    {"SignOfZ", Mapped(Diagonal(1, 1, -1)), "sign", "", NAN, 0, "reversed along z"},
    {"SwappedXY", Mapped(Axes(1, 0, 2)), "frame", "", NAN, 0, "known x is reported as y"},
    {"SwappedYZ", Mapped(Axes(0, 2, 1)), "frame", "", NAN, 0, "known y is reported as z"},
    {"RotatedAxes", Mapped(Axes(1, 2, 0)), "frame", "", NAN, 0, "Axes are exchanged"},
    {"Turn12", Mapped(Turn(12, {1, 0, 0})), "frame", "", 12 * std::numbers::pi / 180, 0.1},
    {"Turn20", Mapped(Turn(20, {0, 0, 1})), "frame", "", 20 * std::numbers::pi / 180, 0.1},
    {"Turn35", Mapped(Turn(35, {1, 2, 2})), "frame", "", 35 * std::numbers::pi / 180, 0.1},
    {"Delay40", Delayed(0.04), "delay", "", 0.04},
    {"Delay150", Delayed(0.15), "delay", "", 0.15},
    {"Early80", Delayed(-0.08), "delay", "", -0.08},
    {"OffsetX", Shifted({0.4, 0, 0}), "zero", "", 0.4},
    {"OffsetZ", Shifted({0, 0, -0.35}), "zero", "", 0.35},
    {"DriftZ", Drifting({0, 0, 0.08}), "time", "", 0.08 * kStep*(kRows - 1)},
    {"DriftX", Drifting({-0.07, 0, 0}), "time", "", 0.07 * kStep*(kRows - 1)},
    {"Saturation",
     Each([](ForceRow* row) { row->estimated.z() = std::max(row->estimated.z(), -1.5); }),
     "channel", "", NAN, 0, "saturation"},
    {"DeadZone",
     Each([](ForceRow* row) { row->estimated.z() = std::min(0.0, row->estimated.z() + 1.3); }),
     "channel", "magnitude zero", NAN, 0, "along z stays at 0 N"},
    {"StuckAtTheEnd", Stuck(8, {0, 1, 2}), "channel", "", NAN, 0, "stays at"},
    {"DeadX", Each([](ForceRow* row) { row->estimated.x() = 0; }), "channel", "", NAN, 0,
     "along x stays at 0 N in 100 %"},
    {"DeadZ", Stuck(0, {2}), "channel", "", NAN, 0, "along z stays at"},
    {"Resampled", [](unsigned seed) { return Resampled(seed, 9); }, "delay", "", 0.04, 0.3},
    {"Filtered", [](unsigned seed) { return Filtered(seed, 0.08); }, "delay", "magnitude", 0.08,
     0.3},
    {"MillisecondsAsSeconds", Clocked(1000), "rate", "", NAN, 0, "ms for s"},
    {"SecondsAsMilliseconds", Clocked(0.001), "rate", "", NAN, 0, "--time-unit"},
    {"SigmaTooSmall", WithSigma(0.3), "sigma", "", NAN, 0, "too small"},
    {"SigmaTooLarge", WithSigma(5), "sigma", "", NAN, 0, "too large"},
};

class CorruptionTest : public testing::TestWithParam<Corruption> {};

TEST_P(CorruptionTest, IsNamedAlone) {
  const Corruption& corruption = GetParam();
  for (unsigned seed = 1; seed <= kCaseSeeds; ++seed) {
    const auto comparison = CompareForces(corruption.record(seed));
    std::set<std::string> permitted{corruption.wrong, "sigma"};
    std::istringstream more(corruption.permitted);
    for (std::string key; more >> key;) permitted.insert(key);
    EXPECT_EQ(comparison.line(corruption.wrong).finding, Judgement::kWrong) << TextOf(comparison);
    std::istringstream wrong(WrongOf(comparison));
    for (std::string key; wrong >> key;) {
      EXPECT_TRUE(permitted.contains(key)) << seed << " " << key << "\n" << TextOf(comparison);
    }
    if (std::isfinite(corruption.value)) {
      EXPECT_NEAR(comparison.line(corruption.wrong).interval->value, corruption.value,
                  corruption.tolerance * std::abs(corruption.value))
          << TextOf(comparison);
    }
    EXPECT_NE(TextOf(comparison).find(corruption.cause), std::string::npos) << TextOf(comparison);
  }
}
INSTANTIATE_TEST_SUITE_P(Kinds, CorruptionTest, testing::ValuesIn(kCorruptions),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(CompareForcesTest, NoneOfTenCleanRecordsIsAlarmed) {
  for (unsigned seed = 101; seed <= 110; ++seed) {
    const auto comparison = CompareForces(Record(seed));
    EXPECT_TRUE(comparison.passes()) << TextOf(comparison);
  }
}

}  // namespace
}  // namespace palpate
