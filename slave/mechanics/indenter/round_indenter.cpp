#include "slave/mechanics/indenter/round_indenter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Error of the moment relative to force times contact width divided by the number of places [-].
// [derived: one place more or less at the rim, where the pressure is smallest]
constexpr double kSpreadByPlaces = 0.5;
// Largest overlap of a free place with the tool, relative to the tool's displacement [-]: smaller
// ones are discretisation errors of the pressure at the rim. [derived]
constexpr double kInside = 0.01;
// Share of the largest pulling force above which a place is released.
constexpr double kMaxPulled = 0.3;
constexpr std::string_view kTooCoarse =
    "the round tool's contact is smaller than the elements: press more deeply, or use more "
    "elements "
    "there";

constexpr std::string_view kPenetrates =
    "places that let go of the round tool are pressed against it again";
// Half the step of the central difference, relative to the displacement [-]: it is so large that
// the iteration's error, 1e-3 of the force, changes the quotient by a few percent, and so small
// that curvature changes it by less than one percent. [derived; round_indenter_test]
constexpr double kStep = 0.03;

const Vector3d kUnknown = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

bool IsKnown(std::span<const ContactResponse> responses) {
  return std::ranges::none_of(responses, [](const ContactResponse& part) {
    return part.validity == Validity::kFailed || !part.force_O.allFinite();
  });
}

Vector3d SumOfForces(std::span<const ContactResponse> responses) {
  Vector3d force = Vector3d::Zero();
  for (const ContactResponse& part : responses) force += part.force_O;
  return force;
}

}  // namespace

std::vector<TouchablePlace> TouchablePlaces(const BoundaryMesh& mesh) {
  std::vector<TouchablePlace> places;
  for (int i = 0; i < mesh.size(); ++i) {
    const Eigen::Vector2d p = mesh.elements[Index(i)].midpoint();
    places.push_back({{p.x(), p.y(), 0}, i});
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

std::vector<TouchablePlace> TouchableMiddles(const SurfaceMesh& mesh) {
  std::set<std::pair<int, int>> seen;  // edges
  std::vector<TouchablePlace> places;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& corners = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto edge = std::minmax(corners[k], corners[(k + 1) % 3]);
      if (!seen.emplace(edge).second) continue;
      places.push_back({0.5 * (mesh.nodes[Index(edge.first)] + mesh.nodes[Index(edge.second)]),
                        static_cast<int>(i)});
    }
  }
  return places;
}

RoundIndenter::RoundIndenter(std::vector<TouchablePlace> places, double radius, ContactLaw law)
    : places_(std::move(places)), radius_(radius), law_(law) {
  RequirePositive("radius", radius);
  if (places_.empty()) throw std::invalid_argument("no boundary point that a tool could touch");
  is_planar_ = std::ranges::all_of(places_, [](const auto& at) { return at.p_O.z() == 0; });
  for (auto* contacts : {&contacts_, &released_, &varied_}) contacts->reserve(places_.size());
  responses_.reserve(places_.size());
}

ContactResponse RoundIndenter::Press(const ToolIndentation& press, DeformationModel* model,
                                     Solution* solution) noexcept {
  const Vector3d& n = press.normal_O;
  if (!press.p_O.allFinite() || !n.allFinite() || !press.displacement_O.allFinite()) return {};
  const auto solve = [&] {
    model->Solve(contacts_, solution);
    return IsKnown(solution->responses());
  };
  Gather(press);
  released_.clear();
  bool was_taken_back = false, penetrates = false;
  while (!contacts_.empty()) {
    if (!solve()) return {};
    if (LetGo(n, *solution)) continue;
    const std::size_t inside = SortReleased(press, model);
    penetrates = inside > 0;
    if (!penetrates || std::exchange(was_taken_back, true)) break;
    contacts_.insert(contacts_.end(), released_.begin(),
                     released_.begin() + static_cast<long>(inside));
    released_.erase(released_.begin(), released_.begin() + static_cast<long>(inside));
  }
  const bool presses = n.dot(press.displacement_O) < 0;
  const auto touched = static_cast<int>(contacts_.size());
  if (touched == 0) {
    TouchNearest(press, presses);
    if (!solve()) return {};
  }
  ContactResponse whole;
  whole.displacement_O = press.displacement_O;
  whole.force_O = SumOfForces(solution->responses());
  whole.stiffness_O = Stiffness(press, model);
  whole.validity = Validity::kValid;
  for (const ContactResponse& part : solution->responses()) {
    if (part.validity > whole.validity) whole.flag_reason = part.flag_reason;
    whole.validity = Worse(whole.validity, part.validity);
  }
  if (penetrates && whole.validity == Validity::kValid) {
    whole.validity = Validity::kExtrapolated;
    whole.flag_reason = kPenetrates;
  }
  const int fewest = is_planar_ ? kMinTouched : kMinTouchedInSpace;
  if (presses && touched < fewest && whole.validity == Validity::kValid) {
    whole.validity = Validity::kExtrapolated;
    whole.flag_reason = kTooCoarse;
  }
  if (presses && touched >= kMinTouched) SetMoment(press, *solution, &whole);
  return whole;
}

