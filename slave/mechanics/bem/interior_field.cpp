#include "slave/mechanics/bem/interior_field.h"

#include <utility>

#include <unsupported/Eigen/AutoDiff>

#include "slave/mechanics/bem/kelvin_integrals.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Dual = Eigen::AutoDiffScalar<Vector2d>;  // a value and its derivatives by x and y

constexpr double kCorner = 0.5;  // cosine of the turn between two elements that makes a corner

// tr(strain) nu / (1 - 2 nu), from the divergence of the kernels, where 1 - 2 nu cancels:
//   div U_j nu / (1 - 2 nu) = 2 nu c r,j / r,
//   div T_j nu / (1 - 2 nu) = 4 G nu c (n_j - 2 r,j dr/dn) / r^2,  c = 1 / (8 pi G (1 - nu)).
double PressurePart(const ElementView& v, const PlaneElasticity& e, const KelvinConstants& c,
                    const LegendreMoments& moments, std::size_t k, const Vector2d& traction,
                    const Vector2d& displacement) {
  const auto pole = moments.pole[k];
  const auto dipole = moments.dipole[k] / (0.5 * v.length);
  const Vector2d by_traction = pole.real() * v.t - pole.imag() * v.n;
  const Vector2d by_displacement = dipole.imag() * v.t + dipole.real() * v.n;
  return 2 * e.effective_nu * c.u *
         (by_traction.dot(traction) - 2 * e.shear_modulus * by_displacement.dot(displacement));
}

// The kernels' integrals with their derivatives by the place of the point: moving it by (dx, dy)
// moves the element back.
KelvinIntegrals<Dual> Integrate(const ElementView& v, const LegendreMoments& moments,
                                std::size_t k) {
  const Dual d(v.d, -v.n);
  if (k == 0) return {Dual(v.xi_a, -v.t), d, v.length};
  const double h = 0.5 * v.length;
  return KelvinMode<Dual>(moments, k, h, d, [&](const auto& value, const auto& slope) {
    const Vector2d of_real = (slope.real() * v.t - slope.imag() * v.n) / h;
    const Vector2d of_imaginary = (slope.imag() * v.t + slope.real() * v.n) / h;
    return std::pair{Dual(value.real(), of_real), Dual(value.imag(), of_imaginary)};
  });
}

}  // namespace

InteriorField::InteriorField(const Bem2dModel& model, BoundaryState state)
    : model_(model), state_(std::move(state)) {}

// An element's values along Legendre's polynomials.
InteriorField::Modes InteriorField::ModesOf(const std::vector<Vector2d>& values,
                                            int element) const {
  const ElementNodes& local = model_.greens_functions().element_nodes();
  const auto count = Index(local.count);
  Modes modes;
  modes.fill(Vector2d::Zero());
  for (std::size_t m = 0; m < count; ++m) {
    const Vector2d& value = values[Index(element) * count + m];
    for (std::size_t k = 0; k < count; ++k) modes[k] += local.mode[m][k] * value;
  }
  return modes;
}

PointState InteriorField::At(const Vector2d& p_O) const {
  const GreensFunctions& greens = model_.greens_functions();
  const PlaneElasticity& elasticity = greens.elasticity();
  const KelvinConstants constants(elasticity.shear_modulus, elasticity.effective_nu);
  const BoundaryMesh& mesh = greens.problem().mesh;
  const auto modes = Index(greens.element_nodes().count);
  const double E = model_.params().young_modulus;
  Eigen::Matrix<Dual, 2, 1> u(Dual(0, Vector2d::Zero()), Dual(0, Vector2d::Zero()));
  double pressure_part = 0;
  for (int j = 0; j < mesh.size(); ++j) {
    const ElementView view = ViewOf(mesh, j, p_O);
    const LegendreMoments moments(view.z());
    const Modes tractions = ModesOf(state_.traction, j);
    const Modes displacements = ModesOf(state_.displacement, j);
    for (std::size_t k = 0; k < modes; ++k) {
      const Vector2d traction = tractions[k] / E;
      const Vector2d displacement = displacements[k] / mesh.length_unit;
      const auto blocks = Combine(constants, Integrate(view, moments, k), k == 0 ? view.length : 0,
                                  view.t.x(), view.t.y());
      for (int i = 0; i < 2; ++i) {
        for (int c = 0; c < 2; ++c) {
          u[i] += blocks.of_traction(i, c) * traction[c];
          u[i] -= blocks.of_displacement(i, c) * displacement[c];
        }
      }
      pressure_part +=
          PressurePart(view, elasticity, constants, moments, k, traction, displacement);
    }
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
  const auto& element = model_.greens_functions().problem().mesh.elements[Index(i)];
  const PlaneElasticity& elasticity = model_.greens_functions().elasticity();
  const Vector2d n = element.normal();
  const Vector2d t(-n.y(), n.x());
  const Modes tractions = ModesOf(state_.traction, i);
  const Modes displacements = ModesOf(state_.displacement, i);
  const Vector2d traction = tractions[0] - 0.5 * tractions[2];

  PointState state;
  state.displacement = displacements[0] - 0.5 * displacements[2];
  const double s_nn = traction.dot(n);
  const double s_nt = traction.dot(t);
  const double nu = elasticity.effective_nu;
  const double G = elasticity.shear_modulus * model_.params().young_modulus;
  const double s_tt = (2 * G * StretchOf(i) + nu * s_nn) / (1 - nu);
  state.stress = s_nn * n * n.transpose() + s_tt * t * t.transpose() +
                 s_nt * (n * t.transpose() + t * n.transpose());
  return state;
}

// Strain along the boundary in the middle of element `i`: from the element's own displacements or,
// where they are constant, from the neighbours that continue it without a corner.
double InteriorField::StretchOf(int i) const {
  const BoundaryMesh& mesh = model_.greens_functions().problem().mesh;
  const auto element = [&](int k) { return mesh.elements[Index(k)]; };
  if (model_.greens_functions().element_nodes().count > 1) {
    const Vector2d edge = element(i).b - element(i).a;
    return 2 * edge.dot(ModesOf(state_.displacement, i)[1]) / edge.squaredNorm();
  }
  const auto moved = [&](int k) { return state_.displacement[Index(k)]; };
  const auto continues = [&](int k) {
    return element(k).normal().dot(element(i).normal()) > kCorner;
  };
  const int after = continues(mesh.Next(i)) ? mesh.Next(i) : i;
  const int before = continues(mesh.Previous(i)) ? mesh.Previous(i) : i;
  if (after == before) return 0;
  const Vector2d step = element(after).midpoint() - element(before).midpoint();
  return step.dot(moved(after) - moved(before)) / step.squaredNorm();
}

}  // namespace palpate
