#include "slave/mechanics/fem/zone/zone_place.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastEnergy = 1e-12;  // of a mode, by that of the first

}  // namespace

ZonePlaces::ZonePlaces(const SolidMesh& mesh, const HeldNodes& held, double nu, int modes)
    : mesh_(mesh),
      nu_(nu),
      modes_(modes),
      rest_(mesh, held, nu),
      finder_(mesh),
      on_surface_(mesh.nodes.size(), 0) {
  for (const auto& p : mesh.nodes) positions_.push_back(p / rest_.length_unit());
  for (const auto& triangle : SurfaceOf(mesh).triangles) {
    for (const int node : triangle) on_surface_[Index(node)] = 1;
  }
}

ZonePlace ZonePlaces::Make(const Vector3d& centre_O, double radius,
                           const std::vector<int>& touched) {
  Zone zone = finder_.Around(centre_O, radius, touched);
  MatrixXd condensed = std::move(rest_.Condense({zone}).front());
  std::vector<char> held;
  for (const int node : zone.nodes) {
    for (int c = 0; c < 3; ++c) held.push_back(rest_.is_held(node, c) ? 1 : 0);
  }
  ZonePlace place{
      MakeZoneBody(std::move(zone), positions_, std::move(held), std::move(condensed), nu_),
      {},
      {}};
  FindModes(&place);
  return place;
}

void ZonePlaces::FindModes(ZonePlace* place) {
  const ZoneBody& body = place->body;
  const Zone& zone = body.zone;
  std::vector<int> loaded;
  ZoneContact surface;
  for (int n = 0; n < zone.inner; ++n) {
    if (!on_surface_[Index(zone.nodes[Index(n)])]) continue;
    loaded.push_back(n);
    surface.points.push_back({{n, 1.0}});
  }
  ZoneTangent tangent(body, surface);
  if (!tangent.Compute(VectorXd::Zero(3 * zone.size()))) {
    throw std::runtime_error("a zone cannot be factored");
  }
  const MatrixXd moved = tangent.columns().bottomRows(3 * zone.border());
  const MatrixXd reaction = body.rest * moved;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> energies(moved.transpose() * reaction);
  const int all = static_cast<int>(moved.cols());
  int count = 0;
  while (count < std::min(modes_, all) &&
         energies.eigenvalues()[all - 1 - count] >
             kLeastEnergy * std::max(0.0, energies.eigenvalues()[all - 1])) {
    ++count;
  }
  // Loads that cause modes of energy one half.
  MatrixXd loads = energies.eigenvectors().rightCols(count).rowwise().reverse();
  for (int k = 0; k < count; ++k) {
    loads.col(k) /= std::sqrt(energies.eigenvalues()[all - 1 - k]);
  }
  place->to_modes = (reaction * loads).transpose();
  MatrixXd force = MatrixXd::Zero(3 * static_cast<int>(mesh_.nodes.size()), count);
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    force.middleRows<3>(3 * zone.nodes[Index(loaded[i])]) =
        loads.middleRows<3>(3 * static_cast<int>(i));
  }
  place->far = rest_.Solve(force).cast<float>();
}

}  // namespace palpate
