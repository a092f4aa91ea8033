#include "slave/pipeline/organ/cloud_load.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "shared/geometry/index.h"
#include "shared/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kCandidates = 64, kFinalists = 4;
constexpr int kSearchPoints = 125, kSearchSteps = 12;
constexpr int kRounds = 12, kStepsPerRound = 2;  // of a candidate's refinement
constexpr double kSettled = 0.02;                // of the width: the patch stays
constexpr double kDrifts = 0.1;                  // likewise, from cloud to cloud
constexpr double kOtherPlace = 2;  // widths from where the stiffness modes are not those any more
constexpr double kWidthSpread = 0.7;  // of the width's logarithm: a factor of two
constexpr int kStepsPerCloud = 4;
constexpr double kLargeStep = 0.05;  // of the force, after which another is taken
constexpr int kMostClouds = 50;      // that a memory is made of
constexpr double kStandsOut = 11.3;  // chi squared of three that one in a hundred exceeds
constexpr double kLongStep = 0.5;    // of the width's logarithm, of a share of stiffness
constexpr double kLocks = 0.49;      // Poisson's ratio, as in FemGreenModel
constexpr double kAtRest = 1.2;      // scatters
constexpr double kMisfit = 0.06;     // of the displacement, beyond the noise
constexpr double kLost = 2;          // times the points' heights of before

constexpr double kMostMoved = 0.5;  // of the larger side, by the place pressed

constexpr std::string_view kFew = "too few points lie on the part of the surface that is in view";
constexpr std::string_view kOtherLoad =
    "the residual of one contact exceeds the noise of the points: more than one load, or another "
    "object";
constexpr std::string_view kUnseen = "the load is on a part of the surface that is not in view";
constexpr std::string_view kTooStiff =
    "four-node tetrahedra are too stiff for a material that hardly changes its volume";
constexpr std::string_view kTooFar = "the displacement is beyond small strain";

void Require(bool holds, const char* what, double value, const char* accepted) {
  if (!holds) {
    throw std::invalid_argument(fmt::format("{} = {}: accepted is {}", what, value, accepted));
  }
}

// The nodes of triangles, and the triangles by numbers among them.
std::vector<int> NodesOf(std::vector<std::array<int, 3>>* triangles, std::size_t count) {
  std::vector<int> number(count, -1), nodes;
  for (auto& triangle : *triangles) {
    for (int& node : triangle) {
      if (number[Index(node)] < 0) {
        number[Index(node)] = static_cast<int>(nodes.size());
        nodes.push_back(node);
      }
      node = number[Index(node)];
    }
  }
  return nodes;
}

double MeanEdge(const SurfaceMesh& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    sum += (surface.nodes[Index(t[1])] - surface.nodes[Index(t[0])]).norm();
  }
  return sum / static_cast<double>(surface.triangles.size());
}

// A step that stays where its derivatives hold.
LoadVector Limited(LoadVector step, double width) {
  if (!step.allFinite()) return LoadVector::Zero();
  const double far = step.segment<2>(3).norm();
  if (far > width) step.segment<2>(3) *= width / far;
  step.tail<kLoadUnknowns - 5>() =
      step.tail<kLoadUnknowns - 5>().cwiseMax(-kLongStep).cwiseMin(kLongStep);
  return step;
}

const CloudLoad::Params& Checked(const CloudLoad::Params& params) {
  Require(params.young_modulus > 0, "young_modulus", params.young_modulus, "> 0");
  Require(params.sigma > 0, "sigma", params.sigma, "> 0");
  Require(params.tolerance > 0 && params.tolerance < 1, "tolerance", params.tolerance, "0 to 1");
  return params;
}

std::vector<int> Watched(const SolidMesh& mesh, const CloudLoad::Params& params) {
  auto triangles = params.seen.empty() ? SurfaceOf(mesh).triangles : params.seen;
  for (const auto& t : triangles) {
    for (const int node : t) {
      Require(node >= 0 && Index(node) < mesh.nodes.size(), "node", node, "a node of the mesh");
    }
  }
  return NodesOf(&triangles, mesh.nodes.size());
}

}  // namespace

