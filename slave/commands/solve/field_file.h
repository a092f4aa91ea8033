// The fields of solved cases as a VTU file (VTK's XML unstructured grid), for ParaView.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "shared/mesh/files/vtu_writer.h"
#include "slave/mechanics/deformation_model.h"

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

// Points and cells of the model's field_mesh(), vertices of no element left out. Every case adds
// the array displacement [m], named after it if there are several.
class NodalFieldFile final : public FieldFile {
 public:
  // Keeps a reference to the model.
  NodalFieldFile(std::filesystem::path file, DeformationModel& model);
  void AddCase(const std::string& name) override;
  [[nodiscard]] bool Write() const override;

 private:
  std::filesystem::path file_;
  DeformationModel& model_;
  VtuGrid grid_;
  std::vector<std::size_t> vertices_;                               // per point, in field_mesh()
  std::vector<std::pair<std::string, std::vector<double>>> cases_;  // points x 3 [m]
};

}  // namespace palpate
