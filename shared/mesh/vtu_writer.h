// VTK's XML unstructured grids, .vtu, as ParaView reads them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Numbers at the points: displacement [m], stress [Pa]. Not finite ones are written as NaN, which
// ParaView shows as holes.
struct PointArray {
  std::string name;
  int components = 3;
  std::vector<double> values;  // points x components, row after row
};
// Any mixture of cells; point numbers from 0.
struct VtuGrid {
  std::vector<Eigen::Vector3d> points;  // p_O [m]
  std::vector<std::array<int, 4>> tets;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> lines;
  std::vector<PointArray> arrays;
};
// Returns the name of an array of one of several cases; `quantity` itself if there is one case.
std::string CaseArrayName(const std::string& quantity, const std::string& case_name,
                          std::size_t cases);

// The grid as a file, its arrays as raw doubles behind the XML. Both throw std::invalid_argument:
// an array that does not have its components at every point.
std::string ToVtu(const VtuGrid& grid);
// False: the file cannot be written.
bool WriteVtu(const std::filesystem::path& file, const VtuGrid& grid);

}  // namespace palpate
