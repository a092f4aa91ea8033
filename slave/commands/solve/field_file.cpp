#include "slave/commands/solve/field_file.h"

#include <utility>

#include <Eigen/Geometry>

#include "slave/mesh/boundary_patch.h"
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

using Eigen::Vector2d;

constexpr int kGrid = 40;  // points along the larger side

Outline OutlineOf(const BoundaryMesh& mesh) {
  Outline outline;
  for (std::size_t loop = 0; loop + 1 < mesh.loop_begin.size(); ++loop) {
    std::vector<Vector2d> points;
    for (int i = mesh.loop_begin[loop]; i < mesh.loop_begin[loop + 1]; ++i) {
      points.push_back(mesh.elements[Index(i)].a);
    }
    if (loop == 0) {
      outline.outer = std::move(points);
    } else {
      outline.holes.push_back(std::move(points));
    }
  }
  return outline;
}

std::vector<Vector2d> GridInside(const BoundaryMesh& mesh) {
  const Outline outline = OutlineOf(mesh);
  Eigen::AlignedBox2d box;
  for (const auto& p : outline.outer) box.extend(p);
  const Vector2d low = box.min(), high = box.max();
  const double step = (high - low).maxCoeff() / kGrid;
  std::vector<Vector2d> inside;
  for (double y = low.y() + 0.5 * step; y < high.y(); y += step) {
    for (double x = low.x() + 0.5 * step; x < high.x(); x += step) {
      const Vector2d p(x, y);
      if (!Contains(outline, p)) continue;
      const auto& nearest = mesh.elements[Index(FindElement(mesh, p))];
      if (DistanceTo(nearest, p) >= nearest.length()) inside.push_back(p);
    }
  }
  return inside;
}

}  // namespace

bool FieldFile::Write() const {
  VtuGrid grid = grid_;
  for (const auto& [name, arrays] : cases_) {
    for (const PointArray& array : arrays) {
      grid.arrays.push_back(array);
      grid.arrays.back().name = CaseArrayName(array.name, name, cases_.size());
    }
  }
  return WriteVtu(file_, grid, form_);
}

NodalFieldFile::NodalFieldFile(std::filesystem::path file, DeformationModel& model)
    : FieldFile(std::move(file), VtuForm::kAppended), model_(model) {
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

void NodalFieldFile::AddCase(const std::string& name, const Solution& solution) {
  std::vector<Eigen::Vector3d> u_O;
  model_.Displacements(solution, &u_O);
  PointArray displacement{"displacement", 3, {}, {}};
  for (const std::size_t v : vertices_) {
    displacement.values.insert(displacement.values.end(), u_O[v].begin(), u_O[v].end());
  }
  cases_.push_back({name, {std::move(displacement)}});
}

PlanarFieldFile::PlanarFieldFile(const std::filesystem::path& file, Bem2dModel& model)
    : FieldFile(file, VtuForm::kAscii),
      model_(model),
      inside_O_(GridInside(model.greens_functions().problem().mesh)) {
  const BoundaryMesh& mesh = model_.greens_functions().problem().mesh;
  for (int i = 0; i < mesh.size(); ++i) {
    const Vector2d middle = mesh.elements[Index(i)].midpoint();
    grid_.points.emplace_back(middle.x(), middle.y(), 0);
    grid_.lines.push_back({i, mesh.Next(i)});
  }
  for (const auto& p : inside_O_) {
    grid_.vertices.push_back(static_cast<int>(grid_.points.size()));
    grid_.points.emplace_back(p.x(), p.y(), 0);
  }
}

void PlanarFieldFile::AddCase(const std::string& name, const Solution& solution) {
  const InteriorField field(model_, model_.Boundary(solution));
  PointArray displacement{"displacement", 3, {}, {}}, stress{"stress", 3, {}, {"xx", "yy", "xy"}};
  const auto add = [&](const PointState& p) {
    displacement.values.insert(displacement.values.end(),
                               {p.displacement.x(), p.displacement.y(), 0});
    stress.values.insert(stress.values.end(), {p.stress(0, 0), p.stress(1, 1), p.stress(0, 1)});
  };
  for (int i = 0; i < model_.info().elements; ++i) add(field.OnBoundary(i));
  for (const auto& p : inside_O_) add(field.At(p));
  cases_.push_back({name, {std::move(displacement), std::move(stress)}});
}

}  // namespace palpate
