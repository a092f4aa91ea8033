#include "slave/identify/law_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "shared/geometry/symmetric_eigen.h"
#include "slave/identify/specimen_spread.h"

namespace palpate::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMinShare = 0.1;   // of the highest peak; limits the weight of a test
constexpr std::size_t kStarts = 4;  // number of best grid points that are refined
constexpr int kMaxEvaluations = 200;
// Effective number of rows per test, because neighbours on a curve are correlated.
constexpr double kEffectiveRows = 40;
constexpr Index kNeighbours = 10;  // a tenth of a test's rows count as neighbours,
constexpr double kFewRows = 1.33;  // factor on variances: (2.26 / 1.96)^2 (Kiefer, Vogelsang 2005)
// Smallest error relative to the peak, because no data are more accurate.
constexpr double kFloor = 1e-4;
// Difference of BIC that is no evidence [paper: Kass and Raftery 1995].
constexpr double kSameBic = 2;

// The weight of each row: one over the test's peak.
VectorXd Weights(const std::vector<MaterialTest>& tests) {
  const double peak = PeakOf(tests);
  std::vector<double> weights;
  for (const MaterialTest& test : tests) {
    weights.insert(weights.end(), test.values(), 1 / std::max(test.Peak(), kMinShare * peak));
  }
  return Eigen::Map<VectorXd>(weights.data(), static_cast<Index>(weights.size()));
}

// Solves least squares with the first `bounded` (at most three) unknowns not negative, by trying
// every set of zero unknowns.
VectorXd SolveNonNegative(const MatrixXd& A, const VectorXd& b, Index bounded) {
  VectorXd best = VectorXd::Zero(A.cols());
  double least = b.squaredNorm();
  for (unsigned set = 1; set < (1U << A.cols()); ++set) {
    std::vector<Index> used;
    for (Index i = 0; i < A.cols(); ++i) {
      if ((set >> i & 1U) != 0) used.push_back(i);
    }
    const MatrixXd part = A(Eigen::all, used);
    const VectorXd x = part.colPivHouseholderQr().solve(b);
    const double left = (part * x - b).squaredNorm();
    bool feasible = x.allFinite();
    for (std::size_t i = 0; i < used.size(); ++i) {
      feasible &= used[i] >= bounded || x[static_cast<Index>(i)] >= 0;
    }
    if (!feasible || !(left < least * (1 - 1e-12))) continue;
    least = left;
    best.setZero();
    best(used) = x;
  }
  return best;
}

// The residuals with the best moduli for given exponents.
class Projection {
 public:
  Projection(const LawFamily& family, const std::vector<MaterialTest>& tests)
      : family_(family), tests_(tests), weights_(Weights(tests)) {
    target_ = weights_.cwiseProduct(Measured(tests));
  }

  [[nodiscard]] VectorXd Bounded(const VectorXd& free) const {
    return free.unaryExpr([](double x) { return kMaxExponent * std::tanh(x / kMaxExponent); });
  }
  // Returns the moduli; nullopt: the law overflows.
  std::optional<VectorXd> Moduli(const VectorXd& shape, VectorXd* left) const {
    MatrixXd A(target_.size(), family_.moduli());
    for (Index i = 0; i < A.cols(); ++i) {
      const HyperLaw unit = family_.Make(VectorXd::Unit(A.cols(), i), shape);
      A.col(i) = weights_.cwiseProduct(Predict(unit, tests_));
    }
    if (!A.allFinite()) return std::nullopt;
    const VectorXd scale = A.colwise().norm().cwiseMax(1e-300).transpose();
    const Index bounded = family_.yeoh.empty() ? A.cols() : 1;
    VectorXd c = SolveNonNegative(A * scale.cwiseInverse().asDiagonal(), target_, bounded);
    c = c.cwiseQuotient(scale);
    *left = A * c - target_;
    return c;
  }
  [[nodiscard]] const VectorXd& weights() const { return weights_; }
  [[nodiscard]] Index rows() const { return target_.size(); }

