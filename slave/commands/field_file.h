// Displacement and stress of solved cases as a VTU file (VTK's XML unstructured grid, ASCII), for
// ParaView.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/mechanics/bem/interior_field.h"

namespace palpate {

// Points: the boundary elements' midpoints, joined by lines along each loop, then a grid inside the
// body that keeps an element's length from the boundary. Every case adds two arrays:
// displacement [m] and stress xx, yy, xy [Pa], named after the case if there are several.
class FieldFile {
 public:
  FieldFile(const std::filesystem::path& file, const Bem2dModel& model);

  // The state of the model's last Respond.
  void AddCase(const std::string& name);
  // False: the file cannot be written.
  [[nodiscard]] bool Write() const;

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