CloudLoad::CloudLoad(const SolidMesh& mesh, const HeldNodes& held, const Params& params)
    : params_(Checked(params)),
      greens_(mesh, held, params.young_modulus, params.poisson_ratio, Watched(mesh, params)),
      skin_(greens_.surface()),
      in_view_(mesh.nodes.size(), false) {
  auto triangles = params.seen.empty() ? greens_.surface().triangles : params.seen;
  NodesOf(&triangles, mesh.nodes.size());
  std::vector<Vector3d> watched;
  for (const int node : greens_.watched()) {
    watched.push_back(mesh.nodes[Index(node)]);
    in_view_[Index(node)] = true;
  }
  fit_ = std::make_unique<CloudFit>(watched, std::move(triangles), params.sigma);
  larger_side_ = LargerSide(greens_.surface().nodes);
  least_width_ = MeanEdge(greens_.surface()) / 2;
  most_width_ = larger_side_ / 6;
  double spacing = 0;
  for (const int node : greens_.Spread(kCandidates, &spacing)) {
    candidates_.push_back(
        greens_.PatchAt(mesh.nodes[Index(node)], greens_.normal(node), 3 * least_width_));
  }
  candidate_fields_ = greens_.PressEach(&candidates_);
  field_ = PatchGreens::Field::Zero(PatchGreens::kColumns,
                                    9 * static_cast<Eigen::Index>(watched.size()));
}

CloudForce CloudLoad::Fit(std::span<const Vector3d> points_O) noexcept {
  try {
    return TryFit(points_O);
  } catch (const std::exception&) {
    known_ = false;
    CloudForce failed;
    failed.why = "out of memory";
    return failed;
  }
}

CloudForce CloudLoad::TryFit(std::span<const Vector3d> points_O) {
  if (known_) known_ = Follow(points_O);
  if (!known_) {
    if (IsAtRest(points_O)) return ResultAtRest();
    Search(points_O);
  }
  if (squares_.used < kFewestPoints) {
    known_ = false;
    CloudForce lost;
    lost.validity = Validity::kTrackingLost;
    lost.used = squares_.used;
    lost.why = kFew;
    return lost;
  }
  const CloudForce told = Result();
  Remember();
  MovePatch(kDrifts);
  if (told.moved < 3 * params_.sigma) known_ = false;  // where it acts is not seen any more
  return told;
}

// Nothing but noise is seen. What is left then is the force of the rough patches.
bool CloudLoad::IsAtRest(std::span<const Vector3d> points_O) {
  u_.setZero();
  field_.setZero();
  squares_ = fit_->Linearise(points_O, field_, u_);
  return squares_.used >= kFewestPoints && squares_.rms < kAtRest * params_.sigma;
}

// By the patch that moves what is seen middling well: a force that moves the points by as much as
// they scatter would not be seen.
CloudForce CloudLoad::ResultAtRest() const {
  std::vector<double> squares;
  for (const auto& field : candidate_fields_) {
    squares.push_back(3 * static_cast<double>(field.squaredNorm()) /
                      static_cast<double>(field.size()));
  }
  CloudForce told;
  told.patch = candidates_.front();
  told.covariance_O = params_.sigma * params_.sigma / MedianOf(squares) * Matrix3d::Identity();
  told.rms = squares_.rms;
  told.used = squares_.used;
  told.validity = Validity::kValid;
  return told;
}

// False: this is another load.
bool CloudLoad::Follow(std::span<const Vector3d> points_O) {
  const double before = squares_.rms;
  for (int step = 0; step < kStepsPerCloud; ++step) {
    if (Step(points_O).norm() < kLargeStep * u_.head<3>().norm()) break;
  }
  return squares_.used >= kFewestPoints && squares_.rms <= kLost * before + 3 * params_.sigma;
}

