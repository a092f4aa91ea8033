#include "slave/mechanics/bem/capacitance_solver.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kBalance = 1e-6;  // of the sum of the forces' magnitudes
constexpr std::size_t kColumnsAhead = 4;
constexpr double kFixesMotion = 1e-10;  // smallest eigenvalue of the modes at prescribed places

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

CapacitanceSolver::CapacitanceSolver(const GreensFunctions& greens)
    : greens_(greens), taken_by_(Index(greens.size()), 0) {}

bool CapacitanceSolver::Prepare(std::span<const ContactPatch> patches) {
  if (!CollectPatches(patches) || LosesPressure() || !CollectFreeMotions()) {
    patches_.clear();
    return false;
  }
  const int values = 2 * static_cast<int>(patches_.size());
  first_value_ = PaddedTo8(order_);
  system_ = {nullptr, OddLanes(first_value_ + values)};
  augmented_.resize(Index(order_) * Index(system_.stride));
  system_.data = augmented_.data();
  scratch_.resize(Index(kPanel * order_));
  FillCapacitance();
  FillPrescribed();
  if (!SolveInPlace(system_, order_, scratch_.data())) {
    patches_.clear();
    return false;
  }
  FillMap();
  return true;
}

bool CapacitanceSolver::CollectPatches(std::span<const ContactPatch> patches) {
  ++preparation_;
  order_ = 0;
  patches_.clear();
  nodes_.clear();
  unknowns_.clear();
  for (const auto& given : patches) {
    Patch patch{given.law, static_cast<int>(nodes_.size()), 0, 0, {}};
    const bool load = given.law == ContactPatch::Law::kLoad;
    for (const int i : given.nodes) {
      int& taken = taken_by_[Index(i)];
      if (taken == preparation_ || (taken == -preparation_ && !load)) return false;
      taken = load ? -preparation_ : preparation_;
      nodes_.push_back(i);
      patch.length += greens_.lengths()[Index(i)];
      patch.blocked[0] = patch.blocked[0] || greens_.held(i, 0);
      patch.blocked[1] = patch.blocked[1] || greens_.held(i, 1);
    }
    patch.end = static_cast<int>(nodes_.size());
    patches_.push_back(patch);
    if (!load) CollectUnknowns(given, static_cast<int>(patches_.size()) - 1);
  }
  return true;
}

// Components that the reference problem holds are no unknowns: they stay with the fixture.
void CapacitanceSolver::CollectUnknowns(const ContactPatch& patch, int index) {
  for (const int i : patch.nodes) {
    Unknowns unknowns{i, index, order_, 0, Matrix2d::Identity()};
    const Vector2d free(greens_.held(i, 0) ? 0 : 1, greens_.held(i, 1) ? 0 : 1);
    if (patch.law == ContactPatch::Law::kFrictionless) {
      unknowns.basis.col(0) = patch.direction.cwiseProduct(free);
      unknowns.count = unknowns.basis.col(0).isZero(0) ? 0 : 1;
    } else {
      if (free.x() == 0) unknowns.basis.col(0) = Vector2d::UnitY();
      unknowns.count = static_cast<int>(free.sum());
    }
    order_ += unknowns.count;
    if (unknowns.count > 0) unknowns_.push_back(unknowns);
  }
}

// Displacements on the whole boundary of a body that is almost incompressible.
bool CapacitanceSolver::LosesPressure() const noexcept {
  const auto& problem = greens_.problem();
  if (problem.plane != Plane::kStrain || problem.nu <= GreensFunctions::kLargestNuAllHeld) {
    return false;
  }
  int held = order_;
  for (int i = 0; i < greens_.size(); ++i) {
    held += (greens_.held(i, 0) ? 1 : 0) + (greens_.held(i, 1) ? 1 : 0);
  }
  return held == 2 * greens_.size();
}

