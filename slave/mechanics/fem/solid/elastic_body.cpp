#include "slave/mechanics/fem/solid/elastic_body.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>

#include "slave/mechanics/fem/solid/shape_functions.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

template <int kNodes>
using Gradients = Eigen::Matrix<double, 3, kNodes>;

// Derivatives of the shape functions at one quadrature point.
template <int kNodes>
Gradients<kNodes> GradientsOf(const TetGeometry& geometry, const Vector4d& bary) {
  if constexpr (kNodes == 4) {
    return geometry.grad;
  } else {
    Gradients<kNodes> gradients;
    for (int i = 0; i < 4; ++i) gradients.col(i) = (4 * bary[i] - 1) * geometry.grad.col(i);
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = kTetEdges[Index(e)];
      gradients.col(4 + e) = 4 * (bary[a] * geometry.grad.col(b) + bary[b] * geometry.grad.col(a));
    }
    return gradients;
  }
}

// Stiffness between component i of node a and component k of node b of an element, for b >= a.
template <int kNodes>
struct Stiffness {
  std::array<std::array<std::array<std::array<double, kNodes>, 3>, 3>, kNodes> of{};  // b, i, k, a

  double& at(int a, int i, int b, int k) { return of[Index(b)][Index(i)][Index(k)][Index(a)]; }
};

// Adds the stiffness of one quadrature point: K_ab = sum over J, L of g_aJ D_JL g_bL.
template <int kNodes>
void AddStiffness(const Matrix9d& D, const Gradients<kNodes>& gradients, double weight,
                  Stiffness<kNodes>* stiffness) {
  for (int b = 0; b < kNodes; ++b) {
    std::array<Matrix3d, 3> T;
    for (int J = 0; J < 3; ++J) {
      T[Index(J)] = weight * (D.block<3, 3>(3 * J, 0) * gradients(0, b) +
                              D.block<3, 3>(3 * J, 3) * gradients(1, b) +
                              D.block<3, 3>(3 * J, 6) * gradients(2, b));
    }
    for (int a = 0; a <= b; ++a) {
      const Matrix3d K = gradients(0, a) * T[0] + gradients(1, a) * T[1] + gradients(2, a) * T[2];
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) stiffness->at(a, i, b, k) += K(i, k);
      }
    }
  }
}

// Adds the stiffness from derivatives with respect to the invariants:
//   K_ab = c_I g_a.g_b 1 + c_FF f_a f_b^T + c_JJ h_a h_b^T + c_J [F (g_a x g_b)],
// f = F g, h = cof F g, and [w] v = v x w. The nodes are processed in parallel lanes.
template <int kNodes>
void AddStiffness(const MaterialLaw::InvariantTangent& c, const Matrix3d& F,
                  const Matrix3d& cofactor, const Gradients<kNodes>& gradients, double weight,
                  Stiffness<kNodes>* stiffness) {
  using Rows = Eigen::Matrix<double, 3, kNodes, Eigen::RowMajor>;
  const Rows g = gradients, f = F * gradients, h = cofactor * gradients;
  const Matrix3d turned = weight * c.pressure * F;
  for (int b = 0; b < kNodes; ++b) {
    const Vector3d g_b = gradients.col(b), along = weight * c.along * f.col(b),
                   volume = weight * c.volume * h.col(b), same = weight * c.identity * g_b;
    Matrix3d across;  // times g_a is g_a x g_b
    across << 0, g_b[2], -g_b[1], -g_b[2], 0, g_b[0], g_b[1], -g_b[0], 0;
    const Matrix3d M = turned * across;
    auto& K = stiffness->of[Index(b)];
    for (int a = 0; a < kNodes; ++a) {
      const auto at = Index(a);
      const double g0 = g(0, a), g1 = g(1, a), g2 = g(2, a);
      const double equal = same[0] * g0 + same[1] * g1 + same[2] * g2;
      const double w0 = M(0, 0) * g0 + M(0, 1) * g1 + M(0, 2) * g2;
      const double w1 = M(1, 0) * g0 + M(1, 1) * g1 + M(1, 2) * g2;
      const double w2 = M(2, 0) * g0 + M(2, 1) * g1 + M(2, 2) * g2;
      K[0][0][at] += f(0, a) * along[0] + h(0, a) * volume[0] + equal;
      K[0][1][at] += f(0, a) * along[1] + h(0, a) * volume[1] + w2;
      K[0][2][at] += f(0, a) * along[2] + h(0, a) * volume[2] - w1;
      K[1][0][at] += f(1, a) * along[0] + h(1, a) * volume[0] - w2;
      K[1][1][at] += f(1, a) * along[1] + h(1, a) * volume[1] + equal;
      K[1][2][at] += f(1, a) * along[2] + h(1, a) * volume[2] + w0;
      K[2][0][at] += f(2, a) * along[0] + h(2, a) * volume[0] + w1;
      K[2][1][at] += f(2, a) * along[1] + h(2, a) * volume[1] - w0;
      K[2][2][at] += f(2, a) * along[2] + h(2, a) * volume[2] + equal;
    }
  }
}

}  // namespace

