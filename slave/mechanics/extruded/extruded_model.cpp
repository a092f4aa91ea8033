#include "slave/mechanics/extruded/extruded_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "shared/link/thread_priority.h"
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
  Position at;
  PressedPrism pressed;    // stiffness relative to E and the larger side; empty front: on a support
  bool is_solved = false;  // false: the body could not be meshed or solved
  double took = 0;         // [s]
  [[nodiscard]] bool is_held() const { return is_solved && pressed.front[0].empty(); }
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
    throw std::invalid_argument("object.fixed: expected a part that is held");
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
  for (const BoundaryElement& at : mesh_.elements) shown_O_.push_back(at.a);
  const PlanarCover& inside = cover();
  shown_O_.insert(shown_O_.end(), inside.inside.begin(), inside.inside.end());
  NotePrecompute();
}

void ExtrudedModel::Prefetch(std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) {
    if (const auto at = PositionOf(contact)) Find(*at);
  }
}

void ExtrudedModel::SolveAside() {
  solver_ = std::jthread([this](const std::stop_token& stop) { SolveWanted(stop); });
}

std::optional<ExtrudedModel::Position> ExtrudedModel::PositionOf(const Contact& contact) const {
  const Vector2d p_O = contact.p_O.head<2>();
  const int element = contact.element >= 0 ? contact.element : FindElement(mesh_, p_O);
  const bool is_known = element >= 0 && element < mesh_.size();
  if (!is_known || !p_O.allFinite() || !(contact.width >= 0)) return std::nullopt;
  const double width = contact.width > 0 ? contact.width : mesh_.elements[Index(element)].length();
  return Position{element, p_O, width};
}

std::unique_ptr<ExtrudedModel::Place> ExtrudedModel::Prepare(const Position& at) const {
  auto place = std::make_unique<Place>();
  place->at = at;
  const auto start = std::chrono::steady_clock::now();
  const double unit = larger_side_;
  Prism prism;
  prism.thickness = params_.thickness / unit;
  prism.front = params_.front / unit;
  prism.depth = params_.depth / unit;
  prism.poisson_ratio = params_.poisson_ratio;
  try {
    const EndExcess excess = ExcessOf(prism, at.width / unit);
    const auto tool =
        PlaceTool(mesh_, held_, at.element, at.p_O, at.width - 2 * unit * excess.along);
    if (tool) {
      prism.points = tool->points;
      prism.segments = tool->segments;
      Narrow(excess.through, &prism);
      for (Vector2d& p : prism.points) p /= unit;
      std::vector<Vector2d> places = shown_O_;
      for (Vector2d& p : places) p /= unit;
      place->pressed = PressPrism(prism, {tool->ends[0] / unit, tool->ends[1] / unit}, places);
    }
    place->is_solved = true;
  } catch (const std::exception&) {
    place->pressed = {};
  }
  place->took = SecondsSince(start);
  return place;
}

void ExtrudedModel::Keep(std::unique_ptr<Place> place) {
  const std::lock_guard lock(places_mutex_);
  places_.push_back(std::move(place));
}

const ExtrudedModel::Place* ExtrudedModel::Known(const Position& at) const {
  const auto found = std::ranges::find(places_, at, [](const auto& place) { return place->at; });
  return found == places_.end() ? nullptr : found->get();
}

const ExtrudedModel::Place* ExtrudedModel::NearestKnown(const Position& at) const {
  const Place* nearest = nullptr;
  for (const auto& place : places_) {
    if (!place->is_solved || place->is_held() || place->at.width != at.width) continue;
    const auto is_nearer = [&](const Place& than) {
      return (place->at.p_O - at.p_O).norm() < (than.at.p_O - at.p_O).norm();
    };
    if (nearest == nullptr || is_nearer(*nearest)) nearest = place.get();
  }
  return nearest;
}

const ExtrudedModel::Place* ExtrudedModel::Find(const Position& at) {
  {
    const std::lock_guard lock(places_mutex_);
    if (solver_.joinable()) {
      wanted_ = at;
      if (const Place* known = Known(at)) return known;
      asked_.notify_one();
      return NearestKnown(at);
    }
    if (const Place* known = Known(at)) return known;
  }
  auto place = Prepare(at);
  info_.dof = std::max(info_.dof, Index(place->pressed.unknowns));
  info_.precompute_s += place->took;
  const Place* const found = place.get();
  Keep(std::move(place));
  return found;
}

std::optional<ExtrudedModel::Position> ExtrudedModel::Unsolved() const {
  constexpr std::array kAhead{1, -1, 2, -2, 3, -3};  // elements
  if (!wanted_) return std::nullopt;
  if (Known(*wanted_) == nullptr) return wanted_;
  for (const int ahead : kAhead) {
    const int element = (wanted_->element + ahead + mesh_.size()) % mesh_.size();
    const Position at{element, mesh_.elements[Index(element)].midpoint(), wanted_->width};
    if (Known(at) == nullptr) return at;
  }
  return std::nullopt;
}

void ExtrudedModel::SolveWanted(const std::stop_token& stop) {
  const OrdinaryPriority ordinary;
  while (!stop.stop_requested()) {
    std::optional<Position> next;
    {
      std::unique_lock lock(places_mutex_);
      asked_.wait(lock, stop, [&] { return (next = Unsolved()).has_value(); });
    }
    if (next && !stop.stop_requested()) Keep(Prepare(*next));
  }
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
    const auto at = PositionOf(contact);
    if (!at) {
      Fail("no element at a contact point");
      return;
    }
    const Place* place = Find(*at);
    if (place == nullptr) {
      Fail(kBeingComputed);
      return;
    }
    if (!place->is_solved) {
      Fail("the body under the tool could not be meshed or solved");
      return;
    }
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
    if (!(place->at == *at)) {
      response.validity = Validity::kExtrapolated;
      response.flag_reason = kBeingComputed;
    }
    shown_ = place;
    moved_O_ = moved;
  } catch (const std::exception&) {
    Fail("out of memory");
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