void RoundIndenter::SetMoment(const ToolIndentation& press, const Solution& solution,
                              ContactResponse* whole) {
  whole->moment_O = MomentAbout(solution, press.p_O + press.displacement_O);
  double reach = 0;
  for (const Contact& contact : solution.contacts()) {
    reach = std::max(reach, (contact.p_O - press.p_O).norm());
  }
  const auto count = static_cast<double>(solution.contacts().size());
  whole->moment_sigma = kSpreadByPlaces * 2 * reach / count * whole->force_O.norm();
}

// Collects all places that would be inside the tool.
void RoundIndenter::Gather(const ToolIndentation& press) noexcept {
  contacts_.clear();
  const Vector3d& n = press.normal_O;
  const double in = -n.dot(press.displacement_O);
  const Vector3d across = press.displacement_O + in * n;
  for (const TouchablePlace& place : places_) {
    const Vector3d from_first = place.p_O - press.p_O;
    const double height = n.dot(from_first);
    const double rho2 = (from_first + press.rolled_O - height * n).squaredNorm();
    if (!(rho2 < radius_ * radius_)) continue;
    const double rise = rho2 / (radius_ + std::sqrt(radius_ * radius_ - rho2));
    const double delta = height + in - rise;
    if (!(delta > 0)) continue;
    contacts_.push_back(
        {Contact::Kind::kDisplacement, place.p_O, place.element, 0, across - delta * n, false});
  }
}

// If the tool presses between places, the nearest one is moved with it.
void RoundIndenter::TouchNearest(const ToolIndentation& press, bool presses) noexcept {
  const auto away = [&](const TouchablePlace& at) { return (at.p_O - press.p_O).squaredNorm(); };
  const auto nearest = std::ranges::min_element(places_, {}, away);
  const Vector3d moved = presses ? press.displacement_O : Vector3d(Vector3d::Zero());
  contacts_.push_back(
      {Contact::Kind::kDisplacement, nearest->p_O, nearest->element, 0, moved, false});
}

// Releases pulled places and returns whether there were any. Only those with the largest pull are
// released, because this often removes the pull at others.
bool RoundIndenter::LetGo(const Vector3d& n, const Solution& solution) noexcept {
  const std::vector<ContactResponse>& parts = solution.responses();
  double most = 0;
  for (const ContactResponse& part : parts) most = std::max(most, part.force_O.dot(n));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (most > 0 && parts[i].force_O.dot(n) >= kMaxPulled * most) {
      released_.push_back(contacts_[i]);
    } else {
      contacts_[kept++] = contacts_[i];
    }
  }
  const bool some = kept < contacts_.size();
  contacts_.resize(kept);
  return some;
}

std::size_t RoundIndenter::SortReleased(const ToolIndentation& press,
                                        DeformationModel* model) noexcept {
  if (released_.empty()) return 0;
  varied_ = contacts_;
  for (Contact contact : released_) {
    contact.kind = Contact::Kind::kForce;
    contact.prescribed_O.setZero();
    varied_.push_back(contact);
  }
  responses_.resize(varied_.size());
  model->Respond(varied_, responses_);
  if (!IsKnown(responses_)) return 0;
  const double most = kInside * press.displacement_O.norm();
  std::size_t inside = 0;
  for (std::size_t i = 0; i < released_.size(); ++i) {
    const Eigen::Vector3d& u = responses_[contacts_.size() + i].displacement_O;
    if (press.normal_O.dot(u - released_[i].prescribed_O) <= most) continue;
    std::swap(released_[inside++], released_[i]);
  }
  return inside;
}

// Computes the stiffness by moving all touching places forward and back together; without friction
// only along n.
Matrix3d RoundIndenter::Stiffness(const ToolIndentation& press, DeformationModel* model) noexcept {
  const Vector3d& n = press.normal_O;
  const double step = std::max(kStep * press.displacement_O.norm(), 1e-6 * radius_);
  responses_.resize(contacts_.size());
  const auto force_at = [&](const Vector3d& moved) -> Vector3d {
    varied_ = contacts_;
    for (Contact& contact : varied_) contact.prescribed_O += moved;
    model->Respond(varied_, responses_);
    return IsKnown(responses_) ? SumOfForces(responses_) : kUnknown;
  };
  const auto force_by = [&](const Vector3d& direction) -> Vector3d {
    const Vector3d change = force_at(step * direction) - force_at(-step * direction);
    return change.allFinite() ? Vector3d(change / (2 * step)) : Vector3d::Zero();
  };
  Matrix3d K = Matrix3d::Zero();
  if (law_ == ContactLaw::kFrictionless) {
    K = force_by(-n).dot(-n) * n * n.transpose();
  } else {
    for (int axis = 0; axis < (is_planar_ ? 2 : 3); ++axis) {
      K.col(axis) = force_by(Vector3d::Unit(axis));
    }
  }
  return K;
}

Vector3d MomentAbout(const Solution& solution, const Vector3d& p_O) noexcept {
  Vector3d moment = Vector3d::Zero();
  for (std::size_t i = 0; i < solution.contacts().size(); ++i) {
    const ContactResponse& part = solution.responses()[i];
    moment += (solution.contacts()[i].p_O + part.displacement_O - p_O).cross(part.force_O);
  }
  return moment;
}

}  // namespace palpate
