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

using Displacements = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxNodes>;

// Adds the stiffness of one quadrature point: K_ab = sum over J, L of g_aJ D_JL g_bL.
void AddStiffness(const Matrix9d& D, const ShapeGradients& gradients, double weight,
                  const std::array<int, kMaxNodes>& start, ElementMatrix* block) {
  const int n = static_cast<int>(gradients.cols());
  for (int b = 0; b < n; ++b) {
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

}  // namespace

struct ElasticBody::Local {
  const TetGeometry& geometry;
  Displacements u;
  Vector4d p = Vector4d::Zero();
};

ElasticBody::ElasticBody(const ElementMesh& mesh, const BlockLayout& layout, const MaterialLaw& law)
    : mesh_(mesh), layout_(layout), law_(law) {
  geometry_.reserve(Index(mesh.element_count()));
  for (int e = 0; e < mesh.element_count(); ++e) geometry_.push_back(GeometryOf(mesh, e));
}

ElasticBody::Local ElasticBody::Gather(const VectorXd& x, int element) const {
  Local local{geometry_[Index(element)], Displacements(3, mesh_.nodes_per_element), {0, 0, 0, 0}};
  const auto nodes = mesh_.element(element);
  for (int i = 0; i < mesh_.nodes_per_element; ++i) {
    local.u.col(i) = x.segment<3>(layout_.first(nodes[Index(i)]));
  }
  if (layout_.has_pressure()) {
    for (int i = 0; i < 4; ++i) local.p[i] = x[layout_.pressure(nodes[Index(i)])];
  }
  return local;
}

// Energy of one element; its gradient, where asked for, goes to one column, node by node.
double ElasticBody::AddElement(const Local& local, ElementMatrix* gradient) const {
  const int n = mesh_.nodes_per_element;
  const bool mixed = layout_.has_pressure();
  double energy = 0;
  for (const auto& q : QuadratureOf(n)) {
    const double w = q.weight * local.geometry.volume;
    const ShapeGradients gradients = GradientsAt(local.geometry, n, q.bary);
    const MaterialLaw::Point point = law_.At(local.u * gradients.transpose());
    const double bulk = 1 / law_.compressibility();
    const double p = mixed ? local.p.dot(q.bary) : bulk * point.g;
    energy += w * (point.energy + (mixed ? p * point.g : 0.5 * p * point.g));
    if (!gradient) continue;
    const Matrix3d stress = point.stress + p * point.volume_stress;
    for (int i = 0, row = 0; i < n; row += layout_.local_size(i), ++i) {
      gradient->block<3, 1>(row, 0).noalias() += w * stress * gradients.col(i);
      if (mixed && i < 4) (*gradient)(row + 3, 0) += w * q.bary[i] * point.g;
    }
  }
  if (!mixed) return energy;
  // - p^2 / (2 k): exactly with ten nodes, lumped with four.
  const double V = local.geometry.volume, c = law_.compressibility();
  const Vector4d mass_p = n == 4 ? Vector4d(V / 4 * local.p)
                                 : Vector4d(V / 20 * (local.p + Vector4d::Constant(local.p.sum())));
  if (gradient) {
    for (int i = 0; i < 4; ++i) (*gradient)(4 * i + 3, 0) -= c * mass_p[i];
  }
  return energy - 0.5 * c * local.p.dot(mass_p);
}

double ElasticBody::Energy(const VectorXd& x, VectorXd* gradient) const {
  gradient->setZero();
  double energy = 0;
  ElementMatrix local(layout_.element_size(), 1);
  for (int e = 0; e < mesh_.element_count(); ++e) {
    local.setZero();
    energy += AddElement(Gather(x, e), &local);
    const auto nodes = mesh_.element(e);
    for (int i = 0, row = 0; i < mesh_.nodes_per_element; ++i) {
      const int size = layout_.local_size(i);
      gradient->segment(layout_.first(nodes[Index(i)]), size) += local.block(row, 0, size, 1);
      row += size;
    }
  }
  return energy;
}

double ElasticBody::Energy(const VectorXd& x) const {
  double energy = 0;
  for (int e = 0; e < mesh_.element_count(); ++e) energy += AddElement(Gather(x, e), nullptr);
  return energy;
}

void ElasticBody::AddTangent(const VectorXd& x, const Tangent& tangent, bool regularised,
                             SparseMatrix* matrix) const {
  const int n = mesh_.nodes_per_element;
  const bool mixed = layout_.has_pressure();
  const double bulk = mixed ? 0 : 1 / law_.compressibility();
  const double c = regularised ? std::max(law_.compressibility(), kLeastCompressibility)
                               : law_.compressibility();
  std::array<int, kMaxNodes> start{};
  for (int i = 1; i < n; ++i) start[Index(i)] = start[Index(i) - 1] + layout_.local_size(i - 1);
  ElementMatrix block(layout_.element_size(), layout_.element_size());
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const Local local = Gather(x, e);
    block.setZero();
    for (const auto& q : QuadratureOf(n)) {
      const double w = q.weight * local.geometry.volume;
      const ShapeGradients gradients = GradientsAt(local.geometry, n, q.bary);
      const Matrix3d H = local.u * gradients.transpose();
      if (!mixed) {
        const double p = law_.law() == FemOptions::Law::kLinear ? 0 : bulk * law_.At(H).g;
        AddStiffness(law_.TangentAt(H, p, bulk, tangent), gradients, w, start, &block);
        continue;
      }
      AddStiffness(law_.TangentAt(H, local.p.dot(q.bary), 0, tangent), gradients, w, start, &block);
      const Matrix3d volume_stress = law_.At(H).volume_stress;
      for (int a = 0; a < n; ++a) {
        const Vector3d change = w * volume_stress * gradients.col(a);
        for (int i = 0; i < 4; ++i) {
          const int row = start[Index(a)], column = 4 * i + 3;
          if (row < column) {
            block.block<3, 1>(row, column) += q.bary[i] * change;
          } else {
            block.block<1, 3>(column, row) += q.bary[i] * change.transpose();
          }
        }
      }
    }
    for (int i = 0; mixed && i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double share = n == 4 ? (i == j ? 0.25 : 0) : (i == j ? 0.1 : 0.05);
        if (i <= j) block(4 * i + 3, 4 * j + 3) -= c * share * local.geometry.volume;
      }
    }
    block.triangularView<Eigen::StrictlyLower>() = block.transpose();
    layout_.Add(e, block, matrix);
  }
}

void ElasticBody::VolumeChange(const VectorXd& x, VectorXd* change) const {
  change->setZero();
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const Local local = Gather(x, e);
    const auto nodes = mesh_.element(e);
    for (const auto& q : QuadratureOf(mesh_.nodes_per_element)) {
      const ShapeGradients gradients = GradientsAt(local.geometry, mesh_.nodes_per_element, q.bary);
      const double g = law_.At(local.u * gradients.transpose()).g;
      for (int i = 0; i < 4; ++i) {
        (*change)[nodes[Index(i)]] += q.weight * local.geometry.volume * q.bary[i] * g;
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
    const Local local = Gather(x, e);
    const auto meet = [&](const Vector4d& bary) {
      const Matrix3d F =
          Matrix3d::Identity() + local.u * GradientsAt(local.geometry, n, bary).transpose();
      smallest = std::min(smallest, F.determinant());
    };
    for (const auto& q : QuadratureOf(n)) meet(q.bary);
    for (int corner = 0; n == 10 && corner < 4; ++corner) meet(Vector4d::Unit(corner));
  }
  return smallest;
}

}  // namespace palpate
