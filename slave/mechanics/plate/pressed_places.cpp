#include "slave/mechanics/plate/pressed_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr double kWorstCondition = 1e12;
constexpr double kTouching = 1e-9;       // tolerance relative to the largest depth or force
constexpr double kDenserOutwards = 1.5;  // exponent of the angles

std::size_t Of(int index) {
  return static_cast<std::size_t>(index);
}

}  // namespace

double Deflection(const PressedPlace& load, const Vector2d& x) noexcept {
  const double w = Deflection(load.disc, x);
  return load.has_twin ? (w + Deflection(load.twin, x)) / 2 : w;
}

void AppendPlaces(const Disc& disc, Face face, bool paired, std::vector<PressedPlace>* places) {
  if (face == Face::kEven) {
    places->emplace_back(disc);
    return;
  }
  const double p = disc.centre.norm();
  const Vector2d outwards = p > 0 ? Vector2d(disc.centre / p) : Vector2d(1, 0);
  const Vector2d across(-outwards.y(), outwards.x());
  for (int k = 0; k < kPairs; ++k) {
    const double angle = std::numbers::pi * std::pow((k + 0.5) / kPairs, kDenserOutwards);
    const Vector2d along = disc.centre + disc.radius * std::cos(angle) * outwards;
    const Vector2d aside = disc.radius * std::sin(angle) * across;
    if (paired) {
      places->emplace_back(along + aside, along - aside);
    } else {
      places->emplace_back(Disc{along + aside, 0});
      places->emplace_back(Disc{along - aside, 0});
    }
  }
}

void PressedPlaces::Clear() {
  bodies_.clear();
  touching_.clear();
  places_ = 0;
  factored_ = false;
}

void PressedPlaces::Add(const Body& body) {
  bodies_.push_back(body);
  signs_.resize(bodies_.size());
  depths_.resize(bodies_.size());
  places_ = std::max(places_, body.first + body.count);
  touching_.reserve(static_cast<std::size_t>(places_));
  factored_for_.reserve(static_cast<std::size_t>(places_));
  const int largest = static_cast<int>(places_) + static_cast<int>(bodies_.size());
  inverse_.resize(Of(largest) * Of(PaddedTo8(largest)));
}

bool PressedPlaces::Solve(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free,
                          std::span<const double> values, Eigen::VectorXd* forces) noexcept {
  if (bodies_.empty()) return true;
  Start(free, values, forces);
  const int rounds = 4 * static_cast<int>(forces->size()) + 10;
  for (int round = 0; round < rounds; ++round) {
    if (!Factorise(compliance)) return false;
    Seek(free, values);
    if (Approach(forces) && !TouchNext(compliance, free, *forces)) return true;
  }
  return false;
}

// Starts from the places that touched last, with admissible forces.
void PressedPlaces::Start(const Eigen::VectorXd& free, std::span<const double> values,
                          Eigen::VectorXd* forces) {
  touching_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    const double sign = values[b] < 0 ? -1 : 1;
    signs_[b] = body.is_force && values[b] == 0 ? 0 : sign;
    const std::size_t before = touching_.size();
    double load = 0;
    for (Index k = body.first; k < body.first + body.count; ++k) {
      double& force = (*forces)[k];
      const bool touches = !body.is_rigid || signs_[b] * force > 0;
      if (touches) touching_.push_back({k, b});
      if (!touches) force = 0;
      load += force;
    }
    if (!body.is_force) continue;
    if (touching_.size() == before) {
      Index first = 0;
      (sign * free.segment(body.first, body.count)).minCoeff(&first);
      touching_.push_back({body.first + first, b});
      (*forces)[body.first + first] = load = values[b];
    }
    if (load != 0) forces->segment(body.first, body.count) *= values[b] / load;
  }
}

// Factorises the equations C f - d = -w0 at the touching places, with sum f = F for each loaded
// body.
bool PressedPlaces::Factorise(const Eigen::MatrixXd& compliance) noexcept {
  if (factored_ && touching_ == factored_for_) return true;
  const auto count = static_cast<int>(touching_.size());
  size_ = count;
  for (const Body& body : bodies_) size_ += body.is_force ? 1 : 0;
  factored_for_ = touching_;
  factored_ = true;
  if (size_ == 0) return true;
  factor_.Reset(size_);
  for (int i = 0; i < size_; ++i) std::fill_n(factor_.row(i), size_, 0.0);
  scale_.setZero(size_);
  for (int i = 0; i < count; ++i) {
    const auto [place, body] = touching_[Of(i)];
    scale_[i] = 1 / std::sqrt(compliance(place, place));
    for (int j = 0; j < count; ++j) {
      factor_.row(i)[j] = compliance(place, touching_[Of(j)].place);
    }
    if (!bodies_[body].is_force) continue;
    const int border = BorderOf(body);
    factor_.row(i)[border] = -1;
    factor_.row(border)[i] = 1;
    scale_[border] = 1 / scale_[i];
  }
  for (int i = 0; i < size_; ++i) {
    for (int j = 0; j < size_; ++j) factor_.row(i)[j] *= scale_[i] * scale_[j];
  }
  factored_ = scale_.allFinite() && Invert();
  return factored_;
}

