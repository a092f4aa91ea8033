#include "slave/mechanics/bem/interior_field.h"

#include <utility>

#include <unsupported/Eigen/AutoDiff>

#include "slave/mechanics/bem/kelvin_integrals.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Dual = Eigen::AutoDiffScalar<Vector2d>;  // a value and its derivatives by x and y

constexpr double kCorner = 0.5;  // cosine of the turn between two elements that makes a corner

// The element seen from a point, in the element's frame [length units].
struct View {
  Vector2d t, n;
  double xi_a, d, length;
};

// tr(strain) nu / (1 - 2 nu), from the divergence of the kernels, where 1 - 2 nu cancels:
//   div U_j nu / (1 - 2 nu) = 2 nu c r,j / r,
//   div T_j nu / (1 - 2 nu) = 4 G nu c (n_j - 2 r,j dr/dn) / r^2,  c = 1 / (8 pi G (1 - nu)).
double PressurePart(const View& v, const PlaneElasticity& e, const KelvinConstants& c,
                    const Vector2d& traction, const Vector2d& displacement) {
  const double xi_b = v.xi_a + v.length;
  const double d2 = v.d * v.d;
  const double slope = v.length / ((v.xi_a * v.xi_a + d2) * (xi_b * xi_b + d2));
  const KelvinIntegrals<double> I(v.xi_a, v.d, v.length);
  const Vector2d by_traction = I.log_ratio * v.t + I.angle * v.n;
  const Vector2d by_displacement =
      -slope * (v.d * (v.xi_a + xi_b) * v.t + (d2 - v.xi_a * xi_b) * v.n);
  return 2 * e.effective_nu * c.u *
         (by_traction.dot(traction) - 2 * e.shear_modulus * by_displacement.dot(displacement));
}

}  // namespace

InteriorField::InteriorField(const Bem2dModel& model, BoundaryState state)
    : model_(model), state_(std::move(state)) {}

PointState InteriorField::At(const Vector2d& p_O) const {
  const GreensFunctions& greens = model_.greens_functions();
  const PlaneElasticity& elasticity = greens.elasticity();
  const KelvinConstants constants(elasticity.shear_modulus, elasticity.effective_nu);
  const BoundaryMesh& mesh = greens.problem().mesh;
  const double E = model_.params().young_modulus;
  Eigen::Matrix<Dual, 2, 1> u(Dual(0, Vector2d::Zero()), Dual(0, Vector2d::Zero()));
  double pressure_part = 0;
  for (std::size_t j = 0; j < mesh.elements.size(); ++j) {
    const auto& element = mesh.elements[j];
    const Vector2d t = (element.b - element.a).normalized();
    const Vector2d r = (element.a - p_O) / mesh.length_unit;
    const View view{
        t, {t.y(), -t.x()}, r.dot(t), r.dot(Vector2d(t.y(), -t.x())), greens.lengths()[j]};
    const Vector2d traction = state_.traction[j] / E;
    const Vector2d displacement = state_.displacement[j] / mesh.length_unit;
    // Moving the point by (dx, dy) moves the element back.
    const KelvinIntegrals<Dual> integrals(Dual(view.xi_a, -view.t), Dual(view.d, -view.n),
                                          view.length);
    const auto blocks = Combine(constants, integrals, view.length, t.x(), t.y());
    for (int i = 0; i < 2; ++i) {
      for (int k = 0; k < 2; ++k) {
        u[i] += blocks.of_traction(i, k) * traction[k];
        u[i] -= blocks.of_displacement(i, k) * displacement[k];
      }
    }
    pressure_part += PressurePart(view, elasticity, constants, traction, displacement);
  }
  Matrix2d gradient;
  gradient << u[0].derivatives().transpose(), u[1].derivatives().transpose();
  PointState state;
  state.displacement = mesh.length_unit * Vector2d(u[0].value(), u[1].value());
  state.stress = E * elasticity.shear_modulus *
                 (gradient + gradient.transpose() + 2 * pressure_part * Matrix2d::Identity());
  return state;
}

PointState InteriorField::OnBoundary(int i) const {
  const PlaneElasticity& elasticity = model_.greens_functions().elasticity();
  const BoundaryMesh& mesh = model_.greens_functions().problem().mesh;
  const auto element = [&](int k) { return mesh.elements[static_cast<std::size_t>(k)]; };
  const auto moved = [&](int k) { return state_.displacement[static_cast<std::size_t>(k)]; };
  const Vector2d n = element(i).normal();
  const Vector2d t(-n.y(), n.x());
  const auto continues = [&](int k) { return element(k).normal().dot(n) > kCorner; };
  const int after = continues(mesh.Next(i)) ? mesh.Next(i) : i;
  const int before = continues(mesh.Previous(i)) ? mesh.Previous(i) : i;

  PointState state;
  state.displacement = moved(i);
  double stretch = 0;
  if (after != before) {
    const Vector2d step = element(after).midpoint() - element(before).midpoint();
    stretch = step.dot(moved(after) - moved(before)) / step.squaredNorm();
  }
  const Vector2d traction = state_.traction[static_cast<std::size_t>(i)];
  const double s_nn = traction.dot(n);
  const double s_nt = traction.dot(t);
  const double nu = elasticity.effective_nu;
  const double G = elasticity.shear_modulus * model_.params().young_modulus;
  const double s_tt = (2 * G * stretch + nu * s_nn) / (1 - nu);
  state.stress = s_nn * n * n.transpose() + s_tt * t * t.transpose() +
                 s_nt * (n * t.transpose() + t * n.transpose());
  return state;
}

}  // namespace palpate
