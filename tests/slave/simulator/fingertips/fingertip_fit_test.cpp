// Compares the simulated fingertip with recordings of real ones. The real values are computed here
// from the files; the allowed factors are the differences between fingers.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/text/csv.h"
#include "slave/capture/tactile_recording.h"
#include "slave/simulator/fingertips/simulated_fingertip.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Samples = std::vector<FingerReading>;

std::filesystem::path Data(const std::string& name) {
  return std::filesystem::path(SourcePath()) / "../shared/data" / name;
}

// Column of counts: an electrode, pac0 or pdc.
std::vector<double> Column(const Samples& samples, std::size_t signal) {
  std::vector<double> column;
  for (const FingerReading& reading : samples) {
    column.push_back(signal < kElectrodeCount    ? reading.channels[signal]
                     : signal == kElectrodeCount ? reading.pac
                                                 : reading.pdc);
  }
  return column;
}
constexpr std::size_t kPacChannel = kElectrodeCount, kPdcChannel = kElectrodeCount + 1;

// The difference of neighbouring samples of white noise has sqrt 2 times its standard deviation.
double NoiseOfColumn(const std::vector<double>& column) {
  double sum = 0;
  for (std::size_t i = 1; i < column.size(); ++i) sum += std::pow(column[i] - column[i - 1], 2);
  return std::sqrt(0.5 * sum / static_cast<double>(column.size() - 1));
}

double Mean(const std::vector<double>& column, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += column[i];
  return sum / static_cast<double>(end - begin);
}

// Mean square change of half-second means over ten seconds.
double DriftSquare(const std::vector<double>& column) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i + 1050 <= column.size(); i += 50, ++count) {
    sum += std::pow(Mean(column, i + 1000, i + 1050) - Mean(column, i, i + 50), 2);
  }
  return sum / count;
}

// Noise and drift of all electrodes of several fingers, root mean square.
struct RestStatistics {
  double noise = 0, drift = 0, pac = 0, pdc = 0;
};
RestStatistics StatisticsOf(const std::vector<Samples>& fingers) {
  RestStatistics s;
  for (const Samples& samples : fingers) {
    for (std::size_t k = 0; k < kElectrodeCount; ++k) {
      const auto column = Column(samples, k);
      s.noise += std::pow(NoiseOfColumn(column), 2) / kElectrodeCount;
      s.drift += DriftSquare(column) / kElectrodeCount;
    }
    s.pac += std::pow(NoiseOfColumn(Column(samples, kPacChannel)), 2);
    s.pdc += std::pow(NoiseOfColumn(Column(samples, kPdcChannel)), 2);
  }
  const auto root = [&](double sum) {
    return std::sqrt(sum / static_cast<double>(fingers.size()));
  };
  return {root(s.noise), root(s.drift), root(s.pac), root(s.pdc)};
}

void ExpectWithin(double simulated, double real, double factor, const char* what) {
  EXPECT_LT(simulated, real * factor) << what << ", real: " << real;
  EXPECT_GT(simulated, real / factor) << what << ", real: " << real;
}

class FoamRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto file = Data("seed001_rf_foam_bar/rh_tactile.csv");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    recording_ = ReadTactileRecording(file, {});
  }
  [[nodiscard]] const Samples& Finger(const std::string& name) const {
    return std::ranges::find_if(recording_.fingers, [&](const auto& f) { return f.name == name; })
        ->samples;
  }

  TactileRecording recording_;
};

TEST_F(FoamRecording, RestingFingersAreAsNoisyAndDriftAsMuchAsRealOnes) {
  std::vector<Samples> real, simulated;
  for (const char* name : {"ff", "mf", "lf", "th"}) real.push_back(Finger(name));
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SimulatedFingertip fingertip(seed);
    Samples samples;
    for (std::size_t i = 0; i < real[0].size(); ++i) {
      samples.push_back(fingertip.Sample(nullptr, 0.01));
    }
    simulated.push_back(std::move(samples));
  }
  const RestStatistics r = StatisticsOf(real), s = StatisticsOf(simulated);
  ExpectWithin(s.noise, r.noise, 1.15, "electrode noise");
  ExpectWithin(s.drift, r.drift, 1.4, "electrode drift in 10 s");
  ExpectWithin(s.pac, r.pac, 1.5, "pac0 noise");
  ExpectWithin(s.pdc, r.pdc, 1.5, "pdc noise");
}

// |force| of a wrench file at the times given, its own first 50 rows removed [N].
std::vector<double> ForceColumn(const std::filesystem::path& file,
                                const std::vector<double>& times) {
  CsvTable rows(file);
  const std::array columns{*rows.Find("rel_time_s"), *rows.Find("fx_N"), *rows.Find("fy_N"),
                           *rows.Find("fz_N")};
  std::vector<double> t;
  std::vector<Vector3d> f;
  while (rows.Next()) {
    const auto number = [&](std::size_t i) { return rows.Number(columns[i], 1e9); };
    t.push_back(number(0));
    f.emplace_back(number(1), number(2), number(3));
  }
  Vector3d rest(0, 0, 0);
  for (std::size_t i = 0; i < 50; ++i) rest += f[i] / 50;
  std::vector<double> magnitude;
  std::size_t next = 1;
  for (const double at : times) {
    while (next + 1 < t.size() && t[next] < at) ++next;
    const double part = std::clamp((at - t[next - 1]) / (t[next] - t[next - 1]), 0.0, 1.0);
    magnitude.push_back((f[next - 1] + part * (f[next] - f[next - 1]) - rest).norm());
  }
  return magnitude;
}

