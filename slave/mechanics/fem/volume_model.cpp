#include "slave/mechanics/fem/volume_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kAbsurd = 1e6;         // larger sides
constexpr std::size_t kTextSize = 240;  // of a remark
// Smallest number of nodes under a tool other than a disc for an accuracy of 10 %. [measured:
// round_indenter_test]
constexpr int kMinTouched = 8;
// Smallest number of nodes for the moment of a tool's force, and its error relative to force times
// width divided by the number of nodes: one node more or less at the rim, where the pressure is
// smallest.
constexpr int kMinOfMoment = 4;
constexpr double kMomentSpread = 0.5;
// Error of a flat face that holds whole nodes, without springs at its rim [-]. [measured: ten-node
// tetrahedra under a disc of four elements, 8 to 9 % too soft]
constexpr double kOfWholeNodes = 0.08;

}  // namespace

VolumeModel::VolumeModel(const SolidMesh& mesh, const HeldNodes& held, const Traits& traits)
    : traits_(traits),
      contacts_(mesh, traits.nodes_per_element, held, traits.length_unit, traits.force_unit,
                traits.finds_tools),
      // If the pressure is a separate unknown, only bending is evaluated.
      strain_(MakeTetMesh(mesh, traits.nodes_per_element, traits.length_unit),
              traits.has_pressure ? HeldNodes{} : held,
              traits.has_pressure ? 0 : traits.poisson_ratio),
      u_(contacts_.node_count()) {
  field_mesh_ = {.vertices = mesh.nodes, .tets = mesh.tets};
  keeps_displacements_ = true;
  info_.kind = "fem";
  info_.elements = static_cast<int>(mesh.tets.size());
  info_.range = traits.range;
  info_.step = traits.step;
}

void VolumeModel::SetRemark(std::string remark) {
  remark_ = std::move(remark);
  info_.remark.reserve(kTextSize);
  info_.remark = remark_;
}

void VolumeModel::Reset() {
  failure_ = {};
  inversion_ = {};
  Rest();
}

void VolumeModel::ComputeResponses(std::span<const Contact> contacts,
                                   std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  std::ranges::fill(responses, ContactResponse{});
  bool answered = false;
  try {
    answered = contacts.size() == responses.size()
                   ? TryRespond(contacts, responses)
                   : Fail("the number of responses and contacts must be equal");
  } catch (const std::exception&) {
    contacts_.Forget();
    if (!traits_.is_dynamic) Rest();
    Fail("out of memory");
  }
  if (answered) return;
  std::ranges::fill(responses, ContactResponse{});
  inversion_ = {};
}

bool VolumeModel::TryRespond(std::span<const Contact> contacts,
                             std::span<ContactResponse> responses) {
  if (!PrepareSet(contacts) || !SolveUnder(contacts)) {
    if (!traits_.is_dynamic && !follows_path()) Rest();
    return false;
  }
  if (TakeState() && FillResponses(contacts, responses)) return true;
  TakeBack();
  if (!traits_.is_dynamic && !follows_path()) Rest();
  return false;
}

bool VolumeModel::FillResponses(std::span<const Contact> contacts,
                                std::span<ContactResponse> responses) {
  RemarkInversion();
  AssessMesh(contacts);
  const std::string_view flag_reason = FlagReasonOf();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ContactResponse response = ResponseOf(k, contacts[k]);
    CorrectForMesh(k, contacts[k], &response);
    if (!response.force_O.allFinite()) return Fail("the solution is not finite");
    response.flag_reason =
        flag_reason.empty() ? FlagReasonOfPlace(k, contacts[k], response) : flag_reason;
    response.validity = response.flag_reason.empty() ? Validity::kValid : Validity::kExtrapolated;
    responses[k] = response;
  }
  return true;
}

std::string_view VolumeModel::FlagReasonOfPlace(std::size_t contact, const Contact& at,
                                                const ContactResponse& response) const {
  const fem::ToolContact* tool = ToolOf(contact);
  if (tool == nullptr && !places()[contact].holds.empty()) {
    if (!settles()) return kNotSettled;
    if (!contacts_.TouchesFew(contact, Touching(contact), response)) return {};
    return places()[contact].patch_error > 0 ? kCoarsePatch : kFewTouched;
  }
  if (tool == nullptr) {
    if (locks() && WidthOfTouch(at) == 0) return kLocking;
    if (contacts_.IsCoarse(contact, response)) return kCoarsePatch;
    return places()[contact].on_support ? kOnSupport : std::string_view();
  }
  if (!tool->settles()) return "which nodes the tool touches did not settle";
  if (tool->shares()) return "two contacts touch the same nodes";
  if (tool->touching() == 0) return tool->depth() > 0 ? kCoarsePatch : std::string_view();
  const bool coarse =
      tool->is_disc() ? contacts_.IsCoarse(contact, response) : tool->touching() < kMinTouched;
  return coarse ? kCoarsePatch : std::string_view();
}

bool VolumeModel::PrepareSet(std::span<const Contact> contacts) {
  if (!contacts_.Prepare(contacts)) return Fail(contacts_.failure());
  if (contacts_.change() == VolumeContacts::Change::kNone) return true;
  touched_.clear();
  for (const ContactPlace& place : places()) {
    for (const PlaceWeight& node : place.nodes) touched_.push_back(node.place);
  }
  if (contacts_.change() == VolumeContacts::Change::kLoads || Hold(contacts)) return true;
  contacts_.Forget();
  return false;
}

