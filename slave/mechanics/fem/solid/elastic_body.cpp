#include "slave/mechanics/fem/solid/elastic_body.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

template <int kNodes>
using Gradients = Eigen::Matrix<double, 3, kNodes>;
template <int kNodes>
using Starts = std::array<int, kNodes>;

// Of the shape functions at one quadrature point.
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

// Adds the stiffness of one quadrature point: K_ab = sum over J, L of g_aJ D_JL g_bL.
template <int kNodes>
void AddStiffness(const Matrix9d& D, const Gradients<kNodes>& gradients, double weight,
                  const Starts<kNodes>& start, ElementMatrix* block) {
  for (int b = 0; b < kNodes; ++b) {
    std::array<Matrix3d, 3> T;
    for (int J = 0; J < 3; ++J) {
      T[Index(J)] = weight * (D.block<3, 3>(3 * J, 0) * gradients(0, b) +
                              D.block<3, 3>(3 * J, 3) * gradients(1, b) +
                              D.block<3, 3>(3 * J, 6) * gradients(2, b));
    }
    for (int a = 0; a <= b; ++a) {
      block->block<3, 3>(start[Index(a)], start[Index(b)]) +=
          gradients(0, a) * T[0] + gradients(1, a) * T[1] + gradients(2, a) * T[2];
    }
  }
}

// The same from derivatives with respect to the invariants:
//   K_ab = c_I g_a.g_b 1 + c_FF f_a f_b^T + c_JJ h_a h_b^T + c_J [F (g_a x g_b)],
// f = F g, h = cof F g, and [w] v = v x w.
template <int kNodes>
void AddStiffness(const MaterialLaw::InvariantTangent& c, const Matrix3d& F,
                  const Matrix3d& cofactor, const Gradients<kNodes>& gradients, double weight,
                  const Starts<kNodes>& start, ElementMatrix* block) {
  const Gradients<kNodes> f = F * gradients, h = cofactor * gradients;
  const double c_I = weight * c.identity, c_FF = weight * c.along, c_JJ = weight * c.volume;
  const Matrix3d turned = weight * c.pressure * F;
  for (int b = 0; b < kNodes; ++b) {
    const Vector3d g = gradients.col(b), along = c_FF * f.col(b), volume = c_JJ * h.col(b);
    for (int a = 0; a <= b; ++a) {
      const Vector3d w = turned * gradients.col(a).cross(g);
      Matrix3d K = f.col(a) * along.transpose() + h.col(a) * volume.transpose();
      K.diagonal().array() += c_I * gradients.col(a).dot(g);
      K(0, 1) += w[2];
      K(1, 0) -= w[2];
      K(0, 2) -= w[1];
      K(2, 0) += w[1];
      K(1, 2) += w[0];
      K(2, 1) -= w[0];
      block->block<3, 3>(start[Index(a)], start[Index(b)]) += K;
    }
  }
}

}  // namespace

template <int kNodes>
struct ElasticBody::Local {
  const TetGeometry& geometry;
  Gradients<kNodes> u;
  Vector4d p = Vector4d::Zero();
};

ElasticBody::ElasticBody(const ElementMesh& mesh, const BlockLayout& layout, const MaterialLaw& law)
    : mesh_(mesh), layout_(layout), law_(law) {
  geometry_.reserve(Index(mesh.element_count()));
  for (int e = 0; e < mesh.element_count(); ++e) geometry_.push_back(GeometryOf(mesh, e));
}

template <int kNodes>
ElasticBody::Local<kNodes> ElasticBody::Gather(const VectorXd& x, int element) const {
  Local<kNodes> local{geometry_[Index(element)], {}, {0, 0, 0, 0}};
  const auto nodes = mesh_.element(element);
  for (int i = 0; i < kNodes; ++i) {
    local.u.col(i) = x.segment<3>(layout_.first(nodes[Index(i)]));
  }
  if (layout_.has_pressure()) {
    for (int i = 0; i < 4; ++i) local.p[i] = x[layout_.pressure(nodes[Index(i)])];
  }
  return local;
}

