// The fields of solved cases as a VTU file (VTK's XML unstructured grid), for ParaView.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {

class FieldFile {
 public:
  virtual ~FieldFile() = default;
  FieldFile() = default;
  FieldFile(const FieldFile&) = delete;
  FieldFile& operator=(const FieldFile&) = delete;

  // The state of the model's last Respond.
  virtual void AddCase(const std::string& name) = 0;
  // False: the file cannot be written.
  [[nodiscard]] virtual bool Write() const = 0;
};

// The file that fits the model. It keeps references to all its arguments.
std::unique_ptr<FieldFile> MakeFieldFile(const std::filesystem::path& file, DeformationModel& model,
                                         const ObjectMesh& mesh);

}  // namespace palpate
