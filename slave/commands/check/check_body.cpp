#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>

#include <spdlog/fmt/fmt.h>

#include "shared/mesh/files/mesh_file.h"
#include "shared/mesh/mesh_check.h"
#include "slave/commands/check/check.h"
#include "slave/commands/progress_bar.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/study/press_spec.h"

namespace palpate {
namespace {

constexpr int kMostTetsToCompare = 3000;  // ten-node ones take about a second

void PrintMeshFile(const MeshFileGeometry& geometry) {
  MeshFile file = ReadMeshFile(geometry.file, geometry.unit);
  const MeshReport report = std::visit(
      [&](auto& mesh) { return CheckMesh(mesh, file.numbers, geometry.unit != 1); }, file.mesh);
  for (const auto& remark : file.remarks) PrintLine("file", remark);
  for (const auto& line : Lines(report)) PrintLine("mesh", line);
  if (file.material) {
    PrintLine("file", fmt::format("its material (E = {:.4g} Pa, nu = {:g}, {:g} kg/m^3) is not "
                                  "used; the scene's material is",
                                  file.material->young_modulus, file.material->poisson_ratio,
                                  file.material->density));
  }
}

struct Probe {
  double force = 0;  // along the press, linear in its depth where the model is [N]
  double update_us = 0;
  Validity validity = Validity::kFailed;
  std::string failure;  // or why it is extrapolated
  Solution solution;
};

Probe Query(const study::PressSpec& question, DeformationModel& model) {
  constexpr int kRepeats = 20;
  const study::Press& press = question.presses.front();
  Contact contact{Contact::Kind::kDisplacement, press.p_O, -1, question.width,
                  question.depth * press.inward_O};
  ContactResponse response;
  model.Reset();
  model.Respond(std::span(&contact, 1), std::span(&response, 1));
  Probe probe{response.force_O.dot(press.inward_O),
              0,
              response.validity,
              std::string(response.doubt.empty() ? model.failure() : response.doubt),
              {}};
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kRepeats; ++i) {
    contact.prescribed_O = question.depth * (1 - 1e-3 * (i % 2)) * press.inward_O;
    model.Respond(std::span(&contact, 1), std::span(&response, 1));
  }
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - began;
  probe.update_us = spent.count() / kRepeats;
  model.Solve({&contact, 1}, &probe.solution);
  return probe;
}

std::optional<double> ForceOf(const Scene& scene, const ObjectMesh& mesh,
                              const study::PressSpec& gentle) {
  const Probe probe = Query(gentle, *MakeModel(scene, mesh));
  if (probe.validity == Validity::kFailed || !(std::abs(probe.force) > 0)) return std::nullopt;
  return probe.force;
}

// How far a press is off because of the model's elements: four-node against ten-node tetrahedra,
// both linear, at a small depth; of a plate because it does not stretch. nullopt: too large to
// compare here, or nothing better is known.
std::optional<double> ExpectedError(const Scene& scene, const ObjectMesh& mesh,
                                    const study::PressSpec& question, double force) {
  Scene better = scene;
  if (std::holds_alternative<MembraneDisc>(mesh)) {
    if (KindOf(scene).linearity == Linearity::kNever) return std::nullopt;
    better.model.kind = "plate-large";
    const auto stretched = ForceOf(better, mesh, question);
    return stretched ? std::optional(std::abs(force / *stretched - 1)) : std::nullopt;
  }
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  const bool is_fine = scene.model.fem.element == FemOptions::Element::kTet10;
  if (solid == nullptr || solid->tets.size() > kMostTetsToCompare || is_fine) return std::nullopt;
  study::PressSpec gentle = question;
  gentle.depth = question.small_depth;
  better.model.kind = "fem";
  better.model.fem = FemOptions();
  better.model.fem.law = FemOptions::Law::kLinear;
  Scene plain = scene;
  if (KindOf(scene).linearity != Linearity::kAlways) plain.model = better.model;
  better.model.fem.element = FemOptions::Element::kTet10;
  const auto by_plain = ForceOf(plain, mesh, gentle);
  const auto by_better = ForceOf(better, mesh, gentle);
  if (!by_plain || !by_better) return std::nullopt;
  return std::abs(*by_plain / *by_better - 1);
}

// What would be pressed; nullopt, and a line that says why: nothing.
std::optional<study::PressSpec> QuestionOf(const Scene& scene) {
  if (!IsHeld(scene.object)) {
    PrintLine(
        "contact",
        "not computed: the object has no fixed boundary, so only balanced loads are accepted");
    return std::nullopt;
  }
  try {
    return study::AskedOf(scene);
  } catch (const std::invalid_argument& reason) {
    PrintLine("contact", std::string("not computed: ") + reason.what());
    return std::nullopt;
  }
}

// Returns its solution, if there is one.
Solution PrintPress(const Scene& scene, const ObjectMesh& mesh, DeformationModel& model) {
  const std::optional<study::PressSpec> asked = QuestionOf(scene);
  if (!asked) return {};
  const study::PressSpec& question = *asked;
  const study::Press& press = question.presses.front();
  const Probe probe = Query(question, model);
  if (probe.validity == Validity::kFailed) {
    PrintLine("contact", "no solution: " + probe.failure);
    return probe.solution;
  }
  PrintLine("contact", fmt::format("{:.4g} N for an indentation of {} at ({}, {}, {}), {} wide",
                                   probe.force, LengthInWords(question.depth),
                                   LengthInWords(press.p_O.x()), LengthInWords(press.p_O.y()),
                                   LengthInWords(press.p_O.z()), LengthInWords(question.width)));
  if (probe.validity != Validity::kValid) {
    PrintLine("contact", "extrapolated: " +
                             (probe.failure.empty() ? std::string(kBeyondRange) : probe.failure));
  }
  PrintLine("update",
            fmt::format("{:.3g} us: {} the requested {:g} Hz", probe.update_us,
                        probe.update_us * 1e-6 * scene.model.rate < 1 ? "meets" : "MISSES",
                        scene.model.rate));
  const auto error = ExpectedError(scene, mesh, question, probe.force);
  if (!error) {
    PrintLine("error", "not estimated; `study` measures it");
    return probe.solution;
  }
  PrintLine(
      "error",
      fmt::format(
          "about {:.2g} % of the force, compared with {}: {} the requested {:g} %", 100 * *error,
          std::holds_alternative<MembraneDisc>(mesh) ? "a plate that stretches"
                                                     : "quadratic elements on the same mesh",
          *error <= scene.model.tolerance ? "meets" : "MISSES", 100 * scene.model.tolerance));
  return probe.solution;
}

}  // namespace

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
  PrintLine(
      "precompute",
      fmt::format("{:.3g} ms, {:.3g} MB of memory, {} degrees of freedom{}",
                  1e3 * info.precompute_s, static_cast<double>(info.memory_bytes) * 1e-6, info.dof,
                  info.condition > 0 ? fmt::format(", condition number {:.3g}", info.condition)
                                     : std::string()));
  if (!info.remark.empty()) PrintLine("remark", info.remark);
  if (MovesInTime(scene)) {
    PrintLine("time", fmt::format("time steps of {:g} s", info.step));
  } else {
    PrintShapeCost(*model, PrintPress(scene, mesh, *model));
  }
}

void CheckBody(const Scene& scene) {
  PrintBody(scene);
  PrintLine("off", "sensing: the scene has no camera and no fingertips; use `solve` and `study`");
}

}  // namespace palpate