// Energy of one element; its gradient, where asked for, goes to one column, node by node.
template <int kNodes>
double ElasticBody::AddElement(const Local<kNodes>& local, ElementMatrix* gradient) const {
  const bool mixed = layout_.has_pressure();
  const double bulk = 1 / law_.compressibility();
  double energy = 0;
  for (const auto& q : QuadratureOf(kNodes)) {
    const double w = q.weight * local.geometry.volume;
    const Gradients<kNodes> gradients = GradientsOf<kNodes>(local.geometry, q.bary);
    const MaterialLaw::Point point = law_.At(local.u * gradients.transpose());
    const double p = mixed ? local.p.dot(q.bary) : bulk * point.g;
    energy += w * (point.energy + (mixed ? p * point.g : 0.5 * p * point.g));
    if (!gradient) continue;
    const Gradients<kNodes> forces = w * (point.stress + p * point.volume_stress) * gradients;
    for (int i = 0, row = 0; i < kNodes; row += layout_.local_size(i), ++i) {
      gradient->block<3, 1>(row, 0) += forces.col(i);
      if (mixed && i < 4) (*gradient)(row + 3, 0) += w * q.bary[i] * point.g;
    }
  }
  if (!mixed) return energy;
  // - p^2 / (2 k): exactly with ten nodes, lumped with four.
  const double V = local.geometry.volume, c = law_.compressibility();
  const Vector4d mass_p = kNodes == 4
                              ? Vector4d(V / 4 * local.p)
                              : Vector4d(V / 20 * (local.p + Vector4d::Constant(local.p.sum())));
  if (gradient) {
    for (int i = 0; i < 4; ++i) (*gradient)(4 * i + 3, 0) -= c * mass_p[i];
  }
  return energy - 0.5 * c * local.p.dot(mass_p);
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
  const double c = regularised ? std::max(law_.compressibility(), kLeastCompressibility)
                               : law_.compressibility();
  Starts<kNodes> start{};
  for (int i = 1; i < kNodes; ++i) {
    start[Index(i)] = start[Index(i) - 1] + layout_.local_size(i - 1);
  }
  ElementMatrix block(layout_.element_size(), layout_.element_size());
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const Local<kNodes> local = Gather<kNodes>(x, e);
    block.setZero();
    for (const auto& q : QuadratureOf(kNodes)) {
      const double w = q.weight * local.geometry.volume;
      const Gradients<kNodes> gradients = GradientsOf<kNodes>(local.geometry, q.bary);
      const Matrix3d H = local.u * gradients.transpose();
      const bool linear = law_.law() == FemOptions::Law::kLinear;
      const bool by_invariants = law_.HasInvariantTangent() && tangent.removed == 0;
      MaterialLaw::Point point;
      if (mixed || !linear) point = law_.At(H);
      const double p = mixed ? local.p.dot(q.bary) : linear ? 0 : bulk * point.g;
      if (by_invariants) {
        AddStiffness<kNodes>(law_.InvariantTangentAt(H, p, bulk), Matrix3d::Identity() + H,
                             point.volume_stress, gradients, w, start, &block);
      } else {
        AddStiffness<kNodes>(law_.TangentAt(H, p, bulk, tangent), gradients, w, start, &block);
      }
      if (!mixed) continue;
      const Gradients<kNodes> changes = w * point.volume_stress * gradients;
      for (int a = 0; a < kNodes; ++a) {
        for (int i = 0; i < 4; ++i) {
          const int row = start[Index(a)], column = 4 * i + 3;
          if (row < column) {
            block.template block<3, 1>(row, column) += q.bary[i] * changes.col(a);
          } else {
            block.template block<1, 3>(column, row) += q.bary[i] * changes.col(a).transpose();
          }
        }
      }
    }
    for (int i = 0; mixed && i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double share = kNodes == 4 ? (i == j ? 0.25 : 0) : (i == j ? 0.1 : 0.05);
        if (i <= j) block(4 * i + 3, 4 * j + 3) -= c * share * local.geometry.volume;
      }
    }
    layout_.Add(e, block, matrix);
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
    const double V = geometry_[Index(e)].volume;
    const auto nodes = mesh_.element(e);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double share =
            mesh_.nodes_per_element == 4 ? (i == j ? 0.25 : 0) : (i == j ? 0.1 : 0.05);
        const int row = nodes[Index(i)], column = nodes[Index(j)];
        if (share > 0 && row <= column) entries.emplace_back(row, column, share * V);
      }
    }
  }
  SparseMatrix mass(mesh_.vertex_count, mesh_.vertex_count);
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

void ElasticBody::AddMass(double factor, bool lumped, SparseMatrix* matrix) const {
  const int n = mesh_.nodes_per_element;
  Eigen::MatrixXd products = ShapeProducts(n);
  if (lumped) {  // in proportion to the diagonal: positive for ten nodes too (Hinton et al. 1976)
    const VectorXd diagonal = products.diagonal() / products.diagonal().sum();
    products = diagonal.asDiagonal();
  }
  ElementMatrix block(layout_.element_size(), layout_.element_size());
  for (int e = 0; e < mesh_.element_count(); ++e) {
    block.setZero();
    for (int b = 0, column = 0; b < n; column += layout_.local_size(b), ++b) {
      for (int a = 0, row = 0; a < n; row += layout_.local_size(a), ++a) {
        const double mass = factor * products(a, b) * geometry_[Index(e)].volume;
        for (int c = 0; c < 3; ++c) block(row + c, column + c) = mass;
      }
    }
    layout_.Add(e, block, matrix);
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

double ElasticBody::SmallestJacobian(const VectorXd& x) const {
  double smallest = std::numeric_limits<double>::infinity();
  const int n = mesh_.nodes_per_element;
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const auto meet = [&](const Vector4d& bary) {
      const Matrix3d F = Matrix3d::Identity() + StrainAt(x, e, bary);
      smallest = std::min(smallest, F.determinant());
    };
    for (const auto& q : QuadratureOf(n)) meet(q.bary);
    for (int corner = 0; n == 10 && corner < 4; ++corner) meet(Vector4d::Unit(corner));
  }
  return smallest;
}

}  // namespace palpate
