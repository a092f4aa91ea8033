#include "slave/mechanics/bem/element_places.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kMaxOff = 0.1;  // of the stiffness

}  // namespace

ElementPlaces::ElementPlaces(const GreensFunctions& greens, double larger_side)
    : greens_(greens), larger_side_(larger_side) {
  for (const auto& element : greens.problem().mesh.elements) normals_.push_back(element.normal());
}

std::string_view ElementPlaces::Find(const Contact& contact, ContactFootprint* footprint) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  const int element =
      contact.element >= 0 ? contact.element : FindElement(mesh, contact.p_O.head<2>());
  if (element < 0 || element >= mesh.size()) return "no element at a contact point";
  FindElements(contact, element);
  footprint->places.clear();
  footprint->arms.clear();
  footprint->point = false;
  footprint->normal_O.head<2>() = normals_[Index(element)];
  // This does not depend on the contact's share of the compliance.
  footprint->patch_error = IsCoarse(contact.width) ? std::numeric_limits<double>::infinity() : 0;
  const int count = greens_.element_nodes().count;
  double length = 0;
  for (const int e : elements_) {
    for (int node = e * count; node < (e + 1) * count; ++node) {
      footprint->places.push_back({node, greens_.lengths()[Index(node)]});
      length += footprint->places.back().weight;
    }
  }
  for (PlaceWeight& place : footprint->places) place.weight /= length;
  if (contact.width > 0 && footprint->places.size() >= kMinForMoment) {
    SetArms(contact, element, footprint);
  }
  return {};
}

void ElementPlaces::FindElements(const Contact& contact, int element) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  elements_.assign(1, element);
  if (contact.width == 0) return;
  const Vector2d place = contact.p_O.head<2>();
  elements_.resize(elements_.capacity());
  const auto count = Index(PatchElements(mesh, element, place, contact.width, elements_));
  if (count > elements_.size()) {
    elements_.resize(count);
    PatchElements(mesh, element, place, contact.width, elements_);
  }
  elements_.resize(count);
}

// The compliance of a strip on a plane body is 2 / (pi E t) ln(c L / width), L its larger side. c
// has little influence; it is 3.3 for the block of paper A, from its stiffness.
bool ElementPlaces::IsCoarse(double width) const {
  constexpr double kBody = 3.3;
  if (width == 0) return false;
  double length = 0;
  for (const int e : elements_) length += greens_.problem().mesh.elements[Index(e)].length();
  const double lacking = std::abs(std::log(length / width));
  return lacking > kMaxOff * std::max(1.0, std::log(kBody * larger_side_ / length));
}

// Computes moment arms as if the patch of whole elements were centred at the contact. They are
// unknown where a support carries a part of the force.
void ElementPlaces::SetArms(const Contact& contact, int element,
                            ContactFootprint* footprint) const {
  const auto off = OffCentre(contact.p_O.head<2>(), element);
  const bool is_free = std::ranges::none_of(footprint->places, [this](const PlaceWeight& at) {
    return greens_.held(at.place, 0) || greens_.held(at.place, 1);
  });
  if (!off || !is_free) return;
  const BoundaryElement& own = greens_.problem().mesh.elements[Index(element)];
  const Vector2d centre = contact.p_O.head<2>() - *off * (own.b - own.a).normalized();
  for (const PlaceWeight& at : footprint->places) {
    const Vector2d arm = greens_.node(at.place).p_O - centre;
    footprint->arms.emplace_back(arm.x(), arm.y(), 0);
  }
}

// Returns the distance along the boundary from the patch's midpoint to the contact's position [m];
// nullopt: its element is not part of the patch.
std::optional<double> ElementPlaces::OffCentre(const Vector2d& p_O, int element) const {
  std::optional<double> before;
  double length = 0;
  for (const int e : elements_) {
    const BoundaryElement& at = greens_.problem().mesh.elements[Index(e)];
    if (e == element) {
      const Vector2d along = (at.b - at.a).normalized();
      before = length + std::clamp(along.dot(p_O - at.a), 0.0, at.length());
    }
    length += at.length();
  }
  if (!before) return std::nullopt;
  return *before - length / 2;
}

}  // namespace palpate
