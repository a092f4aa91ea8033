#include "slave/mechanics/plate/round_press.h"

#include <cmath>
#include <iterator>
#include <numbers>

namespace palpate::plate {
namespace {

constexpr int kDegree = 8;
constexpr int kNodes = kDegree + 1;   // per element
constexpr int kPoints = kDegree + 3;  // of the rule
constexpr int kMaxPressSteps = 40;

// Ends of the elements under a point load: graded by a factor of about five towards the singular
// slope r ln r at the centre and the boundary layer at the rim, which is 0.3 t / w thick.
constexpr double kEnds[] = {1e-4, 1e-3, 6e-3, 0.03, 0.1, 0.25, 0.5, 0.75, 0.92, 0.98, 0.996, 1};

// Under a disc the slope is smooth inside; its third derivative jumps at the edge.
std::vector<double> Ends(double load_radius) {
  const double R = load_radius;
  std::vector<double> ends(std::begin(kEnds), std::end(kEnds));
  if (R == 0) return ends;
  const double apart = 0.15 * std::min(R, 1 - R);
  std::erase_if(ends, [&](double end) { return end < 0.75 * R || std::abs(end - R) <= apart; });
  ends.insert(ends.end(), {R / 2, R});
  std::ranges::sort(ends);
  return ends;
}

// Returns the fraction of the load inside radius r.
double Inside(double r, double load_radius, Face face) {
  if (r >= load_radius) return 1;
  return face == Face::kRigid ? 0 : (r / load_radius) * (r / load_radius);
}

}  // namespace

BandedSymmetric::BandedSymmetric(int size, int band)
    : size_(size),
      band_(band),
      rows_(static_cast<std::size_t>(size) * static_cast<std::size_t>(band + 1), 0.0) {}

void BandedSymmetric::Hold(int i) {
  for (int j = std::max(0, i - band_); j < i; ++j) at(i, j) = 0;
  for (int k = i + 1; k < std::min(size_, i + band_ + 1); ++k) at(k, i) = 0;
  at(i, i) = 1;
}

// Row i of L D, then of L: l_ij d_j = a_ij - sum_k (l_ik d_k) l_jk.
bool BandedSymmetric::Factorise() noexcept {
  for (int i = 0; i < size_; ++i) {
    const int first = std::max(0, i - band_);
    // Indexed by column - first.
    double* row = &rows_[Place(i, first)];
    for (int j = first; j < i; ++j) {
      const int start = std::max(first, j - band_);
      const double* mine = &row[start - first];
      const double* other = &rows_[Place(j, start)];
      double sum = 0;
      for (int k = 0; k < j - start; ++k) sum += mine[k] * other[k];
      row[j - first] -= sum;
    }
    double pivot = row[i - first];
    for (int j = first; j < i; ++j) {
      const double scaled = row[j - first];
      row[j - first] /= rows_[Place(j, j)];
      pivot -= scaled * row[j - first];
    }
    if (!(std::abs(pivot) > 0) || !std::isfinite(pivot)) return false;
    row[i - first] = pivot;
  }
  return true;
}

void BandedSymmetric::Solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept {
  for (int i = 0; i < size_; ++i) {
    for (int j = std::max(0, i - band_); j < i; ++j) x[i] -= rows_[Place(i, j)] * x[j];
  }
  for (int i = 0; i < size_; ++i) x[i] /= rows_[Place(i, i)];
  for (int i = size_ - 1; i >= 0; --i) {
    for (int j = std::max(0, i - band_); j < i; ++j) x[j] -= rows_[Place(i, j)] * x[i];
  }
}

RoundPress::RoundPress(double nu, double load_radius, double prestress, Face face) {
  Divide(load_radius);
  const auto count = static_cast<int>(radius_.size());
  bending_ = stretching_ = BandedSymmetric(count, kDegree);
  tangent_ = BandedSymmetric(2 * count, 2 * kDegree + 1);
  for (auto* v : {&slope_, &psi_, &load_, &residual_}) v->setZero(count);
  depth_.setZero(count);
  for (auto* v : {&step_, &by_load_}) v->setZero(2 * count);
  AssembleLinear(nu, load_radius, prestress, face);
}

void RoundPress::Divide(double load_radius) {
  const std::vector<double> ends = Ends(load_radius);
  const Eigen::VectorXd nodes = LobattoPoints(kNodes);
  radius_.setZero(static_cast<Eigen::Index>(ends.size()) * kDegree + 1);
  double inner = 0;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto first = static_cast<Eigen::Index>(e) * kDegree;
    elements_.push_back({inner, ends[e], static_cast<int>(first)});
    radius_.segment(first, kNodes) = (inner + (ends[e] - inner) * nodes.array()).matrix();
    inner = ends[e];
  }
  rule_ = GaussLegendre(kPoints);
  polynomials_ = Interpolate(nodes, rule_.points);
}

