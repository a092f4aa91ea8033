#include "slave/mechanics/fem/zone/zone_loads.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "slave/mechanics/fem/zone/near/matrix_times.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

// Nodes whose load is taken over in a step of few [nodes]. [tuned: bench_zone: p99_us]
constexpr int kFew = 64;
// What a change that waits would do to the force, by the force: that of all nodes of a zone
// together is a tenth of what steps may lack [-]. [derived: 2e-3 / 10 / sqrt(250) / 3]
constexpr double kUnseen = 4e-6;
// Steps of few after which the rounding of single precision is removed: sqrt(1000) times 1e-7.
constexpr int kMostFew = 1000;

// By a share of its change since `before`, which becomes what it was.
template <class Scalar, class Vector>
void Extrapolate(Scalar share, Vector* now, Vector* before) {
  before->swap(*now);
  *now = *before + share * (*before - *now);
}

}  // namespace

ZoneLoads::ZoneLoads(int size, Eigen::MatrixXf green) : green_(std::move(green)), mixer_(size) {
  for (VectorXd* v : {&r_, &taken_, &next_, &before_.r, &before_.taken}) v->setZero(size);
  for (VectorXf* v : {&moved_, &load_, &before_.moved}) v->setZero(size);
  changed_.resize(Index(size / 3));
  places_.reserve(Index(kFew));
}

void ZoneLoads::Reset() noexcept {
  for (VectorXd* v : {&r_, &taken_, &next_, &before_.r, &before_.taken}) v->setZero();
  moved_.setZero();
  before_.moved.setZero();
  mixer_.Reset();
  begins_ = true;
  few_ = 0;
}

void ZoneLoads::Begin(double share) noexcept {
  next_ = r_ + share * (r_ - before_.r);
  before_.r = r_;
  Extrapolate(share, &taken_, &before_.taken);
  Extrapolate(static_cast<float>(share), &moved_, &before_.moved);
  mixer_.Reset();
  begins_ = true;
}

void ZoneLoads::TakeAll() noexcept {
  few_ = 0;
  if (begins_) {
    taken_ = next_;
  } else {
    mixer_.Advance(r_, &taken_);
  }
  begins_ = false;
  load_ = taken_.cast<float>();
  MatrixTimes(green_, load_, &moved_);
}

// By what the change does to the force.
void ZoneLoads::TakeMostChanged(const Eigen::MatrixXd& dual, double force) noexcept {
  if (++few_ >= kMostFew) return TakeAll();
  if (!begins_) next_ = r_;
  begins_ = false;
  const double least = kUnseen * kUnseen * force * force;
  auto end = changed_.begin();
  for (int n = 0; 3 * n < r_.size(); ++n) {
    const double change = (next_.segment<3>(3 * n) - taken_.segment<3>(3 * n)).squaredNorm();
    const double seen = change * dual.middleRows<3>(3 * n).squaredNorm();
    if (seen > least) *end++ = {seen, n};
  }
  if (end - changed_.begin() > kFew) {
    const auto last = changed_.begin() + kFew;
    std::nth_element(changed_.begin(), last, end, std::greater<>());
    end = last;
  }
  places_.clear();
  for (auto at = changed_.begin(); at != end; ++at) {
    const int n = at->second;
    const Vector3d change = next_.segment<3>(3 * n) - taken_.segment<3>(3 * n);
    load_.segment<3>(3 * n) = change.cast<float>();
    taken_.segment<3>(3 * n) = next_.segment<3>(3 * n);
    places_.push_back(n);
  }
  AddPlaces(green_, places_, load_, &moved_);
}

void ZoneLoads::SetTaken(const VectorXd& taken) noexcept {
  taken_ = before_.taken = taken;
  load_ = taken_.cast<float>();
  MatrixTimes(green_, load_, &moved_);
  before_.moved = moved_;
  before_.r = next_ = r_;
}

}  // namespace palpate
