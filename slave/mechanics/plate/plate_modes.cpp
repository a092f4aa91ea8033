#include "slave/mechanics/plate/plate_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>

#include "slave/mechanics/plate/lobatto.h"

namespace palpate::plate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kMaxOrder = 40;
constexpr int kMaxRoundOrder = 120;
constexpr int kMaxModes = 2048;
constexpr int kMaxRadial = kMaxRoundOrder / 2 + 4;
constexpr int kStressDegrees = 4;  // degrees of stress modes beyond the order

// Jacobi's polynomials P_n^(alpha, beta)(x), n < values.size().
void Jacobi(double alpha, double beta, double x, std::span<double> values) {
  if (values.empty()) return;
  values[0] = 1;
  if (values.size() == 1) return;
  values[1] = alpha + 1 + (alpha + beta + 2) * (x - 1) / 2;
  const double sum = alpha + beta;
  for (std::size_t k = 2; k < values.size(); ++k) {
    const auto n = static_cast<double>(k);
    const double twice = 2 * n + sum;
    const double next =
        (twice - 1) * (twice * (twice - 2) * x + alpha * alpha - beta * beta) * values[k - 1] -
        2 * (n + alpha - 1) * (n + beta - 1) * twice * values[k - 2];
    values[k] = next / (2 * n * (n + sum) * (twice - 2));
  }
}

// r^m P_n^(alpha, m)(2 r^2 - 1) and its two derivatives in r, n < count.
struct Zernike {
  Zernike(double alpha, int m, double r, int count) {
    std::array<double, kMaxRadial> p{}, dp{}, ddp{};
    const auto size = static_cast<std::size_t>(count);
    const double x = 2 * r * r - 1;
    Jacobi(alpha, m, x, std::span(p).first(size));
    Jacobi(alpha + 1, m + 1, x, std::span(dp).first(size));
    Jacobi(alpha + 2, m + 2, x, std::span(ddp).first(size));
    for (std::size_t n = 0; n < size; ++n) {
      const double s = static_cast<double>(n) + alpha + m;
      const double d1 = n >= 1 ? (s + 1) / 2 * dp[n - 1] : 0;
      const double d2 = n >= 2 ? (s + 1) * (s + 2) / 4 * ddp[n - 2] : 0;
      const double rm = std::pow(r, m);
      value[n] = rm * p[n];
      slope[n] = m * rm / r * p[n] + 4 * rm * r * d1;
      curvature[n] =
          m * (m - 1) * rm / (r * r) * p[n] + (8 * m + 4) * rm * d1 + 16 * rm * r * r * d2;
    }
  }
  std::array<double, kMaxRadial> value{}, slope{}, curvature{};
};

// cos(m t), or sin(m t).
double Wave(int m, bool sine, double angle) {
  return sine ? std::sin(m * angle) : std::cos(m * angle);
}

// Returns the inverse Cholesky factor of `gram`, which makes modes orthonormal.
MatrixXd Orthonormaliser(const MatrixXd& gram) {
  const Eigen::LLT<MatrixXd> factor(gram);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error("the plate modes are linearly dependent");
  return factor.matrixL().solve(MatrixXd::Identity(gram.rows(), gram.cols()));
}

double NormOfWave(int m) {
  return m == 0 ? 2 * std::numbers::pi : std::numbers::pi;
}

}  // namespace

// Radial functions of one Fourier mode at the points of the radial rule: one row per mode, one
// column per point.
struct PlateModes::Radial {
  struct Deflection {
    MatrixXd slope, swing;  // f', m f / r
  };
  struct Stress {
    MatrixXd rr, tt, rt;  // factors of cos, cos and sin of an Airy function with a cosine
  };
  Quadrature rule;  // the weights include the factor r
  std::vector<Deflection> deflection;
  std::vector<Stress> stress;
};

