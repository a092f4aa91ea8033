#include "slave/precompute/distributed_factor.h"

#include <malloc.h>

#include "slave/mechanics/linear/mumps_instance.h"

namespace palpate {
namespace {

constexpr int kRelaxation = 5;  // [%]; nothing is pivoted, and memory is what ranks are added for

}  // namespace

DistributedFactor::DistributedFactor(const Ranks& ranks, Eigen::SparseMatrix<double> share,
                                     const std::vector<int>& order)
    : mumps_(std::make_unique<Mumps>(Mumps::kPositiveDefinite, ranks.fortran_communicator())) {
  const int rows = static_cast<int>(share.rows());
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
