#include "slave/mechanics/linear/mumps.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

#include <dmumps_c.h>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {
namespace {

constexpr int kOutOfMemory = -13, kNotPositive = -10;
constexpr std::array kTooSmall{-8, -9, -17, -20};  // workspaces and buffers
constexpr int kMostRelaxation = 1000;              // of the estimated workspace [%]
constexpr int kRelaxation = 30;                    // the same, to begin with [%]

// One instance of the library at a time. A thread in the background inherits the priority of the
// sensing that waits for it.
PriorityInheritanceMutex the_library;

}  // namespace

// One problem of MUMPS.
struct Mumps {
  static constexpr int kPositiveDefinite = 1, kSymmetric = 2;

  DMUMPS_STRUC_C data{};
  std::vector<int> rows, columns;  // counted from one
  std::vector<double> values;

  explicit Mumps(int symmetry);
  ~Mumps() { Run(-2); }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  int& Control(int number) { return data.icntl[number - 1]; }
  [[nodiscard]] int Info(int number) const { return data.infog[number - 1]; }
  int Run(int job);
  void Add(int row, int column) {
    rows.push_back(row + 1);
    columns.push_back(column + 1);
  }
  void Add(const Eigen::SparseMatrix<double>& lower);
  // Of the entries added. Throws: see SpdFactor.
  void Analyse(int order);
  void FactoriseDefinite();
  // In place.
  void Solve(double* right_sides, int count);
  void Require(int outcome) const;
};

Mumps::Mumps(int symmetry) {
  constexpr int kWorld = -987654;  // MPI_COMM_WORLD, also of the sequential library
  data.par = 1;
  data.sym = symmetry;
  data.comm_fortran = kWorld;
  Run(-1);
  for (const int silent : {1, 2, 3, 4}) Control(silent) = 0;
}

int Mumps::Run(int job) {
  const std::lock_guard lock(the_library);
  data.job = job;
  dmumps_c(&data);
  return Info(1);
}

void Mumps::Add(const Eigen::SparseMatrix<double>& lower) {
  for (int c = 0; c < lower.outerSize(); ++c) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(lower, c); entry; ++entry) {
      Add(static_cast<int>(entry.row()), c);
      values.push_back(entry.value());
    }
  }
}

void Mumps::Analyse(int order) {
  data.n = order;
  data.nnz = static_cast<MUMPS_INT8>(rows.size());
  data.irn = rows.data();
  data.jcn = columns.data();
  data.a = values.data();
  Require(Run(1));
}

void Mumps::FactoriseDefinite() {
  int outcome = 0;
  for (Control(14) = kRelaxation; Control(14) <= kMostRelaxation; Control(14) *= 2) {
    outcome = Run(2);
    if (std::ranges::find(kTooSmall, outcome) == kTooSmall.end()) break;
  }
  if (outcome == kNotPositive || (outcome >= 0 && Info(12) > 0)) {
    throw std::invalid_argument(
        "stiffness: accepted is a positive definite one; the supports leave "
        "the body free to move, or an element is too distorted");
  }
  Require(outcome);
  rows = {};
  columns = {};
  values = {};
}

void Mumps::Solve(double* right_sides, int count) {
  data.rhs = right_sides;
  data.nrhs = count;
  data.lrhs = data.n;
  Control(27) = count;  // solved together
  Require(Run(3));
}

void Mumps::Require(int outcome) const {
  if (outcome >= 0) return;
  if (outcome == kOutOfMemory) throw std::bad_alloc();
  throw std::runtime_error("sparse factorisation failed (MUMPS " + std::to_string(outcome) + ")");
}

SpdFactor::SpdFactor(const Eigen::SparseMatrix<double>& lower)
    : mumps_(std::make_unique<Mumps>(Mumps::kPositiveDefinite)) {
  mumps_->Add(lower);
  mumps_->Analyse(static_cast<int>(lower.rows()));
  mumps_->FactoriseDefinite();
}

SpdFactor::~SpdFactor() = default;
SpdFactor::SpdFactor(SpdFactor&&) noexcept = default;
SpdFactor& SpdFactor::operator=(SpdFactor&&) noexcept = default;

void SpdFactor::Solve(double* columns, int count) {
  mumps_->Solve(columns, count);
}

std::size_t SpdFactor::memory_bytes() const {
  return static_cast<std::size_t>(mumps_->Info(22)) * 1'000'000;
}

}  // namespace palpate