 private:
  const LawFamily& family_;
  const std::vector<MaterialTest>& tests_;
  VectorXd weights_, target_;
};

struct ShapeResidual {
  using Scalar = double;
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = MatrixXd;
  static constexpr int InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic;

  const Projection* projection;
  Index shapes;
  [[nodiscard]] int inputs() const { return static_cast<int>(shapes); }
  [[nodiscard]] int values() const { return static_cast<int>(projection->rows()); }
  int operator()(const VectorXd& free, VectorXd& left) const {
    if (!projection->Moduli(projection->Bounded(free), &left)) left.setConstant(values(), 1e3);
    return 0;
  }
};

// Returns the start values of the free exponents: all ascending combinations of a few values.
std::vector<VectorXd> Grid(const LawFamily& family) {
  static constexpr std::array kExponents{-25.0, -12.0, -5.0, -2.0, -0.8, 0.8,
                                         1.5,   2.5,   4.5,  8.0,  14.0, 25.0};
  std::vector<VectorXd> grid{VectorXd::Zero(family.free)};
  for (Index i = 0; i < family.free; ++i) {
    std::vector<VectorXd> longer;
    for (const VectorXd& start : grid) {
      for (const double value : kExponents) {
        if (i > 0 && value <= start[i - 1]) continue;
        longer.push_back(start);
        longer.back()[i] = value;
      }
    }
    grid = std::move(longer);
  }
  return grid;
}

// Returns the shape parameters with the smallest misfit on a grid; memory and time are proportional
// to its size.
VectorXd BestShape(const LawFamily& family, const Projection& projection) {
  std::vector<std::pair<double, VectorXd>> starts;
  VectorXd left;
  for (const VectorXd& start : Grid(family)) {
    if (projection.Moduli(projection.Bounded(start), &left)) {
      starts.emplace_back(left.squaredNorm(), start);
    }
  }
  if (starts.empty()) throw std::runtime_error(family.name + ": overflows");
  std::ranges::stable_sort(starts, {}, [](const auto& start) { return start.first; });
  if (family.free == 0) return {};
  starts.resize(std::min(starts.size(), kStarts));
  for (auto& [misfit, free] : starts) {
    const ShapeResidual residual{&projection, family.free};
    Eigen::NumericalDiff<ShapeResidual, Eigen::Central> differences(residual, 1e-12);
    Eigen::LevenbergMarquardt search(differences);
    search.parameters.maxfev = kMaxEvaluations;
    search.minimize(free);
    if (projection.Moduli(projection.Bounded(free), &left)) misfit = left.squaredNorm();
  }
  return projection.Bounded(
      std::ranges::min_element(starts, {}, [](const auto& start) { return start.first; })->second);
}

HyperLaw LawOf(const LawFamily& family, const VectorXd& values) {
  return family.Make(values.head(family.moduli()), values.tail(family.free));
}

// Sizes of the constants. A modulus that is zero has the size of the others, an exponent that of
// one hundredth.
VectorXd ScalesOf(const LawFamily& family, const VectorXd& values) {
  VectorXd scales = values.cwiseAbs();
  const double moduli = values.head(family.moduli()).cwiseAbs().maxCoeff();
  for (Index i = 0; i < scales.size(); ++i) {
    if (i >= family.moduli()) {
      scales[i] = std::max(scales[i], 1e-2);
    } else if (scales[i] < 1e-9 * moduli) {
      scales[i] = moduli;
    }
  }
  return scales;
}

// Derivatives of all predicted stresses with respect to the constants, by finite differences [Pa
// per unit].
MatrixXd Sensitivities(const LawFamily& family, const VectorXd& values,
                       const std::vector<MaterialTest>& tests) {
  constexpr double kStep = 1e-5;  // relative
  const VectorXd scales = ScalesOf(family, values);
  MatrixXd J(static_cast<Index>(ValuesOf(tests)), values.size());
  for (Index i = 0; i < values.size(); ++i) {
    const double step = kStep * scales[i];
    VectorXd up = values, down = values;
    up[i] += step, down[i] -= step;
    J.col(i) =
        (Predict(LawOf(family, up), tests) - Predict(LawOf(family, down), tests)) / (2 * step);
  }
  return J;
}

