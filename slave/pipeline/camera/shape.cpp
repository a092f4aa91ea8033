#include "slave/pipeline/camera/shape.h"

#include <limits>

namespace palpate {
namespace {

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

// Element nearest to `p_O` by midpoint.
int NearestElement(const BoundaryMesh& mesh, const Eigen::Vector2d& p_O) {
  int best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < mesh.size(); ++i) {
    const double d = (mesh.elements[static_cast<std::size_t>(i)].midpoint() - p_O).squaredNorm();
    if (d < nearest) nearest = d, best = i;
  }
  return best;
}

}  // namespace

BoundaryShape MakeShape(TouchModel& touch, const Eigen::Isometry3d& X_SO,
                        const ContactEstimate& felt, bool nodal_forces) {
  const BoundaryMesh& mesh = touch.mesh;
  std::vector<Eigen::Vector3d> u_O;  // vertex i is the start of element i [m]
  touch.deformation->Displacements(&u_O);

  BoundaryShape shape;
  shape.state_sequence = felt.sequence;
  shape.sensed_at = felt.sensed_at;
  shape.validity = felt.validity;
  for (int i = 0; i < mesh.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    shape.elements.push_back(static_cast<std::uint32_t>(i));
    shape.elements.push_back(static_cast<std::uint32_t>(mesh.Next(i)));
    const Eigen::Vector2d& a = mesh.elements[k].a;
    const Eigen::Vector3d p_O(a.x(), a.y(), 0);
    Append(&shape.rest, X_SO * p_O);
    Append(&shape.positions, X_SO * (p_O + u_O[k]));
  }
  if (nodal_forces) {
    shape.nodal_forces.assign(3 * mesh.elements.size(), 0.0F);
    if (felt.force && felt.local_model.in_contact) {
      const Eigen::Vector3d p_O = X_SO.inverse() * felt.p_S_contact;
      const int element = NearestElement(mesh, p_O.head<2>());
      for (const int vertex : {element, mesh.Next(element)}) {
        for (int axis = 0; axis < 3; ++axis) {
          shape.nodal_forces[static_cast<std::size_t>(3 * vertex + axis)] =
              static_cast<float>(-0.5 * (*felt.force)[axis]);
        }
      }
    }
  }
  return shape;
}

}  // namespace palpate
