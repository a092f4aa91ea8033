#include "slave/mechanics/bem/element_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "slave/mechanics/bem/kelvin_integrals.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

// Smallest cosine of the angle between two elements with a common smooth displacement [-].
// [derived: 45 degrees, between the angles of a polygon of nine elements and of a box]
constexpr double kSmooth = 0.7;

// Ratio of larger side and thickness above which a body bends [-]. [derived: 2 of squares and
// discs]
constexpr double kSlender = 2.5;

// The thickness is 2 A / P, which is the height for a long strip.
bool IsSlender(const BoundaryMesh& mesh) {
  Eigen::AlignedBox2d box;
  double twice_area = 0, perimeter = 0;
  for (const auto& [a, b] : mesh.elements) {
    box.extend(a);
    twice_area += a.x() * b.y() - a.y() * b.x();
    perimeter += (b - a).norm();
  }
  return box.sizes().maxCoeff() * perimeter > kSlender * twice_area;
}

bool IsSmooth(const BoundaryElement& one, const BoundaryElement& next) {
  return (one.b - one.a).normalized().dot((next.b - next.a).normalized()) >= kSmooth;
}

// The coefficients of the missing modes of given displacement fields.
class MissingModes {
 public:
  // `u`: two rows per node, one column per field.
  MissingModes(const ReferenceProblem& problem, const MatrixXd& u)
      : mesh_(problem.mesh),
        local_(ElementNodes::Of(problem.order)),
        u_(u),
        c_(MatrixXd::Zero(2 * mesh_.size(), u.cols())) {
    std::vector<int> alone;
    for (int e = 0; e < mesh_.size(); ++e) {
      if (!FitToSide(e)) alone.push_back(e);
    }
    const MatrixXd sides = c_;
    for (const int e : alone) FitToCorners(e, sides);
    for (int e = 0; e < mesh_.size(); ++e) {
      for (int axis = 0; axis < 2; ++axis) {
        if (problem.held[Index(e)][Index(axis)]) c_.row(2 * e + axis).setZero();
      }
    }
  }
  // Returns the two rows of element `e`.
  [[nodiscard]] auto Of(int e) const { return c_.middleRows<2>(2 * e); }

 private:
  [[nodiscard]] int Neighbour(int e, double end) const {
    return end > 0 ? mesh_.Next(e) : mesh_.Previous(e);
  }
  [[nodiscard]] auto AtNode(int e, int m) const {
    return u_.middleRows<2>(2 * (e * local_.count + m));
  }
  // The discrete displacement of an element, continued beyond its ends.
  [[nodiscard]] MatrixXd At(int e, double s) const {
    MatrixXd sum = MatrixXd::Zero(2, u_.cols());
    for (int m = 0; m < local_.count; ++m) sum += local_.At(Index(m), s) * AtNode(e, m);
    return sum;
  }
  [[nodiscard]] double Mode(double s) const { return ElementNodes::Legendre(local_.count, s); }

  // Extrapolates from the nearest node of each neighbour on the same smooth side. False: there is
  // none.
  bool FitToSide(int e) {
    const BoundaryElement& own = mesh_.elements[Index(e)];
    int found = 0;
    for (const double end : {-1.0, 1.0}) {
      const int other = Neighbour(e, end);
      const BoundaryElement& next = mesh_.elements[Index(other)];
      if (!IsSmooth(own, next)) continue;
      const int node = end > 0 ? 0 : local_.count - 1;
      const double from_end = 1 - std::abs(local_.s[Index(node)]);
      const double s = end * (1 + from_end * next.length() / own.length());
      c_.middleRows<2>(2 * e) += (AtNode(other, node) - At(e, s)) / Mode(s);
      ++found;
    }
    if (found > 0) c_.middleRows<2>(2 * e) /= found;
    return found > 0;
  }
  // The error of an element that is a side by itself, from its neighbours' values at the common
  // corners.
  void FitToCorners(int e, const MatrixXd& sides) {
    for (const double end : {-1.0, 1.0}) {
      const int other = Neighbour(e, end);
      const MatrixXd there = At(other, -end) + Mode(-end) * sides.middleRows<2>(2 * other);
      c_.middleRows<2>(2 * e) += 0.5 * (there - At(e, end)) / Mode(end);
    }
  }

  const BoundaryMesh& mesh_;
  const ElementNodes& local_;
  const MatrixXd& u_;
  MatrixXd c_;
};