// Inverse of J^T J without the combinations of constants that the data do not determine, and the
// covariance of those combinations, which is large.
struct Inverse {
  MatrixXd determined, open;
};

// Scales the columns to length 1, so that units and magnitudes of constants have no influence.
Inverse Invert(const MatrixXd& J, const VectorXd& scales) {
  constexpr double kNothing = 1e-10;  // of the largest eigenvalue
  constexpr double kOpen = 10;        // relative sigma of a constant that is not determined
  const VectorXd sizes = J.colwise().norm().transpose().cwiseProduct(scales);
  const VectorXd unit = scales.cwiseQuotient(sizes.cwiseMax(kNothing * sizes.maxCoeff()));
  const MatrixXd even = J * unit.asDiagonal();
  const SymmetricEigen eigen = EigenOf(even.transpose() * even);
  const MatrixXd zero = MatrixXd::Zero(J.cols(), J.cols());
  Inverse inverse{zero, zero};
  for (Index i = 0; i < J.cols(); ++i) {
    const VectorXd direction = unit.cwiseProduct(VectorXd(eigen.vectors.col(i)));
    if (eigen.values[i] > kNothing * eigen.values.maxCoeff()) {
      inverse.determined += direction * direction.transpose() / eigen.values[i];
    } else {
      const VectorXd open =
          kOpen / direction.cwiseQuotient(scales).cwiseAbs().maxCoeff() * direction;
      inverse.open += open * open.transpose();
    }
  }
  return inverse;
}

// Returns the middle factor of the sandwich estimate, with the correlation of neighbours along a
// curve.
MatrixXd Scores(const MatrixXd& J, const VectorXd& left, const std::vector<MaterialTest>& tests) {
  MatrixXd meat = MatrixXd::Zero(J.cols(), J.cols());
  Index at = 0;
  for (const MaterialTest& test : tests) {
    const auto step = static_cast<Index>(test.components.size());
    const auto rows = static_cast<Index>(test.rows.size());
    const auto reach = std::max<Index>(1, rows / kNeighbours);
    for (Index c = 0; c < step; ++c) {
      for (Index i = 0; i < rows; ++i) {
        const VectorXd here = J.row(at + i * step + c).transpose() * left[at + i * step + c];
        for (Index k = -reach; k <= reach; ++k) {
          if (i + k < 0 || i + k >= rows) continue;
          const double share =
              1 - std::abs(static_cast<double>(k)) / static_cast<double>(reach + 1);
          const Index other = at + (i + k) * step + c;
          meat += share * here * (J.row(other) * left[other]);
        }
      }
    }
    at += rows * step;
  }
  return 0.5 * (meat + meat.transpose());
}

// The sigma of the modulus at rest, to first order.
double YoungSigma(const LawFit& fit) {
  const LawFamily& family = fit.family;
  VectorXd slope(fit.values.size());
  for (Index i = 0; i < slope.size(); ++i) {
    VectorXd up = fit.values;
    const double step = 1e-6 * std::max(std::abs(up[i]), 1e-3);
    up[i] += step;
    slope[i] = (LawOf(family, up).YoungModulus() - fit.law.YoungModulus()) / step;
  }
  return std::sqrt(std::max(0.0, slope.dot(fit.covariance * slope)));
}

// Returns the modulus whose interval includes zero, the least certain one if there are several.
std::optional<Index> SpansZero(const LawFit& fit) {
  std::optional<Index> found;
  double least = kNormalWide;
  for (Index i = 0; i < fit.family.moduli(); ++i) {
    const double size = std::abs(fit.values[i]), sigma = std::sqrt(fit.covariance(i, i));
    const double sure = size > 0 ? size / sigma : 0;
    if (sure <= least) least = sure, found = i;
  }
  return found;
}

