// Displacement of solved cases at the nodes of a volume or a membrane.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "shared/mesh/files/vtu_writer.h"
#include "slave/commands/solve/field_file.h"

namespace palpate {

// Points and cells as the model gives its displacements: tetrahedra, or the triangles of a surface
// or a membrane. Every case adds the array displacement [m], named after it if there are several.
class NodalFieldFile final : public FieldFile {
 public:
  NodalFieldFile(std::filesystem::path file, DeformationModel& model, VtuGrid grid);
  void AddCase(const std::string& name) override;
  [[nodiscard]] bool Write() const override;

 private:
  std::filesystem::path file_;
  DeformationModel& model_;
  VtuGrid grid_;
  std::vector<std::pair<std::string, std::vector<Eigen::Vector3d>>> cases_;
};

}  // namespace palpate
