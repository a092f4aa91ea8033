#include "tests/slave/tactile/localise/plate_presses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <Eigen/Geometry>

#include "slave/capture/tactile_recording.h"
#include "tests/support/csv_columns.h"
#include "tests/support/paths.h"

namespace palpate::presses {
namespace {

using Eigen::Vector3d;

const std::filesystem::path kSharedData = SourcePath("/../shared/data");

// Counts without contact.
struct RestReading {
  std::array<double, kElectrodeCount> electrodes{};
  double pdc = 0;
};

// Median as in numpy: for an even count, the mean of the two central values.
double MedianCounts(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// Medians over the samples that are not in contact.
RestReading RestOf(const std::vector<FingerReading>& samples, double least_pdc) {
  std::array<std::vector<double>, kElectrodeCount> electrodes;
  std::vector<double> pdc;
  for (const FingerReading& sample : samples) {
    if (static_cast<double>(sample.pdc) >= least_pdc) continue;
    pdc.push_back(static_cast<double>(sample.pdc));
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      electrodes[i].push_back(static_cast<double>(sample.channels[i]));
    }
  }
  RestReading rest;
  rest.pdc = MedianCounts(pdc);
  for (std::size_t i = 0; i < kElectrodeCount; ++i)
    rest.electrodes[i] = MedianCounts(electrodes[i]);
  return rest;
}

void Append(const FingerReading& sample, const RestReading& rest, const Vector3d& normal_F,
            Presses* presses) {
  TactileSignals change{};
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    change[i] = static_cast<float>(static_cast<double>(sample.channels[i]) - rest.electrodes[i]);
  }
  change[kElectrodeCount + 1] = static_cast<float>(static_cast<double>(sample.pdc) - rest.pdc);
  presses->change.push_back(change);
  presses->raw.push_back(sample);
  presses->normal_F.push_back(normal_F.normalized());
}

}  // namespace

std::optional<Presses> Read(const std::string& file, double least_pdc) {
  const auto path = kSharedData / "biotac_contact_direction" / (file + ".csv");
  if (!std::filesystem::exists(path)) return std::nullopt;
  const auto samples = ReadTactileRecording(path, {}).fingers.at(0).samples;
  const CsvColumns columns = ReadColumns(path);
  const auto nx = NumbersOf(columns, "nx"), ny = NumbersOf(columns, "ny"),
             nz = NumbersOf(columns, "nz");
  const RestReading rest = RestOf(samples, least_pdc);
  Presses presses;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (static_cast<double>(samples[k].pdc) < least_pdc) continue;
    Append(samples[k], rest, {-nx[k], ny[k], -nz[k]}, &presses);
  }
  return presses;
}

std::optional<Presses> ReadSoftPress() {
  const auto folder = kSharedData / "seed001_rf_foam_bar";
  if (!std::filesystem::exists(folder / "rh_tactile.csv")) return std::nullopt;
  const std::vector<std::string> finger{"rf"};
  const auto samples =
      ReadTactileRecording(folder / "rh_tactile.csv", finger).fingers.at(0).samples;
  const CsvColumns rests = ReadColumns(folder / "rest_values_rf.csv");
  RestReading rest;
  for (std::size_t k = 0; k < rests.at("name").size(); ++k) {
    const std::string name = rests.at("name")[k].substr(3);  // without rf_
    const double counts = std::stod(rests.at("rest")[k]);
    if (name == "pdc") rest.pdc = counts;
    if (name[0] == 'E') rest.electrodes.at(std::stoul(name.substr(1)) - 1) = counts;
  }
  const CsvColumns network = ReadColumns(folder / "lstm_expected_rf.csv");
  const auto fx = NumbersOf(network, "y0"), fy = NumbersOf(network, "y1"),
             fz = NumbersOf(network, "y2");
  // The first row of the network's output belongs to the sample that fills its window.
  const std::size_t first = samples.size() - fx.size();
  Presses presses;
  for (std::size_t k = 0; k < fx.size(); ++k) {
    const FingerReading& sample = samples[first + k];
    if (static_cast<double>(sample.pdc) < rest.pdc + 20) continue;
    Append(sample, rest, {fx[k], fy[k], fz[k]}, &presses);
  }
  return presses;
}

std::optional<ElectrodeLayout> Layout() {
  const auto file = kSharedData / "seed001_biotac_lstm/biotac_electrodes_pose.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  return ReadElectrodeLayout(file);
}

Errors ErrorsOf(const Localiser& localiser, const Presses& presses) {
  std::vector<TouchPlace> places;
  Eigen::Matrix3Xd located(3, 0), measured(3, 0);
  for (std::size_t k = 0; k < presses.change.size(); ++k) {
    const TouchPlace place = localiser.Locate(presses.change[k], presses.raw[k]);
    if (!place.usable()) continue;
    places.push_back(place);
    located.conservativeResize(3, located.cols() + 1);
    measured.conservativeResize(3, measured.cols() + 1);
    located.rightCols<1>() = place.n_F;
    measured.rightCols<1>() = presses.normal_F[k];
  }
  // umeyama also moves and centres; with every vector and its negative both means are zero.
  const auto n = located.cols();
  Eigen::Matrix3Xd from(3, 2 * n), to(3, 2 * n);
  from << located, -located;
  to << measured, -measured;
  const Eigen::Matrix3d R = Eigen::umeyama(from, to, false).topLeftCorner<3, 3>();
  Errors errors;
  errors.rows = static_cast<int>(presses.change.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const double cosine = std::clamp(measured.col(k).dot(R * located.col(k)), -1.0, 1.0);
    const double angle = std::acos(cosine);
    errors.degrees.push_back(angle * 180 / std::numbers::pi);
    errors.of_sigma.push_back(angle * 7e-3 / places[static_cast<std::size_t>(k)].sigma);
  }
  std::sort(errors.degrees.begin(), errors.degrees.end());
  std::sort(errors.of_sigma.begin(), errors.of_sigma.end());
  return errors;
}

}  // namespace palpate::presses
