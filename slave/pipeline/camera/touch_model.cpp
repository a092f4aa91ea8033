#include "slave/pipeline/camera/touch_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {
namespace {

// Relative error of a round tool's force times the number of elements that it touches [-].
// [measured: 416 presses of blocks, wedges and discs with 180 and 360 elements, 3 to 8 of them
// touched, against 1600 elements: rms]
constexpr double kRoundError = 0.035;
// Largest distance at which the place of a tip is prepared, in widths of the tool. [by definition]
constexpr double kNearWidths = 2;

}  // namespace

TouchModel::TouchModel(const Scene& scene, std::shared_ptr<const Outline> found_outline,
                       Progress* progress)
    : TouchModel(scene,
                 MeshOutline(scene, found_outline ? std::optional(*found_outline) : std::nullopt),
                 nullptr, progress) {
  outline = std::move(found_outline);
}

TouchModel::TouchModel(const Scene& scene, BoundaryMesh outline,
                       std::unique_ptr<DeformationModel> model, Progress* progress)
    : law(scene.model.contact),
      mesh(std::move(outline)),
      deformation(model ? std::move(model) : MakeModel(scene, mesh, progress)),
      domain(scene, *scene.tool, mesh),
      held(HeldVertices(scene, mesh)),
      prepares_places_(!KindOf(scene).is_plane),
      tool_width_(scene.tool->width) {
  if (scene.tool->shape == Tool::Shape::kRound) {
    RequirePositive("radius", scene.tool->radius);
    tool_radius_ = scene.tool->radius;
  } else if (!prepares_places_) {
    width_.emplace(mesh, scene);
  }
  contact = std::make_unique<BoundaryContact>(mesh, radius());
  probe = std::make_unique<BoundaryContact>(mesh, radius());
  if (prepares_places_) PrepareUnder(scene.object.X_SO.inverse() * scene.manipulator.home);
}

void TouchModel::PrepareUnder(const Eigen::Vector3d& p_O_tip) noexcept {
  BoundaryPlace place = probe->Move(p_O_tip.head<2>());
  probe->Reset();
  place.gap = 0;
  const Eigen::Vector3d n = Planar(place.normal_O);
  stiffness_at_home = n.dot(Respond(place, {}).stiffness_O * n);
}

// Whole elements are too coarse only if the tool covers fewer than two.
Contact TouchModel::ContactAt(const BoundaryPlace& place) noexcept {
  Contact touch{Contact::Kind::kDisplacement, Planar(place.p_O), place.element, tool_width_, {}};
  if (!prepares_places_) return touch;
  if (place.gap > kNearWidths * tool_width_ && prepared_.element >= 0) return prepared_;
  touch.p_O = Planar(mesh.elements[static_cast<std::size_t>(place.element)].midpoint());
  prepared_ = touch;
  return touch;
}

ContactResponse TouchModel::Solve(const BoundaryPlace& place, const ToolMotion& motion,
                                  Solution* solution) noexcept {
  ContactResponse response = Answer(place, motion, solution);
  domain.FlagOutside({.p_O = Planar(place.p_O),
                      .element = place.element,
                      .width = tool_width_,
                      .prescribed_O = motion.displacement_O},
                     &response);
  return response;
}

ContactResponse TouchModel::Answer(const BoundaryPlace& place, const ToolMotion& motion,
                                   Solution* solution) noexcept {
  if (!is_round()) return SolveFlat(place, motion.displacement_O, solution);
  // The circle's lowest point is below its centre.
  const Contact touch{.p_O = Planar(place.p_O) - motion.rolled_O,
                      .element = place.element,
                      .prescribed_O = motion.displacement_O,
                      .radius = tool_radius_};
  deformation->Solve({&touch, 1}, solution);
  ContactResponse response = solution->responses().front();
  // The moment about the point that touched first.
  if (response.moment_O) *response.moment_O -= motion.rolled_O.cross(response.force_O);
  return response;
}

ContactResponse TouchModel::SolveFlat(const BoundaryPlace& place,
                                      const Eigen::Vector3d& displacement_O,
                                      Solution* solution) noexcept {
  const ToolWidth::Share width = WidthAt(place);
  Contact touch = ContactAt(place);
  touch.prescribed_O = displacement_O;
  deformation->Solve({&touch, 1}, solution);
  ContactResponse response = solution->responses().front();
  width.Correct(&response);
  return response;
}

bool TouchModel::FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
                         std::vector<Eigen::Vector3d>* field) noexcept {
  const bool presses = displacement_O.dot(Planar(place.normal_O)) != 0;
  const ContactResponse response = presses
                                       ? Respond(place, {displacement_O, Eigen::Vector3d::Zero()})
                                       : SolveFlat(place, displacement_O, &asked_);
  if (response.validity == Validity::kFailed) return false;
  deformation->Displacements(asked_, field);
  return true;
}

ToolWidth::Share TouchModel::WidthAt(const BoundaryPlace& place) noexcept {
  return width_ ? width_->At(place, deformation.get()) : ToolWidth::Share{};
}

double TouchModel::RoundSigma(const ContactResponse& response) const noexcept {
  return is_round() && response.touching > 0 ? kRoundError / response.touching : 0;
}

double TouchModel::SecantPart(const ContactResponse& response,
                              const BoundaryPlace& place) const noexcept {
  const Eigen::Vector3d n = Planar(place.normal_O);
  const double linear = n.dot(response.stiffness_O * n) * -place.gap;
  if (!(linear > 0)) return 1;
  return std::clamp(-response.force_O.dot(n) / linear, 0.0, 1.0);
}

Eigen::Matrix3d StiffnessInSlave(const ContactResponse& response,
                                 const Eigen::Isometry3d& X_SO) noexcept {
  const Eigen::Matrix3d& R = X_SO.linear();
  if (response.validity == Validity::kFailed) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d K_O = 0.5 * (response.stiffness_O + response.stiffness_O.transpose());
  return R * K_O * R.transpose();
}

}  // namespace palpate
