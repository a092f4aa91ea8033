#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

#include <spdlog/fmt/fmt.h>

#include "slave/commands/check/check.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_summary.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/mesh_check.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/own_model.h"

namespace palpate {
namespace {

// Prints the mesh file without remarks and warnings, which are logged when the scene is loaded.
void PrintMeshFile(const MeshFileGeometry& geometry) {
  MeshFile file = ReadMeshFile(geometry.file, geometry.unit);
  MeshReport report = std::visit(
      [&](auto& mesh) { return CheckMesh(mesh, file.numbers, geometry.unit != 1); }, file.mesh);
  report.warnings.clear();
  for (const auto& line : Lines(report)) PrintLine("mesh", line);
}

// Prints error and rate. `stated`: error of the force by the model, relative [-].
void PrintVerdicts(const Scene& scene, const study::StudyRow& row, double stated) {
  using study::OnRate, study::OnTolerance;
  PrintLine("update",
            fmt::format("{:.3g} us, of a hundred the slowest: {} the requested {:g} Hz",
                        1e6 * row.update_p99_s,
                        ToString(OnRate(row.update_p99_s, scene.model.rate)), scene.model.rate));
  const bool is_compared = std::isfinite(row.error.value);
  if (!is_compared && !(stated > 0)) {
    return PrintLine("error", "not known from this model alone; `study` compares several");
  }
  // A mesh can agree with the reference by chance.
  const bool is_stated = !is_compared || stated > row.error.value;
  const double error = is_stated ? stated : row.error.value;
  const double bound = is_compared ? std::max(stated, row.bound) : stated;
  const std::string of_plane =
      row.plane_error > 0 && !IsSolidOutline(row.kind)
          ? fmt::format(", of which {:.2g} % by the plane model of a solid", 100 * row.plane_error)
          : "";
  PrintLine("error",
            fmt::format("about {:.2g} % of the contact force, as {} it at this contact{}: "
                        "{} the requested {:g} %",
                        100 * error, is_stated ? "the model states" : "`study` finds", of_plane,
                        ToString(OnTolerance(error, bound, scene.model.tolerance)),
                        100 * scene.model.tolerance));
}

}  // namespace

Solution PrintPress(const Scene& scene, DeformationModel& model, Progress* progress) {
  Solution solution;
  try {
    ProgressBar bar("check");
    const auto [question, row] =
        study::StudyOwn(scene, study::DefaultModelFactory(), progress != nullptr ? progress : &bar);
    bar.Clear();
    const study::Press& press = question.presses.front();
    const Contact contact{Contact::Kind::kDisplacement, press.p_O, -1, question.width,
                          question.depth * press.inward_O};
    model.Solve({&contact, 1}, &solution);
    if (row.outcome != study::Outcome::kAnswered) {
      PrintLine("contact", "no solution: " + row.reason);
      return solution;
    }
    const std::string tool = IsTouchedRound(scene)
                                 ? "by a round tool of radius " + LengthInWords(scene.tool->radius)
                                 : LengthInWords(question.width) + " wide";
    const ContactResponse response = PressOnce(scene, question, question.depth, &model);
    const double force = press.inward_O.dot(response.force_O);
    PrintLine("contact",
              fmt::format("{:.4g} N for an indentation of {} at ({}, {}, {}), {}", force,
                          LengthInWords(question.depth), LengthInWords(press.p_O.x()),
                          LengthInWords(press.p_O.y()), LengthInWords(press.p_O.z()), tool));
    PrintLine("in words", SceneSummary(scene, question, &model));
    if (ReportCollector* report = ReportCollector::present()) {
      report->contact = {question.depth, force, row.update_p99_s};
    }
    if (!question.seen.empty()) {
      PrintLine("estimate", fmt::format("{:.4g} N from the points that the cameras see of a solid "
                                        "under this press",
                                        row.answers.front().full.value));
    }
    if (row.validity != Validity::kValid) {
      PrintLine(question.seen.empty() ? "contact" : "estimate",
                "extrapolated: " + (row.reason.empty() ? std::string(kBeyondRange) : row.reason));
    }
    // Points that cameras see have another estimate than the model.
    const bool is_stated = question.seen.empty() && response.force_error > 0;
    PrintVerdicts(scene, row, is_stated ? response.force_error / response.force_O.norm() : 0);
  } catch (const std::invalid_argument& reason) {
    PrintLine("contact", std::string("not computed: ") + reason.what());
  }
  return solution;
}

void PrintPrecompute(const ModelInfo& info) {
  PrintLine(
      "precompute",
      fmt::format("{:.3g} ms, {:.3g} MB of memory, {} degrees of freedom{}",
                  1e3 * info.precompute_s, static_cast<double>(info.memory_bytes) * 1e-6, info.dof,
                  info.condition > 0 ? fmt::format(", condition number {:.3g}", info.condition)
                                     : std::string()));
}

void PrintShapeCost(DeformationModel& model, const Solution& solution) {
  constexpr int kRepeats = 5;
  std::vector<Eigen::Vector3d> u_O;
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kRepeats; ++i) model.Displacements(solution, &u_O);
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - began;
  if (u_O.empty()) return;
  PrintLine("on demand",
            fmt::format("the deformed shape (WatchMesh): {:.3g} us and {:.3g} kB per state",
                        spent.count() / kRepeats, 12e-3 * static_cast<double>(u_O.size())));
}

void PrintBody(const Scene& scene) {
  PrintObject(scene);
  if (const auto* file = std::get_if<MeshFileGeometry>(&scene.object.geometry)) {
    PrintMeshFile(*file);
  }
  PrintChoice(scene);
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  if (const auto* solid = std::get_if<SolidMesh>(&mesh)) {
    PrintLine("mesh",
              fmt::format("{} nodes, {} tetrahedra", solid->nodes.size(), solid->tets.size()));
  }
  ProgressBar progress("check");
  const auto model = MakeModel(scene, mesh, &progress);
  progress.Clear();
  const ModelInfo& info = model->info();
  if (!info.remark.empty()) PrintLine("remark", info.remark);
  if (MovesInTime(scene)) {
    PrintPrecompute(info);
    PrintLine("time", fmt::format("time steps of {:g} s", info.step));
  } else {
    const Solution solution = PrintPress(scene, *model);
    PrintPrecompute(info);
    PrintShapeCost(*model, solution);
  }
}

void CheckBody(const Scene& scene) {
  PrintBody(scene);
  PrintLine("off", "sensing: the scene has no camera and no fingertips; use `solve` and `study`");
}

}  // namespace palpate
