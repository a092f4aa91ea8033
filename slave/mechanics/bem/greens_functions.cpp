#include "slave/mechanics/bem/greens_functions.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "slave/mechanics/bem/kelvin_integrals.h"

namespace palpate {
namespace {

constexpr double kSmallestReciprocalCondition = 1e-13;
constexpr double kHeldMotion = 1e-9;  // a rigid motion this small at all held places is free

bool AllHeld(const ReferenceProblem& problem) {
  return std::ranges::all_of(problem.held, [](const auto& h) { return h[0] && h[1]; });
}

void RequireUsable(const ReferenceProblem& problem) {
  const auto& mesh = problem.mesh;
  if (mesh.size() < 3) {
    throw std::invalid_argument("a mesh of " + std::to_string(mesh.size()) +
                                " elements: accepted is 3 or more");
  }
  if (problem.held.size() != mesh.elements.size()) {
    throw std::invalid_argument("boundary conditions for " + std::to_string(problem.held.size()) +
                                " of " + std::to_string(mesh.size()) + " elements");
  }
  for (const auto& e : mesh.elements) {
    if (!(e.length() > 0 && e.a.allFinite() && e.b.allFinite())) {
      throw std::invalid_argument("an element without length, or not finite");
    }
  }
  if (!(mesh.length_unit > 0 && std::isfinite(mesh.length_unit))) {
    throw std::invalid_argument("length unit = " + std::to_string(mesh.length_unit) +
                                " m: accepted is a finite length > 0");
  }
  if (problem.plane != Plane::kStrain) return;
  const auto refuse = [&](double largest, const char* body) {
    if (problem.nu <= largest) return;
    throw std::invalid_argument("poisson_ratio = " + std::to_string(problem.nu) +
                                " in plane strain for " + body + ": accepted is at most " +
                                std::to_string(largest) +
                                " (the boundary integrals lose the pressure near 0.5)");
  };
  if (mesh.loop_begin.size() > 2) {
    refuse(GreensFunctions::kLargestNuWithHoles, "a body with holes");
  }
  if (AllHeld(problem)) {
    refuse(GreensFunctions::kLargestNuAllHeld, "a body held on its whole boundary");
  }
}

}  // namespace

PlaneElasticity PlaneElasticity::From(double nu, Plane plane) {
  if (!(nu > -1 && nu <= 0.5)) {
    throw std::invalid_argument("poisson_ratio = " + std::to_string(nu) +
                                ": accepted is -1 < nu <= 0.5");
  }
  return {1 / (2 * (1 + nu)), plane == Plane::kStress ? nu / (1 + nu) : nu};
}

GreensFunctions::GreensFunctions(ReferenceProblem problem)
    : problem_(std::move(problem)),
      elasticity_(PlaneElasticity::From(problem_.nu, problem_.plane)) {
  RequireUsable(problem_);
  for (const auto& e : problem_.mesh.elements) {
    lengths_.push_back(e.length() / problem_.mesh.length_unit);
  }
  FindFreeMotions();
  stride_ = problem_.held.size() + (free_motions_ > 0 ? 2 : 0);

  const auto order = static_cast<Eigen::Index>(2 * stride_);
  Eigen::MatrixXd A(order, order);
  Eigen::MatrixXd E(order, order);
  Assemble(&A, &E);
  if (free_motions_ > 0) AppendFreeMotions(&A, &E);
  const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>> lu(A);
  const double reciprocal = lu.rcond();
  if (!(reciprocal > kSmallestReciprocalCondition)) {
    throw std::invalid_argument(
        "the boundary element system is singular (condition > 1e13): the outline touches itself, "
        "or "
        "its elements differ too much in length");
  }
  condition_ = 1 / reciprocal;
  E = lu.permutationP() * E;
  lu.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(E);
  lu.matrixLU().triangularView<Eigen::Upper>().solveInPlace(E);
  StoreBlocks(E);
}

Eigen::Matrix<double, 2, 3> GreensFunctions::RigidModes(const Eigen::Vector2d& p_O) const noexcept {
  const Eigen::Vector2d p = (p_O - mean_p_O_) / problem_.mesh.length_unit;
  return (Eigen::Matrix<double, 2, 3>() << 1, 0, -p.y(), 0, 1, p.x()).finished() * motions_;
}

// Rigid motions are u = c + w z x (p - p_mean). Those that vanish at all held components remain.
void GreensFunctions::FindFreeMotions() {
  const auto& elements = problem_.mesh.elements;
  double total = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    mean_p_O_ += lengths_[i] * elements[i].midpoint();
    total += lengths_[i];
  }
  mean_p_O_ /= total;
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  double held_length = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (int c = 0; c < 2; ++c) {
      if (!held(static_cast<int>(i), c)) continue;
      for (const auto& end : {elements[i].a, elements[i].b}) {
        const Eigen::RowVector3d moved = RigidModes(end).row(c);
        gram += lengths_[i] * moved.transpose() * moved;
        held_length += lengths_[i];
      }
    }
  }
  free_motions_ = 3;
  if (held_length > 0) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram / held_length);
    free_motions_ = static_cast<int>((eigen.eigenvalues().array() < kHeldMotion).count());
    motions_ = eigen.eigenvectors();  // ascending: the free ones first
  }
  motions_.rightCols(3 - free_motions_).setZero();
}

