// bem3d: each rank integrates rows, all factorise and solve together, the first one keeps blocks of
// columns.
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "shared/geometry/index.h"
#include "shared/text/text.h"
#include "slave/mechanics/bem3d/greens_layout.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/precompute/distributed_lu.h"
#include "slave/precompute/precompute.h"

namespace palpate {
namespace {

using Part = GreensStore::Part;

constexpr int kTriangles = GreensLayout::kTriangles;

ReferenceSystem SystemOf(const Scene& scene) {
  const ObjectMesh object = MeshObject(scene, std::nullopt);
  const auto* mesh = std::get_if<SurfaceMesh>(&object);
  if (mesh == nullptr && !std::holds_alternative<SolidMesh>(object)) {
    throw std::invalid_argument("model.kind = bem3d: accepted is an object with a volume");
  }
  const SurfaceMesh surface = SurfaceOf(object);
  return {surface, HeldTriangles(scene, surface), scene.object.material.poisson_ratio};
}

// The computation, from integrals to columns.
class Computation {
 public:
  // `store`: of the first rank, null on others.
  Computation(const ReferenceSystem& system, const GreensLayout& layout, const Ranks& ranks,
              GreensStore* store, Progress* progress)
      : system_(system),
        layout_(layout),
        ranks_(ranks),
        store_(store),
        progress_(progress),
        square_(ProcessGrid::Square(ranks)),
        rows_(ranks.size(), 1),
        alone_(1, 1) {}

  PrecomputeReport Run() {
    DistributedLu lu(ranks_, square_, Assemble());
    const int adopted = Factorise(&lu);
    const double condition = 1 / lu.ReciprocalCondition();
    ranks_.Together([&] { RequireRegular(condition); });
    const int computed = Solve(lu);
    ranks_.OnFirst([&] { Write(condition); });
    const int panels = (system_.triangles() + kTriangles - 1) / kTriangles;
    return Formatted(
        "bem3d: %d unknowns, %d of %d blocks of the factor and %d of %d of columns computed",
        lu.order(), lu.blocks() - adopted, lu.blocks(), computed, panels);
  }

 private:
  [[nodiscard]] DistributedMatrix Assemble() const;
  int Factorise(DistributedLu* lu);
  int Solve(const DistributedLu& lu);
  void Write(double condition);
  void Keep(Part part, int index, std::span<const double> values);
  void RequireKept() const {
    if (!store_->remark().empty()) throw std::runtime_error(store_->remark());
  }

