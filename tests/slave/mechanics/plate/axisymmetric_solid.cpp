#include "tests/slave/mechanics/plate/axisymmetric_solid.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/SparseLU>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Matrix18 = Eigen::Matrix<double, 18, 18>;
using Vector18 = Eigen::Matrix<double, 18, 1>;

constexpr std::array kPoints{-0.7745966692414834, 0.0, 0.7745966692414834};
constexpr std::array kWeights{5.0 / 9, 8.0 / 9, 5.0 / 9};
constexpr double kGrading = 2.2;

// Lagrange's parabolas through -1, 0, 1 and their slopes.
std::array<double, 3> Shapes(double x) {
  return {x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2};
}
std::array<double, 3> Slopes(double x) {
  return {x - 0.5, -2 * x, x + 0.5};
}

// Ends of elements with a node in the middle of each.
std::vector<double> WithMiddles(const std::vector<double>& ends) {
  std::vector<double> nodes{ends.front()};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    nodes.push_back((ends[i - 1] + ends[i]) / 2);
    nodes.push_back(ends[i]);
  }
  return nodes;
}

}  // namespace

struct AxisymmetricPress::Element {
  std::array<Index, 18> unknowns{};
  Vector18 forces = Vector18::Zero();
  Matrix18 tangent = Matrix18::Zero();
};

AxisymmetricPress::AxisymmetricPress(const Params& params)
    : params_(params),
      mu_(1 / (2 * (1 + params.poisson_ratio))),
      lambda_(params.poisson_ratio /
              ((1 + params.poisson_ratio) * (1 - 2 * params.poisson_ratio))) {
  Grade();
  edge_ = 2 * params.below;
  const int rim = static_cast<int>(r_.size()) - 1, top = static_cast<int>(z_.size()) - 1;
  u_.setZero(unknown(rim, top, 1) + 1);
  held_.assign(static_cast<std::size_t>(u_.size()), 0);
  const auto hold = [&](int line, int level, int component) {
    held_[static_cast<std::size_t>(unknown(line, level, component))] = 1;
  };
  for (int level = 0; level <= top; ++level) {
    hold(0, level, 0);
    hold(rim, level, 0);
    hold(rim, level, 1);
  }
  for (int line = 0; line <= edge_; ++line) hold(line, top, 1);
}

void AxisymmetricPress::Grade() {
  const double b = params_.tool_radius, t = params_.thickness;
  std::vector<double> ends, levels;
  for (int i = 0; i < params_.below; ++i) {
    ends.push_back(b * (1 - std::pow(1 - static_cast<double>(i) / params_.below, kGrading)));
  }
  for (int i = 0; i <= params_.beside; ++i) {
    const double x = static_cast<double>(i) / params_.beside;
    ends.push_back(b + (1 - b) * x * x * (3 - 2 * x));
  }
  for (int i = 0; i <= params_.layers; ++i) {
    levels.push_back(t * (1 - std::pow(1 - static_cast<double>(i) / params_.layers, 1.6)));
  }
  r_ = WithMiddles(ends);
  z_ = WithMiddles(levels);
}

double AxisymmetricPress::Force(double depth, int steps) {
  const double start = depth_;
  for (int k = 1; k <= steps; ++k) {
    depth_ = start + (depth - start) * k / steps;
    if (!Step(depth_)) return std::numeric_limits<double>::quiet_NaN();
  }
  const int top = static_cast<int>(z_.size()) - 1;
  double force = 0;
  for (int line = 0; line <= edge_; ++line) force -= forces_[unknown(line, top, 1)];
  return force;
}

// Newton's method.
bool AxisymmetricPress::Step(double depth) {
  constexpr int kMost = 40;
  constexpr double kConverged = 1e-8;
  const int top = static_cast<int>(z_.size()) - 1;
  for (int step = 0; step < kMost; ++step) {
    if (!Assemble()) return false;
    VectorXd prescribed = VectorXd::Zero(u_.size()), residual = -forces_;
    for (int line = 0; line <= edge_; ++line) {
      const int z = unknown(line, top, 1);
      prescribed[z] = -depth - u_[z];
    }
    const auto held = [&](Index i) { return held_[static_cast<std::size_t>(i)] != 0; };
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& entry : tangent_) {
      if (held(entry.row())) continue;
      if (!held(entry.col())) entries.push_back(entry);
      if (held(entry.col())) residual[entry.row()] -= entry.value() * prescribed[entry.col()];
    }
    for (Index i = 0; i < u_.size(); ++i) {
      if (!held(i)) continue;
      entries.emplace_back(i, i, 1);
      residual[i] = prescribed[i];
    }
    Eigen::SparseMatrix<double> matrix(u_.size(), u_.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    const VectorXd change = Eigen::SparseLU<Eigen::SparseMatrix<double>>(matrix).solve(residual);
    u_ += change;
    const double largest = change.cwiseAbs().maxCoeff();
    if (!std::isfinite(largest)) return false;
    if (largest < kConverged * u_.cwiseAbs().maxCoeff()) return Assemble();
  }
  return false;
}

