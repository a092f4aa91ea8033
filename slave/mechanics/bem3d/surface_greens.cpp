#include "slave/mechanics/bem3d/surface_greens.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/geometry/index.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/linear/dense_lu.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Part = GreensStore::Part;

// Of one multiplication and addition, measured on solutions as large as a block.
double SecondsPerStep() {
  constexpr int kOrder = DenseLu::kWidth;
  DenseLu lu(MatrixXd::Identity(kOrder, kOrder));
  lu.FactorizeNext();
  MatrixXd columns = MatrixXd::Constant(kOrder, kOrder, 0.5);
  double best = 1;
  for (int k = 0; k < 3; ++k) {
    const auto start = std::chrono::steady_clock::now();
    lu.SolveInPlace(columns);
    best = std::min(best, SecondsSince(start));
  }
  return best / (double{kOrder} * kOrder * kOrder);
}

double SecondsPerIntegral(const ReferenceSystem& system) {
  const auto start = std::chrono::steady_clock::now();
  const auto columns = system.Loads(0, 1);
  return SecondsSince(start) / static_cast<double>(columns.rows() / 3);
}

}  // namespace

SurfaceGreens::SurfaceGreens(const SurfaceMesh& mesh, HeldNodes held, double nu,
                             const Options& options, Progress* progress)
    : system_(mesh, std::move(held), nu), layout_(system_) {
  GreensStore store(options.cache, GreensLayout::Inputs(system_));
  auto kept = store.Load();
  from_cache_ = kept && layout_.Fits(*kept);
  if (from_cache_) {
    data_ = std::move(*kept);
    return;
  }
  RequireMemory(options.memory_limit);
  Compute(&store, progress);
  store.Finish(data_);
  remark_ = store.remark();
}

Vector3d SurfaceGreens::Reaction(int triangle, int place, const Vector3d& force) const {
  Vector3d traction = Vector3d::Zero();
  for (int r = 0; r < 3; ++r) {
    const int row = layout_.row(Index(3 * triangle + r));
    if (row < 0) continue;
    for (int c = 0; c < 3; ++c) {
      traction[r] += force[c] * data_.reactions[Index(3 * place + c) * layout_.rows() + Index(row)];
    }
  }
  return traction;
}

void SurfaceGreens::RequireMemory(std::size_t limit) const {
  const auto order = static_cast<double>(system_.order());
  const double bytes = 2 * order * order * sizeof(double);
  if (bytes <= static_cast<double>(limit)) return;
  constexpr double kGiB = 1 << 30;
  throw std::invalid_argument(std::to_string(places()) + " triangles need " +
                              std::to_string(bytes / kGiB) + " GiB: accepted is at most " +
                              std::to_string(static_cast<double>(limit) / kGiB));
}

// Unfinished blocks of an earlier run are taken over; the integrals are not worth keeping, they
// take less time than reading them would.
void SurfaceGreens::Compute(GreensStore* store, Progress* progress) {
  const int order = system_.order();
  const int triangles = places();
  if (progress) {
    const double n = order;
    const double integrals = 2.0 * triangles * triangles;
    progress->Expect(
        {4.0 / 3 * n * n * n * SecondsPerStep() + integrals * SecondsPerIntegral(system_),
         static_cast<std::size_t>(2 * n * n * sizeof(double))});
  }
  MatrixXd A = system_.Matrix(
      [&](int j) { ReportProgress(progress, "integrals", static_cast<double>(j) / triangles); });
  if (!A.allFinite()) RefuseSingular();
  DenseLu lu(std::move(A));
  while (lu.done() < lu.blocks()) {
    ReportProgress(progress, "factorisation", static_cast<double>(lu.done()) / lu.blocks());
    const auto kept = store->Resume(Part::kFactor, lu.done());
    if (kept && lu.AdoptNext(*kept)) continue;
    if (!lu.FactorizeNext()) RefuseSingular();
    store->Keep(Part::kFactor, lu.done() - 1, lu.LastBlock());
  }
  data_.condition = 1 / lu.ReciprocalCondition();
  RequireRegular(data_.condition);

  constexpr int kTriangles = GreensLayout::kTriangles;
  data_.blocks.resize(layout_.blocks(Index(triangles)));
  data_.reactions.resize(layout_.reactions(Index(triangles)));
  for (int begin = 0; begin < triangles; begin += kTriangles) {
    ReportProgress(progress, "green's functions", static_cast<double>(begin) / triangles);
    const int end = std::min(begin + kTriangles, triangles);
    MatrixXd columns;
    const auto kept = store->Resume(Part::kColumns, begin);
    if (kept && kept->size() == 3 * Index((end - begin) * order)) {
      columns = Eigen::Map<const MatrixXd>(kept->data(), order, 3 * (end - begin));
    } else {
      columns = system_.Loads(begin, end);
      lu.SolveInPlace(columns);
      store->Keep(Part::kColumns, begin,
                  {columns.data(), static_cast<std::size_t>(columns.size())});
    }
    layout_.Split(columns, data_.blocks.data() + layout_.blocks(Index(begin)),
                  data_.reactions.data() + layout_.reactions(Index(begin)));
  }
  ReportProgress(progress, "green's functions", 1);
}

}  // namespace palpate
