// Named materials for scenes: the table of deploy/scenes/materials.md, which the build includes in
// the program.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

struct NamedMaterial {
  std::string_view name;
  double young_modulus = 0;  // [Pa]
  double poisson_ratio = 0;  // [-]; NaN: unknown
  double density = 0;        // [kg/m^3]; 0: unknown
  double tolerance = 0;      // of the modulus, one standard deviation, relative [-]
  std::string_view source;   // the document that states them
};

// In the order of the table. Throws std::logic_error: a cell that is not understood.
const std::vector<NamedMaterial>& NamedMaterials();
// nullptr: there is none.
const NamedMaterial* FindMaterial(std::string_view name);

// The material that a scene names, also by an override; nullptr: none.
const NamedMaterial* MaterialOfScene(const std::filesystem::path& scene,
                                     const std::vector<std::string>& overrides);

// The page with the table, Markdown.
std::string_view MaterialsPage();

}  // namespace palpate
