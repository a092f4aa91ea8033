#include "slave/commands/solve/field_file.h"

#include <utility>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Calls `visit` with each vertex of each cell.
template <typename Grid, typename Visit>
void ForCorners(Grid& grid, const Visit& visit) {
  for (auto& cell : grid.lines)
    for (auto& v : cell) visit(v);
  for (auto& cell : grid.triangles)
    for (auto& v : cell) visit(v);
  for (auto& cell : grid.tets)
    for (auto& v : cell) visit(v);
}

}  // namespace

FieldFile::FieldFile(std::filesystem::path file, DeformationModel& model)
    : file_(std::move(file)), model_(model) {
  const FieldMesh& mesh = model_.field_mesh();
  std::vector<int> number(mesh.vertices.size(), -1);
  ForCorners(mesh, [&](int v) { number[Index(v)] = 0; });
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<int>(vertices_.size());
    vertices_.push_back(v);
    grid_.points.push_back(mesh.vertices[v]);
  }
  grid_.lines = mesh.lines;
  grid_.triangles = mesh.triangles;
  grid_.tets = mesh.tets;
  ForCorners(grid_, [&](int& v) { v = number[Index(v)]; });
}

void FieldFile::AddCase(const std::string& name, const Solution& solution) {
  std::vector<Eigen::Vector3d> u_O;
  model_.Displacements(solution, &u_O);
  PointArray displacement{"displacement", 3, {}};
  for (const std::size_t v : vertices_) {
    displacement.values.insert(displacement.values.end(), u_O[v].begin(), u_O[v].end());
  }
  cases_.emplace_back(name, std::move(displacement));
}

bool FieldFile::Write() const {
  VtuGrid grid = grid_;
  for (const auto& [name, array] : cases_) {
    grid.arrays.push_back(array);
    grid.arrays.back().name = CaseArrayName(array.name, name, cases_.size());
  }
  return WriteVtu(file_, grid);
}

}  // namespace palpate
