#include "slave/pipeline/camera/tool_width.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "slave/mechanics/object_mesh.h"

namespace palpate {
namespace {

// Sigma of the remaining error, see tool_width.h: part of the next order in the element length [-].
// [tuned: tool_width_test, the division does not matter]
constexpr double kNext = 0.045;
// Part of the other elements [-]. [tuned: tool_width_test, the division does not matter]
constexpr double kOfBody = 0.0013;
// Part in proportion to the correction for the support [-]. [derived: the slope is 1, 0.86 was
// measured]
constexpr double kSupported = 0.2;

// Returns ln of the supported length in the mesh relative to the arcs' length on a disc; only whole
// elements are supported.
double SupportOf(const BoundaryMesh& mesh, const Scene& scene) {
  if (!std::holds_alternative<DiscGeometry>(scene.object.geometry)) return 0;
  double held = 0, wanted = 0;
  for (const Fixed& fixed : scene.object.fixed) {
    const auto* arc = std::get_if<FixedArc>(&fixed.where);
    if (arc == nullptr || arc->half_angle >= std::numbers::pi) continue;
    Scene alone = scene;
    alone.object.fixed = {fixed};
    const auto count = std::ranges::count_if(FixedElementDofs(alone, mesh),
                                             [](const auto& dofs) { return dofs[0] || dofs[1]; });
    held += 2 * std::numbers::pi * static_cast<double>(count) / mesh.size();
    wanted += 2 * arc->half_angle;
  }
  return held > 0 && wanted > 0 ? std::log(held / wanted) : 0;
}

}  // namespace

void ToolWidth::Share::Correct(ContactResponse* response) const noexcept {
  response->force_O *= factor;
  response->stiffness_O *= factor;
  if (response->moment_O) *response->moment_O *= factor;
  response->moment_sigma *= factor;
}

ToolWidth::ToolWidth(const BoundaryMesh& mesh, const Scene& scene)
    : mesh_(&mesh), width_(scene.tool->width), support_(width_ > 0 ? SupportOf(mesh, scene) : 0) {}

ToolWidth::Share ToolWidth::At(const BoundaryPlace& place, DeformationModel* model) noexcept {
  if (!(width_ > 0) || place.element < 0) return {};
  if (place.element != place_.element || place.p_O != place_.p_O) {
    place_ = place;
    last_ = Find(place, model);
  }
  return last_;
}

// Returns the compliance along the normal [m/N]; 0: unknown.
double ToolWidth::Compliance(const BoundaryPlace& place, double width,
                             DeformationModel* model) const noexcept {
  Contact contact;
  contact.p_O.head<2>() = place.p_O;
  contact.element = place.element;
  contact.width = width;
  ContactResponse response;
  model->Respond(std::span(&contact, 1), std::span(&response, 1));
  const Eigen::Vector2d& n = place.normal_O;
  const double stiffness = n.dot(response.stiffness_O.topLeftCorner<2, 2>() * n);
  return response.validity != Validity::kFailed && stiffness > 0 ? 1 / stiffness : 0;
}

ToolWidth::Share ToolWidth::Find(const BoundaryPlace& place,
                                 DeformationModel* model) const noexcept {
  const double h = mesh_->elements[static_cast<std::size_t>(place.element)].length();
  const double wider = width_ + 2 * h;
  const double C = Compliance(place, width_, model), C_more = Compliance(place, wider, model);
  if (!(C > C_more && C_more > 0)) return {};
  const double slope = (C - C_more) / (C * std::log(wider / width_));  // -d ln C / d ln w
  const double compliance = 1 + slope * support_;
  if (!(compliance > 0)) return {};
  const double next = kNext * (h / width_) * (h / width_);
  return {1 / compliance, std::hypot(kOfBody, slope * std::hypot(next, kSupported * support_))};
}

}  // namespace palpate
