#include "slave/mechanics/membrane/inflated_membrane.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

void Refuse(const std::string& what) {
  throw std::invalid_argument("membrane: " + what);
}
void Refuse(const std::string& name, double value, const std::string& accepted) {
  Refuse(name + " = " + std::to_string(value) + ": expected " + accepted);
}

void CheckParams(const InflatedMembrane::Params& params) {
  const auto not_negative = [](const std::string& name, double value) {
    if (!(value >= 0 && std::isfinite(value))) Refuse(name, value, ">= 0");
  };
  not_negative("modulus", params.modulus);
  not_negative("tension", params.tension);
  not_negative("air_stiffness", params.air_stiffness);
  if (!(params.modulus + params.tension > 0)) {
    Refuse("modulus", params.modulus, "> 0, or a tension > 0");
  }
  if (!(params.poisson_ratio > -1 && params.poisson_ratio <= 0.5)) {
    Refuse("poisson_ratio", params.poisson_ratio, "-1 < nu <= 0.5");
  }
  if (params.pressure && !std::isfinite(*params.pressure)) {
    Refuse("pressure", *params.pressure, "a number");
  }
}

MembraneTriangle TriangleOf(const SurfaceMesh& mesh, std::size_t t) {
  const auto at = [&](int corner) { return mesh.nodes[Index(mesh.triangles[t][Index(corner)])]; };
  return MembraneTriangle({at(0), at(1), at(2)});
}

// Returns which nodes are fixed; throws for unusable shapes.
std::vector<char> CheckShape(const MembraneShape& shape) {
  const SurfaceMesh& mesh = shape.surface;
  const auto nodes = static_cast<int>(mesh.nodes.size());
  if (mesh.triangles.empty()) Refuse("no triangle");
  for (int i = 0; i < nodes; ++i) {
    if (!mesh.nodes[Index(i)].allFinite()) Refuse("node " + std::to_string(i) + " is not finite");
  }
  std::vector<char> used(mesh.nodes.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    double longest = 0;
    for (const int node : mesh.triangles[t]) {
      if (node < 0 || node >= nodes)
        Refuse("triangle " + std::to_string(t) + " has a node that does not exist");
      used[Index(node)] = 1;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = Index(mesh.triangles[t][k]);
      const auto b = Index(mesh.triangles[t][(k + 1) % 3]);
      longest = std::max(longest, (mesh.nodes[a] - mesh.nodes[b]).squaredNorm());
    }
    if (!(TriangleOf(mesh, t).area() > 1e-9 * longest)) {
      Refuse("triangle " + std::to_string(t) + " has no area");
    }
  }
  std::vector<char> held(mesh.nodes.size(), 0);
  for (const int node : shape.held) {
    if (node < 0 || node >= nodes) Refuse("fixed node " + std::to_string(node) + " does not exist");
    held[Index(node)] = 1;
  }
  for (int i = 0; i < nodes; ++i) {
    const auto at = Index(i);
    if (used[at] == 0 && held[at] == 0) {
      Refuse("node " + std::to_string(i) + " belongs to no triangle");
    }
  }
  return held;
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// Makes nodes at `place(radius share, angle)`, ring by ring around the centre, with the outermost
// ring fixed, and counter-clockwise triangles.
MembraneShape MakeRings(int rings, const std::function<Eigen::Vector3d(double, double)>& place) {
  if (rings < 1 || rings > 1000) RefuseValue("rings", rings, "1 to 1000");
  MembraneShape made;
  auto& [nodes, triangles] = made.surface;
  nodes.push_back(place(0, 0));
  const auto first = [](int ring) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1); };
  for (int ring = 1; ring <= rings; ++ring) {
    const int count = 6 * ring;
    const int inner_count = std::max(1, count - 6);
    for (int k = 0; k < count; ++k) {
      nodes.push_back(place(static_cast<double>(ring) / rings, 2 * std::numbers::pi * k / count));
      // Sextant and step in it; the next inner ring has one step fewer per sextant.
      const int sextant = k / ring;
      const int step = k % ring;
      const int outer = first(ring) + k;
      const int outer_next = first(ring) + (k + 1) % count;
      const int inner = first(ring - 1) + (sextant * (ring - 1) + step) % inner_count;
      triangles.push_back({outer, outer_next, inner});
      if (step < ring - 1) {
        const int inner_next = first(ring - 1) + (sextant * (ring - 1) + step + 1) % inner_count;
        triangles.push_back({inner, outer_next, inner_next});
      }
      if (ring == rings) made.held.push_back(outer);
    }
  }
  return made;
}

}  // namespace

MembraneTriangle::MembraneTriangle(const std::array<Eigen::Vector3d, 3>& p) : p_(p) {
  const Eigen::Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
  area_ = twice_area.norm() / 2;
  normal_ = twice_area.normalized();
  for (int k = 0; k < 3; ++k) {
    const auto next = Index((k + 1) % 3);
    const auto last = Index((k + 2) % 3);
    gradients_.col(k) = normal_.cross(p[last] - p[next]) / (2 * area_);
  }
}

