#include "slave/pipeline/camera/touch_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "shared/mesh/boundary_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {

namespace {

constexpr std::array<double, 3> kEnds{0.28, 0.11, 0.06};  // constant, linear, quadratic [elements]
constexpr double kLeft = 0.05;                            // sigma of these [elements]
constexpr double kOfBody = 0.002;                         // and of the elements elsewhere
constexpr double kStretched = 0.05;  // of what is put right, where that is much
constexpr std::size_t kMostElements = 256;

}  // namespace

TouchModel::TouchModel(const Scene& scene, const std::optional<Outline>& seen, Progress* progress)
    : law(scene.model.contact),
      mesh(MeshOutline(scene, seen)),
      deformation(MakeModel(scene, mesh, progress)),
      contact(std::make_unique<BoundaryContact>(mesh)),
      probe(std::make_unique<BoundaryContact>(mesh)),
      held(HeldVertices(scene, mesh)),
      tool_width_(scene.tool->width) {
  if (scene.tool->shape == Tool::Shape::kRound) {
    indenter = std::make_unique<RoundIndenter>(TouchablePlaces(mesh), scene.tool->radius, law);
  } else {
    width_.emplace(mesh, scene);
  }
}

ContactResponse TouchModel::Solve(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
                                  Solution* solution) noexcept {
  if (!indenter) return SolveFlat(place, displacement_O, solution);
  const ToolIndentation at{Planar(place.p_O), Planar(place.normal_O), displacement_O};
  return indenter->Press(at, deformation.get(), solution);
}

ContactResponse TouchModel::SolveFlat(const BoundaryPlace& place,
                                      const Eigen::Vector3d& displacement_O,
                                      Solution* solution) noexcept {
  const double factor = WidthAt(place).factor;
  const Contact touch{Contact::Kind::kDisplacement, Planar(place.p_O), place.element, tool_width_,
                      displacement_O};
  deformation->Solve({&touch, 1}, solution);
  ContactResponse response = solution->responses().front();
  response.force_O *= factor;
  response.stiffness_O *= factor;
  return response;
}

bool TouchModel::FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
                         std::vector<Eigen::Vector3d>* field) noexcept {
  const bool presses = displacement_O.dot(Planar(place.normal_O)) != 0;
  const ContactResponse response =
      presses ? Respond(place, displacement_O) : SolveFlat(place, displacement_O, &asked_);
  if (response.validity == Validity::kFailed) return false;
  deformation->Displacements(asked_, field);
  return true;
}

ToolWidth::Share TouchModel::WidthAt(const BoundaryPlace& place) noexcept {
  return width_ ? width_->At(place, deformation.get()) : ToolWidth::Share{};
}

double TouchModel::SecantPart(const ContactResponse& response,
                              const BoundaryPlace& place) const noexcept {
  const Eigen::Vector3d n = Planar(place.normal_O);
  const double linear = n.dot(response.stiffness_O * n) * -place.gap;
  if (!indenter || !(linear > 0)) return 1;
  return std::clamp(-response.force_O.dot(n) / linear, 0.0, 1.0);
}

Eigen::Matrix3d StiffnessInSlave(const ContactResponse& response,
                                 const Eigen::Isometry3d& X_SO) noexcept {
  const Eigen::Matrix3d& R = X_SO.linear();
  if (response.validity == Validity::kFailed) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d K_O = 0.5 * (response.stiffness_O + response.stiffness_O.transpose());
  return R * K_O * R.transpose();
}

ToolWidth::ToolWidth(const BoundaryMesh& mesh, const Scene& scene)
    : mesh_(&mesh),
      width_(scene.model.wall > 0 ? 0 : scene.tool->width),
      ends_(kEnds[static_cast<std::size_t>(scene.model.order)]) {}

ToolWidth::Share ToolWidth::At(const BoundaryPlace& place, DeformationModel* model) noexcept {
  if (!(width_ > 0) || place.element < 0) return {};
  if (place.element != place_.element || place.p_O != place_.p_O) {
    place_ = place;
    last_ = Find(place, model);
  }
  return last_;
}

// Of the patch's elements; 0: too many.
double ToolWidth::LengthOf(const BoundaryPlace& place, double width) const noexcept {
  std::array<int, kMostElements> patch;
  const int count = PatchElements(*mesh_, place.element, place.p_O, width, patch);
  if (count > static_cast<int>(patch.size())) return 0;
  double length = 0;
  for (int i = 0; i < count; ++i) {
    length +=
        mesh_->elements[static_cast<std::size_t>(patch[static_cast<std::size_t>(i)])].length();
  }
  return length;
}

// Along the normal [m/N]; 0: not known.
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
  const double own = LengthOf(place, width_) - ends_ * h, more = LengthOf(place, wider) - ends_ * h;
  const double C = Compliance(place, width_, model), C_more = Compliance(place, wider, model);
  if (!(own > 0 && more > own && C > C_more && C_more > 0)) return {};
  const double slope = (C - C_more) / (C * std::log(more / own));  // -d ln C / d ln w
  const double wanted = std::log(width_ / own);
  const double compliance = 1 - slope * wanted;
  if (!(compliance > 0)) return {};
  return {1 / compliance,
          std::hypot(kOfBody, slope * kLeft * h / width_, kStretched * slope * wanted)};
}

}  // namespace palpate
