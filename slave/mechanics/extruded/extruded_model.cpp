#include "slave/mechanics/extruded/extruded_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/mechanics/extruded/pressed_prism.h"
#include "slave/mechanics/extruded/tool_on_outline.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"
#include "slave/scene/model_kinds.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAbsurd = 1e6;  // larger sides

// Shortens the tool by `excess` at its ends through the thickness, except where it ends with the
// body.
void Narrow(double excess, Prism* prism) {
  const double near = 1e-6 * prism->thickness;
  if (prism->front + prism->depth < prism->thickness - near) prism->depth -= excess;
  if (prism->front <= near) return;
  prism->front += excess;
  prism->depth -= excess;
}

}  // namespace

struct ExtrudedModel::Place {
  int element = 0;
  Vector2d p_O{0, 0};
  double width = 0;      // [m]
  PressedPrism pressed;  // stiffness relative to E and the larger side; empty front: on a support
  [[nodiscard]] bool is_held() const { return pressed.front[0].empty(); }
};

ExtrudedModel::~ExtrudedModel() = default;

ExtrudedModel::ExtrudedModel(BoundaryMesh mesh, std::vector<std::array<bool, 2>> held,
                             const Params& params)
    : mesh_(std::move(mesh)), held_(std::move(held)), params_(params) {
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("thickness", params.thickness);
  RequirePositive("range", params.range);
  RequirePositive("depth", params.depth);
  if (!(params.poisson_ratio > -1 && params.poisson_ratio <= kMaxExtrudedNu)) {
    throw std::invalid_argument(Formatted(
        "object.material.poisson_ratio: expected at most %g with extruded", kMaxExtrudedNu));
  }
  const auto is_held = [](const std::array<bool, 2>& h) { return h[0] && h[1]; };
  if (std::ranges::none_of(held_, is_held)) {
    throw std::invalid_argument("object.fixed: expected a part that is held along x and y");
  }
  Eigen::AlignedBox2d box;
  for (int i = 0; i < mesh_.size(); ++i) {
    const Vector2d& a = mesh_.elements[Index(i)].a;
    box.extend(a);
    field_mesh_.vertices.emplace_back(a.x(), a.y(), 0);
    field_mesh_.lines.push_back({i, mesh_.Next(i)});
  }
  larger_side_ = box.sizes().maxCoeff();
  info_.kind = "extruded";
  info_.elements = mesh_.size();
  info_.range = params.range;
  info_.remark = "the tool is glued; small strains only";
  NotePrecompute();
}

void ExtrudedModel::Prefetch(std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) Find(contact);
}

std::unique_ptr<ExtrudedModel::Place> ExtrudedModel::Prepare(int element, const Vector2d& p_O,
                                                             double width) {
  auto place = std::make_unique<Place>();
  place->element = element;
  place->p_O = p_O;
  place->width = width;
  const auto start = std::chrono::steady_clock::now();
  const double unit = larger_side_;
  Prism prism;
  prism.thickness = params_.thickness / unit;
  prism.front = params_.front / unit;
  prism.depth = params_.depth / unit;
  prism.poisson_ratio = params_.poisson_ratio;
  const EndExcess excess = ExcessOf(prism, width / unit);
  const auto tool = PlaceTool(mesh_, held_, element, p_O, width - 2 * unit * excess.along);
  if (!tool) return place;
  prism.points = tool->points;
  prism.segments = tool->segments;
  Narrow(excess.through, &prism);
  for (Vector2d& p : prism.points) p /= unit;
  std::vector<Vector2d> places;
  for (const BoundaryElement& at : mesh_.elements) places.emplace_back(at.a / unit);
  for (const Vector2d& inside : cover().inside) places.emplace_back(inside / unit);
  place->pressed = PressPrism(prism, {tool->ends[0] / unit, tool->ends[1] / unit}, places);
  info_.dof = Index(place->pressed.unknowns);
  info_.precompute_s += SecondsSince(start);
  return place;
}

// Returns nullptr if there is no element at the contact.
const ExtrudedModel::Place* ExtrudedModel::Find(const Contact& contact) {
  const Vector2d p_O = contact.p_O.head<2>();
  const int element = contact.element >= 0 ? contact.element : FindElement(mesh_, p_O);
  if (element < 0 || element >= mesh_.size() || !p_O.allFinite() || !(contact.width >= 0)) {
    Fail("no element at a contact point");
    return nullptr;
  }
  const double width = contact.width > 0 ? contact.width : mesh_.elements[Index(element)].length();
  const auto found = std::ranges::find_if(places_, [&](const auto& place) {
    return place->element == element && place->p_O == p_O && place->width == width;
  });
  if (found != places_.end()) return found->get();
  places_.push_back(Prepare(element, p_O, width));
  return places_.back().get();
}

void ExtrudedModel::ComputeResponses(std::span<const Contact> contacts,
                                     std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  shown_ = nullptr;
  std::ranges::fill(responses, ContactResponse{});
  if (contacts.empty()) return;
  try {
    if (contacts.size() != 1) {
      Fail("an extruded body is pressed by one contact at a time");
      return;
    }
    const Contact& contact = contacts.front();
    const Place* place = Find(contact);
    if (place == nullptr) return;
    if (place->is_held()) {
      Fail("the tool touches what is held");
      return;
    }
    const Eigen::Matrix2d K = params_.young_modulus * larger_side_ * place->pressed.stiffness;
    const bool is_load = contact.kind == Contact::Kind::kForce;
    const Vector2d given = contact.prescribed_O.head<2>();
    const Vector2d moved = is_load ? Vector2d(K.inverse() * given) : given;
    if (!(moved.norm() < kAbsurd * larger_side_) || contact.prescribed_O.z() != 0) {
      Fail("a displacement beyond reason, or through the thickness");
      return;
    }
    ContactResponse& response = responses.front();
    response.force_O.head<2>() = K * moved;
    response.displacement_O.head<2>() = moved;
    response.stiffness_O.topLeftCorner<2, 2>() = K;
    response.validity = Validity::kValid;
    if (moved.norm() > params_.range * larger_side_) {
      response.validity = Validity::kExtrapolated;
      response.flag_reason = kBeyondRange;
    }
    shown_ = place;
    moved_O_ = moved;
  } catch (const std::exception&) {
    Fail("the body under the tool could not be meshed or solved");
  }
}

void ExtrudedModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->clear();
  AppendFront(0, mesh_.elements.size(), u_O);
}

void ExtrudedModel::ComputeInside(const std::vector<Vector2d>& places, std::vector<Vector3d>* u_O) {
  AppendFront(mesh_.elements.size(), places.size(), u_O);
}

void ExtrudedModel::AppendFront(std::size_t first, std::size_t count,
                                std::vector<Vector3d>* u_O) const {
  if (shown_ == nullptr) return u_O->resize(u_O->size() + count, Vector3d::Zero());
  const auto& [by_x, by_y] = shown_->pressed.front;
  for (std::size_t i = first; i < first + count; ++i) {
    u_O->emplace_back(moved_O_.x() * by_x[i] + moved_O_.y() * by_y[i]);
  }
}

}  // namespace palpate