// Contribution of an element's missing mode to the collocated equations.
MatrixXd IntegrateMode(const ReferenceProblem& problem, const std::vector<BoundaryNode>& nodes,
                       const PlaneElasticity& elasticity, int element) {
  const KelvinConstants constants(elasticity.shear_modulus, elasticity.effective_nu);
  const ElementNodes& local = ElementNodes::Of(problem.order);
  const int count = static_cast<int>(nodes.size());
  MatrixXd integrals(2 * count, 2);
  for (int i = 0; i < count; ++i) {
    ElementView view = ViewOf(problem.mesh, element, nodes[Index(i)].p_O);
    if (nodes[Index(i)].element == element) {
      view.d = 0;
      view.xi_a = -0.5 * view.length * (1 + local.s[Index(i % local.count)]);
    }
    const auto mode =
        KelvinMode(LegendreMoments(view.z()), Index(local.count), 0.5 * view.length, view.d);
    integrals.middleRows<2>(2 * i) =
        Combine(constants, mode, 0, view.t.x(), view.t.y()).of_displacement;
  }
  return integrals;
}

}  // namespace

ElementError::ElementError(const ReferenceProblem& problem, const std::vector<BoundaryNode>& nodes,
                           const PlaneElasticity& elasticity, const DenseLu& lu,
                           const MatrixXd& E) {
  if (!IsSlender(problem.mesh)) return;
  ChooseProbes(problem);
  const ElementNodes& local = ElementNodes::Of(problem.order);
  const int rows = 2 * static_cast<int>(nodes.size());
  const int columns = 2 * static_cast<int>(elements_.size());
  const auto held = [&](int row) {
    return problem.held[Index(nodes[Index(row / 2)].element)][Index(row % 2)];
  };
  MatrixXd u = MatrixXd::Zero(rows, columns);
  for (int k = 0; k < columns; ++k) {
    for (int m = 0; m < local.count; ++m) {
      const int node = elements_[Index(k / 2)] * local.count + m;
      if (held(2 * node + k % 2)) continue;
      u.col(k) +=
          local.weight[Index(m)] / nodes[Index(node)].length * E.col(2 * node + k % 2).head(rows);
    }
  }
  for (std::size_t term = 0; term < terms_.size(); ++term) {
    if (term > 0) {
      const MissingModes modes(problem, u);
      MatrixXd delta = MatrixXd::Zero(lu.order(), columns);
      for (int e = 0; e < problem.mesh.size(); ++e) {
        delta.topRows(rows).noalias() -= IntegrateMode(problem, nodes, elasticity, e) * modes.Of(e);
      }
      lu.SolveInPlace(delta);
      u = delta.topRows(rows);
    }
    for (int row = 0; row < rows; ++row) {
      if (held(row)) u.row(row).setZero();  // the answer there is a traction
    }
    terms_[term].setZero(columns, columns);
    for (int p = 0; p < columns / 2; ++p) {
      for (int m = 0; m < local.count; ++m) {
        terms_[term].middleRows<2>(2 * p) +=
            local.weight[Index(m)] * u.middleRows<2>(2 * (elements_[Index(p)] * local.count + m));
      }
    }
  }
}

// Chooses at least one probe at the midpoint of each smooth side, and more in proportion to its
// elements.
void ElementError::ChooseProbes(const ReferenceProblem& problem) {
  const BoundaryMesh& mesh = problem.mesh;
  std::vector<int> side;  // of elements, on which the element begins
  for (int e = 0; e < mesh.size(); ++e) {
    const bool begins = std::ranges::find(mesh.loop_begin, e) != mesh.loop_begin.end() ||
                        !IsSmooth(mesh.elements[Index(e) - 1], mesh.elements[Index(e)]) ||
                        problem.held[Index(e) - 1] != problem.held[Index(e)];
    if (begins) AddSide(problem, &side);
    side.push_back(e);
  }
  AddSide(problem, &side);
}

void ElementError::AddSide(const ReferenceProblem& problem, std::vector<int>* side) {
  const auto size = static_cast<int>(side->size());
  const int share = (size * kProbes + problem.mesh.size() - 1) / problem.mesh.size();
  const int count = std::min(size, share);
  for (int i = 0; i < size; ++i) {
    probe_of_.push_back(static_cast<int>(elements_.size()) + i * count / size);
  }
  for (int p = 0; p < count; ++p) {
    elements_.push_back((*side)[Index((2 * p + 1) * size / (2 * count))]);
  }
  side->clear();
}

double ElementError::MissingPart(std::span<const Vector2d> forces) const noexcept {
  std::array<double, 1 + kSteps> work{};
  for (std::size_t k = 0; k < forces.size(); ++k) {
    if (forces[k].isZero(0)) continue;
    for (std::size_t j = 0; j < forces.size(); ++j) {
      if (forces[j].isZero(0)) continue;
      const auto row = static_cast<Eigen::Index>(2 * k), column = static_cast<Eigen::Index>(2 * j);
      for (std::size_t term = 0; term < terms_.size(); ++term) {
        work[term] += forces[k].dot(terms_[term].block<2, 2>(row, column) * forces[j]);
      }
    }
  }
  double missing = 0;
  for (std::size_t term = 1; term < work.size(); ++term) missing += std::abs(work[term]);
  if (missing == 0) return 0;
  return work[0] > 0 ? missing / work[0] : std::numeric_limits<double>::infinity();
}

}  // namespace palpate