// Effects of a press in foam per newton.
struct FoamPress {
  double pdc = 0, electrodes = 0, highest = 0, creep = 0, left = 0, pac_at_touch = 0;
  int rising = 0;
};
FoamPress PressOf(const Samples& samples, const std::vector<double>& t,
                  const std::vector<double>& force) {
  const auto mean = [&](const std::vector<double>& column, double from, double to) {
    const auto begin = std::ranges::lower_bound(t, from) - t.begin();
    const auto end = std::ranges::lower_bound(t, to) - t.begin();
    return Mean(column, static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
  };
  FoamPress press;
  double early = 0, late = 0;
  // The hold with the largest force in the first press, and the long hold of the second press.
  const double newtons = mean(force, 6.4, 7.3);
  for (std::size_t k = 0; k < kElectrodeCount; ++k) {
    const auto column = Column(samples, k);
    const double rest = Mean(column, 0, 200);
    const double per_newton = (mean(column, 6.4, 7.3) - rest) / newtons;
    press.electrodes += per_newton / kElectrodeCount;
    press.highest = std::max(press.highest, per_newton);
    press.rising += per_newton > 0 ? 1 : 0;
    early += (mean(column, 12.0, 12.3) - rest) / mean(force, 12.0, 12.3);
    late += (mean(column, 13.8, 14.1) - rest) / mean(force, 13.8, 14.1);
    press.left += (mean(column, 7.9, 8.2) - rest) / newtons / kElectrodeCount;
  }
  press.creep = late / early;
  press.left /= press.electrodes;
  const auto pdc = Column(samples, kPdcChannel), pac = Column(samples, kPacChannel);
  press.pdc = (mean(pdc, 6.4, 7.3) - Mean(pdc, 0, 200)) / newtons;
  press.pac_at_touch = *std::min_element(pac.begin(), pac.begin() + 400) - Mean(pac, 0, 200);
  return press;
}

TEST_F(FoamRecording, APressInFoamReadsLikeTheRealOne) {
  const auto wrench = Data("seed001_rf_foam_bar/sensor_readings_wrench.csv");
  const std::vector<double> force = ForceColumn(wrench, recording_.t);
  SimulatedFingertip fingertip(9);
  Samples simulated;
  // The contact's position on the fingertip is unknown; the most likely one is opposite to the side
  // that rises most.
  const Vector3d n = Vector3d(0.1, -0.6, -0.8).normalized();
  for (std::size_t i = 0; i < recording_.t.size(); ++i) {
    const FingertipLoad load{simulation::kSkinRadius * n, -force[i] * n, 9e-3};
    simulated.push_back(fingertip.Sample(force[i] > 0.02 ? &load : nullptr,
                                         i > 0 ? recording_.t[i] - recording_.t[i - 1] : 0.01));
  }
  const FoamPress r = PressOf(Finger("rf"), recording_.t, force);
  const FoamPress s = PressOf(simulated, recording_.t, force);
  ExpectWithin(s.pdc, r.pdc, 1.25, "pdc per newton");
  ExpectWithin(s.electrodes, r.electrodes, 1.4, "mean electrode per newton");
  ExpectWithin(s.highest, r.highest, 2, "highest electrode per newton");
  ExpectWithin(-s.pac_at_touch, -r.pac_at_touch, 2, "fall of pac0 at touch");
  ExpectWithin(s.creep - 1, r.creep - 1, 2, "creep of the electrodes in a hold");
  ExpectWithin(s.left, r.left, 2.5, "what is left after release");
  EXPECT_GE(s.rising, r.rising - 3);
}

// The hardest contact of the pad with the plate: how far electrodes fall and rise at its pdc.
TEST(PlateRecording, AHardPressReadsLikeTheRealOne) {
  const auto file = Data("biotac_contact_direction/trial1.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const TactileRecording recording = ReadTactileRecording(file, {});
  const Samples& samples = recording.fingers[0].samples;
  const auto pdc = Column(samples, kPdcChannel);
  std::vector<double> sorted = pdc;
  std::ranges::sort(sorted);
  const double rest_pdc = sorted[sorted.size() / 10];
  const auto top = static_cast<std::size_t>(std::ranges::max_element(pdc) - pdc.begin());
  double real_low = 0, real_high = 0;
  for (std::size_t k = 0; k < kElectrodeCount; ++k) {
    const double change = Column(samples, k)[top] - Mean(Column(samples, k), 0, 100);
    real_low = std::min(real_low, change);
    real_high = std::max(real_high, change);
  }
  SimulatedFingertip fingertip(3);
  Samples simulated;
  const Vector3d n = Vector3d(0.11, 0.11, -0.99).normalized();
  FingertipLoad load{simulation::kSkinRadius * n, {0, 0, 0}, 4e-3};
  for (int i = 0; i < 100; ++i) simulated.push_back(fingertip.Sample(nullptr, 0.01));
  const double start = Mean(Column(simulated, kPdcChannel), 0, 100);
  double newtons = 0;
  while (static_cast<double>(simulated.back().pdc) - start < pdc[top] - rest_pdc && newtons < 20) {
    newtons += 0.01;
    load.f_F = -newtons * n;
    simulated.push_back(fingertip.Sample(&load, 0.01));
  }
  double low = 0, high = 0;
  for (std::size_t k = 0; k < kElectrodeCount; ++k) {
    const auto column = Column(simulated, k);
    const double change = column.back() - Mean(column, 0, 100);
    low = std::min(low, change);
    high = std::max(high, change);
  }
  ExpectWithin(-low, -real_low, 1.6, "deepest fall");
  ExpectWithin(high, real_high, 1.4, "highest rise");
  EXPECT_LT(newtons, 8);  // limit for a press by hand
}

}  // namespace
}  // namespace palpate
