#include "slave/mechanics/footprint/contact_footprint.h"

#include <algorithm>
#include <cstddef>

#include "shared/geometry/index.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
namespace {

constexpr std::string_view kNoPlace =
    "no surface is met there: farther from it than half the longest edge of the nearest triangle";

}  // namespace

// A third of the area of each triangle of the patch to each of its nodes.
void SurfaceFootprints::ShareAmongNodes(ContactFootprint* footprint) {
  for (const int t : patch().triangles) {
    const double area = finder_.area(t);
    for (const int node : surface().triangles[Index(t)]) {
      if (load_[Index(node)] == 0) footprint->places.push_back({node, 0});
      load_[Index(node)] += area / 3;
    }
  }
  std::ranges::sort(footprint->places, {}, &PlaceWeight::place);
  for (auto& [node, weight] : footprint->places) {
    weight = load_[Index(node)] / patch().triangle_area;
    load_[Index(node)] = 0;
  }
}

std::string_view SurfaceFootprints::OnNodes(const Contact& contact, ContactFootprint* footprint) {
  const auto at = finder_.Find(contact);
  if (!at) return kNoPlace;
  footprint->at = *at;
  footprint->places.clear();
  footprint->point = true;
  footprint->normal_O = finder_.NormalAt(*at);
  footprint->coarse = false;
  const bool loads = contact.kind == Contact::Kind::kForce;
  if (contact.width > 0) {
    finder_.FindPatch(*at, contact.p_O, contact.width);
    footprint->coarse = IsPatchCoarse(
        CoverOf(patch(), loads ? PatchBasis::kLoadedTriangles : PatchBasis::kMovedNodes));
  }
  if (contact.width > 0 && loads) {
    ShareAmongNodes(footprint);
  } else if (contact.width > 0 && !patch().nodes.empty()) {
    const std::size_t count = patch().nodes.size();
    footprint->point = count == 1;
    for (const int node : patch().nodes) {
      footprint->places.push_back({node, 1 / static_cast<double>(count)});
    }
  } else if (at->node >= 0) {
    footprint->places.push_back({at->node, 1});
  } else {
    for (int v = 0; v < 3; ++v) {
      footprint->places.push_back(
          {surface().triangles[Index(at->triangle)][Index(v)], at->weights[v]});
    }
  }
  return {};
}

std::string_view SurfaceFootprints::OnTriangles(const Contact& contact,
                                                ContactFootprint* footprint) {
  footprint->places.clear();
  footprint->point = true;
  footprint->coarse = false;
  const int triangles = static_cast<int>(surface().triangles.size());
  if (contact.width == 0 && contact.element >= 0 && contact.element < triangles) {
    footprint->places.push_back({contact.element, 1});
    footprint->normal_O = Normal(surface(), contact.element);
    return {};
  }
  const auto at = finder_.Find(contact);
  if (!at) return kNoPlace;
  footprint->at = *at;
  footprint->normal_O = finder_.NormalAt(*at);
  if (contact.width == 0) {
    footprint->places.push_back({at->triangle, 1});
    return {};
  }
  finder_.FindPatch(*at, contact.p_O, contact.width);
  footprint->coarse = IsPatchCoarse(CoverOf(patch(), PatchBasis::kTractionTriangles));
  for (const int t : patch().triangles) {
    footprint->places.push_back({t, finder_.area(t) / patch().triangle_area});
  }
  footprint->point = footprint->places.size() == 1;
  return {};
}

}  // namespace palpate
