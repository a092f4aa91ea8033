#include "slave/mechanics/fem/green/spd_factor.h"

#include <new>
#include <string>
#include <vector>

#include <dmumps_c.h>

namespace palpate {
namespace {

constexpr int kNoMpi = -987654;  // MPI_COMM_WORLD of the sequential library
constexpr int kOutOfMemory = -13, kWorkspaceTooSmall = -9;
constexpr int kMostRelaxation = 1000;  // of the estimated workspace [%]

}  // namespace

struct SpdFactor::Mumps {
  DMUMPS_STRUC_C data{};
  std::vector<int> rows, columns;
  std::vector<double> values;

  Mumps() {
    data.par = 1;
    data.sym = 1;
    data.comm_fortran = kNoMpi;
    Run(-1);
    for (const int silent : {1, 2, 3, 4}) Control(silent) = 0;
  }
  ~Mumps() {
    data.job = -2;
    dmumps_c(&data);
  }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  int& Control(int number) { return data.icntl[number - 1]; }
  [[nodiscard]] int Info(int number) const { return data.infog[number - 1]; }
  int Run(int job) {
    data.job = job;
    dmumps_c(&data);
    return Info(1);
  }
  void Require(int outcome) const {
    if (outcome >= 0) return;
    if (outcome == kOutOfMemory) throw std::bad_alloc();
    throw std::runtime_error("sparse factorisation failed (MUMPS " + std::to_string(outcome) + ")");
  }
};

SpdFactor::SpdFactor(const Eigen::SparseMatrix<double>& lower) : mumps_(std::make_unique<Mumps>()) {
  Mumps& m = *mumps_;
  for (int c = 0; c < lower.outerSize(); ++c) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(lower, c); entry; ++entry) {
      m.rows.push_back(static_cast<int>(entry.row()) + 1);
      m.columns.push_back(c + 1);
      m.values.push_back(entry.value());
    }
  }
  m.data.n = static_cast<int>(lower.rows());
  m.data.nnz = static_cast<MUMPS_INT8>(m.values.size());
  m.data.irn = m.rows.data();
  m.data.jcn = m.columns.data();
  m.data.a = m.values.data();
  m.Require(m.Run(1));
  int outcome = 0;
  for (m.Control(14) = 30; m.Control(14) <= kMostRelaxation; m.Control(14) *= 2) {
    outcome = m.Run(2);
    if (outcome != kWorkspaceTooSmall) break;
  }
  if (outcome == -10 || (outcome >= 0 && m.Info(12) > 0)) {
    throw std::invalid_argument(
        "stiffness: accepted is a positive definite one; the supports leave "
        "the body free to move, or an element is too distorted");
  }
  m.Require(outcome);
  m.rows = {};
  m.columns = {};
  m.values = {};
}

SpdFactor::~SpdFactor() = default;
SpdFactor::SpdFactor(SpdFactor&&) noexcept = default;
SpdFactor& SpdFactor::operator=(SpdFactor&&) noexcept = default;

void SpdFactor::Solve(double* columns, int count) {
  Mumps& m = *mumps_;
  m.data.rhs = columns;
  m.data.nrhs = count;
  m.data.lrhs = m.data.n;
  m.Control(27) = count;  // solved together
  m.Require(m.Run(3));
}

std::size_t SpdFactor::memory_bytes() const {
  return static_cast<std::size_t>(mumps_->Info(22)) * 1'000'000;
}

}  // namespace palpate
