#include "slave/commands/precompute/precompute_command.h"

#include <cstdio>
#include <stdexcept>
#include <variant>

#include "slave/commands/progress_bar.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/green_columns.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

CacheFilling Fill(const Scene& scene, const SolidMesh& mesh, Progress* progress) {
  ReportProgress(progress, "assembling stiffness", 0);
  return FillColumnCache(
      AssembleAtRest(mesh, HeldTetNodes(scene, mesh), scene.object.material.poisson_ratio,
                     scene.model.fem.element),
      ContactWidth(scene), scene.model.cache, progress);
}

}  // namespace

int RunPrecompute(const PrecomputeOptions& options, const std::stop_token& stop) {
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
    filling = Fill(scene, *mesh, &bar);
  }
  std::printf("%s: %zu of %zu groups computed\ncache: %s\n", model.kind.c_str(), filling.computed,
              filling.groups, model.cache.c_str());
  return 0;
}

}  // namespace palpate
