#include "slave/commands/scene_summary.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/scene/scene_text.h"
#include "slave/solve/case_solver.h"
#include "slave/study/own_model.h"

namespace palpate {
namespace {

std::string Sizes(const Scene& scene) {
  return fmt::format("{}, about as stiff as {}", InWords(scene.object.geometry),
                     StiffAs(scene.object.material.young_modulus));
}

}  // namespace

ContactResponse PressOnce(const Scene& scene, const study::PressSpec& spec, double depth,
                          DeformationModel* model) {
  const study::Press& press = spec.presses.front();
  SolveRow row;
  row.tool = scene.tool.value_or(Tool{.width = spec.width});
  row.contact = {.p_O = press.p_O,
                 .width = spec.width,
                 .prescribed_O = depth * press.inward_O,
                 .is_rigid = row.tool.IsRigidFace()};
  std::vector<SolveRow> rows{std::move(row)};
  Solution solution;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  CaseSolver(scene, mesh, model).Solve({0}, CaseStart::kRest, &rows, &solution);
  model->Reset();
  return rows.front().response;
}

std::string SceneSummary(const Scene& scene, const study::PressSpec& spec,
                         DeformationModel* model) {
  constexpr double kMillimetre = 1e-3;
  const double depth = std::min(kMillimetre, spec.depth);
  const Eigen::Vector3d force_O = PressOnce(scene, spec, depth, model).force_O;
  return fmt::format("{}; {} deep the tool presses with {}", Sizes(scene), LengthInWords(depth),
                     ForceText(spec.presses.front().inward_O.dot(force_O)));
}

std::string SceneSummary(const Scene& scene) {
  if (!study::CanStudy(scene)) return Sizes(scene);
  const ModelKind& kind = KindOf(scene);
  const bool is_quick = kind.object == ObjectClass::kOutline ? kind.is_plane : !kind.has_tets;
  if (!is_quick) return Sizes(scene);
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  return SceneSummary(scene, study::AskedOf(scene), model.get());
}

}  // namespace palpate
