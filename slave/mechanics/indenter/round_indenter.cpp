#include "slave/mechanics/indenter/round_indenter.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMostPulled = 0.3;  // part of the largest pull at which a place lets go
constexpr std::string_view kTooCoarse =
    "the round tool's contact is smaller than the elements: use more elements there";

}  // namespace

std::vector<TouchablePlace> TouchablePlaces(const BoundaryMesh& mesh) {
  std::vector<TouchablePlace> places;
  for (int i = 0; i < mesh.size(); ++i) {
    const Eigen::Vector2d p = mesh.elements[Index(i)].midpoint();
    places.push_back({{p.x(), p.y(), 0}, i});
  }
  return places;
}

std::vector<TouchablePlace> TouchableTriangles(const SurfaceMesh& mesh) {
  std::vector<TouchablePlace> places;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vector3d middle =
        (mesh.nodes[Index(a)] + mesh.nodes[Index(b)] + mesh.nodes[Index(c)]) / 3;
    places.push_back({middle, static_cast<int>(i)});
  }
  return places;
}

std::vector<TouchablePlace> TouchableNodes(const SurfaceMesh& mesh) {
  std::vector<int> triangle_at(mesh.nodes.size(), -1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const int node : mesh.triangles[i]) triangle_at[Index(node)] = static_cast<int>(i);
  }
  std::vector<TouchablePlace> places;
  for (std::size_t node = 0; node < mesh.nodes.size(); ++node) {
    if (triangle_at[node] >= 0) places.push_back({mesh.nodes[node], triangle_at[node]});
  }
  return places;
}

RoundIndenter::RoundIndenter(std::vector<TouchablePlace> places, double radius, ContactLaw law)
    : places_(std::move(places)), radius_(radius), law_(law) {
  RequirePositive("radius", radius);
  if (places_.empty()) throw std::invalid_argument("no boundary point that a tool could touch");
  is_planar_ = std::ranges::all_of(places_, [](const auto& at) { return at.p_O.z() == 0; });
  contacts_.reserve(places_.size());
  responses_.reserve(places_.size());
  moved_.reserve(places_.size());
}

ContactResponse RoundIndenter::Press(const ToolIndentation& press,
                                     DeformationModel* model) noexcept {
  const Vector3d& n = press.normal_O;
  if (!press.p_O.allFinite() || !n.allFinite() || !press.displacement_O.allFinite()) return {};
  Gather(press);
  while (!contacts_.empty()) {
    if (!Query(model)) return {};
    if (!LetGo(n)) break;
  }
  const bool presses = n.dot(press.displacement_O) < 0;
  const auto touched = static_cast<int>(contacts_.size());
  if (touched == 0) TouchNearest(press, presses);
  ContactResponse whole;
  whole.stiffness_O = Stiffness(n, model);
  if (!Query(model)) return {};
  whole.displacement_O = press.displacement_O;
  whole.force_O = Sum();
  whole.validity = Validity::kValid;
  for (const ContactResponse& part : responses_) {
    if (part.validity > whole.validity) whole.doubt = part.doubt;
    whole.validity = Worse(whole.validity, part.validity);
  }
  if (presses && touched < kFewest && whole.validity == Validity::kValid) {
    whole.validity = Validity::kExtrapolated;
    whole.doubt = kTooCoarse;
  }
  return whole;
}

Vector3d RoundIndenter::MomentAbout(const Vector3d& p_O) const noexcept {
  Vector3d moment = Vector3d::Zero();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const ContactResponse& part = responses_[i];
    moment += (contacts_[i].p_O + part.displacement_O - p_O).cross(part.force_O);
  }
  return moment;
}

// All places that the tool would pass through.
void RoundIndenter::Gather(const ToolIndentation& press) noexcept {
  contacts_.clear();
  const Vector3d& n = press.normal_O;
  const double in = -n.dot(press.displacement_O);
  const Vector3d across = press.displacement_O + in * n;
  for (const TouchablePlace& place : places_) {
    const Vector3d from_apex = place.p_O - press.p_O;
    const double height = n.dot(from_apex);
    const double rho2 = (from_apex - height * n).squaredNorm();
    if (!(rho2 < radius_ * radius_)) continue;
    const double rise = rho2 / (radius_ + std::sqrt(radius_ * radius_ - rho2));
    const double delta = height + in - rise;
    if (!(delta > 0)) continue;
    contacts_.push_back(
        {Contact::Kind::kDisplacement, place.p_O, place.element, 0, across - delta * n, false});
  }
}

// Moved with the apex if it presses, between places.
void RoundIndenter::TouchNearest(const ToolIndentation& press, bool presses) noexcept {
  const auto away = [&](const TouchablePlace& at) { return (at.p_O - press.p_O).squaredNorm(); };
  const auto nearest = std::ranges::min_element(places_, {}, away);
  const Vector3d moved = presses ? press.displacement_O : Vector3d(Vector3d::Zero());
  contacts_.push_back(
      {Contact::Kind::kDisplacement, nearest->p_O, nearest->element, 0, moved, false});
}

// Whether some places were pulled, which have let go: those that are pulled most, since with them
// others' pull goes too.
bool RoundIndenter::LetGo(const Vector3d& n) noexcept {
  double most = 0;
  for (const ContactResponse& part : responses_) most = std::max(most, part.force_O.dot(n));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (most > 0 && responses_[i].force_O.dot(n) >= kMostPulled * most) continue;
    contacts_[kept++] = contacts_[i];
  }
  const bool some = kept < contacts_.size();
  contacts_.resize(kept);
  return some;
}

bool RoundIndenter::Query(DeformationModel* model) noexcept {
  responses_.resize(contacts_.size());
  model->Respond(contacts_, responses_);
  return std::ranges::none_of(responses_, [](const ContactResponse& part) {
    return part.validity == Validity::kFailed || !part.force_O.allFinite();
  });
}

Vector3d RoundIndenter::Sum() const noexcept {
  Vector3d force = Vector3d::Zero();
  for (const ContactResponse& part : responses_) force += part.force_O;
  return force;
}

// All that touches is moved alike by one, along n alone where nothing rubs. Of a linear model that
// is the derivative; others are near it where the step is small.
Matrix3d RoundIndenter::Stiffness(const Vector3d& n, DeformationModel* model) noexcept {
  const double step = 1e-6 * radius_;
  moved_.resize(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) moved_[i] = contacts_[i].prescribed_O;
  const auto force_when_moved = [&](const Vector3d& by) {
    for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_[i].prescribed_O = by;
    return Query(model) ? Vector3d(Sum() / step) : Vector3d(Vector3d::Zero());
  };
  Matrix3d K = Matrix3d::Zero();
  if (law_ == ContactLaw::kFrictionless) {
    K = force_when_moved(-step * n).dot(-n) * n * n.transpose();
  } else {
    for (int axis = 0; axis < (is_planar_ ? 2 : 3); ++axis) {
      K.col(axis) = force_when_moved(step * Vector3d::Unit(axis));
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_[i].prescribed_O = moved_[i];
  return K;
}

}  // namespace palpate
