#include "slave/mechanics/bem/greens_functions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <sys/mman.h>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr double kMinReciprocalCondition = 1e-13;
constexpr double kMatricesAtOnce = 2;   // A and E, then E and the blocks
constexpr double kPerIntegral = 60e-9;  // [s] for each entry of A and Abar
constexpr double kOperationsPerSecond = 3e10;
constexpr Eigen::Index kColumnsAtOnce = 64;  // columns per solve, between checks for a stop request
constexpr std::size_t kCacheLine = 64;       // bytes
constexpr std::size_t kLargePage = 2 << 20;
constexpr double kHeldMotion = 1e-9;  // a rigid motion this small at all held places is free

bool AllHeld(const ReferenceProblem& problem) {
  return std::ranges::all_of(problem.held, [](const auto& h) { return h[0] && h[1]; });
}

void RequireUsable(const ReferenceProblem& problem) {
  const auto& mesh = problem.mesh;
  if (mesh.size() < 3) {
    throw std::invalid_argument("a mesh of " + std::to_string(mesh.size()) +
                                " elements: expected 3 or more");
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
  RequirePositive("length unit", mesh.length_unit);
  if (problem.plane == Plane::kStrain && AllHeld(problem) &&
      problem.nu > GreensFunctions::kMaxNuAllHeld) {
    RefuseValue("poisson_ratio", problem.nu,
                "at most 0.499 in plane strain for a body whose whole boundary is fixed (the "
                "boundary integrals do not determine the pressure near 0.5)");
  }
}

bool NeedsHolePressures(const ReferenceProblem& problem) {
  const bool plain = problem.order == ElementOrder::kConstant &&
                     problem.nu <= GreensFunctions::kMaxNuWithoutHolePressures;
  return problem.plane == Plane::kStrain && problem.mesh.loop_begin.size() > 2 && !plain;
}

}  // namespace

PrecomputeCost GreensFunctions::Estimate(int elements, ElementOrder order) {
  const double unknowns = 2.0 * elements * ElementNodes::Of(order).count;
  const double operations = 8.0 / 3 * unknowns * unknowns * unknowns;
  const double bytes = kMatricesAtOnce * unknowns * unknowns * sizeof(double);
  return {kPerIntegral * unknowns * unknowns + operations / kOperationsPerSecond,
          static_cast<std::size_t>(bytes)};
}

GreensFunctions::GreensFunctions(ReferenceProblem problem, Progress* progress)
    : Compliance(2),
      problem_(std::move(problem)),
      elasticity_(PlaneElasticity::From(problem_.nu, problem_.plane)) {
  RequireUsable(problem_);
  nodes_ = NodesOf(problem_);
  for (const auto& node : nodes_) lengths_.push_back(node.length);
  FindFreeMotions();
  stride_ = nodes_.size() + (free_motions_ > 0 ? 2 : 0);

  const BoundarySystem system(problem_, nodes_, elasticity_);
  const int pressures = NeedsHolePressures(problem_) ? system.holes() : 0;
  const auto columns = static_cast<Eigen::Index>(2 * stride_);
  Eigen::MatrixXd A(columns + pressures, columns + pressures);
  Eigen::MatrixXd E(columns + pressures, columns);
  system.Collocate(&A, &E, progress);
  if (pressures > 0) system.AppendHolePressures(columns, &A, &E);
  if (free_motions_ > 0) AppendFreeMotions(&A, &E);
  Solve(DenseLu(std::move(A)), &E, progress);
  StoreBlocks(E);
}

// E := A_0^-1 E.
void GreensFunctions::Solve(DenseLu lu, Eigen::MatrixXd* E, Progress* progress) {
  bool regular = true;
  while (regular && lu.done() < lu.blocks()) {
    ReportProgress(progress, "factorising",
                   std::pow(static_cast<double>(lu.done()) / lu.blocks(), 2));
    regular = lu.FactorizeNext();
  }
  const double reciprocal = regular ? lu.ReciprocalCondition() : 0;
  if (!(reciprocal > kMinReciprocalCondition)) {
    throw std::invalid_argument(
        "the boundary element system is singular (condition > 1e13): the outline touches itself, "
        "or its elements differ too much in length");
  }
  condition_ = 1 / reciprocal;
  for (Eigen::Index j = 0; j < E->cols(); j += kColumnsAtOnce) {
    ReportProgress(progress, "solving", static_cast<double>(j) / static_cast<double>(E->cols()));
    lu.SolveInPlace(E->middleCols(j, std::min(kColumnsAtOnce, E->cols() - j)));
  }
  error_ = ElementError(problem_, nodes_, elasticity_, lu, *E);
}

Eigen::Matrix3d GreensFunctions::FreeBlock(const double* column, int by, int at) {
  Eigen::Matrix3d free = BlockAt(column, at);
  for (int c = 0; c < 2; ++c) {
    if (at < size() && held(at, c)) free.row(c).setZero();
    if (by < size() && held(by, c)) free.col(c).setZero();
  }
  return free;
}

