#include "shared/text/file_format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <fstream>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kInspectedBytes = 512;  // [bytes]

struct Format {
  std::string_view magic;  // at `at`
  std::size_t at;
  std::string_view name, advice;
};

using namespace std::string_view_literals;
constexpr std::string_view kAsCsv = "save the table as CSV";
constexpr std::string_view kAsPng = "write each image as a 16-bit PNG, for depths in a whole unit";
constexpr std::string_view kByMeshio = "meshio convert FILE OUT.msh";

// First bytes of formats, from their specifications.
constexpr std::array kFormats{
    Format{"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", 0, "a workbook (.xls)", kAsCsv},
    Format{"PAR1", 0, "a Parquet file", kAsCsv},
    Format{"ARROW1", 0, "an Arrow file", kAsCsv},
    Format{"FEA1", 0, "a Feather file", kAsCsv},
    Format{"\x93NUMPY", 0, "a NumPy array (.npy)",
           "write a table by numpy.savetxt with a header, an image as PNG"},
    Format{"TDSm", 0, "a LabVIEW file (.tdms)", kAsCsv},
    Format{"\x89HDF\r\n\x1A\n", 0, "an HDF5 file", "write its arrays as CSV, meshes by meshio"},
    Format{"MATLAB 5.0 MAT-file", 0, "a MATLAB file", "write its arrays by writematrix as CSV"},
    Format{"SQLite format 3\0"sv, 0, "an SQLite database, such as a rosbag2 .db3",
           "ros2 bag convert writes MCAP"},
    Format{"#ROSBAG", 0, "a bag of ROS 1", "mcap convert writes MCAP"},
    Format{"\x89MCAP0\r\n", 0, "an MCAP file",
           "palpate-slave process reads those of palpate-slave serve --record"},
    Format{"\x28\xB5\x2F\xFD", 0, "a file compressed by zstd", "zstd -d unpacks it"},
    Format{"\x1F\x8B", 0, "a file compressed by gzip", "gunzip unpacks it"},
    Format{"BZh", 0, "a file compressed by bzip2", "bunzip2 unpacks it"},
    Format{"\xFD\x37zXZ", 0, "a file compressed by xz", "unxz unpacks it"},
    Format{"7z\xBC\xAF\x27\x1C", 0, "a 7z archive", "7z x unpacks it"},
    Format{"Rar!", 0, "a RAR archive", "unrar x unpacks it"},
    Format{"II*\0"sv, 0, "a TIFF image", kAsPng},
    Format{"MM\0*"sv, 0, "a TIFF image", kAsPng},
    Format{"v/1\x01", 0, "an OpenEXR image", kAsPng},
    Format{"\x89PNG\r\n", 0, "a PNG image", ""},
    Format{"\xFF\xD8\xFF", 0, "a JPEG image", ""},
    Format{"ftyp", 4, "a video", "name it as sense.camera.file"},
    Format{"\x1A\x45\xDF\xA3", 0, "a video (Matroska)", "name it as sense.camera.file"},
    Format{"%PDF", 0, "a PDF document", ""},
    Format{"LASF", 0, "a LAS point cloud", "CloudCompare saves PCD"},
    Format{"ASTM-E57", 0, "an E57 point cloud", "CloudCompare saves PCD"},
    Format{"$NOD", 0, "a Gmsh mesh of format 1",
           "gmsh FILE.msh -save -format msh2 -o OUT.msh converts it"},
    Format{"# vtk DataFile", 0, "a VTK file", kByMeshio},
    Format{"MeshVersionFormatted", 0, "a Medit mesh", kByMeshio},
    Format{"OFF\n", 0, "a Geomview mesh (OFF)", kByMeshio},
    Format{"OFF\r\n", 0, "a Geomview mesh (OFF)", kByMeshio},
    Format{"glTF", 0, "a glTF scene", "Blender saves its surface as STL"},
    Format{"ISO-10303-21", 0, "a STEP body of CAD",
           "gmsh FILE.step -3 -format msh2 -o OUT.msh meshes it"},
};

// Recognises the content of a ZIP archive by the names of its first members, which are not
// compressed.
std::string ArchiveFormat(std::string_view beginning) {
  const auto has = [&](std::string_view part) {
    return beginning.find(part) != std::string_view::npos;
  };
  if (has("[Content_Types].xml") || has("xl/") || has("_rels/") || has("docProps/")) {
    return "a workbook (.xlsx): " + std::string(kAsCsv);
  }
  if (has("opendocument.spreadsheet")) return "a workbook (.ods): " + std::string(kAsCsv);
  if (has(".npy")) return "NumPy arrays (.npz): write them by numpy.savetxt with a header";
  if (has("data.pkl")) {
    return "a file of PyTorch: python3 -m palpate.convert_network writes network.json";
  }
  return "a ZIP archive: unzip it";
}

// Vertices are the first lines of a Wavefront file that are neither comments nor names.
bool IsWavefront(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool is_name = line.starts_with("o ") || line.starts_with("g ");
    if (line.empty() || line.front() == '#' || is_name) continue;
    if (line.starts_with("mtllib ")) return true;
    const std::string_view first = Trimmed(line.substr(1));
    return line.starts_with("v ") && ParseFinite(first.substr(0, first.find(' '))).has_value();
  }
  return false;
}

std::string TextFormat(std::string_view text) {
  const std::string_view plain = Trimmed(text);
  const std::string lower = Lowercase(plain);
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  if (lower.starts_with("<!doctype html") || lower.starts_with("<html")) return "a web page";
  if (lower.starts_with("<vtkfile") || (lower.starts_with("<?xml") && has("<vtkfile"))) {
    return "a VTK file in XML: " + std::string(kByMeshio);
  }
  const bool is_tag = lower.size() > 1 && lower[0] == '<' && std::isalpha(lower[1]) != 0;
  if (is_tag || lower.starts_with("<?xml")) return "an XML file";
  const bool is_deck = lower.starts_with("**") && (has("\n*heading") || has("\n*node"));
  if (is_deck || lower.starts_with("*heading") || lower.starts_with("*node")) {
    return "an Abaqus or CalculiX mesh: " + std::string(kByMeshio);
  }
  if (has("begin bulk")) return "a Nastran mesh: " + std::string(kByMeshio);
  if (IsWavefront(plain)) return "a Wavefront mesh (OBJ): " + std::string(kByMeshio);
  return {};
}

}  // namespace

std::string ForeignFormat(std::string_view beginning) {
  beginning = beginning.substr(0, kInspectedBytes);
  for (const auto& [magic, at, name, advice] : kFormats) {
    if (beginning.size() < at || !beginning.substr(at).starts_with(magic)) continue;
    if (at > 0 && beginning.front() != '\0') continue;  // a length before the name
    return std::string(name) + (advice.empty() ? "" : ": ") + std::string(advice);
  }
  if (beginning.starts_with("PK\x03\x04")) return ArchiveFormat(beginning);
  return TextFormat(beginning);
}

std::string ForeignFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string beginning(kInspectedBytes, '\0');
  if (!stream) return {};
  stream.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, stream.gcount())));
  return ForeignFormat(std::string_view(beginning));
}

}  // namespace palpate
