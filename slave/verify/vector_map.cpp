#include "slave/verify/vector_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// Smallest size of a tested direction relative to the largest one.
constexpr double kMinShare = 0.2;
constexpr double kNearlyWhole = 0.98;  // smallest share of an axis within the tested directions
constexpr double kTie = 0.02;          // cosines that differ less are equally good

// Returns all relations that change only the axes in `axes`, the simplest ones first.
std::vector<AxisRelation> Relations(const std::vector<int>& axes) {
  struct Rated {
    AxisRelation relation;
    int cost;
  };
  std::vector<Rated> rated;
  std::vector<int> order = axes;
  const auto flips_end = 1U << axes.size();
  do {
    for (unsigned flips = 0; flips < flips_end; ++flips) {
      Rated one{{}, 0};
      for (std::size_t k = 0; k < axes.size(); ++k) {
        const auto j = static_cast<std::size_t>(axes[k]);
        one.relation.axis[j] = order[k];
        one.relation.sign[j] = (flips >> k & 1U) != 0 ? -1 : 1;
        one.cost += (order[k] != axes[k] ? 2 : 0) + (one.relation.sign[j] < 0 ? 2 : 0);
      }
      // Reversing the sign of all axes counts as one mistake, like reversing one axis.
      if (flips + 1 == flips_end && !one.relation.is_permuted()) one.cost = 1;
      rated.push_back(one);
    }
  } while (std::ranges::next_permutation(order).found);
  std::ranges::stable_sort(rated, {}, &Rated::cost);
  std::vector<AxisRelation> relations;
  for (const Rated& one : rated) relations.push_back(one.relation);
  return relations;
}

// Sums of products of (first, second, 1) over rows.
using Moments = Eigen::Matrix<double, 7, 7>;

// A least-squares map in the tested directions of its argument.
struct Fit {
  Matrix3d map;
  Matrix3d K;  // covariance of the argument in these directions
};

// Both maps from one set of rows.
struct Fits {
  Fit forth, back;
};

class MapFitter {
 public:
  MapFitter(const Moments& all, const std::vector<int>& axes) : relations_(Relations(axes)) {
    const Matrix6d c = Centred(all);
    const auto projector = [](const Matrix3d& covariance) -> Matrix3d {
      const Directions basis = TestedDirections(covariance);
      return basis * basis.transpose();
    };
    first_ = projector(c.topLeftCorner<3, 3>());
    second_ = projector(c.bottomRightCorner<3, 3>());
  }

  // Projectors on the tested directions of the first and of the second column.
  [[nodiscard]] const Matrix3d& first() const { return first_; }
  [[nodiscard]] const Matrix3d& second() const { return second_; }
  [[nodiscard]] const std::vector<AxisRelation>& relations() const { return relations_; }