// Which patch, from rest: a rough fit at places all over the surface, a careful one at the best.
void CloudLoad::Search(std::span<const Vector3d> points_O) {
  std::vector<Vector3d> some;
  const std::size_t every = std::max<std::size_t>(1, points_O.size() / kSearchPoints);
  for (std::size_t i = 0; i < points_O.size(); i += every) some.push_back(points_O[i]);
  memory_ = {};
  std::vector<Attempt> attempts;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    field_.setZero();
    field_.row(0) = candidate_fields_[k];
    patch_ = candidates_[k];
    u_.setZero();
    for (int step = 0; step < kSearchSteps; ++step) Step(some);
    attempts.push_back({candidates_[k], u_, squares_.distance});
  }
  std::ranges::sort(attempts, {}, &Attempt::distance);
  attempts.resize(std::min<std::size_t>(attempts.size(), kFinalists));
  for (Attempt& attempt : attempts) Refine(points_O, &attempt);
  const Attempt& best = *std::ranges::min_element(attempts, {}, &Attempt::distance);
  patch_ = best.patch;
  u_ = best.u;
  greens_.Press(&patch_, &field_);
  greens_.Soften(&field_);
  softened_ = patch_;
  for (int round = 0; round < kRounds; ++round) {
    for (int step = 0; step < kStepsPerRound; ++step) Step(points_O);
    if (!MovePatch(kSettled)) break;
  }
  Step(points_O);
  known_ = true;
}

void CloudLoad::Refine(std::span<const Vector3d> points_O, Attempt* attempt) {
  patch_ = softened_ = attempt->patch;
  u_ = attempt->u;
  field_.setZero();
  greens_.Press(&patch_, &field_);
  for (int round = 0; round < kRounds; ++round) {
    for (int step = 0; step < kStepsPerRound; ++step) Step(points_O);
    softened_ = patch_;  // no modes yet: none to renew
    if (!MovePatch(kSettled)) break;
  }
  attempt->patch = patch_;
  attempt->u = u_;
  attempt->distance = squares_.distance;
}

// The patch to where its shifts lead, where that is farther than `least` of its width.
bool CloudLoad::MovePatch(double least) {
  const Vector3d still = u_.segment<3>(3);
  const double far = std::max(still.head<2>().norm() / patch_.width, std::abs(still[2]));
  if (far < least) return false;
  const auto place = skin_.Find(patch_.p_O + still[0] * patch_.along_O + still[1] * patch_.across_O,
                                std::numeric_limits<double>::infinity());
  if (!place) return false;
  LoadPatch moved = patch_;
  moved.p_O = place->p_O;
  moved.n_O = place->n_O;
  moved.along_O = (patch_.along_O - patch_.along_O.dot(place->n_O) * place->n_O).stableNormalized();
  moved.across_O = moved.n_O.cross(moved.along_O);
  moved.width = std::clamp(patch_.width * std::exp(still[2]), least_width_, most_width_);
  if (!greens_.CanPress(moved)) return false;
  patch_ = moved;
  memory_.vector -= memory_.information.leftCols<3>() * still;
  u_.segment<3>(3).setZero();
  greens_.Press(&patch_, &field_);
  if ((patch_.p_O - softened_.p_O).norm() > kOtherPlace * patch_.width) {
    greens_.Soften(&field_);
    softened_ = patch_;
  }
  return true;
}

void CloudLoad::AddPriors(LoadMatrix* H, LoadVector* g) const {
  const auto add = [&](int i, double sigma, double mean) {
    (*H)(i, i) += 1 / (sigma * sigma);
    (*g)[i] += (mean - u_[i]) / (sigma * sigma);
  };
  add(5, kWidthSpread, std::log(3 * least_width_ / patch_.width));
  for (int i = 3 + PatchGreens::kShifts; i < kLoadUnknowns; ++i) add(i, params_.tolerance, 0);
  // A place is somewhere on the organ.
  for (const int i : {3, 4}) add(i, larger_side_, 0);
}

