#include "slave/mechanics/mesher/fill_surface.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"
#include "slave/mesh/files/file_cursor.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/index.h"
#include "slave/mesh/mesh_check.h"
#include "slave/program/private_folder.h"
#include "slave/program/run_program.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

using Program = FillOptions::Program;

constexpr double kMaxTets = 4e6;
constexpr double kVolumeSlack = 0.02;
constexpr const char* kQuality = "1.4/12";  // radius-edge ratio, smallest dihedral angle [deg]

// Volume of a regular tetrahedron.
double VolumeOfEdge(double edge) {
  return edge * edge * edge / (6 * std::numbers::sqrt2);
}

// Keeps the nodes that elements use.
template <class Elements>
void DropUnused(std::vector<Vector3d>* nodes, Elements* elements) {
  std::vector<int> number(nodes->size(), -1);
  for (const auto& element : *elements) {
    for (const int i : element) number[Index(i)] = 0;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < nodes->size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(kept);
    (*nodes)[kept++] = (*nodes)[i];
  }
  nodes->resize(kept);
  for (auto& element : *elements) {
    for (int& i : element) i = number[Index(i)];
  }
}

void RequireResolution(double resolution, double volume) {
  const double least = std::cbrt(6 * std::numbers::sqrt2 * volume / kMaxTets);
  if (resolution == 0 || (std::isfinite(resolution) && resolution >= least)) return;
  throw std::invalid_argument("resolution = " + Brief(resolution) + " m: expected 0, or at least " +
                              Brief(least) + " m (4 million tetrahedra)");
}

// Returns the requested program; without a request TetGen, or Gmsh if there is no TetGen.
std::pair<Program, std::filesystem::path> Choose(Program wanted) {
  for (const auto& [program, name] :
       {std::pair{Program::kTetgen, "tetgen"}, std::pair{Program::kGmsh, "gmsh"}}) {
    if (wanted != Program::kFirstFound && wanted != program) continue;
    if (auto path = FindProgram(name)) return {program, *std::move(path)};
  }
  const char* const accepted = wanted == Program::kTetgen ? "the package tetgen"
                               : wanted == Program::kGmsh ? "the package gmsh"
                                                          : "one of the packages tetgen and gmsh";
  throw std::runtime_error(std::string("no mesher to fill a surface: expected ") + accepted +
                           " to be installed (deploy/install.sh mesher), or a mesh of tetrahedra");
}

// Returns the last line of a program's output as a message for users.
std::string Words(const std::string& output) {
  constexpr std::size_t kMaxLength = 600;
  std::string words;
  for (const char c : output) {
    const bool blank = c == '\n' || c == '\r' || c == '\t' || c == ' ';
    if (!blank) words += c >= ' ' && c <= '~' ? c : '?';
    if (blank && !words.empty() && words.back() != ' ') words += ' ';
  }
  return words.size() > kMaxLength ? "..." + words.substr(words.size() - kMaxLength) : words;
}

void AppendPoints(const std::vector<Vector3d>& points, std::string* text) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    AppendNumber(i, ' ', text);
    AppendNumber(points[i].x(), ' ', text);
    AppendNumber(points[i].y(), ' ', text);
    AppendNumber(points[i].z(), '\n', text);
  }
}

// Remeshing a surface with similar edge lengths would only lose volume where it is curved.
constexpr double kMuchLonger = 1.5;

double MaxEdgeLength(const SurfaceMesh& surface) {
  double longest = 0;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = surface.nodes[Index(t[i])];
      const auto& b = surface.nodes[Index(t[(i + 1) % 3])];
      longest = std::max(longest, (b - a).norm());
    }
  }
  return longest;
}

