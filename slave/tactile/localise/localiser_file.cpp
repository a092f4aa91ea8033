// Fitted localisers in files.
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"
#include "slave/tactile/localise/fitted_localiser.h"

namespace palpate {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "palpate-localiser/1";
constexpr double kRotationTolerance = 1e-6;
constexpr double kLargest = 1e6;  // beyond it no place is computed

template <typename Matrix>
json RowsOf(const Matrix& matrix) {
  json rows = json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

json RowsOf(const std::array<Eigen::Vector3d, kElectrodeCount>& vectors) {
  json rows = json::array();
  for (const Eigen::Vector3d& v : vectors) rows.push_back({v.x(), v.y(), v.z()});
  return rows;
}

// Throws std::runtime_error naming the member.
Eigen::MatrixXd MatrixOf(const json& file, const char* member, Eigen::Index columns) {
  const auto rows = file.at(member).get<std::vector<std::vector<double>>>();
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != static_cast<std::size_t>(columns)) {
      throw std::runtime_error(std::string(member) + ": row " + std::to_string(i) + " has " +
                               std::to_string(rows[i].size()) + " numbers: accepted are " +
                               std::to_string(columns));
    }
    for (Eigen::Index j = 0; j < columns; ++j) {
      matrix(static_cast<Eigen::Index>(i), j) = rows[i][static_cast<std::size_t>(j)];
    }
  }
  if (!(matrix.array().abs() <= kLargest).all()) {
    throw std::runtime_error(std::string(member) + ": accepted are numbers up to 1e6");
  }
  return matrix;
}

double NumberOf(const json& file, const char* member, double more_than, double at_most) {
  const double number = file.at(member).get<double>();
  if (!(number > more_than && number <= at_most)) {
    throw std::runtime_error(std::string(member) + " = " + file.at(member).dump() +
                             ": accepted is > " + json(more_than).dump() +
                             " and <= " + json(at_most).dump());
  }
  return number;
}

std::array<Eigen::Vector3d, kElectrodeCount> ElectrodesOf(const json& file, const char* member) {
  const Eigen::MatrixXd rows = MatrixOf(file, member, 3);
  if (rows.rows() != kElectrodeCount) {
    throw std::runtime_error(std::string(member) + " has " + std::to_string(rows.rows()) +
                             " rows: accepted are 19");
  }
  std::array<Eigen::Vector3d, kElectrodeCount> vectors;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    vectors[i] = rows.row(static_cast<Eigen::Index>(i)).transpose();
  }
  return vectors;
}

LocaliserWeights WeightsOf(const json& file) {
  if (file.at("format") != kFormat) {
    throw std::runtime_error("format: accepted is " + std::string(kFormat));
  }
  LocaliserWeights weights;
  weights.layout.p_F = ElectrodesOf(file, "electrodes");
  weights.layout.n_F = ElectrodesOf(file, "electrode_normals");
  weights.threshold = NumberOf(file, "threshold", 0, 1e6);
  weights.quiet = NumberOf(file, "quiet", 0, 1e6);
  weights.gamma = NumberOf(file, "gamma", 0, 1e6);
  weights.sigma_angle = NumberOf(file, "sigma_angle", 0, 4);
  weights.ridge = NumberOf(file, "ridge", 0, 1e6);
  weights.median_error = file.at("median_error").get<double>();
  weights.samples = file.at("samples").get<int>();
  const Eigen::MatrixXd R = MatrixOf(file, "rotation", 3);
  if (R.rows() != 3 || !((R * R.transpose()).isIdentity(kRotationTolerance)) ||
      R.topRows<3>().determinant() < 0) {
    throw std::runtime_error("rotation: accepted is a rotation matrix of three rows");
  }
  weights.R = R;
  weights.centres = MatrixOf(file, "centres", kElectrodeCount).transpose();
  weights.corrections = MatrixOf(file, "corrections", 3).transpose();
  if (weights.centres.cols() != weights.corrections.cols() || weights.centres.cols() < 1 ||
      weights.centres.cols() > kMostLocaliserCentres) {
    throw std::runtime_error("centres and corrections: accepted are as many of both, 1 to " +
                             std::to_string(kMostLocaliserCentres));
  }
  return weights;
}

}  // namespace

void WriteLocaliser(const LocaliserWeights& weights, const std::filesystem::path& file) {
  const json content = {{"format", kFormat},
                        {"threshold", weights.threshold},
                        {"quiet", weights.quiet},
                        {"gamma", weights.gamma},
                        {"sigma_angle", weights.sigma_angle},
                        {"ridge", weights.ridge},
                        {"median_error", weights.median_error},
                        {"samples", weights.samples},
                        {"rotation", RowsOf(weights.R)},
                        {"electrodes", RowsOf(weights.layout.p_F)},
                        {"electrode_normals", RowsOf(weights.layout.n_F)},
                        {"centres", RowsOf(weights.centres.transpose())},
                        {"corrections", RowsOf(weights.corrections.transpose())}};
  WriteWholeFile(file, content.dump() + '\n');
}

LocaliserWeights ReadLocaliser(const std::filesystem::path& file) {
  constexpr std::uintmax_t kLargestFile = 64 << 20;  // [bytes]
  const std::string text = ReadWholeFile(file, kLargestFile, "the file of a fitted localiser");
  return NamingFile(file, [&] { return WeightsOf(json::parse(text)); });
}

}  // namespace palpate
