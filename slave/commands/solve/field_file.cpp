#include "slave/commands/solve/field_file.h"

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

NodalFieldFile::NodalFieldFile(std::filesystem::path file, DeformationModel& model)
    : file_(std::move(file)), model_(model) {
  const FieldMesh& mesh = model_.field_mesh();
  std::vector<int> number(mesh.vertices.size(), -1);
  ForCorners(mesh, [&](int v) { number[static_cast<std::size_t>(v)] = 0; });
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<int>(vertices_.size());
    vertices_.push_back(v);
    grid_.points.push_back(mesh.vertices[v]);
  }
  grid_.lines = mesh.lines;
  grid_.triangles = mesh.triangles;
  grid_.tets = mesh.tets;
  ForCorners(grid_, [&](int& v) { v = number[static_cast<std::size_t>(v)]; });
}

void NodalFieldFile::AddCase(const std::string& name) {
  std::vector<Eigen::Vector3d> u_O;
  model_.Displacements(&u_O);
  auto& values = cases_.emplace_back(name, std::vector<double>()).second;
  for (const std::size_t v : vertices_) values.insert(values.end(), u_O[v].begin(), u_O[v].end());
}

bool NodalFieldFile::Write() const {
  VtuGrid grid = grid_;
  for (const auto& [name, values] : cases_) {
    grid.arrays.push_back({CaseArrayName("displacement", name, cases_.size()), 3, values, {}});
  }
  return WriteVtu(file_, grid, VtuForm::kAppended);
}

}  // namespace palpate
