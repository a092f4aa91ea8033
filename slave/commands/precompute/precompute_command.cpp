#include "slave/commands/precompute/precompute_command.h"

#include <cstdio>
#include <optional>
#include <stdexcept>
#include <variant>

#include "slave/commands/progress_bar.h"
#include "slave/commands/study/shards.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/green_columns.h"
#include "slave/mechanics/fem/zone/fem_zone_model.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

CacheFilling Fill(const Scene& scene, const SolidMesh& mesh, const CacheShare& share,
                  Progress* progress) {
  const Material& material = scene.object.material;
  if (scene.model.kind == "fem-green") {
    ReportProgress(progress, "assembling stiffness", 0);
    return FillColumnCache(AssembleAtRest(mesh, HeldTetNodes(scene, mesh), material.poisson_ratio,
                                          scene.model.fem.element),
                           scene.model.cache, share, progress);
  }
  const std::optional<double> width = ContactWidth(scene);
  if (!width) {
    throw std::invalid_argument("no width of a contact: expected tool.width, or fingertips");
  }
  return MakeZoneModel(scene, mesh, progress)->FillCache(*width, share, progress);
}

}  // namespace

int RunPrecompute(const PrecomputeOptions& options, const std::stop_token& stop) {
  const study::Shard shard = ParseShard(options.shard);
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  const ModelOptions& model = scene.model;
  if (model.kind != "fem-green" && model.kind != "fem-zone") {
    throw std::invalid_argument("model.kind = " + model.kind + ": expected fem-green or fem-zone");
  }
  if (model.cache.empty()) throw std::invalid_argument("model.cache: expected a folder");
  const ObjectMesh object = MeshObject(scene, std::nullopt);
  const auto* mesh = std::get_if<SolidMesh>(&object);
  if (mesh == nullptr) {
    throw std::invalid_argument("object.geometry: expected an object with a volume");
  }
  CacheFilling filling;
  {
    ProgressBar bar("precompute", stop);
    filling = Fill(scene, *mesh, {shard.index - 1, shard.count}, &bar);
  }
  std::printf("%s, shard %zu/%zu: %zu of %zu groups of columns computed\ncache: %s\n",
              model.kind.c_str(), shard.index, shard.count, filling.computed, filling.groups,
              model.cache.c_str());
  return 0;
}

}  // namespace palpate
