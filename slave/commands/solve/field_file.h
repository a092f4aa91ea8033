// The fields of solved cases as a VTU file (VTK's XML unstructured grid), for ParaView.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "shared/mesh/vtu_writer.h"
#include "slave/mechanics/bem/interior_field.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

class FieldFile {
 public:
  virtual ~FieldFile() = default;
  FieldFile(const FieldFile&) = delete;
  FieldFile& operator=(const FieldFile&) = delete;

  // A solution of the model.
  virtual void AddCase(const std::string& name, const Solution& solution) = 0;
  // Every case's arrays, named after it if there are several. False: the file cannot be written.
  [[nodiscard]] bool Write() const;

 protected:
  FieldFile(std::filesystem::path file, VtuForm form) : file_(std::move(file)), form_(form) {}

  VtuGrid grid_;                                                        // without arrays
  std::vector<std::pair<std::string, std::vector<PointArray>>> cases_;  // by name

 private:
  std::filesystem::path file_;
  VtuForm form_;
};

// Points and cells of the model's field_mesh(), vertices of no element left out. Every case adds
// the array displacement [m].
class NodalFieldFile final : public FieldFile {
 public:
  // Keeps a reference to the model.
  NodalFieldFile(std::filesystem::path file, DeformationModel& model);
  void AddCase(const std::string& name, const Solution& solution) override;

 private:
  DeformationModel& model_;
  std::vector<std::size_t> vertices_;  // per point, in field_mesh()
};

// Displacement and stress on and inside a planar body. Points: the midpoints of the boundary
// elements, joined by lines along each loop, then a grid inside the body at least an element's
// length from the boundary. Every case adds two arrays: displacement [m] and stress xx, yy, xy
// [Pa].
class PlanarFieldFile final : public FieldFile {
 public:
  // Keeps a reference to the model.
  PlanarFieldFile(const std::filesystem::path& file, Bem2dModel& model);
  void AddCase(const std::string& name, const Solution& solution) override;

 private:
  Bem2dModel& model_;
  std::vector<Eigen::Vector2d> inside_O_;  // [m]
};

}  // namespace palpate