// On a body that may move freely, prescribed displacements must fix the motion; the balancing
// tractions are then asked to vanish, and the mean motions become unknowns.
bool CapacitanceSolver::CollectFreeMotions() {
  const int motions = greens_.free_motions();
  if (motions == 0 || unknowns_.empty()) return true;
  Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
  gram.topLeftCorner(motions, motions).setZero();
  for (const auto& u : unknowns_) {
    const auto& element = greens_.problem().mesh.elements[Index(greens_.node(u.node).element)];
    for (const Vector2d& end : {element.a, element.b}) {
      const Eigen::Matrix<double, 3, 2> along = greens_.RigidModes(end).transpose() * u.basis;
      for (int k = 0; k < u.count; ++k) gram += along.col(k) * along.col(k).transpose() / order_;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > kFixesMotion)) return false;
  for (int block = greens_.size(); block < greens_.block_count(); ++block, order_ += 2) {
    unknowns_.push_back({block, -1, order_, 2, Matrix2d::Identity()});
  }
  return true;
}

// Blocks lie at random places of a large matrix: those of the next column are on their way while
// one is copied.
void CapacitanceSolver::Fetch(const Unknowns& from) const noexcept {
  for (const auto& to : unknowns_) __builtin_prefetch(greens_.block(to.node, from.node));
}

void CapacitanceSolver::FillCapacitance() {
  for (std::size_t i = 0; i < std::min(kColumnsAhead, unknowns_.size()); ++i) Fetch(unknowns_[i]);
  for (std::size_t column = 0; column < unknowns_.size(); ++column) {
    const Unknowns& from = unknowns_[column];
    if (column + kColumnsAhead < unknowns_.size()) Fetch(unknowns_[column + kColumnsAhead]);
    for (const auto& to : unknowns_) {
      const double* e = greens_.block(to.node, from.node);
      double* row = system_.row(to.row) + from.row;
      if (to.count == 2 && from.count == 2) {
        row[0] = e[0];
        row[1] = e[2];
        row[system_.stride] = e[1];
        row[system_.stride + 1] = e[3];
        continue;
      }
      Matrix2d projected = Matrix2d::Zero();
      projected = to.basis.transpose() * Eigen::Map<const Matrix2d>(e) * from.basis;
      for (int r = 0; r < to.count; ++r) {
        for (int c = 0; c < from.count; ++c) row[r * system_.stride + c] = projected(r, c);
      }
    }
  }
}

// What a unit force on `load`, spread evenly, does at `element`.
Matrix2d CapacitanceSolver::ByLoad(int node, const Patch& load) const noexcept {
  Matrix2d sum = Matrix2d::Zero();
  for (const int j : NodesOf(load)) sum += Block(node, j);
  for (int c = 0; c < 2; ++c) {
    if (load.blocked[Index(c)]) sum.col(c).setZero();
  }
  return sum / load.length;
}

void CapacitanceSolver::FillPrescribed() {
  for (const auto& u : unknowns_) {
    for (int r = 0; r < u.count; ++r) {
      double* row = system_.row(u.row + r);
      std::fill(row + order_, row + system_.stride, 0.0);
      if (u.patch < 0) continue;
      row[first_value_ + 2 * u.patch] = u.basis(0, r);
      row[first_value_ + 2 * u.patch + 1] = u.basis(1, r);
    }
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      if (patches_[p].law != ContactPatch::Law::kLoad) continue;
      const Matrix2d moved = u.basis.transpose() * ByLoad(u.node, patches_[p]);
      for (int r = 0; r < u.count; ++r) {
        double* row = system_.row(u.row + r) + first_value_ + 2 * static_cast<int>(p);
        row[0] = -moved(r, 0);
        row[1] = -moved(r, 1);
      }
    }
  }
}

Matrix2d CapacitanceSolver::Observed(const Patch& patch, int by_node) const noexcept {
  const bool load = patch.law == ContactPatch::Law::kLoad;
  Matrix2d sum = Matrix2d::Zero();
  for (const int i : NodesOf(patch)) {
    const double length = greens_.lengths()[Index(i)];
    const double weight = load ? length / patch.length : length;
    const Matrix2d block = Block(i, by_node);
    for (int c = 0; c < 2; ++c) {
      if (greens_.held(i, c) != load) sum.row(c) += weight * block.row(c);
    }
  }
  return sum;
}

