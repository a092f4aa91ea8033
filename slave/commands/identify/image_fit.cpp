#include "slave/commands/identify/image_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>
#include <spdlog/fmt/fmt.h>

#include "shared/state/driven_clock.h"
#include "shared/text/csv.h"
#include "slave/live/live_slave.h"

namespace palpate {
namespace {

constexpr double kMaxForce = 1e9;
constexpr int kMaxPasses = 8, kMinPresses = 3;
constexpr double kSettled = 1e-3;  // deviation of the factor s from 1

using Forces = std::map<std::uint64_t, double>;  // of samples [N]

Forces ReadForces(const std::filesystem::path& file) {
  CsvTable rows(file);
  const auto sequence = rows.Find("sequence"), size = rows.Find("force");
  const std::array parts{rows.Find("fx"), rows.Find("fy"), rows.Find("fz")};
  const bool has_parts =
      std::ranges::all_of(parts, [](const auto& part) { return part.has_value(); });
  if (!size && !has_parts) {
    throw InputError(file.string() + ":1: no column force: expected [sequence,]force or fx,fy,fz");
  }
  Forces forces;
  while (rows.Next()) {
    const double number =
        sequence ? rows.Number(*sequence, 1e15) : static_cast<double>(forces.size() + 1);
    if (!(number >= 1) || number != std::floor(number)) {
      rows.Fail("sequence: expected a whole number from 1");
    }
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (!size) f[static_cast<Eigen::Index>(k)] = rows.Number(*parts[k], kMaxForce);
    }
    const double force = size ? std::abs(rows.Number(*size, kMaxForce)) : f.norm();
    if (!forces.emplace(static_cast<std::uint64_t>(number), force).second) {
      rows.Fail("sequence: expected each sample once");
    }
  }
  return forces;
}

struct Pair {
  double estimated = 0, sigma = 0, measured = 0;  // [N]
};

// Common relative error of the estimated forces: the mean of the single images' errors over the
// images with the largest forces.
double CommonShare(const std::vector<Pair>& pairs) {
  double estimated2 = 0, sigma2 = 0;
  for (const Pair& pair : pairs) {
    estimated2 += pair.estimated * pair.estimated;
    sigma2 += pair.estimated > 0 ? pair.sigma * pair.sigma : 0;
  }
  return std::sqrt(sigma2 / estimated2);
}

std::vector<Pair> EstimateAll(const Scene& scene, const Forces& forces,
                              const std::stop_token& stop) {
  const DrivenClock clock;
  const auto slave = MakeLiveSlave(scene);
  std::vector<Pair> pairs;
  while (slave->Acquire(stop)) {
    const ContactEstimate estimate = slave->Estimate();
    const auto known = forces.find(estimate.sample);
    if (known == forces.end() || !estimate.force || estimate.validity != Validity::kValid) continue;
    pairs.push_back({estimate.force->norm(), estimate.sigma, known->second});
  }
  return pairs;
}

// measured = slope estimated + offset.
struct Line {
  double slope = 0, sigma_slope = 0, offset = 0, sigma_offset = 0, rms = 0;
};

Line FitLine(const std::vector<Pair>& pairs) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double square = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d row(pair.estimated, 1);
    normal += row * row.transpose();
    right += pair.measured * row;
    square += pair.measured * pair.measured;
  }
  const Eigen::Matrix2d inverse = normal.inverse();
  const Eigen::Vector2d line = inverse * right;
  const double rest = std::max(0.0, square - line.dot(right));
  const double variance = rest / std::max(1.0, static_cast<double>(pairs.size()) - 2);
  return {line[0], std::sqrt(variance * inverse(0, 0)), line[1],
          std::sqrt(variance * inverse(1, 1)), std::sqrt(rest / static_cast<double>(pairs.size()))};
}

// Returns the number of samples in contact; throws if they cannot determine the modulus.
int Pressed(const std::vector<Pair>& pairs, const std::filesystem::path& file) {
  const auto pressed = static_cast<int>(
      std::ranges::count_if(pairs, [](const Pair& pair) { return pair.estimated > 0; }));
  const auto [least, most] = std::ranges::minmax(pairs, {}, &Pair::estimated);
  if (pressed >= kMinPresses && most.estimated > 1.1 * least.estimated) return pressed;
  throw std::runtime_error(
      fmt::format("{}: {} samples with a known force have a valid contact: expected {} or "
                  "more, with different forces",
                  file.string(), pressed, kMinPresses));
}

}  // namespace

ImageFit FitImages(const Scene& scene, const std::filesystem::path& file,
                   const std::stop_token& stop) {
  if (IsSimulated(scene)) {
    throw std::invalid_argument(
        "images: expected a scene with recorded images or samples; a simulated one has the "
        "modulus of the scene");
  }
  const Forces forces = ReadForces(file);
  Scene tried = scene;
  double& E = tried.object.material.young_modulus;
  tried.object.material.young_modulus_tolerance = 0;  // the unknown modulus
  const bool is_dome = std::holds_alternative<DomeGeometry>(scene.object.geometry);
  ImageFit fit;
  for (Line line; fit.passes < kMaxPasses && std::abs(line.slope - 1) > kSettled;) {
    const std::vector<Pair> pairs = EstimateAll(tried, forces, stop);
    ++fit.passes;
    if (pairs.empty()) Pressed({{}}, file);
    fit.pressed = Pressed(pairs, file);
    fit.samples = static_cast<int>(pairs.size());
    line = FitLine(pairs);
    if (!(line.slope > 0) || !std::isfinite(line.slope)) {
      throw std::runtime_error(file.string() +
                               ": the measured forces do not increase with the estimated ones: no "
                               "modulus explains them");
    }
    E *= line.slope;
    if (is_dome) tried.model.prestress *= line.slope;
    fit.sigma_modulus = E * std::hypot(line.sigma_slope / line.slope, CommonShare(pairs));
    fit.offset = line.offset, fit.sigma_offset = line.sigma_offset;
    fit.rms = line.rms / std::ranges::max(pairs, {}, &Pair::measured).measured;
    if (stop.stop_requested()) break;
  }
  fit.young_modulus = E;
  fit.prestress = tried.model.prestress;
  return fit;
}

}  // namespace palpate
