#include "slave/precompute/distributed_factor.h"

#include <malloc.h>

#include "slave/mechanics/linear/mumps_instance.h"

namespace palpate {
namespace {

constexpr int kRelaxation = 20;  // [%]; with 5 and 10 single runs of four ranks failed
constexpr int kStandardOutput = 6;

}  // namespace

DistributedFactor::DistributedFactor(const Ranks& ranks, Eigen::SparseMatrix<double> share,
                                     const std::vector<int>& order)
    : mumps_(std::make_unique<Mumps>(Mumps::kPositiveDefinite, ranks.fortran_communicator())) {
  const int rows = static_cast<int>(share.rows());
  // MUMPS 5.5 ends a rank that has an error of its workspace and no place to write it.
  mumps_->Control(1) = kStandardOutput;
  mumps_->Add(share);
  share = {};
  mumps_->EliminateAs(order);
  mumps_->Analyse(rows, true);
  malloc_trim(0);  // what assembly and analysis needed
  mumps_->FactoriseDefinite(kRelaxation);
}

DistributedFactor::~DistributedFactor() = default;

void DistributedFactor::Solve(double* columns, int count) {
  mumps_->Solve(columns, count);
}

}  // namespace palpate