Eigen::Matrix<double, 2, 3> GreensFunctions::RigidModes(const Eigen::Vector2d& p_O) const noexcept {
  const Eigen::Vector2d p = (p_O - mean_p_O_) / problem_.mesh.length_unit;
  return (Eigen::Matrix<double, 2, 3>() << 1, 0, -p.y(), 0, 1, p.x()).finished() * motions_;
}

// Rigid motions are u = c + w z x (p - p_mean). The free motions are those that vanish at all fixed
// components.
void GreensFunctions::FindFreeMotions() {
  const auto& elements = problem_.mesh.elements;
  double total = 0;
  for (const auto& node : nodes_) {
    mean_p_O_ += node.length * node.p_O;
    total += node.length;
  }
  mean_p_O_ /= total;
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  double held_length = 0;
  for (int i = 0; i < size(); ++i) {
    const auto& element = elements[Index(node(i).element)];
    for (int c = 0; c < 2; ++c) {
      if (!held(i, c)) continue;
      for (const auto& end : {element.a, element.b}) {
        const Eigen::RowVector3d moved = RigidModes(end).row(c);
        gram += node(i).length * moved.transpose() * moved;
        held_length += node(i).length;
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

// H u - G m b = G t with the balancing tractions m b, which also affect the holes' pressures; the
// mean of m . u is prescribed.
void GreensFunctions::AppendFreeMotions(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const {
  const Eigen::Index n = 2 * static_cast<Eigen::Index>(size());
  const Eigen::Index pressures = A->cols() - Abar->cols();
  A->middleCols(n, 4).setZero();
  A->middleRows(n, 4).setZero();
  Abar->rightCols(4).setZero();
  Abar->middleRows(n, 4).setZero();
  A->block(n, n, 4, 4).diagonal().tail(4 - free_motions_).setOnes();
  Abar->block(n, n, 4, 4).setIdentity();
  const double total = Eigen::Map<const Eigen::VectorXd>(lengths_.data(), size()).sum();
  Eigen::MatrixXd modes(n, 3);
  for (int i = 0; i < size(); ++i) {
    modes.middleRows<2>(Eigen::Index{2} * i) = RigidModes(node(i).p_O);
    for (int c = 0; c < 2; ++c) {
      if (held(i, c)) continue;
      A->block(n, 2 * i + c, 3, 1) += node(i).length / total * modes.row(2 * i + c).transpose();
    }
  }
  const auto balancing = modes.leftCols(free_motions_);
  A->block(0, n, n, free_motions_) = -Abar->topLeftCorner(n, n) * balancing;
  A->block(n + 4, n, pressures, free_motions_) = -Abar->bottomLeftCorner(pressures, n) * balancing;
}

void GreensFunctions::Free::operator()(double* memory) const noexcept {
  std::free(memory);  // NOLINT(cppcoreguidelines-no-malloc): it came from aligned_alloc
}

// Contacts read blocks at random places. Blocks are therefore aligned to cache lines, and large
// memory pages are used if available, to avoid page-table lookups.
void GreensFunctions::StoreBlocks(const Eigen::MatrixXd& E) {
  const std::size_t alignment = memory_bytes() < kLargePage ? kCacheLine : kLargePage;
  const std::size_t bytes = (memory_bytes() + alignment - 1) / alignment * alignment;
  blocks_.reset(static_cast<double*>(std::aligned_alloc(alignment, bytes)));
  if (!blocks_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (alignment == kLargePage) madvise(blocks_.get(), bytes, MADV_HUGEPAGE);
#endif
  double* block = blocks_.get();
  for (Eigen::Index j = 0; j < E.cols(); j += 2) {
    for (Eigen::Index i = 0; i < E.cols(); i += 2, block += 4) {
      Eigen::Map<Eigen::Matrix2d>(block, 2, 2) = E.block<2, 2>(i, j);
    }
  }
}

BoundarySum::BoundarySum(const GreensFunctions& greens)
    : greens_(greens), answer_(Index(greens.size()), Eigen::Vector2d::Zero()), given_(answer_) {}

void BoundarySum::Add(int j, const Eigen::Vector2d& value) {
  for (int i = 0; i < greens_.size(); ++i) {
    answer_[Index(i)] += Eigen::Map<const Eigen::Matrix2d>(greens_.block(i, j)) * value;
  }
  if (j < greens_.size()) given_[Index(j)] += value;
}

void BoundarySum::Finish(std::vector<Eigen::Vector2d>* displacement,
                         std::vector<Eigen::Vector2d>* traction) {
  displacement->assign(answer_.size(), Eigen::Vector2d::Zero());
  *traction = std::move(given_);
  for (std::size_t i = 0; i < answer_.size(); ++i) {
    for (int c = 0; c < 2; ++c) {
      auto& known = greens_.held(static_cast<int>(i), c) ? *traction : *displacement;
      known[i][c] = answer_[i][c];
    }
  }
}

}  // namespace palpate
