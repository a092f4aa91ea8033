#include "slave/study/mesh_division.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

std::string Times(const std::array<int, 3>& cells) {
  return std::to_string(cells[0]) + " x " + std::to_string(cells[1]) + " x " +
         std::to_string(cells[2]) + " cells";
}

std::vector<Division> BoxDivisions(const Scene& scene, const BoxGeometry& box) {
  std::vector<Division> divisions;
  std::set<std::array<int, 3>> seen;
  for (const double factor : {1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 6.0}) {
    BoxGeometry scaled = box;
    for (int& n : scaled.cells) n = std::max(1, static_cast<int>(std::lround(n * factor)));
    if (!seen.insert(scaled.cells).second) continue;
    const auto [i, j, k] = scaled.cells;
    Division d;
    d.scene = scene;
    d.resolution = Times(scaled.cells);
    d.own = factor == 1;
    d.between = factor == 1.5;
    d.scene.object.geometry = scaled;
    d.element_size = std::cbrt(box.size.prod() / (1.0 * i * j * k));
    d.nodes = Index(i + 1) * Index(j + 1) * Index(k + 1);
    d.tets = 6 * Index(i) * Index(j) * Index(k);
    divisions.push_back(std::move(d));
  }
  return divisions;
}

double Volume(const SolidMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) sum += SignedVolume(mesh, t);
  return sum;
}

// For nodes fixed by number: refined nodes between two of them are fixed as well.
void HoldBetween(const SolidMesh& coarse, const SolidMesh& fine, std::vector<int>* nodes) {
  const std::set<int> held(nodes->begin(), nodes->end());
  const auto key = [](const Vector3d& p) { return std::array<double, 3>{p.x(), p.y(), p.z()}; };
  std::map<std::array<double, 3>, int> number;
  for (std::size_t i = coarse.nodes.size(); i < fine.nodes.size(); ++i) {
    number[key(fine.nodes[i])] = static_cast<int>(i);
  }
  std::set<int> more;
  for (const auto& tet : coarse.tets) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        if (a == b || !held.contains(tet[a]) || !held.contains(tet[b])) continue;
        const Vector3d middle = 0.5 * (coarse.nodes[Index(tet[a])] + coarse.nodes[Index(tet[b])]);
        const auto found = number.find(key(middle));
        if (found != number.end()) more.insert(found->second);
      }
    }
  }
  nodes->insert(nodes->end(), more.begin(), more.end());
}

// Refines `mesh` once and returns the supports of `scene` on it.
void RefineSupports(SolidMesh* mesh, Scene* scene) {
  SolidMesh fine = Refined(*mesh);
  for (Fixed& fixed : scene->object.fixed) {
    if (auto* listed = std::get_if<FixedNodes>(&fixed.where)) {
      HoldBetween(*mesh, fine, &listed->nodes);
    }
  }
  *mesh = std::move(fine);
}

std::vector<Division> FileDivisions(const Scene& scene, std::size_t max_dof) {
  std::vector<Division> divisions;
  Scene supported = scene;
  supported.model.refinements = 0;
  const auto solid = std::get<SolidMesh>(MeshObject(supported, std::nullopt));
  SolidMesh refined = solid;
  for (int r = 0; r <= 2; ++r) {
    if (r > 0 && HoldsByNumber(scene)) {
      if (24 * refined.nodes.size() > max_dof) break;
      RefineSupports(&refined, &supported);
    }
    Division d;
    d.scene = supported;
    d.own = r == scene.model.refinements;
    d.scene.model.refinements = r;
    const auto eights = static_cast<std::size_t>(1) << (3 * r);
    d.tets = solid.tets.size() * eights;
    d.nodes = solid.nodes.size() * eights;
    d.element_size = std::cbrt(6 * Volume(solid) / static_cast<double>(d.tets));
    d.resolution = std::to_string(d.tets) + " tets";
    divisions.push_back(std::move(d));
  }
  return divisions;
}

}  // namespace

std::vector<Division> DivisionsOf(const Scene& scene, std::size_t max_dof) {
  const auto* box = std::get_if<BoxGeometry>(&scene.object.geometry);
  const bool by_cells = box != nullptr && !HoldsByNumber(scene);
  return by_cells ? BoxDivisions(scene, *box) : FileDivisions(scene, max_dof);
}

}  // namespace palpate::study