// Distance along the unit `direction` to triangle a b c; nullopt: the ray misses it. Source:
// Moeller and Trumbore, J. Graphics Tools 2 (1997) 21-28.
std::optional<double> Hit(const Vector3d& origin, const Vector3d& direction, const Vector3d& a,
                          const Vector3d& b, const Vector3d& c) {
  const Vector3d across = direction.cross(c - a);
  const double determinant = (b - a).dot(across);
  if (determinant == 0) return std::nullopt;
  const Vector3d from = origin - a;
  const double u = from.dot(across) / determinant;
  const Vector3d turned = from.cross(b - a);
  const double v = direction.dot(turned) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return std::nullopt;
  const double distance = (c - a).dot(turned) / determinant;
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

Vector3d PointBefore(const SurfaceMesh& surface, int triangle) {
  const Vector3d origin = Centroid(surface, triangle), direction = Normal(surface, triangle);
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (t == triangle) continue;
    const auto& [a, b, c] = surface.triangles[Index(t)];
    const auto p = [&](int i) -> const Vector3d& { return surface.nodes[Index(i)]; };
    if (const auto distance = Hit(origin, direction, p(a), p(b), p(c))) {
      nearest = std::min(nearest, *distance);
    }
  }
  return origin + 0.5 * nearest * direction;
}

// TetGen's .smesh, in units of the surface's diagonal: nodes, triangles, a point in every cavity.
void WriteTetgenInput(const std::filesystem::path& file, const SurfaceMesh& surface) {
  std::string text;
  AppendNumber(surface.nodes.size(), ' ', &text);
  text += "3 0 0\n";
  AppendPoints(surface.nodes, &text);
  AppendNumber(surface.triangles.size(), ' ', &text);
  text += "0\n";
  for (const auto& [a, b, c] : surface.triangles) {
    text += "3 ";
    AppendNumber(a, ' ', &text);
    AppendNumber(b, ' ', &text);
    AppendNumber(c, '\n', &text);
  }
  const std::vector<Vector3d> holes = HolePoints(surface);
  AppendNumber(holes.size(), '\n', &text);
  AppendPoints(holes, &text);
  WriteWholeFile(file, text);
}

// Returns Gmsh's .geo for the surface `surface.msh` in the same folder. `edge` > 0 requests edges
// of that length, and remeshes the surface if its edges are much longer. 0: Gmsh chooses the length
// and keeps the surface.
void WriteGmshInput(const std::filesystem::path& file, const SurfaceMesh& surface, double edge) {
  if (!WriteGmsh(file.parent_path() / "surface.msh", surface)) {
    throw std::runtime_error(file.string() + " cannot be written");
  }
  // After the classification a cavity is a separate surface, which Gmsh leaves empty.
  std::string text = "Merge \"surface.msh\";\nClassifySurfaces{40*Pi/180, 1, 1, Pi};\n";
  if (edge > 0 && MaxEdgeLength(surface) > kMuchLonger * edge) text += "CreateGeometry;\n";
  // The surface's file names a physical group; without SaveAll nothing else would be written.
  text += "Surface Loop(1) = Surface{:};\nVolume(1) = {1};\nMesh.SaveAll = 1;\n";
  if (edge > 0) {
    for (const char* bound : {"Mesh.MeshSizeMin = ", "Mesh.MeshSizeMax = "}) {
      text += bound;
      AppendNumber(edge, ';', &text);
      text += '\n';
    }
  }
  WriteWholeFile(file, text);
}

// Runs the chosen program in a temporary folder, on a surface in units of its diagonal.
class Mesher {
 public:
  Mesher(const FillOptions& options, const std::stop_token& stop)
      : options_(options), stop_(stop), program_(Choose(options.program)) {}

  // `edge` 0: the program chooses it.
  SolidMesh Fill(const SurfaceMesh& surface, double edge) {
    return program_.first == Program::kTetgen ? ByTetgen(surface, edge) : ByGmsh(surface, edge);
  }

  [[noreturn]] void Fail(const std::string& what, const std::string& output) const {
    throw std::runtime_error(program_.second.filename().string() + " " + what + ": " +
                             Words(output));
  }

 private:
  ProgramEnd Run(const std::vector<std::string>& arguments) const {
    return RunProgram(program_.second, arguments, folder_.path(), options_.timeout, stop_);
  }