bool AxisymmetricPress::Assemble() {
  forces_.setZero(u_.size());
  tangent_.clear();
  for (int line = 0; line + 2 < static_cast<int>(r_.size()); line += 2) {
    for (int level = 0; level + 2 < static_cast<int>(z_.size()); level += 2) {
      Element element;
      if (!Integrate(line, level, &element)) return false;
      for (std::size_t i = 0; i < element.unknowns.size(); ++i) {
        const auto row = static_cast<Index>(i);
        forces_[element.unknowns[i]] += element.forces[row];
        for (std::size_t j = 0; j < element.unknowns.size(); ++j) {
          tangent_.emplace_back(element.unknowns[i], element.unknowns[j],
                                element.tangent(row, static_cast<Index>(j)));
        }
      }
    }
  }
  return true;
}

bool AxisymmetricPress::Integrate(int line, int level, Element* element) const {
  const auto first_r = static_cast<std::size_t>(line), first_z = static_cast<std::size_t>(level);
  const double width = r_[first_r + 2] - r_[first_r], height = z_[first_z + 2] - z_[first_z];
  Vector18 u;
  for (int n = 0; n < 18; ++n) {
    const int at = unknown(line + n / 6, level + n / 2 % 3, n % 2);
    element->unknowns[static_cast<std::size_t>(n)] = at;
    u[n] = u_[at];
  }
  for (std::size_t k = 0; k < 9; ++k) {
    const double x = kPoints[k / 3], y = kPoints[k % 3];
    const double r = r_[first_r] + (x + 1) / 2 * width;
    const double weight =
        kWeights[k / 3] * kWeights[k % 3] / 4 * width * height * 2 * std::numbers::pi * r;
    const auto Nx = Shapes(x), Ny = Shapes(y), dx = Slopes(x), dy = Slopes(y);
    Eigen::Matrix<double, 5, 18> B = Eigen::Matrix<double, 5, 18>::Zero();
    for (std::size_t n = 0; n < 9; ++n) {
      const double by_r = dx[n / 3] * Ny[n % 3] * 2 / width;
      const double by_z = Nx[n / 3] * dy[n % 3] * 2 / height;
      const auto column = static_cast<Index>(2 * n);
      B.col(column) << by_r, by_z, 0, 0, Nx[n / 3] * Ny[n % 3] / r;
      B.col(column + 1) << 0, 0, by_r, by_z, 0;
    }
    Gradient F = B * u, P;
    F += Gradient(1, 0, 0, 1, 1);
    Eigen::Matrix<double, 5, 5> tangent;
    if (!Stress(F, &P, &tangent)) return false;
    element->forces += weight * B.transpose() * P;
    element->tangent += weight * B.transpose() * tangent * B;
  }
  return true;
}

bool AxisymmetricPress::Stress(const Gradient& F, Gradient* P,
                               Eigen::Matrix<double, 5, 5>* tangent) const {
  const double plane = F[0] * F[3] - F[1] * F[2], around = F[4], J = plane * around;
  if (!(J > 0)) return false;
  Gradient dJ;
  dJ << F[3] * around, -F[2] * around, -F[1] * around, F[0] * around, plane;
  Eigen::Matrix<double, 5, 5> ddJ = Eigen::Matrix<double, 5, 5>::Zero();
  ddJ(0, 3) = ddJ(3, 0) = around;
  ddJ(1, 2) = ddJ(2, 1) = -around;
  ddJ.row(4) << F[3], -F[2], -F[1], F[0], 0;
  ddJ.col(4) = ddJ.row(4).transpose();
  const double by_J = (lambda_ * std::log(J) - mu_) / J;
  const double by_JJ = (lambda_ + mu_ - lambda_ * std::log(J)) / (J * J);
  *P = mu_ * F + by_J * dJ;
  *tangent = by_J * ddJ + by_JJ * dJ * dJ.transpose();
  tangent->diagonal().array() += mu_;
  return true;
}

}  // namespace palpate