template <int kNodes>
struct ElasticBody::Local {
  const TetGeometry& geometry;
  double modulus = 1;
  Gradients<kNodes> u;
  Vector4d p = Vector4d::Zero();  // divided by the modulus
};

ElasticBody::ElasticBody(const TetMesh& mesh, const BlockLayout& layout, const MaterialLaw& law)
    : mesh_(mesh), layout_(layout), law_(law) {
  geometry_.reserve(Index(mesh.element_count()));
  for (int e = 0; e < mesh.element_count(); ++e)
    geometry_.push_back(GeometryOf(mesh.nodes, mesh.element(e)));
}

template <int kNodes>
ElasticBody::Local<kNodes> ElasticBody::Gather(const VectorXd& x, int element) const {
  Local<kNodes> local{geometry_[Index(element)], mesh_.ModulusOf(element), {}, {0, 0, 0, 0}};
  const auto nodes = mesh_.element(element);
  for (int i = 0; i < kNodes; ++i) {
    local.u.col(i) = x.segment<3>(layout_.first(nodes[Index(i)]));
  }
  if (layout_.has_pressure()) {
    for (int i = 0; i < 4; ++i) local.p[i] = x[layout_.pressure(nodes[Index(i)])] / local.modulus;
  }
  return local;
}

// Energy of one element; its gradient, if requested, is stored in one column, node by node.
template <int kNodes>
double ElasticBody::AddElement(const Local<kNodes>& local, ElementMatrix* gradient) const {
  const bool mixed = layout_.has_pressure();
  const double bulk = 1 / law_.compressibility();
  double energy = 0;
  for (const auto& q : QuadratureOf(kNodes)) {
    const double volume = q.weight * local.geometry.volume, w = local.modulus * volume;
    const Gradients<kNodes> gradients = GradientsOf<kNodes>(local.geometry, q.bary);
    const MaterialLaw::Point point = law_.At(local.u * gradients.transpose());
    const double p = mixed ? local.p.dot(q.bary) : bulk * point.g;
    energy += w * (point.energy + (mixed ? p * point.g : 0.5 * p * point.g));
    if (!gradient) continue;
    const Gradients<kNodes> forces = w * (point.stress + p * point.volume_stress) * gradients;
    for (int i = 0, row = 0; i < kNodes; row += layout_.local_size(i), ++i) {
      gradient->block<3, 1>(row, 0) += forces.col(i);
      if (mixed && i < 4) (*gradient)(row + 3, 0) += volume * q.bary[i] * point.g;
    }
  }
  if (!mixed) return energy;
  const double V = local.geometry.volume, c = law_.compressibility();
  const Vector4d volumes = V * (PressureMatrix(c, kNodes) * local.p);
  if (gradient) {
    for (int i = 0; i < 4; ++i) (*gradient)(4 * i + 3, 0) -= volumes[i];
  }
  return energy - 0.5 * local.modulus * local.p.dot(volumes);
}

