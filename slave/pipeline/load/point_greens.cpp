#include "slave/pipeline/load/point_greens.h"

#include <limits>
#include <span>
#include <utility>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSamePlace = 1e-9;  // of the distance from the origin

std::size_t At(int i) {
  return static_cast<std::size_t>(i);
}

bool IsSamePlace(const Vector3d& a, const Vector3d& b) {
  return (a - b).norm() <= kSamePlace * (a.norm() + b.norm());
}

}  // namespace

PointGreens::PointGreens(const SurfaceMesh& surface, double load, double patch)
    : surface_(surface), load_(load), index_(surface.nodes.size(), -1) {
  for (const auto& triangle : surface_.triangles) {
    for (const int node : triangle) {
      if (index_[At(node)] >= 0) continue;
      index_[At(node)] = static_cast<int>(nodes_.size());
      nodes_.push_back(node);
    }
  }
  FindPatches(patch);
}

// As the models spread a load, so that the same load through the model moves the points alike.
void PointGreens::FindPatches(double patch) {
  SurfaceFootprints footprints(surface_);
  for (const int node : nodes_) {
    const Contact load{
        .kind = Contact::Kind::kForce, .p_O = surface_.nodes[At(node)], .width = patch};
    ContactFootprint footprint;
    const bool is_met = footprints.OnNodes(load, &footprint).empty();
    patches_.push_back(is_met ? std::move(footprint.places) : std::vector{PlaceWeight{node, 1}});
  }
}

void PointGreens::See(DeformationModel& model, const SurfaceContact& contact,
                      const std::vector<Vector3d>& p_O_rest) {
  if (rest_.size() != p_O_rest.size()) {
    rest_.assign(p_O_rest.size(), Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    known_.assign(p_O_rest.size(), false);
    for (auto& by : by_) {
      by.setZero(3 * static_cast<Eigen::Index>(p_O_rest.size()),
                 static_cast<Eigen::Index>(nodes_.size()));
    }
  }
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (!p_O_rest[i].allFinite() || IsSamePlace(rest_[i], p_O_rest[i])) continue;
    rest_[i] = p_O_rest[i];
    known_[i] = false;
    const auto place = contact.Find(rest_[i], std::numeric_limits<double>::infinity());
    if (!place) continue;
    Contact press{.kind = Contact::Kind::kForce, .p_O = place->p_O, .element = place->triangle};
    bool answered = true;
    for (int axis = 0; axis < 3 && answered; ++axis) {
      press.prescribed_O = load_ * Vector3d::Unit(axis);
      answered = Load(model, press, 3 * static_cast<Eigen::Index>(i) + axis);
    }
    known_[i] = answered;
  }
}

bool PointGreens::Load(DeformationModel& model, const Contact& contact, Eigen::Index row) {
  ContactResponse response;
  model.Reset();
  model.Respond(std::span(&contact, 1), std::span(&response, 1));
  if (response.validity == Validity::kFailed) return false;
  model.Displacements(&field_);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Vector3d mean = Vector3d::Zero();
    for (const auto& [node, weight] : patches_[k]) mean += weight / load_ * field_[At(node)];
    for (int axis = 0; axis < 3; ++axis)
      by_[At(axis)](row, static_cast<Eigen::Index>(k)) = mean[axis];
  }
  return true;
}

}  // namespace palpate
