// fem-green: each rank assembles its tetrahedra, all factorise together, the first one keeps the
// columns.
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "shared/geometry/index.h"
#include "shared/text/text.h"
#include "slave/commands/program.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/green_groups.h"
#include "slave/precompute/distributed_factor.h"
#include "slave/precompute/precompute.h"

namespace palpate {
namespace {

// Groups that the cache lacks, or that are damaged there.
std::vector<int> MissingGroups(const GreenGroups& layout, const ColumnCache& cache) {
  std::vector<int> missing;
  std::vector<double> values;
  for (int g = 0; g < layout.groups(); ++g) {
    values.resize(layout.values(g));
    if (!cache.Has(g) || !cache.Load(g, values)) missing.push_back(g);
  }
  return missing;
}

TetRange ShareOf(std::size_t tets, const Ranks& ranks) {
  const auto rank = Index(ranks.rank()), size = Index(ranks.size());
  return {tets * rank / size, tets * (rank + 1) / size};
}

struct Share {
  TetStiffness stiffness;
  SurfaceMesh surface;
  std::vector<int> order;  // of elimination
};

// The mesh is not needed after it.
Share Assemble(const Scene& scene, const Ranks& ranks) {
  const ObjectMesh object = MeshObject(scene, std::nullopt);
  const auto* mesh = std::get_if<SolidMesh>(&object);
  if (mesh == nullptr) {
    throw std::invalid_argument("model.kind = fem-green: accepted is an object with a volume");
  }
  const HeldNodes held = HeldTetNodes(scene, *mesh);
  const TetElement element = GreenElement(scene);
  return {AssembleTetStiffness(*mesh, held, scene.object.material.poisson_ratio, element,
                               ShareOf(mesh->tets.size(), ranks)),
          SurfaceOf(*mesh), DissectedRows(*mesh, held, element)};
}

}  // namespace

PrecomputeReport PrecomputeFemGreen(const Scene& scene, const Ranks& ranks, Progress* progress) {
  Share share;
  ReportTogether(ranks, progress, "assembling stiffness", 0);
  ranks.Together([&] { share = Assemble(scene, ranks); });
  TetStiffness& stiffness = share.stiffness;
  const auto order = stiffness.lower.rows();
  const GreenGroups layout(std::move(stiffness.row), stiffness.inputs, share.surface);
  ranks.RequireSame(layout.hash(), "a scene and a mesh");
  ColumnCache cache;
  std::vector<int> missing;
  ranks.OnFirst([&] {
    cache = layout.Cache(scene.model.cache);
    missing = MissingGroups(layout, cache);
  });
  int count = static_cast<int>(missing.size());
  ranks.Broadcast(&count);
  const PrecomputeReport report =
      Formatted("fem-green: %d unknowns, %d places, %d of %d groups computed",
                static_cast<int>(order), layout.places(), count, layout.groups());
  if (count == 0) return report;

  ReportTogether(ranks, progress, "factorising stiffness", 0);
  std::optional<DistributedFactor> factor;  // whose errors all ranks have
  ranks.Together([&] { factor.emplace(ranks, std::move(stiffness.lower), share.order); });
  Eigen::MatrixXd columns;
  std::vector<double> values;
  if (ranks.first()) columns.resize(order, GreenGroups::kColumns);
  for (int k = 0; k < count; ++k) {
    ReportTogether(ranks, progress, "Green's functions", double{1} * k / count);
    if (ranks.first()) layout.SetLoads(missing[Index(k)], columns);
    ranks.Together([&] { factor->Solve(columns.data(), GreenGroups::kColumns); });
    ranks.OnFirst([&] {
      const int group = missing[Index(k)];
      values.resize(layout.values(group));
      layout.TakeSurface(group, columns, values);
      cache.Save(group, values);
      if (!cache.Has(group)) {
        throw std::runtime_error("cannot write to the cache " + scene.model.cache.string());
      }
    });
  }
  ReportTogether(ranks, progress, "Green's functions", 1);
  return report;
}

}  // namespace palpate