Eigen::Matrix4d ElasticBody::PressureMatrix(double compressibility, int nodes_per_element) const {
  const Eigen::Matrix4d mass = (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity()) / 20;
  if (nodes_per_element == 10) return compressibility * mass;
  const Eigen::Matrix4d of_means = Eigen::Matrix4d::Constant(1.0 / 16);
  return compressibility * mass + (mass - of_means) / (2 * law_.mu());
}

template <int kNodes>
double ElasticBody::EnergyOf(const VectorXd& x, VectorXd* gradient) const {
  double energy = 0;
  if (!gradient) {
    for (int e = 0; e < mesh_.element_count(); ++e) {
      energy += AddElement(Gather<kNodes>(x, e), nullptr);
    }
    return energy;
  }
  gradient->setZero();
  ElementMatrix local(layout_.element_size(), 1);
  for (int e = 0; e < mesh_.element_count(); ++e) {
    local.setZero();
    energy += AddElement(Gather<kNodes>(x, e), &local);
    const auto nodes = mesh_.element(e);
    for (int i = 0, row = 0; i < kNodes; ++i) {
      const int size = layout_.local_size(i);
      gradient->segment(layout_.first(nodes[Index(i)]), size) += local.block(row, 0, size, 1);
      row += size;
    }
  }
  return energy;
}

double ElasticBody::Energy(const VectorXd& x, VectorXd* gradient) const {
  return mesh_.nodes_per_element == 4 ? EnergyOf<4>(x, gradient) : EnergyOf<10>(x, gradient);
}

double ElasticBody::Energy(const VectorXd& x) const {
  return Energy(x, nullptr);
}

void ElasticBody::AddTangent(const VectorXd& x, const Tangent& tangent, bool regularised,
                             SparseMatrix* matrix) const {
  if (mesh_.nodes_per_element == 4) {
    AddTangents<4>(x, tangent, regularised, matrix);
  } else {
    AddTangents<10>(x, tangent, regularised, matrix);
  }
}

template <int kNodes>
void ElasticBody::AddTangents(const VectorXd& x, const Tangent& tangent, bool regularised,
                              SparseMatrix* matrix) const {
  const bool mixed = layout_.has_pressure();
  const double bulk = mixed ? 0 : 1 / law_.compressibility();
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const Local<kNodes> local = Gather<kNodes>(x, e);
    const double own = law_.compressibility();
    const double c = regularised ? std::max(own, kMinCompressibility * local.modulus) : own;
    const Eigen::Matrix4d pressures =
        mixed ? Eigen::Matrix4d(local.geometry.volume / local.modulus * PressureMatrix(c, kNodes))
              : Eigen::Matrix4d(Eigen::Matrix4d::Zero());
    Stiffness<kNodes> stiffness;
    // Coupling of displacements (rows) and pressures (columns).
    Eigen::Matrix<double, 3 * kNodes, 4> coupling = Eigen::Matrix<double, 3 * kNodes, 4>::Zero();
    for (const auto& q : QuadratureOf(kNodes)) {
      const double volume = q.weight * local.geometry.volume, w = local.modulus * volume;
      const Gradients<kNodes> gradients = GradientsOf<kNodes>(local.geometry, q.bary);
      const Matrix3d H = local.u * gradients.transpose();
      const bool linear = law_.law() == FemOptions::Law::kLinear;
      MaterialLaw::Point point;
      if (mixed || !linear) point = law_.At(H);
      const double p = mixed ? local.p.dot(q.bary) : linear ? 0 : bulk * point.g;
      if (law_.HasInvariantTangent() && tangent.removed == 0) {
        AddStiffness<kNodes>(law_.InvariantTangentAt(H, p, bulk), Matrix3d::Identity() + H,
                             point.volume_stress, gradients, w, &stiffness);
      } else {
        AddStiffness<kNodes>(law_.TangentAt(H, p, bulk, tangent), gradients, w, &stiffness);
      }
      if (!mixed) continue;
      const Gradients<kNodes> changes = volume * point.volume_stress * gradients;
      coupling += changes.reshaped() * q.bary.transpose();
    }
    const auto entry = [&](int a, int i, int b, int k) {
      if (i < 3 && k < 3) return stiffness.at(a, i, b, k);
      if (i < 3) return coupling(3 * a + i, b);
      if (k < 3) return coupling(3 * b + k, a);
      return -pressures(a, b);
    };
    layout_.Add(e, entry, matrix);
  }
}