PlateModes::PlateModes(int order, double nu, Symmetry widest) : order_(order), widest_(widest) {
  const int largest = widest == Symmetry::kRound ? kMaxRoundOrder : kMaxOrder;
  if (order < 2 || order > largest || order % 2 != 0) {
    throw std::invalid_argument("order = " + std::to_string(order) +
                                ": expected an even number from 2 to " + std::to_string(largest));
  }
  Number(&deflections_, order, false);
  Number(&stresses_, order + kStressDegrees, true);
  Radial radial;
  radial.rule = GaussLegendre(2 * order + 10);
  radial.rule.weights.array() *= radial.rule.points.array();
  const Index points = radial.rule.points.size();
  const auto tabulate = [&](double alpha, int m, int count, auto&& put) {
    for (Index q = 0; q < points; ++q) {
      const Zernike z(alpha, m, radial.rule.points[q], count);
      for (int n = 0; n < count; ++n) put(n, q, radial.rule.points[q], z);
    }
  };
  for (const Family& family : deflections_) {
    if (family.sine) break;
    const int m = family.m;
    MatrixXd slope(family.count, points), swing = slope, laplacian = slope;
    tabulate(4, m, family.count, [&](int n, Index q, double r, const Zernike& z) {
      const auto k = static_cast<std::size_t>(n);
      const double c = 1 - r * r;
      const double f = c * c * z.value[k];
      const double df = c * c * z.slope[k] - 4 * r * c * z.value[k];
      const double ddf =
          c * c * z.curvature[k] - 8 * r * c * z.slope[k] + (12 * r * r - 4) * z.value[k];
      slope(n, q) = df;
      swing(n, q) = m * f / r;
      laplacian(n, q) = ddf + df / r - m * m * f / (r * r);
    });
    const MatrixXd gram =
        NormOfWave(m) * laplacian * radial.rule.weights.asDiagonal() * laplacian.transpose();
    orthonormal_.push_back(Orthonormaliser(gram));
    radial.deflection.push_back({orthonormal_.back() * slope, orthonormal_.back() * swing});
  }
  for (const Family& family : stresses_) {
    if (family.sine) break;
    const int m = family.m;
    const int skipped = m < 2 ? 1 : 0;
    MatrixXd rr(family.count, points), tt = rr, rt = rr;
    tabulate(0, m, family.count + skipped, [&](int n, Index q, double r, const Zernike& z) {
      if (n < skipped) return;
      const auto k = static_cast<std::size_t>(n);
      rr(n - skipped, q) = z.slope[k] / r - m * m * z.value[k] / (r * r);
      tt(n - skipped, q) = z.curvature[k];
      rt(n - skipped, q) = m * (z.slope[k] / r - z.value[k] / (r * r));
    });
    const auto product = [&](const MatrixXd& a, const MatrixXd& b) -> MatrixXd {
      return a * radial.rule.weights.asDiagonal() * b.transpose();
    };
    const MatrixXd mixed = product(rr, tt);
    const MatrixXd gram =
        NormOfWave(m) * (product(rr, rr) + product(tt, tt) - nu * (mixed + mixed.transpose()) +
                         2 * (1 + nu) * product(rt, rt));
    const MatrixXd change = Orthonormaliser(gram);
    radial.stress.push_back({change * rr, change * tt, change * rt});
  }
  for (const auto symmetry : {Symmetry::kRound, Symmetry::kMirror, Symmetry::kNone}) {
    AppendBlocks(symmetry, radial);
  }
  MeasureSlopes(radial);
}

// Airy functions that are constant or linear carry no stress.
void PlateModes::Number(std::vector<Family>* families, int degree, bool is_stress) const {
  int next = 0;
  for (const bool sine : {false, true}) {
    for (int m = sine ? 1 : 0; m <= degree; ++m) {
      const bool wanted =
          widest_ == Symmetry::kNone || (!sine && (m == 0 || widest_ == Symmetry::kMirror));
      if (!wanted) continue;
      const int count = (degree - m) / 2 + 1 - (is_stress && m < 2 ? 1 : 0);
      families->push_back({m, sine, next, count});
      next += count;
    }
  }
}

