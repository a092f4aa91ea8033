#include "slave/mechanics/bem3d/surface_greens.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "shared/geometry/index.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/linear/dense_lu.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Part = GreensStore::Part;

constexpr double kLargestCondition = 1e13;
constexpr int kTriangles = 64;         // whose columns are solved for together
constexpr double kDiscretisation = 1;  // rises whenever the same inputs give another result

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

[[noreturn]] void RefuseSingular() {
  throw std::invalid_argument(
      "the boundary element system is singular (condition > 1e13): the surface touches itself, or "
      "its triangles differ too much in size");
}

}  // namespace

SurfaceGreens::SurfaceGreens(const SurfaceMesh& mesh, HeldNodes held, double nu,
                             const Options& options, Progress* progress)
    : system_(mesh, std::move(held), nu) {
  NumberReactions();
  GreensStore store(options.cache, Inputs());
  auto kept = store.Load();
  from_cache_ = kept && Fits(*kept);
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
    const int row = reaction_[Index(3 * triangle + r)];
    if (row < 0) continue;
    for (int c = 0; c < 3; ++c) {
      traction[r] += force[c] * data_.reactions[Index(3 * place + c) * reactions_ + Index(row)];
    }
  }
  return traction;
}

void SurfaceGreens::NumberReactions() {
  for (int i = 0; i < places(); ++i) {
    for (int c = 0; c < 3; ++c) {
      reaction_.push_back(system_.held(i, c) ? static_cast<int>(reactions_++) : -1);
    }
  }
}

std::vector<double> SurfaceGreens::Inputs() const {
  std::vector<double> inputs{kDiscretisation, double{DenseLu::kWidth}, double{kTriangles},
                             system_.nu()};
  for (int i = 0; i < places(); ++i) {
    for (const auto& corner : system_.surface().elements[Index(i)].corners) {
      inputs.insert(inputs.end(), corner.begin(), corner.end());
    }
    for (int c = 0; c < 3; ++c) inputs.push_back(system_.held(i, c) ? 1 : 0);
  }
  return inputs;
}

bool SurfaceGreens::Fits(const GreensData& data) const {
  const auto count = Index(places());
  return data.blocks.size() == 9 * count * count && data.reactions.size() == 3 * count * reactions_;
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
  if (!(data_.condition < kLargestCondition)) RefuseSingular();

  data_.blocks.resize(9 * Index(triangles) * Index(triangles));
  data_.reactions.resize(3 * Index(triangles) * reactions_);
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
    Store(begin, columns);
  }
  ReportProgress(progress, "green's functions", 1);
}

// What is unknown where a component is free is its displacement, where it is held its traction.
void SurfaceGreens::Store(int begin, const MatrixXd& columns) {
  const auto count = Index(places());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const auto column = 3 * Index(begin) + static_cast<std::size_t>(k);
    double* blocks = data_.blocks.data() + 9 * count * (column / 3) + 3 * (column % 3);
    double* reactions = data_.reactions.data() + column * reactions_;
    for (std::size_t row = 0; row < 3 * count; ++row) {
      const double value = columns(static_cast<Eigen::Index>(row), k);
      const bool held = reaction_[row] >= 0;
      blocks[9 * (row / 3) + row % 3] = held ? 0 : value;
      if (held) reactions[reaction_[row]] = value;
    }
  }
}

}  // namespace palpate