// Displacement gradient F - I.
Matrix3d ElasticBody::StrainAt(const VectorXd& x, int element, const Vector4d& bary) const {
  if (mesh_.nodes_per_element == 4) {
    const auto local = Gather<4>(x, element);
    return local.u * local.geometry.grad.transpose();
  }
  const auto local = Gather<10>(x, element);
  return local.u * GradientsOf<10>(local.geometry, bary).transpose();
}

void ElasticBody::VolumeChange(const VectorXd& x, VectorXd* change) const {
  change->setZero();
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const TetGeometry& geometry = geometry_[Index(e)];
    const auto nodes = mesh_.element(e);
    for (const auto& q : QuadratureOf(mesh_.nodes_per_element)) {
      const double g = law_.At(StrainAt(x, e, q.bary)).g;
      for (int i = 0; i < 4; ++i) {
        (*change)[nodes[Index(i)]] += q.weight * geometry.volume * q.bary[i] * g;
      }
    }
  }
}

SparseMatrix ElasticBody::PressureMass() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const double V = geometry_[Index(e)].volume / mesh_.ModulusOf(e);
    const auto nodes = mesh_.element(e);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double share = i == j ? 0.1 : 0.05;
        const int row = nodes[Index(i)], column = nodes[Index(j)];
        if (row <= column) entries.emplace_back(row, column, share * V);
      }
    }
  }
  SparseMatrix mass(mesh_.vertex_count, mesh_.vertex_count);
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

void ElasticBody::AddMass(double factor, SparseMatrix* matrix) const {
  const int n = mesh_.nodes_per_element;
  const Eigen::MatrixXd products = ShapeProducts(n);
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const double mass = factor * geometry_[Index(e)].volume;
    const auto entry = [&](int a, int i, int b, int k) {
      return i == k && i < 3 ? mass * products(a, b) : 0;
    };
    layout_.Add(e, entry, matrix);
  }
}

VectorXd ElasticBody::NodeVolumes() const {
  VectorXd volumes = VectorXd::Zero(mesh_.node_count());
  const ShapeValues shares = ShapeIntegrals(mesh_.nodes_per_element);
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const auto nodes = mesh_.element(e);
    for (int i = 0; i < mesh_.nodes_per_element; ++i) {
      volumes[nodes[Index(i)]] += shares[i] * geometry_[Index(e)].volume;
    }
  }
  return volumes;
}

ElasticBody::Jacobians ElasticBody::FindJacobians(const VectorXd& x) const {
  Jacobians found{.smallest = std::numeric_limits<double>::infinity()};
  const int n = mesh_.nodes_per_element;
  for (int e = 0; e < mesh_.element_count(); ++e) {
    double smallest = std::numeric_limits<double>::infinity();
    const auto meet = [&](const Vector4d& bary) {
      const Matrix3d F = Matrix3d::Identity() + StrainAt(x, e, bary);
      smallest = std::min(smallest, F.determinant());
    };
    for (const auto& q : QuadratureOf(n)) meet(q.bary);
    for (int corner = 0; n == 10 && corner < 4; ++corner) meet(Vector4d::Unit(corner));
    if (!(smallest > 0) && found.inverted++ == 0) found.first_inverted = e;
    found.smallest = std::min(found.smallest, smallest);
  }
  return found;
}

}  // namespace palpate