int PlateModes::Count(const std::vector<Family>& families, Symmetry symmetry) {
  int count = 0;
  for (const Family& family : families) {
    const bool belongs = symmetry == Symmetry::kNone ||
                         (!family.sine && (family.m == 0 || symmetry == Symmetry::kMirror));
    if (belongs) count += family.count;
  }
  return count;
}

std::size_t PlateModes::blocks(Symmetry symmetry) const {
  if (symmetry == Symmetry::kRound) return round_blocks_;
  return symmetry == Symmetry::kMirror ? mirror_blocks_ : blocks_.size();
}

std::size_t PlateModes::memory_bytes() const {
  std::size_t numbers = static_cast<std::size_t>(slope_energy_.size());
  for (const Block& block : blocks_) numbers += block.values.size();
  return numbers * sizeof(double);
}

void PlateModes::Evaluate(const Eigen::Vector2d& x,
                          Eigen::Ref<Eigen::VectorXd> values) const noexcept {
  const double s = x.squaredNorm();
  const double clamp = std::max(0.0, 1 - s) * std::max(0.0, 1 - s);
  const std::complex<double> z(x.x(), x.y());
  std::complex<double> power = clamp;  // (1 - r^2)^2 (x + i y)^m
  std::array<double, kMaxRadial> p{};
  const auto waves = static_cast<std::size_t>(widest_ == Symmetry::kRound ? 0 : order_);
  for (std::size_t m = 0; m <= waves; ++m) {
    const Family& family = deflections_[m];
    Jacobi(4, family.m, 2 * s - 1, std::span(p).first(static_cast<std::size_t>(family.count)));
    const MatrixXd& change = orthonormal_[m];
    for (int n = 0; n < family.count; ++n) {
      double f = 0;
      for (int l = 0; l <= n; ++l) f += change(n, l) * p[static_cast<std::size_t>(l)];
      const auto put = [&](int row, double wave) {
        if (row < values.size()) values[row] = f * wave;
      };
      put(family.first + n, power.real());
      if (m > 0 && widest_ == Symmetry::kNone) put(deflections_[waves + m].first + n, power.imag());
    }
    power *= z;
  }
}

// Integrates by a rule of rings inside the disc, whose degree grows with the variation of the modes
// within it.
void PlateModes::Mean(const Disc& disc, Eigen::Ref<Eigen::VectorXd> values) const noexcept {
  if (disc.radius == 0) return Evaluate(disc.centre, values);
  static const std::array<Quadrature, 4> kRings = {GaussLegendre(3), GaussLegendre(5),
                                                   GaussLegendre(8), GaussLegendre(24)};
  const double variation = disc.radius * order_;
  const std::size_t level = variation < 0.5 ? 0 : variation < 2 ? 1 : variation < 5 ? 2 : 3;
  const Quadrature& rings = kRings[level];
  const auto angles = 2 * rings.points.size();
  std::array<double, kMaxModes> storage;
  Eigen::Map<Eigen::VectorXd> one(storage.data(), values.size());
  values.setZero();
  for (Index q = 0; q < rings.points.size(); ++q) {
    const double r = disc.radius * std::sqrt(rings.points[q]);  // equal areas for equal steps
    for (Index t = 0; t < angles; ++t) {
      const double angle =
          2 * std::numbers::pi * static_cast<double>(t) / static_cast<double>(angles);
      Evaluate(disc.centre + r * Eigen::Vector2d(std::cos(angle), std::sin(angle)), one);
      values += rings.weights[q] / static_cast<double>(angles) * one;
    }
  }
}