bool VolumeModel::TakeState() {
  double largest_square = 0;
  for (std::size_t i = 0; i < u_.size(); ++i) {
    u_[i] = DisplacementAt(static_cast<int>(i));
    const double square = u_[i].squaredNorm();
    if (!(square <= kAbsurd * kAbsurd)) return Fail("the solution is too large or not finite");
    largest_square = std::max(largest_square, square);
  }
  largest_ = std::sqrt(largest_square);
  inversion_ = FindInversion();
  return true;
}

bool VolumeModel::locks() const {
  return traits_.nodes_per_element == 4 && !traits_.has_pressure &&
         traits_.poisson_ratio >= kLocksAtPoint;
}

void VolumeModel::AssessMesh(std::span<const Contact> contacts) {
  // Without load the remaining strain is an error of the solution.
  const bool acts = traits_.is_dynamic || traits_.weighs ||
                    std::ranges::any_of(contacts, [](const Contact& contact) {
                      return contact.prescribed_O != Vector3d::Zero();
                    });
  strain_.Take(u_);
  softness_ = acts ? strain_.Softness(touched_) : 0;
}

// A contact at a point has no limit for smaller elements, and so no error of the mesh.
void VolumeModel::CorrectForMesh(std::size_t contact, const Contact& at,
                                 ContactResponse* response) {
  const double width = WidthOfTouch(at);
  if (width == 0) return;
  const double work = response->force_O.dot(response->displacement_O);
  const MeshShare share =
      strain_.ShareNear(contact, {at.p_O / traits_.length_unit, width / traits_.length_unit},
                        work / (traits_.force_unit * traits_.length_unit));
  if (at.kind == Contact::Kind::kForce) {
    response->mesh_error = EffectOnLoad(share).error * response->displacement_O.norm();
    response->displacement_error += response->mesh_error;
    return;
  }
  const auto elements = traits_.nodes_per_element == 10 ? Elements::kTenNodes
                        : traits_.has_pressure          ? Elements::kFourNodesMixed
                                                        : Elements::kFourNodes;
  MeshEffect effect = EffectOf(share, {response->spring_share, response->touching}, elements);
  if (!places()[contact].holds.empty() && at.radius == 0) effect.error += kOfWholeNodes;
  Correct(effect, response);
}

// Returns why the last answer is extrapolated; empty: it is not, except for reasons of single
// patches.
std::string_view VolumeModel::FlagReasonOf() const {
  if (inversion_.elements > 0) return "elements are inside out";
  if (traits_.range > 0 && largest_ > traits_.range) return kBeyondRange;
  if (ended_early()) return "the deadline came before the residual";
  if (gained_energy()) return "the time step gained energy";
  return softness_ > kMaxSoftness ? kStiffInBending : std::string_view();
}

void VolumeModel::RemarkInversion() {
  info_.remark.clear();
  if (inversion_.elements > 0) {
    std::array<char, kTextSize> text{};
    std::snprintf(text.data(), text.size(), "%d elements are inside out, the first is %d%s",
                  inversion_.elements, inversion_.first, remark_.empty() ? "" : "; ");
    info_.remark.assign(text.data());
  }
  info_.remark.append(remark_);
}

ContactResponse VolumeModel::ResponseOf(std::size_t contact, const Contact& at) const {
  const ContactPlace& place = places()[contact];
  const bool moves = at.kind == Contact::Kind::kDisplacement;
  const auto force_at = [&](std::size_t i) -> Vector3d {
    const auto& [node, weight] = place.nodes[i];
    return moves ? Vector3d(traits_.force_unit * ReactionAt(node))
                 : Vector3d(weight * at.prescribed_O);
  };
  if (const fem::ToolContact* tool = ToolOf(contact)) {
    ContactResponse response = ToolResponse(*tool, at);
    response.force_error = traits_.force_unit * ErrorOf(contact);
    return response;
  }
  ContactResponse response;
  response.force_O = response.displacement_O = at.prescribed_O;
  if (moves) {
    response.force_error = traits_.force_unit * ErrorOf(contact);
  } else {
    response.displacement_error = traits_.length_unit * ErrorOf(contact);
  }
  if (!moves) {
    response.displacement_O.setZero();
    for (const auto& [node, weight] : place.nodes) {
      response.displacement_O += traits_.length_unit * weight * u_[Index(node)];
    }
  } else if (place.is_point) {
    response.force_O = traits_.force_unit * PointForce(contact);
  } else {
    response.force_O.setZero();
    for (std::size_t i = 0; i < place.nodes.size(); ++i) response.force_O += force_at(i);
  }
  if (!place.holds.empty()) response.touching = Touching(contact);
  SetMoment(place.arms, at.width, force_at, &response);
  return response;
}

ContactResponse VolumeModel::ToolResponse(const fem::ToolContact& tool, const Contact& at) const {
  ContactResponse response;
  response.displacement_O = at.prescribed_O;
  response.force_O = traits_.force_unit * tool.force();
  const double work = tool.force().dot(tool.displacement());
  response.touching = tool.touching();
  response.spring_share = work > 0 ? tool.spring_work() / work : 0;
  if (tool.touching() < kMinOfMoment) return response;
  response.moment_O = traits_.force_unit * traits_.length_unit * tool.moment();
  response.moment_sigma = kMomentSpread * 2 * traits_.length_unit * tool.reach() / tool.touching() *
                          response.force_O.norm();
  return response;
}

void VolumeModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->resize(field_mesh_.vertices.size());
  for (std::size_t i = 0; i < u_O->size(); ++i) {
    (*u_O)[i] = traits_.length_unit * DisplacementAt(static_cast<int>(i));
  }
}

}  // namespace palpate