// Fits a family without insignificant terms; nullopt: the result is a simpler law of the list, or
// has no term. Yeoh's law without a higher power is not in the list, unless only the first term is
// left.
std::optional<LawFit> FitNeeded(LawFamily family, const std::vector<MaterialTest>& tests,
                                std::vector<std::string>* dropped) {
  while (true) {
    LawFit fit = FitLaw(family, tests);
    const auto open = SpansZero(fit);
    if (!open) return fit;
    const std::string& name = fit.names[static_cast<std::size_t>(*open)];
    if (dropped != nullptr) dropped->push_back(family.name + " " + name);
    if (*open == 0 || family.yeoh.size() < 3) return std::nullopt;
    family.yeoh.erase(family.yeoh.begin() + *open);
    family.name += " without " + name;
  }
}

std::vector<MaterialTest> UpTo(const std::vector<MaterialTest>& tests, double strain) {
  std::vector<MaterialTest> cut = tests;
  for (MaterialTest& test : cut) {
    std::erase_if(test.rows, [&](const TestRow& row) { return LargestStrain(test, row) > strain; });
  }
  return cut;
}

// Fits the rows up to `strain`, at least three.
AtRest FindAtRest(const HyperLaw& law, const MaterialTest& test, double strain) {
  MaterialTest begin = test;
  std::erase_if(begin.rows, [&](const TestRow& row) { return LargestStrain(test, row) == 0; });
  std::ranges::stable_sort(begin.rows, {},
                           [&](const TestRow& row) { return LargestStrain(test, row); });
  std::size_t count = std::min<std::size_t>(3, begin.rows.size());
  while (count < begin.rows.size() && LargestStrain(test, begin.rows[count]) <= strain) ++count;
  begin.rows.resize(count);
  const VectorXd predicted = Predict(law, begin), measured = Measured(begin);
  const double square = predicted.squaredNorm();
  if (!(square > 0)) return {};
  const double share = predicted.dot(measured) / square;
  const auto freedom = static_cast<double>(std::max<Index>(1, predicted.size() - 1));
  return {share - 1, std::sqrt((measured - share * predicted).squaredNorm() / freedom / square)};
}

double Bic(double misfit, const std::vector<MaterialTest>& tests, Index rows, int parameters) {
  double effective = 0;
  for (const MaterialTest& test : tests) {
    effective += std::min(static_cast<double>(test.values()), kEffectiveRows);
  }
  const double mean = misfit / static_cast<double>(rows) + kFloor * kFloor;
  return effective * std::log(mean) + parameters * std::log(effective);
}

}  // namespace

double RelativeRms(const HyperLaw& law, const std::vector<MaterialTest>& tests,
                   std::vector<double>* shares) {
  double sum = 0;
  for (const MaterialTest& test : tests) {
    const double misfit = (Predict(law, test) - Measured(test)).squaredNorm();
    shares->push_back(std::sqrt(misfit / static_cast<double>(test.values())) / test.Peak());
    sum += misfit;
  }
  return std::sqrt(sum / static_cast<double>(ValuesOf(tests))) / PeakOf(tests);
}

AtRest FindAtRest(const HyperLaw& law, const std::vector<MaterialTest>& tests) {
  constexpr double kClear = 0.04;  // sigma that is small enough
  AtRest farthest;
  for (const MaterialTest& test : tests) {
    AtRest at_rest;
    for (const double strain : {0.1, 0.2, 0.4}) {
      at_rest = FindAtRest(law, test, strain);
      if (at_rest.sigma < kClear) break;
    }
    if (at_rest.excess() >= farthest.excess()) farthest = at_rest;
  }
  return farthest;
}

