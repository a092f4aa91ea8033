#include "tests/slave/pipeline/organ/liver_sequences.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <variant>

#include "shared/mesh/files/mesh_file.h"
#include "tests/support/paths.h"

namespace palpate::liver {
namespace {

const std::filesystem::path kFolder = SourcePath("/../shared/data/liver_registration");

std::vector<std::vector<double>> ReadRows(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(stream, line);  // header
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

}  // namespace

bool IsThere() {
  return std::filesystem::exists(kFolder);
}

Liver ReadLiver(const std::string& mesh) {
  const auto folder = kFolder / ("mesh-" + mesh);
  Liver liver;
  liver.mesh = std::get<SolidMesh>(ReadMeshFile(folder / "liver.msh", 1).mesh);
  liver.held.resize(liver.mesh.nodes.size());
  for (const auto& row : ReadRows(folder / "fixed_vertices.csv")) {
    liver.held.at(static_cast<std::size_t>(row[0])) = {true, true, true};
  }
  for (const auto& row : ReadRows(folder / "matching_triangles.csv")) {
    liver.seen.push_back(
        {static_cast<int>(row[0]), static_cast<int>(row[1]), static_cast<int>(row[2])});
  }
  return liver;
}

std::vector<Frame> ReadSequence(const std::string& name) {
  const auto forces = ReadRows(kFolder / name / "true_forces.csv");
  std::vector<Frame> frames;
  for (const auto& row : forces) {
    const std::string number = std::to_string(static_cast<int>(row[0]));
    const std::string file = "cloud_" + std::string(number.size() < 2 ? "0" : "") + number + ".csv";
    if (!std::filesystem::exists(kFolder / name / file)) continue;
    frames.push_back({{}, {row[1], row[2], row[3]}});
    for (const auto& p : ReadRows(kFolder / name / file)) {
      frames.back().cloud.emplace_back(p[0], p[1], p[2]);
    }
  }
  return frames;
}

std::vector<std::string> Sequences(const std::string& law) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder / law)) {
    names.push_back(law + "/" + entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace palpate::liver
