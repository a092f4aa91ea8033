#include "tests/slave/tactile/localise/plate_presses.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "tests/support/paths.h"

namespace palpate::presses {
namespace {

const std::filesystem::path kData = SourcePath("/../shared/data");
struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  [[nodiscard]] std::size_t Column(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw std::runtime_error("no column " + name);
    return static_cast<std::size_t>(found - names.begin());
  }
  [[nodiscard]] double At(std::size_t row, const std::string& name) const {
    return rows[row][Column(name)];
  }
};

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

Table ReadTable(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  Table table{CellsOf(line), {}};
  while (std::getline(stream, line)) {
    std::vector<double> row;
    for (const std::string& cell : CellsOf(line)) row.push_back(std::stod(cell));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Rows of a name and a number.
std::map<std::string, double> ReadNumbers(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::map<std::string, double> numbers;
  while (std::getline(stream, line)) {
    const auto cells = CellsOf(line);
    numbers[cells.at(0)] = std::stod(cells.at(1));
  }
  return numbers;
}

std::string ElectrodeName(std::size_t i) {
  return std::string("E").append(std::to_string(i + 1));
}

// Median of one column over the rows that are not in contact, as numpy's: the mean of the middle
// two.
double RestOf(const Table& table, double least_pdc, const std::string& name) {
  std::vector<double> values;
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    if (table.At(k, "pdc") < least_pdc) values.push_back(table.At(k, name));
  }
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// Appends one row: its counts by `prefix` and name, minus `rest`.
void Append(const Table& table, std::size_t k, const std::string& prefix,
            const std::map<std::string, double>& rest, const Eigen::Vector3d& normal_F,
            Presses* presses) {
  FingerReading raw;
  raw.present = true;
  TactileSignals change{};
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const std::string name = prefix + ElectrodeName(i);
    raw.channels[i] = static_cast<float>(table.At(k, name));
    change[i] = static_cast<float>(table.At(k, name) - rest.at(name));
  }
  const std::string pdc = prefix + "pdc";
  raw.pdc = static_cast<float>(table.At(k, pdc));
  change[kElectrodeCount + 1] = static_cast<float>(table.At(k, pdc) - rest.at(pdc));
  presses->change.push_back(change);
  presses->raw.push_back(raw);
  presses->normal_F.push_back(normal_F.normalized());
}

}  // namespace

std::optional<Presses> Read(const std::string& file, double least_pdc) {
  const auto path = kData / "biotac_contact_direction" / (file + ".csv");
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Table table = ReadTable(path);
  std::map<std::string, double> rest{{"pdc", RestOf(table, least_pdc, "pdc")}};
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    rest[ElectrodeName(i)] = RestOf(table, least_pdc, ElectrodeName(i));
  }
  Presses presses;
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    if (table.At(k, "pdc") < least_pdc) continue;
    const Eigen::Vector3d n(-table.At(k, "nx"), table.At(k, "ny"), -table.At(k, "nz"));
    Append(table, k, "", rest, n, &presses);
  }
  return presses;
}

std::optional<Presses> ReadSoftPress() {
  const auto folder = kData / "seed001_rf_foam_bar";
  if (!std::filesystem::exists(folder / "rh_tactile.csv")) return std::nullopt;
  const Table tactile = ReadTable(folder / "rh_tactile.csv");
  const Table network = ReadTable(folder / "lstm_expected_rf.csv");
  const auto rest = ReadNumbers(folder / "rest_values_rf.csv");
  // The network's rows begin with the sample that fills its window.
  const std::size_t first = tactile.rows.size() - network.rows.size();
  Presses presses;
  for (std::size_t k = 0; k < network.rows.size(); ++k) {
    if (tactile.At(first + k, "rf_pdc") < rest.at("rf_pdc") + 20) continue;
    const Eigen::Vector3d f(network.At(k, "y0"), network.At(k, "y1"), network.At(k, "y2"));
    Append(tactile, first + k, "rf_", rest, f, &presses);
  }
  return presses;
}

std::optional<ElectrodeLayout> Layout() {
  const auto file = kData / "seed001_biotac_lstm/biotac_electrodes_pose.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  return ReadElectrodeLayout(file);
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