// One step; how far the force went.
Vector3d CloudLoad::Step(std::span<const Vector3d> points_O) {
  squares_ = fit_->Linearise(points_O, field_, u_);
  LoadMatrix H = squares_.H / squares_.effect;
  LoadVector g = squares_.g / squares_.effect;
  // What is pressed moves by no more than a share of the organ's size.
  const Matrix3d moves = patch_.compliance_O / (kMostMoved * larger_side_);
  H.topLeftCorner<3, 3>() += moves.transpose() * moves;
  g.head<3>() -= moves.transpose() * moves * u_.head<3>();
  // What this cloud says of what stays, whatever its force is.
  const Eigen::LDLT<Matrix3d> force(H.topLeftCorner<3, 3>());
  const Eigen::Matrix<double, 3, kStill> by = force.solve(H.topRightCorner<3, kStill>());
  latest_.information =
      H.bottomRightCorner<kStill, kStill>() - H.bottomLeftCorner<kStill, 3>() * by;
  latest_.vector =
      latest_.information * u_.tail<kStill>() + g.tail<kStill>() - by.transpose() * g.head<3>();
  const double share = 1.0 / std::min(kMostClouds, memory_.clouds + 1);
  LoadMatrix prior = LoadMatrix::Zero();
  LoadVector pull = LoadVector::Zero();
  AddPriors(&prior, &pull);
  prior.bottomRightCorner<kStill, kStill>() += (1 - share) * memory_.information;
  pull.tail<kStill>() += (1 - share) * (memory_.vector - memory_.information * u_.tail<kStill>());
  H += prior / share;
  g += pull / share;
  posterior_ = H;
  share_ = share;
  by_ = by;
  force_information_ = H.topLeftCorner<3, 3>();
  const LoadVector step = Limited(H.ldlt().solve(g), patch_.width);
  u_ += step;
  return step.head<3>();
}

void CloudLoad::Remember() {
  const double share = 1.0 / std::min(kMostClouds, memory_.clouds + 1);
  memory_.information += share * (latest_.information - memory_.information);
  memory_.vector += share * (latest_.vector - memory_.vector);
  ++memory_.clouds;
}

// The covariance is that of the force where all else is known, and what that is uncertain by.
CloudForce CloudLoad::Result() const {
  CloudForce told;
  told.force_O = u_.head<3>();
  told.patch = patch_;
  told.rms = squares_.rms;
  told.moved = squares_.moved;
  told.used = squares_.used;
  const StillMatrix still = posterior_.bottomRightCorner<kStill, kStill>() -
                            posterior_.bottomLeftCorner<kStill, 3>() * by_;
  const StillMatrix spread = still.ldlt().solve(StillMatrix::Identity()) / share_;
  const double scale = params_.tolerance;  // of the modulus as a whole, which no shape tells
  told.covariance_O = force_information_.ldlt().solve(Matrix3d::Identity()) +
                      by_ * spread * by_.transpose() +
                      scale * scale * told.force_O * told.force_O.transpose();
  told.validity = Validity::kValid;
  const double stands = told.force_O.dot(told.covariance_O.ldlt().solve(told.force_O));
  const auto doubt = [&](FailedCheck check, std::string_view why) {
    told.validity = Validity::kExtrapolated;
    told.check = check;
    told.why = why;
  };
  if (told.rms > 3 * params_.sigma + kMisfit * told.moved) doubt(FailedCheck::kMisfit, kOtherLoad);
  if (stands < kStandsOut) return told;
  if ((patch_.compliance_O * told.force_O).norm() > params_.range * larger_side_) {
    doubt(FailedCheck::kModelRange, kTooFar);
  }
  if (params_.poisson_ratio >= kLocks) doubt(FailedCheck::kModelRange, kTooStiff);
  const auto place = skin_.Find(patch_.p_O, std::numeric_limits<double>::infinity());
  const auto& corners = greens_.surface().triangles[Index(place->triangle)];
  if (!std::ranges::all_of(corners, [&](int node) { return in_view_[Index(node)]; })) {
    doubt(FailedCheck::kMisfit, kUnseen);
  }
  return told;
}

}  // namespace palpate