// Appends the blocks of this symmetry that no narrower symmetry contains.
void PlateModes::AppendBlocks(Symmetry symmetry, const Radial& radial) {
  for (const Family& k : stresses_) {
    for (const Family& i : deflections_) {
      for (const Family& j : deflections_) {
        if (j.first < i.first) continue;
        const bool round = k.m == 0 && i.m == 0 && j.m == 0;
        const bool mirror = !k.sine && !i.sine && !j.sine;
        const Symmetry own = round    ? Symmetry::kRound
                             : mirror ? Symmetry::kMirror
                                      : Symmetry::kNone;
        const bool meet = k.m == i.m + j.m || k.m == std::abs(i.m - j.m);
        if (own == symmetry && meet && (k.sine == (i.sine != j.sine))) AppendBlock(k, i, j, radial);
      }
    }
  }
  if (symmetry == Symmetry::kRound) round_blocks_ = blocks_.size();
  if (symmetry == Symmetry::kMirror) mirror_blocks_ = blocks_.size();
}

void PlateModes::AppendBlock(const Family& k, const Family& i, const Family& j,
                             const Radial& radial) {
  // Integrals of the waves over the angle, by the rule that is exact for them. A deflection's swing
  // m f / r has the factor -sin where it has a cosine and cos where it has a sine; so does, with
  // the other sign, the shear of an Airy function.
  const int steps = k.m + i.m + j.m + 1;
  double rr = 0, tt = 0, rt = 0, tr = 0;
  for (int step = 0; step < steps; ++step) {
    const double angle = 2 * std::numbers::pi * step / steps;
    const auto wave = [angle](const Family& f) { return Wave(f.m, f.sine, angle); };
    const auto swing = [angle](const Family& f) {
      return (f.sine ? 1 : -1) * Wave(f.m, !f.sine, angle);
    };
    rr += wave(k) * wave(i) * wave(j);
    tt += wave(k) * swing(i) * swing(j);
    rt -= swing(k) * wave(i) * swing(j);
    tr -= swing(k) * swing(i) * wave(j);
  }
  const double step_angle = 2 * std::numbers::pi / steps;
  const auto& N = radial.stress[static_cast<std::size_t>(k.m)];
  const auto& f = radial.deflection[static_cast<std::size_t>(i.m)];
  const auto& g = radial.deflection[static_cast<std::size_t>(j.m)];
  Block block{i.first, i.count, j.first, j.count, k.first, k.count, {}};
  block.values.reserve(static_cast<std::size_t>(i.count) * static_cast<std::size_t>(j.count) *
                       static_cast<std::size_t>(k.count));
  const Eigen::RowVectorXd weights = step_angle * radial.rule.weights.transpose();
  Eigen::RowVectorXd by_rr, by_tt, by_rt;
  for (int a = 0; a < i.count; ++a) {
    for (int b = 0; b < j.count; ++b) {
      by_rr = rr * weights.cwiseProduct(f.slope.row(a)).cwiseProduct(g.slope.row(b));
      by_tt = tt * weights.cwiseProduct(f.swing.row(a)).cwiseProduct(g.swing.row(b));
      by_rt = rt * weights.cwiseProduct(f.slope.row(a)).cwiseProduct(g.swing.row(b)) +
              tr * weights.cwiseProduct(f.swing.row(a)).cwiseProduct(g.slope.row(b));
      for (int c = 0; c < k.count; ++c) {
        block.values.push_back(N.rr.row(c).dot(by_rr) + N.tt.row(c).dot(by_tt) +
                               N.rt.row(c).dot(by_rt));
      }
    }
  }
  blocks_.push_back(std::move(block));
}

void PlateModes::MeasureSlopes(const Radial& radial) {
  const int count = deflections(Symmetry::kNone);
  slope_energy_.setZero(count, count);
  for (const Family& family : deflections_) {
    const auto& f = radial.deflection[static_cast<std::size_t>(family.m)];
    slope_energy_.block(family.first, family.first, family.count, family.count) =
        NormOfWave(family.m) * (f.slope * radial.rule.weights.asDiagonal() * f.slope.transpose() +
                                f.swing * radial.rule.weights.asDiagonal() * f.swing.transpose());
  }
}

}  // namespace palpate::plate