TriangleMatrix MembraneTriangle::Elastic(double poisson_ratio) const {
  const double nu = poisson_ratio;
  Eigen::Matrix3d law;
  law << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  law /= 1 - nu * nu;
  const Eigen::Vector3d e1 = (p_[1] - p_[0]).normalized();
  const Eigen::Vector3d e2 = normal_.cross(e1);
  Eigen::Matrix<double, 3, 9> strain;
  for (int k = 0; k < 3; ++k) {
    const double d1 = gradients_.col(k).dot(e1);
    const double d2 = gradients_.col(k).dot(e2);
    strain.block<1, 3>(0, 3 * k) = d1 * e1.transpose();
    strain.block<1, 3>(1, 3 * k) = d2 * e2.transpose();
    strain.block<1, 3>(2, 3 * k) = d2 * e1.transpose() + d1 * e2.transpose();
  }
  return area_ * strain.transpose() * law * strain;
}

TriangleMatrix MembraneTriangle::Tension() const {
  TriangleMatrix k = TriangleMatrix::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double product = area_ * gradients_.col(i).dot(gradients_.col(j));
      k.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(product);
    }
  }
  return k;
}

TriangleMatrix MembraneTriangle::Volume() const {
  TriangleMatrix h = TriangleMatrix::Zero();
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    const int last = (i + 2) % 3;
    const Eigen::Matrix3d block = CrossMatrix(p_[Index(last)]) / 6;
    h.block<3, 3>(3 * i, 3 * next) = -block;
    h.block<3, 3>(3 * next, 3 * i) = block;
  }
  return h;
}

struct InflatedMembrane::Factor {
  Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>> cholesky;
  double scale = 1;           // of K before it was factored
  Eigen::VectorXd volume;     // v, of the unknown components
  Eigen::VectorXd by_volume;  // K^-1 v, without the air
  double give_by_volume = 0;  // v . K^-1 v
};

InflatedMembrane::InflatedMembrane(MembraneShape shape, const Params& params)
    : shape_(std::move(shape)), params_(params), factor_(std::make_unique<Factor>()) {
  CheckParams(params_);
  held_ = CheckShape(shape_);
  int unknowns = 0;
  for (const char held : held_) {
    unknown_.push_back(held != 0 ? -1 : unknowns);
    unknowns += held != 0 ? 0 : 3;
  }
  if (unknowns == 0) Refuse("every node is fixed");
  FindNormals();
  Assemble();
}

InflatedMembrane::~InflatedMembrane() = default;
InflatedMembrane::InflatedMembrane(InflatedMembrane&&) noexcept = default;
InflatedMembrane& InflatedMembrane::operator=(InflatedMembrane&&) noexcept = default;

// Normals, areas, and the pressure that balances the tension best.
void InflatedMembrane::FindNormals() {
  const SurfaceMesh& mesh = shape_.surface;
  // Nodal force per unit pressure.
  std::vector<Eigen::Vector3d> push(mesh.nodes.size(), Eigen::Vector3d::Zero());
  std::vector<Eigen::Vector3d> pull = push;  // nodal force per unit tension
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const MembraneTriangle triangle = TriangleOf(mesh, t);
    Eigen::Matrix<double, 9, 1> p;
    for (int k = 0; k < 3; ++k) {
      const int node = mesh.triangles[t][Index(k)];
      push[Index(node)] += triangle.area() / 3 * triangle.normal();
      p.segment<3>(3 * k) = mesh.nodes[Index(node)];
    }
    const Eigen::Matrix<double, 9, 1> pulled = triangle.Tension() * p;
    for (int k = 0; k < 3; ++k) {
      const int node = mesh.triangles[t][Index(k)];
      pull[Index(node)] += pulled.segment<3>(3 * k);
    }
  }
  double pull_by_push = 0;
  double push_by_push = 0;
  for (std::size_t i = 0; i < push.size(); ++i) {
    normals_.push_back(push[i].normalized());
    areas_.push_back(push[i].norm());
    if (held_[i] != 0) continue;
    pull_by_push += pull[i].dot(push[i]);
    push_by_push += push[i].squaredNorm();
  }
  pressure_ = params_.pressure.value_or(params_.tension * pull_by_push / push_by_push);
}

