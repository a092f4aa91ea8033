// Displacement and stress of solved cases on and inside a planar body.
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "slave/commands/solve/field_file.h"
#include "slave/mechanics/bem/interior_field.h"

namespace palpate {

// Points: the boundary elements' midpoints, joined by lines along each loop, then a grid inside the
// body that keeps an element's length from the boundary. Every case adds two arrays:
// displacement [m] and stress xx, yy, xy [Pa], named after the case if there are several.
class PlanarFieldFile final : public FieldFile {
 public:
  PlanarFieldFile(const std::filesystem::path& file, const Bem2dModel& model);
  void AddCase(const std::string& name) override;
  [[nodiscard]] bool Write() const override;

 private:
  struct Case {
    std::string name;
    std::vector<PointState> points;
  };

  void WriteArray(std::ostream* stream, const Case& solved) const;

  std::filesystem::path file_;
  const Bem2dModel& model_;
  std::vector<Eigen::Vector2d> inside_O_;  // [m]
  std::vector<Case> cases_;
};

}  // namespace palpate
