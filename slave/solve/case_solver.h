// Solves contacts and loads that act together on an object at rest, and sets their validity.
// `solve` and Python call it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/pipeline/camera/tool_width.h"
#include "slave/scene/scene.h"
#include "slave/solve/round_rows.h"
#include "slave/solve/solve_rows.h"

namespace palpate {

using Case = std::vector<std::size_t>;  // rows that act together

// State of the object before a case.
enum class CaseStart : std::uint8_t {
  kRest,
  kLastCase,  // where the last case left it, so that friction follows the path of the cases
};

// Solves `contacts`, which act together, and measures the time. Returns false if there is no
// answer.
bool SolveTogether(std::span<const Contact> contacts, DeformationModel* model, Solution* solution,
                   double* solve_us);

class CaseSolver {
 public:
  // Stores references to its arguments.
  CaseSolver(const Scene& scene, const ObjectMesh& mesh, DeformationModel* model)
      : scene_(scene), mesh_(mesh), model_(model), round_(scene, mesh) {}

  // Solves the rows of one case. A contact continues one of the last case if it IsAt the same
  // place. After a failed case the state is unknown, so that later cases fail until one starts from
  // rest. False: there is no solution, which the rows state. Throws std::invalid_argument for a
  // single contact on an object without supports and gravity.
  bool Solve(const Case& one, CaseStart start, std::vector<SolveRow>* rows, Solution* solution);
  // Why the last case has no solution, one clause with static lifetime; may be empty.
  [[nodiscard]] std::string_view failure() const { return failure_; }

 private:
  bool SolveRows(const Case& one, std::vector<SolveRow>* rows, Solution* solution);
  // Range in which the force of a tool is known. The last one is cached, because successive rows
  // usually have the same tool.
  struct Domain {
    Tool tool;
    ToolDomain where;
    std::optional<ToolWidth> width;  // of an outline
  };
  void TakeTool(const Tool& tool);
  // Corrects the answer for the tool and sets its validity. It queries the model for two more
  // contacts in the plane.
  void FitTool(bool acts_alone, SolveRow* row);
  // What whole elements under a flat tool in the plane change.
  [[nodiscard]] ToolWidth::Share WidthShareOf(const SolveRow& row);

  const Scene& scene_;
  const ObjectMesh& mesh_;
  DeformationModel* model_;
  RoundRows round_;
  std::optional<Domain> domain_;
  std::vector<Contact> contacts_;  // memory for Solve
  bool has_state_ = true;          // the last case was solved
  std::string_view failure_;
};

}  // namespace palpate
