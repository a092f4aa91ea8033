#include "slave/commands/precompute/precompute_command.h"

#include <cstdio>
#include <stdexcept>
#include <variant>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/green_columns.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

// Parses `3/8`, the third of eight parts. Throws std::invalid_argument.
CacheShare ParseShare(const std::string& text) {
  std::size_t index = 0, count = 0;
  const int read = std::sscanf(text.c_str(), "%zu/%zu", &index, &count);
  if (read != 2 || index < 1 || index > count || text != Formatted("%zu/%zu", index, count)) {
    throw std::invalid_argument("--shard " + text +
                                ": expected i/n with 1 <= i <= n, for example 3/8");
  }
  return {index - 1, count};
}

CacheFilling Fill(const Scene& scene, const SolidMesh& mesh, const CacheShare& share,
                  Progress* progress) {
  ReportProgress(progress, "assembling stiffness", 0);
  return FillColumnCache(
      AssembleAtRest(mesh, HeldTetNodes(scene, mesh), scene.object.material.poisson_ratio,
                     scene.model.fem.element),
      ContactWidth(scene), scene.model.cache, share, progress);
}

}  // namespace

int RunPrecompute(const PrecomputeOptions& options, const std::stop_token& stop) {
  const CacheShare share = ParseShare(options.shard);
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  const ModelOptions& model = scene.model;
  if (model.kind != "fem-green") {
    throw std::invalid_argument("model.kind = " + model.kind + ": expected fem-green");
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
    filling = Fill(scene, *mesh, share, &bar);
  }
  std::printf("%s, shard %s: %zu of %zu groups computed\ncache: %s\n", model.kind.c_str(),
              options.shard.c_str(), filling.computed, filling.groups, model.cache.c_str());
  return 0;
}

}  // namespace palpate