// Assembles the constant parts: both operators of the slope and of psi, the load, the deflection at
// the centre. The slope is fixed at the centre and the rim, psi at the centre, by a one on the
// diagonal.
void RoundPress::AssembleLinear(double nu, double load_radius, double prestress, Face face) {
  const double D = 1 / (12 * (1 - nu * nu));
  const auto last = static_cast<int>(radius_.size()) - 1;
  for (const Element& element : elements_) {
    const double length = element.outer - element.inner;
    const bool is_within = face == Face::kRigid && element.inner < load_radius;
    for (int q = 0; q < kPoints; ++q) {
      const double r = element.inner + length * rule_.points[q];
      const double weight = rule_.weights[q] * length;
      for (int i = 0; i < kNodes; ++i) {
        const double Ni = polynomials_.value(q, i);
        const double dNi = polynomials_.slope(q, i) / length;
        load_[element.first + i] +=
            weight * Inside(r, load_radius, face) * Ni / (2 * std::numbers::pi);
        if (!is_within) depth_[element.first + i] -= weight * Ni;
        for (int j = 0; j <= i; ++j) {
          const double Nj = polynomials_.value(q, j);
          const double laplace =
              weight * (r * dNi * polynomials_.slope(q, j) / length + Ni * Nj / r);
          bending_.at(element.first + i, element.first + j) +=
              D * laplace + prestress * weight * r * Ni * Nj;
          stretching_.at(element.first + i, element.first + j) += laplace;
        }
      }
    }
  }
  stretching_.at(last, last) -= nu;
  for (const int held : {0, last}) load_[held] = 0;
  stretching_factor_ = stretching_;
  stretching_factor_.Hold(0);
  stretching_factor_.Factorise();
}

void RoundPress::Reset() noexcept {
  slope_.setZero();
  psi_.setZero();
  force_ = stiffness_ = 0;
}

bool RoundPress::Solve(const Goal& goal) noexcept {
  if (!std::isfinite(goal.value)) return false;
  return SolveBySteps(
      std::abs(goal.value),
      [&](double share) {
        return Newton({goal.is_force, share * goal.value});
      },
      [&] { Reset(); });
}

bool RoundPress::Newton(const Goal& goal) noexcept {
  const Eigen::Index count = slope_.size();
  // The slope's entries of a vector in which slope and psi alternate.
  const auto odd = [count](Eigen::VectorXd& both) {
    return Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<2>>(both.data(), count);
  };
  for (int iteration = 0; iteration < kMaxPressSteps; ++iteration) {
    if (!Tangent()) return false;
    step_.setZero();
    by_load_.setZero();
    odd(step_) = -residual_;
    odd(by_load_) = -load_;
    tangent_.Solve(step_);
    tangent_.Solve(by_load_);
    const double compliance = depth_ * odd(by_load_);
    double more = goal.value - force_;
    if (!goal.is_force) more = (goal.value - depth_ * (slope_ + odd(step_))) / compliance;
    const double before = LargestEntry(slope_);
    const double change = LargestEntry(odd(step_) + more * odd(by_load_));
    if (!std::isfinite(change) || !(compliance > 0)) return false;
    slope_ += odd(step_) + more * odd(by_load_);
    force_ += more;
    stiffness_ = 1 / compliance;
    UpdateTension();
    if (change <= kConverged * std::max(before, LargestEntry(slope_))) return true;
  }
  return false;
}

// The tangent of the bordered system in slope and psi, and the residual of the first equation.
bool RoundPress::Tangent() noexcept {
  const auto last = static_cast<int>(radius_.size()) - 1;
  tangent_.SetZero();
  residual_ = force_ * load_;
  for (int i = 0; i <= last; ++i) {
    for (int j = std::max(0, i - kDegree); j <= i; ++j) {
      const double stiffness = bending_.at(i, j);
      tangent_.at(2 * i, 2 * j) = stiffness;
      tangent_.at(2 * i + 1, 2 * j + 1) = -stretching_.at(i, j);
      residual_[i] += stiffness * slope_[j];
      if (j < i) residual_[j] += stiffness * slope_[i];
    }
  }
  for (const Element& element : elements_) AddTension(element);
  for (const int held : {0, 1, 2 * last}) tangent_.Hold(held);
  residual_[0] = residual_[last] = 0;
  return tangent_.Factorise();
}

void RoundPress::AddTension(const Element& element) noexcept {
  const double length = element.outer - element.inner;
  Eigen::Matrix<double, kNodes, kNodes> by_slope, by_psi;
  by_slope.setZero();
  by_psi.setZero();
  for (int q = 0; q < kPoints; ++q) {
    const auto N = polynomials_.value.row(q);
    const double b = N * slope_.segment<kNodes>(element.first);
    const double psi = N * psi_.segment<kNodes>(element.first);
    const double weight = rule_.weights[q] * length;
    by_slope.noalias() += (weight * psi) * N.transpose() * N;
    by_psi.noalias() += (weight * b) * N.transpose() * N;
    residual_.segment<kNodes>(element.first) += (weight * psi * b) * N.transpose();
  }
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j <= i; ++j) {
      const int row = 2 * (element.first + i);
      const int column = 2 * (element.first + j);
      tangent_.at(row, column) += by_slope(i, j);
      tangent_.at(row + 1, column) += by_psi(i, j);
      if (j < i) tangent_.at(row, column + 1) += by_psi(i, j);
    }
  }
}

// psi of the present slope: its equation is linear.
void RoundPress::UpdateTension() noexcept {
  psi_.setZero();
  for (const Element& element : elements_) {
    const double length = element.outer - element.inner;
    for (int q = 0; q < kPoints; ++q) {
      const auto N = polynomials_.value.row(q);
      const double b = N * slope_.segment<kNodes>(element.first);
      psi_.segment<kNodes>(element.first) +=
          (rule_.weights[q] * length * b * b / 2) * N.transpose();
    }
  }
  psi_[0] = 0;
  stretching_factor_.Solve(psi_);
}

}  // namespace palpate::plate
