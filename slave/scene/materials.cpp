#include "slave/scene/materials.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/scene/document.h"
#include "slave/scene/keys.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

double ValueOf(std::string_view cell, Dimension dimension, double absent) {
  if (cell.empty()) return absent;
  const auto value = ParseQuantity(cell, dimension);
  if (!value) throw std::logic_error("materials.md: " + std::string(cell));
  return *value;
}

std::vector<NamedMaterial> ReadPage() {
  constexpr std::size_t kCells = 6;
  std::vector<NamedMaterial> materials;
  std::string_view page = MaterialsPage();
  bool is_row = false;  // below the head of the table
  while (!page.empty()) {
    const std::string_view line = page.substr(0, page.find('\n'));
    page.remove_prefix(std::min(page.size(), line.size() + 1));
    if (!line.starts_with('|')) continue;
    if (line.starts_with("|---")) {
      is_row = true;
    } else if (is_row) {
      const auto cells = TableCells(line);
      if (cells.size() < kCells) throw std::logic_error("materials.md: " + std::string(line));
      materials.push_back(
          {cells[0], ValueOf(cells[1], Dimension::kPressure, 0),
           ValueOf(cells[2], Dimension::kNumber, std::numeric_limits<double>::quiet_NaN()),
           ValueOf(cells[3], Dimension::kDensity, 0), ValueOf(cells[4], Dimension::kNumber, 0),
           cells[5]});
    }
  }
  return materials;
}

}  // namespace

const std::vector<NamedMaterial>& NamedMaterials() {
  static const std::vector<NamedMaterial> materials = ReadPage();
  return materials;
}

const NamedMaterial* FindMaterial(std::string_view name) {
  const auto& materials = NamedMaterials();
  const auto found = std::ranges::find(materials, name, &NamedMaterial::name);
  return found == materials.end() ? nullptr : &*found;
}

const NamedMaterial* MaterialOfScene(const std::filesystem::path& scene,
                                     const std::vector<std::string>& overrides) {
  Mistakes mistakes(scene);
  const DocumentNode root = ReadDocument(scene, overrides, &mistakes);
  const DocumentNode* node = &root;
  for (const char* key : {"object", "material", "name"}) {
    node = node->Find(key);
    if (node == nullptr) return nullptr;
  }
  return FindMaterial(node->text);
}

}  // namespace palpate