LawFit FitLaw(const LawFamily& family, const std::vector<MaterialTest>& tests) {
  const Projection projection(family, tests);
  const VectorXd shape = BestShape(family, projection);
  VectorXd left;
  const auto moduli = projection.Moduli(shape, &left);
  LawFit fit{
      .family = family, .law = family.Make(*moduli, shape), .names = family.ParameterNames()};
  fit.values.resize(family.parameters());
  fit.values << *moduli, shape;
  std::vector<double> shares;
  fit.rms = RelativeRms(fit.law, tests, &shares);
  fit.bic = Bic(left.squaredNorm(), tests, projection.rows(), family.parameters());
  const MatrixXd J = projection.weights().asDiagonal() * Sensitivities(family, fit.values, tests);
  const MatrixXd meat = Scores(J, left, tests) + kFloor * kFloor * (J.transpose() * J);
  const Inverse inverse = Invert(J, ScalesOf(family, fit.values));
  fit.covariance = kFewRows * (inverse.determined * meat * inverse.determined) + inverse.open;
  fit.young_sigma = YoungSigma(fit);
  const auto [low, high] = StretchRange(tests);
  fit.unstable = FirstInstability(fit.law, low, high);
  return fit;
}

std::vector<LawFit> FitLaws(const std::vector<MaterialTest>& tests,
                            std::vector<std::string>* dropped) {
  const std::size_t rows = ValuesOf(tests);
  std::vector<LawFit> fits;
  const LawFamily* simplest = nullptr;
  for (const LawFamily& family : OfferedLaws()) {
    if (rows < 2 * static_cast<std::size_t>(family.parameters())) continue;
    auto fit = FitNeeded(family, tests, dropped);
    if (simplest == nullptr) simplest = &family;
    if (fit && fit->law.ShearModulus() > 0) fits.push_back(std::move(*fit));
  }
  if (fits.empty() && simplest != nullptr) {
    LawFit fit = FitLaw(*simplest, tests);
    if (fit.law.ShearModulus() > 0) fits.push_back(std::move(fit));
  }
  if (fits.empty())
    throw std::runtime_error("no constitutive model with a positive modulus fits these tests");
  std::ranges::stable_sort(
      fits, {}, [](const LawFit& fit) { return std::pair(!fit.unstable.empty(), fit.bic); });
  const auto alike = std::ranges::find_if(fits, [&](const LawFit& fit) {
    return fit.unstable.empty() != fits.front().unstable.empty() ||
           fit.bic > fits.front().bic + kSameBic;
  });
  const auto fewest = std::ranges::min_element(
      fits.begin(), alike, {}, [](const LawFit& fit) { return fit.family.parameters(); });
  std::rotate(fits.begin(), fewest, fewest + 1);
  return fits;
}

FitFromRest FitLawsFromRest(const std::vector<MaterialTest>& tests, bool may_leave_out) {
  constexpr double kMinStrainRange = 0.2;  // range of strains
  constexpr std::size_t kMinRows = 8;      // rows of a test
  FitFromRest best;
  double strain = 0;
  for (const MaterialTest& test : tests) {
    for (const TestRow& row : test.rows) strain = std::max(strain, LargestStrain(test, row));
  }
  for (; best.fits.empty() || strain >= kMinStrainRange; strain /= 2) {
    FitFromRest next{
        .tests = UpTo(tests, strain), .largest_strain = strain, .is_all = best.fits.empty()};
    const bool is_first = best.fits.empty();
    const bool has_rows = std::ranges::all_of(
        next.tests, [](const MaterialTest& test) { return test.rows.size() >= kMinRows; });
    if (!is_first && !has_rows) break;
    try {
      next.fits = FitLaws(next.tests, &next.dropped);
    } catch (const std::runtime_error&) {  // only noise
      if (is_first) throw;
      break;
    }
    for (LawFit& fit : next.fits) {
      fit.at_rest = FindAtRest(fit.law, tests);
      fit.young_sigma = std::hypot(fit.young_sigma, fit.at_rest.excess() * fit.law.YoungModulus());
    }
    const AtRest at_rest = next.fits.front().at_rest;
    if (is_first || std::abs(at_rest.off) < std::abs(best.fits.front().at_rest.off)) {
      best = std::move(next);
    }
    if (!may_leave_out || std::abs(at_rest.off) <= kOffAtRest || at_rest.excess() == 0) break;
  }
  return best;
}

}  // namespace palpate::identify