  [[nodiscard]] Fits FitBoth(const Moments& moments) const {
    const Matrix6d c = Centred(moments);
    const auto fit = [](const Matrix3d& cross, const Matrix3d& argument, const Matrix3d& within) {
      const Matrix3d K = within * argument * within;
      const Matrix3d regular = K + argument.trace() * (Matrix3d::Identity() - within);
      return Fit{cross * within * regular.inverse() * within, K};
    };
    return {fit(c.bottomLeftCorner<3, 3>(), c.topLeftCorner<3, 3>(), first_),
            fit(c.topRightCorner<3, 3>(), c.bottomRightCorner<3, 3>(), second_)};
  }
  [[nodiscard]] static double Gain(const Fit& fit) {
    return Eigen::JacobiSVD<Matrix3d>(fit.map * fit.K).singularValues().sum() / fit.K.trace();
  }
  [[nodiscard]] static double Cosine(const Fit& fit, const AxisRelation& relation) {
    const double second = (fit.map * fit.K * fit.map.transpose()).trace();
    if (!(second > 0)) return 0;
    return (fit.map.transpose() * relation.matrix() * fit.K).trace() /
           std::sqrt(second * fit.K.trace());
  }
  [[nodiscard]] std::size_t BestRelation(const Fit& fit) const {
    std::size_t best = 0;
    double highest = -2;
    for (std::size_t i = 0; i < relations_.size(); ++i) {
      const double cosine = Cosine(fit, relations_[i]);
      if (cosine > highest + kTie) highest = cosine, best = i;
    }
    return best;
  }
  // Returns by how much the best other relation explains the map better than equal axes.
  [[nodiscard]] double CaseForOthers(const Fit& fit) const {
    double highest = -2;
    for (std::size_t i = 1; i < relations_.size(); ++i) {
      highest = std::max(highest, Cosine(fit, relations_[i]));
    }
    return highest - Cosine(fit, relations_[0]) - kTie;
  }
  // Returns the nearest rotation to `map` within the tested directions; it may include a
  // reflection.
  [[nodiscard]] Matrix3d Rotation(const Matrix3d& map) const {
    const Eigen::JacobiSVD<Matrix3d> svd(map * first_, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const auto count = static_cast<Index>(std::lround(first_.trace()));
    return svd.matrixU().leftCols(count) * svd.matrixV().leftCols(count).transpose();
  }

  // Returns the inverse of a map of the second column, within its tested directions.
  [[nodiscard]] Matrix3d InverseOf(const Matrix3d& back) const {
    const Eigen::JacobiSVD<Matrix3d> svd(back, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3d inverse = Matrix3d::Zero();
    for (Index i = 0; i < std::lround(second_.trace()); ++i) {
      const double gain = svd.singularValues()(i);
      if (gain > 0) inverse += svd.matrixV().col(i) * svd.matrixU().col(i).transpose() / gain;
    }
    return inverse;
  }

  static double Variance(const Moments& m) { return Centred(m).diagonal().tail<3>().sum(); }

 private:
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  static Matrix6d Centred(const Moments& m) {
    return m.topLeftCorner<6, 6>() -
           m.topRightCorner<6, 1>() * m.bottomLeftCorner<1, 6>() / m(6, 6);
  }

  std::vector<AxisRelation> relations_;
  Matrix3d first_, second_;
};

// Largest angle between rotations [rad].
double AngleBetween(const Matrix3d& a, const Matrix3d& b) {
  const double chord = Eigen::JacobiSVD<Matrix3d>(a - b).singularValues()(0);
  return 2 * std::asin(std::min(1.0, chord / 2));
}

Interval Inverse(const Interval& interval) {
  return {1 / interval.value, 1 / interval.high,
          interval.low > 0 ? 1 / interval.low : std::numeric_limits<double>::infinity()};
}

}  // namespace

Judgement FindingOfInterval(const Interval& interval, double low, double high) {
  if (interval.low >= low && interval.high <= high) return Judgement::kRight;
  return interval.high < low || interval.low > high ? Judgement::kWrong : Judgement::kOpen;
}

std::vector<int> BlocksOf(Index count) {
  constexpr Index kBlocks = 20;
  std::vector<int> block;
  for (Index i = 0; i < count; ++i) {
    block.push_back(static_cast<int>(i * std::min(kBlocks, count) / count));
  }
  return block;
}

std::optional<MeanVector> MeanOf(const Matrix3Xd& errors) {
  constexpr Index kParts = 10;
  const Index parts = std::min(kParts, errors.cols());
  if (parts < 3) return std::nullopt;
  Matrix3Xd means(3, parts);
  for (Index i = 0; i < parts; ++i) {
    const Index from = i * errors.cols() / parts, until = (i + 1) * errors.cols() / parts;
    means.col(i) = errors.middleCols(from, until - from).rowwise().mean();
  }
  const Vector3d mean = means.rowwise().mean();
  const auto n = static_cast<double>(parts);
  const double reach =
      StudentReach(n - 1) * std::sqrt((means.colwise() - mean).squaredNorm() / (n * (n - 1)));
  const double size = mean.norm();
  return MeanVector{mean, {size, std::fmax(0, size - reach), size + reach}};
}

Directions TestedDirections(const Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(covariance);
  const double most = eigen.eigenvalues()(2);
  if (!(most > 0)) return Directions(3, 0);
  const Index count = (eigen.eigenvalues().array() >= kMinShare * kMinShare * most).count();
  return eigen.eigenvectors().rightCols(count).rowwise().reverse();
}

Matrix3d AxisRelation::matrix() const {
  Matrix3d matrix = Matrix3d::Zero();
  for (std::size_t j = 0; j < 3; ++j) matrix(axis[j], static_cast<Index>(j)) = sign[j];
  return matrix;
}

Interval Scale::Both() const {
  return {std::sqrt(forth.value * back.value), std::fmin(forth.low, back.low),
          std::fmax(forth.high, back.high)};
}

Judgement Scale::FindingWithin(double tolerance) const {
  const double low = 1 - tolerance, high = 1 + tolerance;
  const Judgement a = FindingOfInterval(forth, low, high), b = FindingOfInterval(back, low, high);
  if (a == Judgement::kRight || b == Judgement::kRight) return Judgement::kRight;
  const bool agree = (forth.high < low) == (back.high < low);
  return a == Judgement::kWrong && b == Judgement::kWrong && agree ? Judgement::kWrong
                                                                   : Judgement::kOpen;
}

VectorMap FitMap(const Matrix3Xd& first, const Matrix3Xd& second, const std::vector<int>& block,
                 const std::vector<int>& axes) {
  VectorMap result;
  if (block.empty() || axes.empty()) return result;
  std::vector<Moments> of_block(static_cast<std::size_t>(block.back()) + 1, Moments::Zero());
  for (std::size_t i = 0; i < block.size(); ++i) {
    Eigen::Vector<double, 7> row = Eigen::Vector<double, 7>::Zero();
    for (const int axis : axes) {
      row(axis) = first(axis, static_cast<Index>(i));
      row(3 + axis) = second(axis, static_cast<Index>(i));
    }
    row(6) = 1;
    of_block[static_cast<std::size_t>(block[i])] += row * row.transpose();
  }
  Moments sum = Moments::Zero();
  for (const Moments& one : of_block) sum += one;
  const MapFitter fitter(sum, axes);
  const Matrix3d &P = fitter.first(), &Q = fitter.second();
  const double variance = MapFitter::Variance(sum);
  const double rounding = 1e-18 * sum.diagonal().head<6>().sum();
  if (P.isZero() || Q.isZero() || !(variance > rounding)) return result;

  const Fits fits = fitter.FitBoth(sum);
  const Fit &forth = fits.forth, &back = fits.back;
  result.directions = static_cast<int>(std::lround(P.trace()));
  result.map = forth.map;
  result.inverse = fitter.InverseOf(back.map);
  result.explained = (forth.map * forth.K * forth.map.transpose()).trace() / variance;
  result.relation = fitter.relations()[fitter.BestRelation(forth)];
  std::vector<Fits> without;
  for (const Moments& one : of_block) {
    without.push_back(fitter.FitBoth(sum - one));
    without.back().forth.K = forth.K;  // the selection of loads is no error
    without.back().back.K = back.K;
  }
  const auto freedom = static_cast<double>(of_block.size()) - 1 - P.trace();
  result.is_decided = freedom > 1.5 && std::ranges::all_of(without, [](const Fits& one) {
                        return (one.forth.map + one.back.map).allFinite();
                      });
  if (!result.is_decided) return result;

  const auto interval = [&](const auto& statistic) {
    const double value = statistic(fits);
    const double reach =
        JackknifeReach(without, freedom, [&](const Fits& one) { return statistic(one) - value; });
    return Interval{value, value - reach, value + reach};
  };
  result.gain = {interval([](const Fits& f) { return MapFitter::Gain(f.forth); }),
                 Inverse(interval([](const Fits& f) { return MapFitter::Gain(f.back); }))};
  for (Index j = 0; j < 3; ++j) {
    if (P.col(j).norm() < kNearlyWhole) continue;
    const Interval gain = interval([&](const Fits& f) { return f.forth.map.col(j).norm(); });
    const Index i = result.relation.axis[static_cast<std::size_t>(j)];
    result.axis_gain[static_cast<std::size_t>(j)] = {gain, gain};
    if (Q.col(i).norm() >= kNearlyWhole) {
      result.axis_gain[static_cast<std::size_t>(j)]->back =
          Inverse(interval([&](const Fits& f) { return f.back.map.col(i).norm(); }));
    }
    for (Index k = 0; k < 3; ++k) {
      const auto entry = interval([&](const Fits& f) { return f.forth.map(k, j); });
      result.half_width(k, j) = entry.high - entry.value;
    }
  }
  result.along = interval([](const Fits& f) { return MapFitter::Cosine(f.forth, {}); });
  const Interval others = interval([&](const Fits& f) { return fitter.CaseForOthers(f.forth); });
  result.relation_is_clear = others.low > 0 || others.high < 0;
  const Matrix3d rotation = fitter.Rotation(forth.map);
  const double angle = AngleBetween(rotation, result.relation.matrix() * P);
  // The estimate of an angle is never negative, so that noise moves it up.
  const double reach = JackknifeReach(without, freedom, [&](const Fits& f) {
    return AngleBetween(fitter.Rotation(f.forth.map), rotation);
  });
  result.turn = {angle, std::fmax(0, angle - reach), std::fmin(std::numbers::pi, angle + reach)};
  return result;
}

}  // namespace palpate
