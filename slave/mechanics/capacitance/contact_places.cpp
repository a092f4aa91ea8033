#include "slave/mechanics/capacitance/contact_places.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kOnEdge = 1e-9;  // barycentric weight
constexpr std::string_view kInnerNode = "a node inside the body is no place on its surface";

}  // namespace

std::string_view SurfaceNodePlaces::Find(const Contact& contact, ContactFootprint* footprint) {
  const std::string_view refusal = footprints_.OnNodes(contact, footprint);
  if (!refusal.empty()) return refusal;
  const auto at = [this](int node) { return place_of_node_[static_cast<std::size_t>(node)]; };
  if (footprint->at.node >= 0 && at(footprint->at.node) < 0) return kInnerNode;
  if (footprint->places.size() == 3) {  // a point on an edge
    std::erase_if(footprint->places, [](const PlaceWeight& p) { return p.weight <= kOnEdge; });
  }
  for (PlaceWeight& touched : footprint->places) touched.place = at(touched.place);
  const bool met = std::ranges::all_of(
      footprint->places, [](int p) { return p >= 0; }, &PlaceWeight::place);
  return met ? std::string_view{} : kInnerNode;
}

}  // namespace palpate
