#include "slave/commands/solve/planar_field_file.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include "shared/mesh/boundary_patch.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr int kGrid = 40;  // points along the larger side
constexpr int kVtkVertex = 1;
constexpr int kVtkLine = 3;

Outline OutlineOf(const BoundaryMesh& mesh) {
  Outline outline;
  for (std::size_t loop = 0; loop + 1 < mesh.loop_begin.size(); ++loop) {
    std::vector<Vector2d> points;
    for (int i = mesh.loop_begin[loop]; i < mesh.loop_begin[loop + 1]; ++i) {
      points.push_back(mesh.elements[static_cast<std::size_t>(i)].a);
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
  Eigen::Array2d low = outline.outer.front();
  Eigen::Array2d high = low;
  for (const auto& p : outline.outer) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  const double step = (high - low).maxCoeff() / kGrid;
  std::vector<Vector2d> inside;
  for (double y = low.y() + 0.5 * step; y < high.y(); y += step) {
    for (double x = low.x() + 0.5 * step; x < high.x(); x += step) {
      const Vector2d p(x, y);
      if (!Contains(outline, p)) continue;
      const auto& nearest = mesh.elements[static_cast<std::size_t>(FindElement(mesh, p))];
      if (DistanceTo(nearest, p) >= nearest.length()) inside.push_back(p);
    }
  }
  return inside;
}

// Letters that XML would read as its own.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return escaped;
}

}  // namespace

PlanarFieldFile::PlanarFieldFile(const std::filesystem::path& file, const Bem2dModel& model)
    : file_(file), model_(model), inside_O_(GridInside(model.greens_functions().problem().mesh)) {}

void PlanarFieldFile::AddCase(const std::string& name) {
  const InteriorField field(model_, model_.Boundary());
  Case solved{name, {}};
  for (int i = 0; i < model_.info().elements; ++i) solved.points.push_back(field.OnBoundary(i));
  for (const auto& p : inside_O_) solved.points.push_back(field.At(p));
  cases_.push_back(std::move(solved));
}

void PlanarFieldFile::WriteArray(std::ostream* stream, const Case& solved) const {
  std::string suffix;
  if (cases_.size() > 1) suffix.append(1, ' ').append(Escaped(solved.name));
  *stream << "<DataArray type=\"Float64\" Name=\"displacement" << suffix
          << "\" NumberOfComponents=\"3\" format=\"ascii\">\n";
  for (const auto& p : solved.points) {
    *stream << p.displacement.x() << ' ' << p.displacement.y() << " 0\n";
  }
  *stream << "</DataArray>\n<DataArray type=\"Float64\" Name=\"stress" << suffix
          << "\" NumberOfComponents=\"3\" ComponentName0=\"xx\" ComponentName1=\"yy\" "
             "ComponentName2=\"xy\" format=\"ascii\">\n";
  for (const auto& p : solved.points) {
    *stream << p.stress(0, 0) << ' ' << p.stress(1, 1) << ' ' << p.stress(0, 1) << '\n';
  }
  *stream << "</DataArray>\n";
}

bool PlanarFieldFile::Write() const {
  const BoundaryMesh& mesh = model_.greens_functions().problem().mesh;
  const std::size_t count = mesh.elements.size() + inside_O_.size();
  std::ofstream stream(file_);
  stream.precision(17);
  stream << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
            "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\""
         << count << "\" NumberOfCells=\"" << count << "\">\n<Points>\n"
         << "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n";
  for (const auto& e : mesh.elements) {
    stream << e.midpoint().x() << ' ' << e.midpoint().y() << " 0\n";
  }
  for (const auto& p : inside_O_) stream << p.x() << ' ' << p.y() << " 0\n";
  stream << "</DataArray>\n</Points>\n<Cells>\n"
            "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n";
  for (int i = 0; i < mesh.size(); ++i) stream << i << ' ' << mesh.Next(i) << '\n';
  for (std::size_t i = mesh.elements.size(); i < count; ++i) stream << i << '\n';
  stream << "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n";
  for (std::size_t i = 1; i <= count; ++i) {
    stream << i + std::min(i, mesh.elements.size()) << '\n';
  }
  stream << "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n";
  for (std::size_t i = 0; i < count; ++i) {
    stream << (i < mesh.elements.size() ? kVtkLine : kVtkVertex) << '\n';
  }
  stream << "</DataArray>\n</Cells>\n<PointData>\n";
  for (const auto& solved : cases_) WriteArray(&stream, solved);
  stream << "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  stream.flush();
  return stream.good();
}

}  // namespace palpate