void InflatedMembrane::Assemble() {
  const SurfaceMesh& mesh = shape_.surface;
  const auto unknowns =
      3 * static_cast<Eigen::Index>(std::count(held_.begin(), held_.end(), char{0}));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const MembraneTriangle triangle = TriangleOf(mesh, t);
    const TriangleMatrix k = params_.modulus * triangle.Elastic(params_.poisson_ratio) +
                             params_.tension * triangle.Tension() - pressure_ * triangle.Volume();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const int row = unknown_[Index(mesh.triangles[t][i])];
        const int column = unknown_[Index(mesh.triangles[t][j])];
        if (row < 0 || column < 0) continue;
        for (int a = 0; a < 9; ++a) {
          entries.emplace_back(row + a % 3, column + a / 3,
                               k(3 * static_cast<int>(i) + a % 3, 3 * static_cast<int>(j) + a / 3));
        }
      }
    }
  }
  Sparse stiffness(unknowns, unknowns);
  stiffness.setFromTriplets(entries.begin(), entries.end());
  factor_->scale = 1 / (params_.modulus + params_.tension);
  stiffness *= factor_->scale;
  factor_->cholesky.compute(stiffness);
  if (factor_->cholesky.info() != Eigen::Success) {
    Refuse("unstable at a pressure of " + std::to_string(pressure_) +
           " Pa: expected less pressure, or more tension or modulus");
  }
  factor_->volume.resize(unknowns);
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    if (unknown_[i] >= 0) factor_->volume.segment<3>(unknown_[i]) = areas_[i] * normals_[i];
  }
  factor_->by_volume = factor_->cholesky.solve(factor_->volume) * factor_->scale;
  factor_->give_by_volume = factor_->volume.dot(factor_->by_volume);
}

double InflatedMembrane::Displace(std::span<const Eigen::Vector3d> forces,
                                  std::vector<Eigen::Vector3d>* displacements) const {
  Eigen::VectorXd f(factor_->volume.size());
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    if (unknown_[i] >= 0) f.segment<3>(unknown_[i]) = forces[i];
  }
  Eigen::VectorXd u = factor_->cholesky.solve(f) * factor_->scale;
  const double k = params_.air_stiffness;
  const double rise =
      -k * factor_->volume.dot(u) / (1 + k * factor_->give_by_volume);  // Sherman-Morrison
  u += rise * factor_->by_volume;
  displacements->assign(unknown_.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    if (unknown_[i] >= 0) (*displacements)[i] = u.segment<3>(unknown_[i]);
  }
  return rise;
}

Eigen::MatrixXd InflatedMembrane::NormalCompliance() const {
  const auto nodes = static_cast<Eigen::Index>(unknown_.size());
  Eigen::MatrixXd compliance = Eigen::MatrixXd::Zero(nodes, nodes);
  const auto normal_part = [this](const Eigen::VectorXd& u, Eigen::Index i) {
    const int at = unknown_[static_cast<std::size_t>(i)];
    return at < 0 ? 0.0 : normals_[static_cast<std::size_t>(i)].dot(u.segment<3>(at));
  };
  Eigen::VectorXd f = Eigen::VectorXd::Zero(factor_->volume.size());
  for (Eigen::Index j = 0; j < nodes; ++j) {
    const int at = unknown_[static_cast<std::size_t>(j)];
    if (at < 0) continue;
    f.segment<3>(at) = normals_[static_cast<std::size_t>(j)];
    const Eigen::VectorXd u = factor_->cholesky.solve(f) * factor_->scale;
    f.segment<3>(at).setZero();
    for (Eigen::Index i = 0; i < nodes; ++i) compliance(i, j) = normal_part(u, i);
  }
  if (params_.air_stiffness > 0) {
    Eigen::VectorXd by_volume(nodes);
    for (Eigen::Index i = 0; i < nodes; ++i) by_volume[i] = normal_part(factor_->by_volume, i);
    compliance -= params_.air_stiffness / (1 + params_.air_stiffness * factor_->give_by_volume) *
                  by_volume * by_volume.transpose();
  }
  return compliance;
}

double DistanceOutside(const Ellipsoid& ellipsoid, const Eigen::Vector3d& p) {
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  const Eigen::Vector3d on_sphere = inverse * (p - ellipsoid.centre);
  const double radius = on_sphere.norm();
  return (radius - 1) * radius / (inverse * on_sphere).norm();
}

MembraneShape MeshFlatMembrane(double radius, int rings) {
  RequirePositive("radius", radius);
  return MakeRings(rings, [&](double share, double angle) {
    const double r = radius * share;
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0);
  });
}

MembraneShape MeshDomedMembrane(const Ellipsoid& ellipsoid, const Eigen::Vector3d& axis, double rim,
                                int rings) {
  const Eigen::Vector3d e1 = axis.unitOrthogonal();
  const Eigen::Vector3d e2 = axis.cross(e1);
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  // Returns the point of the ellipsoid at this angle from the axis.
  const auto point = [&](double polar, double angle) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = std::cos(polar) * axis + std::sin(polar) * std::cos(angle) * e1 +
                                std::sin(polar) * std::sin(angle) * e2;
    return ellipsoid.centre + ray / (inverse * ray).norm();
  };
  const auto above = [&](const Eigen::Vector3d& p) { return p.dot(axis) - rim; };
  if (!(above(point(0, 0)) > 0 && above(point(std::numbers::pi, 0)) < 0)) {
    RefuseValue("rim", rim, "a plane that cuts the ellipsoid along the axis");
  }
  return MakeRings(rings, [&](double share, double angle) {
    double low = 0;
    double high = std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (above(point(middle, angle)) > 0 ? low : high) = middle;
    }
    return point(share * low, angle);
  });
}

}  // namespace palpate