void CapacitanceSolver::FillMap() {
  const int values = 2 * static_cast<int>(patches_.size());
  map_.assign(Index(values) * Index(values), 0.0);
  const auto add = [&](int answer, double factor, const Unknowns& u, int k) {
    Eigen::Map<Eigen::ArrayXd>(map_.data() + Index(answer) * Index(values), values) +=
        factor * Eigen::Map<const Eigen::ArrayXd>(system_.row(u.row + k) + first_value_, values);
  };
  for (const auto& u : unknowns_) {
    if (u.patch < 0) continue;
    const double length = greens_.lengths()[Index(u.node)];
    for (int k = 0; k < u.count; ++k) {
      for (int c = 0; c < 2; ++c) {
        if (u.basis(c, k) != 0) add(2 * u.patch + c, length * u.basis(c, k), u, k);
      }
    }
  }
  for (int p = 0; 2 * p < values; ++p) {
    const Patch& patch = patches_[Index(p)];
    if (!Observes(patch)) continue;
    for (const auto& u : unknowns_) {
      const Matrix2d seen = Observed(patch, u.node) * u.basis;
      for (int k = 0; k < u.count; ++k) {
        add(2 * p, seen(0, k), u, k);
        add(2 * p + 1, seen(1, k), u, k);
      }
    }
    for (int q = 0; 2 * q < values; ++q) {
      const Patch& load = patches_[Index(q)];
      if (load.law != ContactPatch::Law::kLoad) continue;
      Eigen::Map<RowMatrix> map(map_.data(), values, values);
      for (const int j : NodesOf(load)) {
        map.block<2, 2>(2 * p, 2 * q) += Observed(patch, j) / load.length;
      }
    }
  }
}

bool CapacitanceSolver::Balanced(std::span<const double> prescribed) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double magnitude = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Vector2d force(prescribed[2 * p], prescribed[2 * p + 1]);
    magnitude += force.norm();
    for (const int i : NodesOf(patches_[p])) {
      sum += greens_.lengths()[Index(i)] / patches_[p].length *
             greens_.RigidModes(greens_.node(i).p_O).transpose() * force;
    }
  }
  return sum.cwiseAbs().maxCoeff() <= kBalance * magnitude;
}

bool CapacitanceSolver::Respond(std::span<const double> prescribed,
                                std::span<double> answer) const noexcept {
  const std::size_t values = 2 * patches_.size();
  if (prescribed.size() != values || answer.size() != values) return false;
  for (std::size_t v = 0; v < values; ++v) {
    if (prescribed[v] != 0 && patches_[v / 2].blocked[v % 2]) return false;
  }
  if (greens_.free_motions() > 0 && unknowns_.empty() && !Balanced(prescribed)) return false;
  const auto size = static_cast<Eigen::Index>(values);
  const Eigen::Map<const RowMatrix> map(map_.data(), size, size);
  const Eigen::Map<const Eigen::VectorXd> given(prescribed.data(), size);
  for (Eigen::Index a = 0; a < size; ++a)
    answer[static_cast<std::size_t>(a)] = map.row(a).dot(given);
  return true;
}

Matrix2d CapacitanceSolver::Derivative(int patch) const noexcept {
  const std::size_t values = 2 * patches_.size();
  const double* first = map_.data() + 2 * Index(patch) * (values + 1);
  return (Matrix2d() << first[0], first[1], first[values], first[values + 1]).finished();
}

Vector2d CapacitanceSolver::Traction(const Unknowns& u,
                                     std::span<const double> prescribed) const noexcept {
  Vector2d value = Vector2d::Zero();
  for (int k = 0; k < u.count; ++k) {
    const double* by_value = system_.row(u.row + k) + first_value_;
    double amplitude = 0;
    for (std::size_t v = 0; v < prescribed.size(); ++v) amplitude += by_value[v] * prescribed[v];
    value += amplitude * u.basis.col(k);
  }
  return value;
}

void CapacitanceSolver::Boundary(std::span<const double> prescribed,
                                 std::vector<Vector2d>* displacement,
                                 std::vector<Vector2d>* traction) const {
  BoundarySum sum(greens_);
  for (const auto& u : unknowns_) sum.Add(u.node, Traction(u, prescribed));
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    if (patches_[p].law != ContactPatch::Law::kLoad) continue;
    const Vector2d force(prescribed[2 * p], prescribed[2 * p + 1]);
    for (const int j : NodesOf(patches_[p])) sum.Add(j, force / patches_[p].length);
  }
  sum.Finish(displacement, traction);
}

}  // namespace palpate
