#include "slave/mechanics/bem/element_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kMaxOff = 0.1;  // of the stiffness
// Width by which a flat face is narrower in the mesh, for constant, linear and quadratic elements
// [elements]. [measured: bonded tools on blocks, wedges and discs, with 1.5 to 10 elements under
// the tool, against quadratic finite elements graded to the tool's ends]
constexpr std::array<double, 3> kEnds{0.28, 0.11, 0.06};
constexpr double kTurnsSteadily = 0.9;  // cosine of the angle between elements of a smooth outline
constexpr double kLengthSlack = 1e-9;
constexpr double kSameSide = 0.5;  // cosine of the angle to the tool's axis
constexpr double kDeeper = 1.25;   // than the depth: more places than a round tool touches
// Places under a tool that has touched only some, below which its force is flagged. [measured: a
// round tool's force changes by a hundredth with one place more or less]
constexpr std::size_t kFewest = 3;

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
  if (IsTool(contact)) return FindTool(contact, element, footprint);
  FindElements(contact, element);
  footprint->places.clear();
  footprint->holds.clear();
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

Vector2d ElementPlaces::AxisAt(int element, const Vector2d& p_O) const {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  const BoundaryElement& own = mesh.elements[Index(element)];
  const Vector2d& normal = normals_[Index(element)];
  const auto at_end = [&](int neighbour) -> Vector2d {
    const Vector2d& other = normals_[Index(neighbour)];
    if (normal.dot(other) < kTurnsSteadily) return normal;
    // The shorter element's normal is nearer to the end.
    const double length = mesh.elements[Index(neighbour)].length();
    return (length * normal + own.length() * other).normalized();
  };
  // The normal at the midpoint is the element's.
  const Vector2d along = own.b - own.a;
  const double s = std::clamp(2 * along.dot(p_O - own.a) / along.squaredNorm() - 1, -1.0, 1.0);
  const Vector2d end = at_end(s < 0 ? mesh.Previous(element) : mesh.Next(element));
  return ((1 - std::abs(s)) * normal + std::abs(s) * end).normalized();
}

std::string_view ElementPlaces::FindTool(const Contact& contact, int element,
                                         ContactFootprint* footprint) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  footprint->places.clear();
  footprint->holds.clear();
  footprint->arms.clear();
  footprint->point = false;
  const BoundaryElement& own = mesh.elements[Index(element)];
  Contact touch = contact;
  if (contact.radius == 0) {  // its centre lies on the element; a round tool may have rolled on
    const Vector2d along = own.b - own.a;
    const double at = along.dot(contact.p_O.head<2>() - own.a) / along.squaredNorm();
    touch.p_O.head<2>() = own.a + std::clamp(at, 0.0, 1.0) * along;
  }
  // Springs do not make up for a tool that is shorter than the element.
  const bool is_short = contact.radius == 0 && contact.width < (1 - kLengthSlack) * own.length();
  footprint->patch_error = is_short ? std::numeric_limits<double>::infinity() : 0;
  footprint->normal_O.setZero();
  footprint->normal_O.head<2>() = AxisAt(element, touch.p_O.head<2>());
  footprint->depth = kDeeper * std::max(0.0, -footprint->normal_O.dot(contact.prescribed_O));
  elements_.clear();
  const auto reaches = [&](int e) {
    return normals_[Index(e)].dot(footprint->normal_O.head<2>()) >= kSameSide &&
           AddTouched(touch, e, footprint);
  };
  if (!reaches(element)) return "the tool reaches no element at a contact point";
  int last = mesh.Next(element);
  while (last != element && reaches(last)) last = mesh.Next(last);
  if (last != element) {
    for (int e = mesh.Previous(element); e != last && reaches(e); e = mesh.Previous(e)) {
    }
  }
  double reached = 0;  // elements or their parts
  for (const ToolHold& hold : footprint->holds) reached += hold.share;
  footprint->fewest =
      contact.radius > 0 ? kFewest : std::min(kFewest, static_cast<std::size_t>(reached));
  double whole = 0;
  for (const PlaceWeight& place : footprint->places) whole += place.weight;
  for (PlaceWeight& place : footprint->places) place.weight /= whole;
  const bool is_free = std::ranges::none_of(footprint->places, [this](const PlaceWeight& at) {
    return greens_.held(at.place, 0) || greens_.held(at.place, 1);
  });
  for (const PlaceWeight& at : footprint->places) {
    if (!is_free) break;
    const Vector2d arm = greens_.node(at.place).p_O - touch.p_O.head<2>();
    footprint->arms.emplace_back(arm.x(), arm.y(), 0);
  }
  return {};
}

bool ElementPlaces::AddTouched(const Contact& contact, int element, ContactFootprint* footprint) {
  const BoundaryElement& at = greens_.problem().mesh.elements[Index(element)];
  const ElementNodes& local = greens_.element_nodes();
  const Vector2d n = footprint->normal_O.head<2>(), t(-n.y(), n.x());
  const Vector2d p = contact.p_O.head<2>();
  const double half = (contact.width + kEnds[Index(local.count - 1)] * at.length()) / 2;
  const double R = contact.radius;
  bool is_reached = false;
  double part_begin = 0;  // of the element
  for (int m = 0; m < local.count; ++m) {
    const int node = element * local.count + m;
    const double part_end = part_begin + local.weight[Index(m)];
    const Vector2d from = greens_.node(node).p_O - p;
    const double height = n.dot(from);
    ToolHold hold;
    if (R > 0) {
      const double rho2 = t.dot(from) * t.dot(from);
      hold.gap = rho2 < R * R ? std::max(0.0, rho2 / (R + std::sqrt(R * R - rho2)) - height)
                              : std::numeric_limits<double>::infinity();
      is_reached = is_reached || hold.gap <= footprint->depth;
    } else {
      const double x0 = t.dot(at.a + part_begin * (at.b - at.a) - p);
      const double x1 = t.dot(at.a + part_end * (at.b - at.a) - p);
      const double low = std::max(std::min(x0, x1), -half), high = std::min(std::max(x0, x1), half);
      hold.gap = std::max(0.0, -height);
      hold.share = std::clamp((high - low) / std::abs(x1 - x0), 0.0, 1.0);
      is_reached = is_reached || hold.share >= kLeastShare;
    }
    part_begin = part_end;
    if (hold.share < kLeastShare || std::isinf(hold.gap)) continue;
    if (hold.gap > footprint->depth && R > 0 && !elements_.empty()) continue;
    footprint->places.push_back({node, hold.share * greens_.lengths()[Index(node)]});
    footprint->holds.push_back(hold);
  }
  const bool is_first = elements_.empty();
  elements_.push_back(element);
  return is_reached || is_first;
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