  const ReferenceSystem& system_;
  const GreensLayout& layout_;
  const Ranks& ranks_;
  GreensStore* store_;
  Progress* progress_;
  ProcessGrid square_, rows_, alone_;
};

// Every rank integrates the rows of some triangles, which then go to where they belong.
DistributedMatrix Computation::Assemble() const {
  constexpr int kRows = ReferenceSystem::kRows;
  const int n = system_.order(), triangles = system_.triangles();
  DistributedMatrix A(square_, n, n, DistributedLu::kBlock, DistributedLu::kBlock);
  DistributedMatrix rows(rows_, 3 * kRows * ranks_.size(), n, 3 * kRows, n);
  for (int begin = 0; begin < triangles; begin += kRows * ranks_.size()) {
    ReportTogether(ranks_, progress_, "integrals", double{1} * begin / triangles);
    const int first = std::min(begin + kRows * ranks_.rank(), triangles);
    const int last = std::min(first + kRows, triangles);
    ranks_.Together([&] {
      if (first == last) return;
      rows.share().topRows(3 * (last - first)) = system_.Rows(first, last);
      if (!rows.share().allFinite()) RefuseSingular();
    });
    const int count = std::min(kRows * ranks_.size(), triangles - begin);
    Copy(3 * count, n, rows, {0, 0}, &A, {3 * begin, 0}, square_);
  }
  if (system_.free_motions() > 0) {
    if (ranks_.first()) rows.share().topRows(6) = system_.MeanMotions();
    Copy(6, n, rows, {0, 0}, &A, {n - 6, 0}, square_);
  }
  return A;
}

// Returns how many blocks were there.
int Computation::Factorise(DistributedLu* lu) {
  int adopted = 0;
  while (lu->done() < lu->blocks()) {
    ReportTogether(ranks_, progress_, "factorisation", double{1} * lu->done() / lu->blocks());
    if (adopted == lu->done()) {
      std::optional<std::vector<double>> kept;
      ranks_.OnFirst([&] {
        kept = store_->Resume(Part::kFactor, lu->done());
        RequireKept();
      });
      if (lu->AdoptNext(kept.value_or(std::vector<double>()))) {
        ++adopted;
        continue;
      }
    }
    if (!lu->FactorizeNext()) ranks_.Together(RefuseSingular);
    const auto block = lu->LastBlock();
    Keep(Part::kFactor, lu->done() - 1, block);
  }
  return adopted;
}

// Returns how many blocks of columns were not there.
int Computation::Solve(const DistributedLu& lu) {
  const int n = system_.order(), triangles = system_.triangles();
  const int share = (triangles + ranks_.size() - 1) / ranks_.size();
  const int first = std::min(share * ranks_.rank(), triangles);
  const int last = std::min(first + share, triangles);
  int computed = 0;
  for (int begin = 0; begin < triangles; begin += kTriangles) {
    ReportTogether(ranks_, progress_, "Green's functions", double{1} * begin / triangles);
    const int end = std::min(begin + kTriangles, triangles), columns = 3 * (end - begin);
    int is_kept = 0;
    ranks_.OnFirst([&] {
      const auto kept = store_->Resume(Part::kColumns, begin);
      is_kept = kept && kept->size() == Index(columns) * Index(n) ? 1 : 0;
    });
    ranks_.Broadcast(&is_kept);
    if (is_kept != 0) continue;
    DistributedMatrix rows(rows_, 3 * triangles, columns, 3 * share, columns);
    ranks_.Together([&] {
      if (first < last) rows.share() = system_.LoadRows(begin, end, first, last);
    });
    DistributedMatrix B(square_, n, columns, DistributedLu::kBlock, DistributedLu::kBlock);
    Copy(3 * triangles, columns, rows, {0, 0}, &B, {0, 0}, square_);
    lu.SolveInPlace(&B);
    DistributedMatrix whole(alone_, n, columns, n, columns);
    Copy(n, columns, B, {0, 0}, &whole, {0, 0}, square_);
    Keep(Part::kColumns, begin, {whole.data(), static_cast<std::size_t>(whole.share().size())});
    ++computed;
  }
  ReportTogether(ranks_, progress_, "Green's functions", 1);
  return computed;
}

void Computation::Keep(Part part, int index, std::span<const double> values) {
  ranks_.OnFirst([&] {
    store_->Keep(part, index, values);
    RequireKept();
  });
}

// Of the kept columns first the blocks, then the reactions.
void Computation::Write(double condition) {
  const int triangles = system_.triangles();
  std::vector<double> blocks, reactions;
  const auto pieces = [&](std::size_t count, const std::vector<double>* piece) {
    return GreensStore::Pieces{
        count, [&, piece, begin = 0]() mutable -> std::span<const double> {
          const int end = std::min(begin + kTriangles, triangles);
          const auto loaded = Index(end - begin);
          const auto kept = store_->Again(Part::kColumns, begin);
          if (!kept || kept->size() != 3 * loaded * Index(system_.order())) return {};
          blocks.resize(layout_.blocks(loaded));
          reactions.resize(layout_.reactions(loaded));
          layout_.Split(Eigen::Map<const Eigen::MatrixXd>(kept->data(), system_.order(),
                                                          3 * Eigen::Index{end - begin}),
                        blocks.data(), reactions.data());
          begin = end;
          return *piece;
        }};
  };
  store_->Finish(pieces(layout_.blocks(layout_.places()), &blocks),
                 pieces(layout_.reactions(layout_.places()), &reactions), condition);
  RequireKept();
}

}  // namespace

PrecomputeReport PrecomputeBem3d(const Scene& scene, const Ranks& ranks, Progress* progress) {
  std::optional<ReferenceSystem> system;
  ranks.Together([&] { system.emplace(SystemOf(scene)); });
  const GreensLayout layout(*system);
  auto inputs = GreensLayout::Inputs(*system);
  ranks.RequireSame(Hash().Add(std::as_bytes(std::span(inputs))).value(), "a scene and a mesh");
  std::optional<GreensStore> store;
  int is_finished = 0;
  ranks.OnFirst([&] {
    store.emplace(scene.model.cache, std::move(inputs));
    const std::size_t places = layout.places();
    is_finished = store->Has(layout.blocks(places), layout.reactions(places)) ? 1 : 0;
  });
  ranks.Broadcast(&is_finished);
  if (is_finished != 0) {
    return Formatted("bem3d: %d unknowns, all in the cache", system->order());
  }
  return Computation(*system, layout, ranks, store ? &*store : nullptr, progress).Run();
}

}  // namespace palpate
