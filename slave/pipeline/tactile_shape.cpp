#include "slave/pipeline/tactile_shape.h"

#include <array>

#include "slave/contact/surface_contact.h"

namespace palpate {
namespace {

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

std::vector<Eigen::Vector3d> NodalForces(const TactileEstimator& estimator) {
  const TactileBody& body = *estimator.body();
  std::vector<Eigen::Vector3d> f_O(body.surface.nodes.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < estimator.contacts().size(); ++k) {
    const Contact& contact = estimator.contacts()[k];
    const ContactResponse& response = estimator.responses()[k];
    if (response.validity == Validity::kFailed) continue;
    const auto& triangle = body.surface.triangles[static_cast<std::size_t>(contact.element)];
    std::array<Eigen::Vector3d, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = body.surface.nodes[static_cast<std::size_t>(triangle[c])];
    }
    const Eigen::Vector3d weights = TriangleWeights(contact.p_O, corners, AreaWeights::kClosest);
    for (std::size_t c = 0; c < 3; ++c) {
      f_O[static_cast<std::size_t>(triangle[c])] +=
          weights[static_cast<Eigen::Index>(c)] * response.force_O;
    }
  }
  return f_O;
}

}  // namespace

BoundaryShape MakeTactileShape(TactileEstimator& estimator, bool nodal_forces) {
  BoundaryShape shape;
  shape.nodes_per_element = 3;
  shape.state_sequence = estimator.felt().sequence;
  shape.sensed_at = estimator.felt().sensed_at;
  shape.validity = estimator.shape_validity();
  TactileBody* body = estimator.body();
  if (body == nullptr) return shape;
  const Eigen::Isometry3d& X_SO = estimator.X_SO();
  std::vector<Eigen::Vector3d> p_S;
  estimator.DeformedNodes(&p_S);
  shape.elements = body->skin_triangles;
  for (const int node : body->skin) {
    const auto i = static_cast<std::size_t>(node);
    Append(&shape.rest, X_SO * body->surface.nodes[i]);
    Append(&shape.positions, p_S[i]);
  }
  if (!nodal_forces) return shape;
  const std::vector<Eigen::Vector3d> f_O = NodalForces(estimator);
  for (const int node : body->skin) {
    Append(&shape.nodal_forces, X_SO.linear() * f_O[static_cast<std::size_t>(node)]);
  }
  return shape;
}

}  // namespace palpate
