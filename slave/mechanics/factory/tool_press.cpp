#include "slave/mechanics/factory/tool_press.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <variant>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"

namespace palpate {
namespace {

// Largest ring radius relative to l: the deflection under its load differs by 2 % from that of a
// point: c^2 (1 + 2 ln(l / c)) / l^2. [derived]
constexpr double kWidestRing = 0.06;
constexpr double kDeepestSink = 0.02;  // of the deflection

}  // namespace

bool IsTouchedRound(const Scene& scene) {
  return scene.tool && scene.tool->shape == Tool::Shape::kRound && !IsSkin(scene.object.geometry);
}

ToolPress::ToolPress(const Scene& scene, const Tool& tool, const ObjectMesh& mesh)
    : domain_(scene, tool, mesh), is_rigid_face_(tool.IsRigidFace()) {
  if (tool.shape != Tool::Shape::kRound || ShapesTool(scene)) return;
  if (MovesInTime(scene)) {
    throw std::invalid_argument(
        "tool.shape = round: expected flat with a model that moves in time");
  }
  if (std::holds_alternative<MembraneDisc>(mesh)) {
    const auto& disc = std::get<MembraneDisc>(mesh);
    const double nu = scene.object.material.poisson_ratio;
    const double modulus = scene.object.material.young_modulus / (1 - nu * nu);
    plate_ = {disc.radius, modulus * std::pow(disc.thickness, 3) / 12, modulus, tool.radius};
    return;
  }
  RequirePositive("radius", tool.radius);
  radius_ = tool.radius;
}

ContactResponse ToolPress::Press(const Contact& contact, DeformationModel* model,
                                 Solution* solution) noexcept {
  Contact touch = contact;
  touch.is_rigid = is_rigid_face_;
  ContactResponse response = Answer(touch, model, solution);
  domain_.FlagOutside(touch, &response);
  return response;
}

ContactResponse ToolPress::Answer(const Contact& contact, DeformationModel* model,
                                  Solution* solution) noexcept {
  Contact touch = contact;
  touch.radius = radius_;
  if (plate_ || radius_ > 0) touch.width = 0;
  model->Solve({&touch, 1}, solution);
  ContactResponse response = solution->responses().front();
  if (plate_) CheckPoint(&response);
  return response;
}

void ToolPress::CheckPoint(ContactResponse* response) const noexcept {
  if (response->validity != Validity::kValid) return;
  const double force = std::abs(response->force_O.z()),
               depth = std::abs(response->displacement_O.z());
  const double ring =
      std::exp(-4 * std::numbers::pi * plate_->rigidity / (force * plate_->tool_radius));
  const double sunk =
      std::cbrt(9 * force * force / (16 * plate_->modulus * plate_->modulus * plate_->tool_radius));
  if (ring <= kWidestRing && sunk <= kDeepestSink * depth) return;
  response->validity = Validity::kExtrapolated;
  response->flag_reason = kPointOnPlate;
}

}  // namespace palpate
