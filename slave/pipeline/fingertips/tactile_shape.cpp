// The object's surface as fingertips deform it, for observers.
#include <cstddef>
#include <optional>
#include <vector>

#include "shared/mesh/disc_patch.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Shares of a contact's force among the nodes, as DeformationModel spreads a load (rules:
// slave/solve/README.md): over the triangles of a patch, a third of each one's share per node, or
// over the triangle of a point.
void Spread(const SurfaceMesh& surface, const FingerContact& finger, const Vector3d& force_O,
            std::vector<Vector3d>* f_O) {
  const double width = finger.contact().width;
  const auto add = [&](int triangle, const Vector3d& weights) {
    const auto& nodes = surface.triangles[Index(triangle)];
    for (std::size_t c = 0; c < 3; ++c) {
      (*f_O)[Index(nodes[c])] += weights[static_cast<Eigen::Index>(c)] * force_O;
    }
  };
  SurfacePlace place;
  place.triangle = finger.place().triangle;
  const DiscPatch patch =
      width > 0 ? PatchAt(surface, place, finger.place().p_O, width) : DiscPatch{};
  double area = 0;
  for (const int t : patch.triangles) area += Area(surface, t);
  if (!(area > 0)) return add(place.triangle, finger.place().weights);
  for (const int t : patch.triangles) add(t, Vector3d::Constant(Area(surface, t) / area / 3));
}

// nullopt: the force of a touching fingertip is unknown.
std::optional<std::vector<Vector3d>> NodalForces(const TactileEstimator& estimator) {
  const TouchedObject& object = estimator.object();
  const SurfaceMesh& surface = object.body()->surface;
  const Eigen::Matrix3d R_OS = object.X_SO().linear().transpose();
  std::vector<Vector3d> f_O(surface.nodes.size(), Vector3d::Zero());
  for (int i = 0; i < estimator.finger_count(); ++i) {
    if (!object.contact(i).has_place()) continue;
    const std::optional<Vector3d>& force = estimator.finger(i).force;
    if (!force) return std::nullopt;
    Spread(surface, object.contact(i), -(R_OS * *force), &f_O);
  }
  return f_O;
}

void FillShape(const TouchedObject& object, bool with_field, BoundaryShape* shape) {
  const TactileBody& body = *object.body();
  const Eigen::Isometry3d X_OS = object.X_SO().inverse();
  if (with_field) shape->field.emplace().triangles = body.skin_triangles;
  const std::vector<Vector3d> p_S = object.DeformedNodes();
  shape->elements = body.skin_triangles;
  shape->fixed_nodes = body.skin_held;
  for (const int node : body.skin) {
    const auto i = Index(node);
    const Vector3d& p_O = body.surface.nodes[i];
    Append(&shape->rest, object.X_SO() * p_O);
    Append(&shape->positions, p_S[i]);
    if (!with_field) continue;
    Append(&shape->field->rest, p_O);
    Append(&shape->field->displacement, X_OS * p_S[i] - p_O);
  }
}

}  // namespace

BoundaryShape TactileEstimator::Shape(const ShapeParts& parts) {
  BoundaryShape shape = ShapeAsOf(estimate_, 3);
  shape.validity = object_.validity();
  if (body() == nullptr) return shape;
  for (int i = 0; i < finger_count(); ++i) {  // the model did not solve for this contact
    const FingerContact& contact = object_.contact(i);
    if (contact.has_place() && contact.is_beyond_model()) shape.validity = Validity::kFailed;
  }
  const bool is_known = shape.validity != Validity::kFailed;
  if (!is_known && !last_shape_.rest.empty()) {
    shape = last_shape_;
    shape.validity = Validity::kFailed;
  } else {
    FillShape(object_, parts.field, &shape);
  }
  if (is_known) last_shape_ = shape;
  if (!parts.nodal_forces) return shape;
  const auto f_O = NodalForces(*this);
  if (!f_O) return shape;
  for (const int node : body()->skin) {
    Append(&shape.nodal_forces, object_.X_SO().linear() * (*f_O)[Index(node)]);
  }
  return shape;
}

}  // namespace palpate
