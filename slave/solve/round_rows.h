// The round tools that press rows of a contacts file with a `radius`.
#pragma once

#include <optional>

#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"
#include "slave/solve/solve_rows.h"

namespace palpate {

// The tool of the last row is cached, because successive rows usually have the same one.
class RoundRows {
 public:
  // Both must outlive this.
  RoundRows(const Scene& scene, const ObjectMesh& mesh) : scene_(scene), mesh_(mesh) {}

  // `row` is pressed round. Throws std::invalid_argument: see ToolPress.
  ContactResponse Press(const SolveRow& row, DeformationModel* model, Solution* solution) {
    const bool same = radius_ == row.tool.radius && depth_ == row.tool.depth;
    if (!press_ || !same) press_.emplace(scene_, row.tool, mesh_);
    radius_ = row.tool.radius;
    depth_ = row.tool.depth;
    return press_->Press(row.contact, model, solution);
  }

 private:
  const Scene& scene_;
  const ObjectMesh& mesh_;
  double radius_ = 0;            // of press_ [m]
  std::optional<double> depth_;  // depth of the last row's tool
  std::optional<ToolPress> press_;
};

}  // namespace palpate
