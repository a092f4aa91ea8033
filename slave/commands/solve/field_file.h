// The displacement of solved cases as a VTU file (VTK's XML unstructured grid), for ParaView.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "shared/mesh/vtu_writer.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

// Writes points and cells of the model's field_mesh(), without vertices that belong to no element.
// Every case adds the array displacement [m].
class FieldFile {
 public:
  // Stores a reference to the model.
  FieldFile(std::filesystem::path file, DeformationModel& model);

  // A solution of the model.
  void AddCase(const std::string& name, const Solution& solution);
  // Writes the array of every case, named after the case if there are several. False: the file
  // cannot be written.
  [[nodiscard]] bool Write() const;

 private:
  std::filesystem::path file_;
  DeformationModel& model_;
  std::vector<std::size_t> vertices_;                      // per point, in field_mesh()
  VtuGrid grid_;                                           // without arrays
  std::vector<std::pair<std::string, PointArray>> cases_;  // by name
};

}  // namespace palpate