  SolidMesh ByTetgen(const SurfaceMesh& surface, double edge) {
    WriteTetgenInput(folder_.path() / "in.smesh", surface);
    std::string switches = std::string("-pzq") + kQuality;
    if (edge > 0) {
      // TetGen reads no exponents in its switches.
      std::array<char, 400> volume{};
      const auto end = std::to_chars(volume.data(), volume.data() + volume.size(),
                                     VolumeOfEdge(edge), std::chars_format::fixed, 24);
      switches.append("a").append(volume.data(), end.ptr);
    }
    const ProgramEnd end = Run({switches, "in.smesh"});
    if (end.status == 0 && std::filesystem::exists(folder_.path() / "in.1.ele")) {
      return Read("in.1.node", end.output);
    }
    // A second run finds intersecting triangles, the usual reason.
    const ProgramEnd why = Run({"-d", "in.smesh"});
    Fail("cannot fill the surface (it may intersect itself)", end.output + " " + why.output);
  }

  SolidMesh ByGmsh(const SurfaceMesh& surface, double edge) {
    const auto bodies = std::ranges::count_if(
        ClosedParts(surface), [](const SurfacePart& part) { return part.depth % 2 == 0; });
    if (bodies > 1) {
      throw std::invalid_argument(
          "the surface has " + std::to_string(bodies) +
          " closed parts beside each other, or parts that intersect: expected one body");
    }
    WriteGmshInput(folder_.path() / "in.geo", surface, edge);
    const ProgramEnd end = Run({"-3", "-format", "msh41", "-o", "out.msh", "in.geo"});
    if (end.status != 0 || !std::filesystem::exists(folder_.path() / "out.msh")) {
      Fail("cannot fill the surface (it may intersect itself)", end.output);
    }
    return Read("out.msh", end.output);
  }

  [[nodiscard]] SolidMesh Read(const char* name, const std::string& output) const {
    try {
      MeshFile file = ReadMeshFile(folder_.path() / name, 1);
      if (auto* solid = std::get_if<SolidMesh>(&file.mesh)) return std::move(*solid);
    } catch (const std::invalid_argument& error) {
      Fail(std::string("wrote a file that cannot be read (") + error.what() + ")", output);
    }
    Fail("made no tetrahedra (the surface may intersect itself)", output);
  }

  const FillOptions& options_;
  const std::stop_token& stop_;
  std::pair<Program, std::filesystem::path> program_;
  PrivateFolder folder_;
};

}  // namespace

SolidMesh FillSurface(const SurfaceMesh& surface, const FillOptions& options,
                      const std::stop_token& stop) {
  SurfaceMesh scaled = surface;
  const MeshReport asked = CheckMesh(scaled, options.numbers, true);
  RequireSound(asked);
  RequireResolution(options.resolution, asked.volume);
  const double unit = (asked.high_O - asked.low_O).norm();
  DropUnused(&scaled.nodes, &scaled.triangles);
  for (auto& p : scaled.nodes) p = (p - asked.low_O) / unit;

  Mesher mesher(options, stop);
  SolidMesh mesh = mesher.Fill(scaled, options.resolution / unit);
  DropUnused(&mesh.nodes, &mesh.tets);
  for (auto& p : mesh.nodes) p = asked.low_O + unit * p;
  const MeshReport made = CheckMesh(mesh, {}, true);
  if (!made.refusals.empty()) mesher.Fail("made an unusable mesh", made.refusals.front());
  if (!(std::abs(made.volume / asked.volume - 1) <= kVolumeSlack)) {
    mesher.Fail("filled another volume",
                Brief(made.volume) + " m^3 instead of the surface's " + Brief(asked.volume) +
                    " m^3: expected a difference of 2 % (check whether the surface intersects "
                    "itself, or curves within the resolution)");
  }
  return mesh;
}

std::vector<Vector3d> HolePoints(const SurfaceMesh& surface) {
  std::vector<Vector3d> points;
  for (const SurfacePart& part : ClosedParts(surface)) {
    if (part.depth % 2 == 0) continue;
    const int largest = *std::ranges::max_element(
        part.triangles, {}, [&](int triangle) { return Area(surface, triangle); });
    points.push_back(PointBefore(surface, largest));
  }
  return points;
}

}  // namespace palpate
