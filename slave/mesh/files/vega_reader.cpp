// Vega FEM's .veg: *VERTICES and *ELEMENTS as TetGen's tables, *MATERIAL name with a line
// `ENU, density, Young's modulus, Poisson's ratio`, *REGION set, material.
// Source: Vega FEM user's manual, "The .veg file format".
#include <map>

#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

class VegaReader {
 public:
  explicit VegaReader(const std::filesystem::path& file) : rows_(file), builder_(rows_) {}

  MeshFile Read(double unit) {
    while (rows_.Next()) ReadSection();
    MeshFile file = builder_.Finish(unit);
    AddMaterial(&file);
    return file;
  }

 private:
  void ReadSection() {
    const std::string name(rows_.fields()[0]);
    if (name == "*VERTICES") {
      ReadNodeTable(&rows_, &builder_);
    } else if (name == "*ELEMENTS") {
      ReadElements();
    } else if (name == "*MATERIAL") {
      ReadMaterial();
    } else if (name == "*REGION") {
      ReadRegion();
    } else if (name == "*SET") {
      PassOver();
    } else {
      rows_.Refuse(Quoted(name), "*VERTICES, *ELEMENTS, *MATERIAL, *REGION, *SET or *INCLUDE");
    }
  }

  void ReadElements() {
    rows_.Require("the kind of elements", 1);
    const std::string kind(rows_.fields()[0]);
    if (kind != "TET" && kind != "TETS") rows_.Refuse("elements " + Quoted(kind), "TET or TETS");
    ReadElementTable(&rows_, &builder_);
  }

  void ReadMaterial() {
    if (rows_.fields().size() != 2) rows_.Refuse("*MATERIAL", "a name after it");
    const std::string name(rows_.fields()[1]);
    rows_.Require("a material's law", 1);
    const std::string law(rows_.fields()[0]);
    if (law != "ENU") {
      builder_.Remark("material " + Quoted(name) + " of law " + Quoted(law) +
                      " is not read: expected ENU");
      return;
    }
    if (rows_.fields().size() != 4) {
      rows_.Refuse("a material with " + std::to_string(rows_.fields().size()) + " fields",
                   "ENU, density, Young's modulus, Poisson's ratio");
    }
    const FileMaterial material{rows_.Real(1, "density"), rows_.Real(2, "Young's modulus"),
                                rows_.Real(3, "Poisson's ratio")};
    if (!(material.density >= 0)) RefuseValue("density", material.density, ">= 0 kg/m^3");
    if (!(material.young_modulus > 0)) {
      RefuseValue("Young's modulus", material.young_modulus, "> 0 Pa");
    }
    if (!(material.poisson_ratio > -1 && material.poisson_ratio <= 0.5)) {
      RefuseValue("Poisson's ratio", material.poisson_ratio, "-1 < nu <= 0.5");
    }
    materials_[name] = material;
  }

  void ReadRegion() {
    rows_.Require("a region `set, material`", 2);
    const std::string name(rows_.fields()[1]);
    if (const auto found = materials_.find(name); found != materials_.end()) used_.insert(*found);
  }

  void PassOver() {
    while (rows_.Next()) {
      if (!rows_.fields()[0].starts_with('*')) continue;
      rows_.Back();
      return;
    }
  }

  [[noreturn]] void RefuseValue(const char* what, double value, const char* accepted) {
    rows_.Refuse(std::string(what) + " " + Brief(value), accepted);
  }

  // Reads the material of the regions; a file without regions has one material for all.
  void AddMaterial(MeshFile* file) {
    const auto& named = used_.empty() ? materials_ : used_;
    if (named.size() == 1) file->material = named.begin()->second;
    if (named.size() > 1) {
      file->remarks.push_back(std::to_string(named.size()) +
                              " materials: not read, expected one for the whole object");
    }
  }

  MeshRowReader rows_;
  MeshBuilder builder_;
  std::map<std::string, FileMaterial> materials_, used_;
};

}  // namespace

MeshFile ReadVega(const std::filesystem::path& file, double unit) {
  return VegaReader(file).Read(unit);
}

}  // namespace palpate