bool PressedPlaces::Invert() noexcept {
  const auto rows = [this](auto&& row) {
    double largest = 0;
    for (int i = 0; i < size_; ++i) {
      double sum = 0;
      for (int j = 0; j < size_; ++j) sum += std::abs(row(i)[j]);
      largest = std::max(largest, sum);
    }
    return largest;
  };
  const RowMajor inverse{inverse_.data(), PaddedTo8(size_)};
  const double norm = rows([this](int i) { return factor_.row(i); });
  if (!factor_.Factorise()) return false;
  std::fill_n(inverse.data, size_ * inverse.stride, 0.0);
  for (int i = 0; i < size_; ++i) inverse.row(i)[i] = 1;
  factor_.Solve(inverse);
  const double condition = norm * rows([&](int i) { return inverse.row(i); });
  for (int i = 0; i < size_; ++i) {
    for (int j = 0; j < size_; ++j) inverse.row(i)[j] *= scale_[i] * scale_[j];
  }
  return condition < kWorstCondition;  // false for NaN too
}

// Computes forces and depths for unchanged touching places.
void PressedPlaces::Seek(const Eigen::VectorXd& free, std::span<const double> values) noexcept {
  right_.resize(size_);
  for (int i = 0; i < static_cast<int>(touching_.size()); ++i) {
    const auto [place, body] = touching_[Of(i)];
    right_[i] = (bodies_[body].is_force ? 0 : values[body]) - free[place];
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].is_force) right_[BorderOf(b)] = values[b];
  }
  wanted_.resize(size_);
  wanted_.noalias() = Inverse() * right_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    depths_[b] = bodies_[b].is_force ? wanted_[BorderOf(b)] : values[b];
  }
}

// Moves from the present forces towards the computed ones until one would pull, and releases that
// place. Returns true if no place was released.
bool PressedPlaces::Approach(Eigen::VectorXd* forces) {
  const auto count = static_cast<int>(touching_.size());
  double way = 1, largest = 0;
  for (int i = 0; i < count; ++i) {
    const auto [place, body] = touching_[Of(i)];
    const double present = signs_[body] * (*forces)[place], wanted = signs_[body] * wanted_[i];
    largest = std::max({largest, std::abs(present), std::abs(wanted)});
    if (bodies_[body].is_rigid && wanted < 0) way = std::min(way, present / (present - wanted));
  }
  for (int i = 0; i < count; ++i) {
    double& force = (*forces)[touching_[Of(i)].place];
    force += way * (wanted_[i] - force);
  }
  if (way == 1) return true;
  std::erase_if(touching_, [&](const Touching& touching) {
    double& force = (*forces)[touching.place];
    const bool pulls = signs_[touching.body] * force <= kTouching * largest;
    const bool may_leave = bodies_[touching.body].is_rigid && signs_[touching.body] != 0;
    if (!may_leave || !pulls) return false;
    force = 0;
    return true;
  });
  return false;
}

// Adds the place that is farthest inside a rigid face. Returns false if no place is inside.
bool PressedPlaces::TouchNext(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free,
                              const Eigen::VectorXd& forces) {
  Touching next;
  double farthest = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].is_rigid) continue;
    for (Index k = bodies_[b].first; k < bodies_[b].first + bodies_[b].count; ++k) {
      if (forces[k] != 0) continue;
      double w = free[k];
      for (const Touching& touching : touching_) {
        w += compliance(k, touching.place) * forces[touching.place];
      }
      const double inside = signs_[b] * (depths_[b] - w);
      const double slack = kTouching * std::max(std::abs(depths_[b]), std::abs(free[k]));
      if (inside <= std::max(farthest, slack)) continue;
      farthest = inside;
      next = {k, b};
    }
  }
  if (farthest == 0) return false;
  touching_.push_back(next);
  return true;
}

double PressedPlaces::Stiffness(std::size_t body) const noexcept {
  if (bodies_[body].is_force) return 1 / Inverse()(BorderOf(body), BorderOf(body));
  double stiffness = 0;
  for (int i = 0; i < static_cast<int>(touching_.size()); ++i) {
    for (int j = 0; j < static_cast<int>(touching_.size()); ++j) {
      if (touching_[Of(i)].body == body && touching_[Of(j)].body == body) {
        stiffness += Inverse()(i, j);
      }
    }
  }
  return stiffness;
}

double PressedPlaces::StiffnessAt(const Eigen::MatrixXd& compliance, Index place) const noexcept {
  double own = compliance(place, place);
  for (int i = 0; i < static_cast<int>(touching_.size()); ++i) {
    for (int j = 0; j < static_cast<int>(touching_.size()); ++j) {
      own -= compliance(place, touching_[Of(i)].place) * Inverse()(i, j) *
             compliance(touching_[Of(j)].place, place);
    }
  }
  return own > 0 ? 1 / own : 0;
}

}  // namespace palpate::plate
