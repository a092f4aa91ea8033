#include "tests/slave/tactile/localise/plate_presses.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include <Eigen/Geometry>

namespace palpate::presses {
namespace {

const std::filesystem::path kData = PALPATE_SOURCE_DIR "/../shared/data";
constexpr std::size_t kPdc = 1, kFirstElectrode = 2, kNormal = 21, kColumns = 24;

using Row = std::array<double, kColumns>;

std::vector<Row> ReadRows(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    Row row{};
    for (double& value : row) {
      cells >> value;
      cells.ignore(1);
    }
    rows.push_back(row);
  }
  return rows;
}

// Of one column over the rows that are not in contact, as numpy's: the mean of the middle two.
double RestOf(const std::vector<Row>& rows, double least_pdc, std::size_t column) {
  std::vector<double> values;
  for (const Row& row : rows) {
    if (row[kPdc] < least_pdc) values.push_back(row[column]);
  }
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

}  // namespace

std::optional<Presses> Read(const std::string& file, double least_pdc) {
  const auto path = kData / "biotac_contact_direction" / (file + ".csv");
  if (!std::filesystem::exists(path)) return std::nullopt;
  const std::vector<Row> rows = ReadRows(path);
  Row rest{};
  for (std::size_t c = kPdc; c < kNormal; ++c) rest[c] = RestOf(rows, least_pdc, c);
  Presses presses;
  for (const Row& row : rows) {
    if (row[kPdc] < least_pdc) continue;
    FingerReading raw;
    raw.present = true;
    raw.pdc = static_cast<float>(row[kPdc]);
    TactileSignals change{};
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const std::size_t c = kFirstElectrode + i;
      raw.electrodes[i] = static_cast<float>(row[c]);
      change[i] = static_cast<float>(row[c] - rest[c]);
    }
    change[kElectrodeCount + 1] = static_cast<float>(row[kPdc] - rest[kPdc]);
    presses.change.push_back(change);
    presses.raw.push_back(raw);
    presses.normal_F.push_back(
        Eigen::Vector3d(-row[kNormal], row[kNormal + 1], -row[kNormal + 2]).normalized());
  }
  return presses;
}

std::optional<ElectrodeLayout> Layout() {
  const auto file = kData / "seed001_biotac_lstm/biotac_electrodes_pose.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  return ReadElectrodeLayout(file);
}

Presses Part(const Presses& all, std::size_t begin, std::size_t end) {
  const auto part = [&](const auto& v) {
    return std::remove_cvref_t<decltype(v)>(v.begin() + static_cast<std::ptrdiff_t>(begin),
                                            v.begin() + static_cast<std::ptrdiff_t>(end));
  };
  return {part(all.change), part(all.raw), part(all.normal_F)};
}

double Errors::Quantile(double share) const {
  return degrees.at(static_cast<std::size_t>(share * static_cast<double>(degrees.size() - 1)));
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