// Columns of A_0 and of -Abar_0.
void GreensFunctions::Assemble(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const {
  const KelvinConstants constants(elasticity_.shear_modulus, elasticity_.effective_nu);
  const auto& elements = problem_.mesh.elements;
  const double unit = problem_.mesh.length_unit;
  std::vector<Eigen::Vector2d> midpoints;
  midpoints.reserve(elements.size());
  for (const auto& e : elements) midpoints.emplace_back(e.midpoint() / unit);

  for (std::size_t j = 0; j < elements.size(); ++j) {
    const Eigen::Vector2d a = elements[j].a / unit;
    const Eigen::Vector2d t = (elements[j].b - elements[j].a).normalized();
    const Eigen::Vector2d n(t.y(), -t.x());
    const double length = lengths_[j];
    const auto column = static_cast<Eigen::Index>(2 * j);
    // Unknown displacement: H to the left, G to the right; unknown traction: -G and -H.
    const auto place = [&](int c) {
      const bool held = problem_.held[j][static_cast<std::size_t>(c)];
      double* h = held ? &(*Abar)(0, column + c) : &(*A)(0, column + c);
      double* g = held ? &(*A)(0, column + c) : &(*Abar)(0, column + c);
      return std::pair{h, g};
    };
    const auto [hx, gx] = place(0);
    const auto [hy, gy] = place(1);
    const double sx = problem_.held[j][0] ? -1 : 1;
    const double sy = problem_.held[j][1] ? -1 : 1;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const Eigen::Vector2d r = a - midpoints[i];
      const bool self = i == j;
      const KelvinIntegrals<double> integrals(self ? -0.5 * length : r.dot(t),
                                              self ? 0.0 : r.dot(n), length);
      const auto blocks = Combine(constants, integrals, length, t.x(), t.y());
      const double c = self ? 0.5 : 0;
      hx[2 * i] = sx * (blocks.of_displacement(0, 0) + c);
      hx[2 * i + 1] = sx * blocks.of_displacement(1, 0);
      hy[2 * i] = sy * blocks.of_displacement(0, 1);
      hy[2 * i + 1] = sy * (blocks.of_displacement(1, 1) + c);
      gx[2 * i] = sx * blocks.of_traction(0, 0);
      gx[2 * i + 1] = sx * blocks.of_traction(1, 0);
      gy[2 * i] = sy * blocks.of_traction(0, 1);
      gy[2 * i + 1] = sy * blocks.of_traction(1, 1);
    }
  }
}

// H u - G m b = G t with the balancing tractions m b; the mean of m . u is prescribed.
void GreensFunctions::AppendFreeMotions(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const {
  const Eigen::Index n = 2 * static_cast<Eigen::Index>(size());
  A->rightCols(4).setZero();
  A->bottomRows(4).setZero();
  Abar->rightCols(4).setZero();
  Abar->bottomRows(4).setZero();
  A->bottomRightCorner(4, 4).diagonal().tail(4 - free_motions_).setOnes();
  Abar->bottomRightCorner(4, 4).setIdentity();
  const double total = Eigen::Map<const Eigen::VectorXd>(lengths_.data(), size()).sum();
  Eigen::MatrixXd modes(n, 3);
  for (int i = 0; i < size(); ++i) {
    const auto element = static_cast<std::size_t>(i);
    modes.middleRows<2>(Eigen::Index{2} * i) =
        RigidModes(problem_.mesh.elements[element].midpoint());
    for (int c = 0; c < 2; ++c) {
      if (held(i, c)) continue;
      A->block(n, 2 * i + c, 3, 1) += lengths_[element] / total * modes.row(2 * i + c).transpose();
    }
  }
  A->block(0, n, n, free_motions_) = -Abar->topLeftCorner(n, n) * modes.leftCols(free_motions_);
}

void GreensFunctions::StoreBlocks(const Eigen::MatrixXd& E) {
  blocks_.resize(4 * stride_ * stride_);
  double* block = blocks_.data();
  for (Eigen::Index j = 0; j < E.cols(); j += 2) {
    for (Eigen::Index i = 0; i < E.rows(); i += 2, block += 4) {
      Eigen::Map<Eigen::Matrix2d>(block, 2, 2) = E.block<2, 2>(i, j);
    }
  }
}

}  // namespace palpate
