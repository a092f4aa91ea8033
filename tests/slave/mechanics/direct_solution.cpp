#include "tests/slave/mechanics/direct_solution.h"

#include <filesystem>
#include <map>
#include <random>
#include <stdexcept>
#include <string>

#include <Eigen/LU>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/index.h"
#include "tests/support/fixed_nodes.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MatrixXd DenseStiffness(const Body& body) {
  const auto size = static_cast<Eigen::Index>(3 * body.mesh.nodes.size());
  MatrixXd K = MatrixXd::Zero(size, size);
  for (const auto& tet : body.mesh.tets) {
    const auto k = VoigtStiffness(body.mesh, tet, body.E, body.nu);
    for (int a = 0; a < 12; ++a) {
      for (int b = 0; b < 12; ++b) {
        K(3 * tet[Index(a / 3)] + a % 3, 3 * tet[Index(b / 3)] + b % 3) += k(a, b);
      }
    }
  }
  return K;
}

using Shares = std::map<int, double>;  // node: weight

// `springs`: of nodes at a flat tool's rim [m/N].
Shares SharesOf(const SurfaceMesh& surface, const Contact& contact, const Body& body,
                bool whole_nodes, bool* point, std::map<int, Eigen::Matrix3d>* springs) {
  const auto place = FindPlace(surface, contact.p_O);
  if (!place) throw std::invalid_argument("no place there");
  Shares shares;
  *point = true;
  if (contact.width > 0) {
    const DiscPatch patch = PatchAt(surface, *place, contact.p_O, contact.width);
    if (contact.kind == Contact::Kind::kForce) {
      double total = 0;
      for (const int t : patch.triangles) total += Area(surface, t);
      for (const int t : patch.triangles) {
        for (const int n : surface.triangles[Index(t)]) shares[n] += Area(surface, t) / total / 3;
      }
      return shares;
    }
    ContactFootprint under;
    SurfaceFootprints(surface).OnTool(contact, whole_nodes, &under);
    *point = false;
    for (std::size_t k = 0; k < under.places.size(); ++k) {
      const ToolHold& hold = under.holds[k];
      shares[under.places[k].place] = 1;
      if (hold.share >= kWholeShare) continue;
      (*springs)[under.places[k].place] =
          SpringAtRim(body.nu, hold.part_radius, hold.share).Around(under.normal_O) / body.E;
    }
    return shares;
  }
  if (place->node >= 0) return {{place->node, 1.0}};
  for (int v = 0; v < 3; ++v) {
    shares[surface.triangles[Index(place->triangle)][Index(v)]] += place->weights[v];
  }
  return shares;
}

struct Constraint {
  std::vector<std::pair<int, double>> dofs;
  double value = 0;
  int contact = -1;
  Vector3d direction{0, 0, 0};
  int node = -1;  // of a flat tool's rim
  Eigen::Matrix3d spring = Eigen::Matrix3d::Zero();
};

// Mean of the normals of the triangles around a node.
Vector3d NodeNormal(const SurfaceMesh& surface, int node) {
  Vector3d sum = Vector3d::Zero();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    for (const int n : surface.triangles[Index(t)]) {
      if (n == node) sum += Normal(surface, t);
    }
  }
  return sum.normalized();
}

}  // namespace

Eigen::Matrix<double, 12, 12> VoigtStiffness(const SolidMesh& mesh, const std::array<int, 4>& tet,
                                             double E, double nu) {
  const double factor = E / ((1 + nu) * (1 - 2 * nu));
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  D.topLeftCorner<3, 3>().setConstant(factor * nu);
  D.topLeftCorner<3, 3>().diagonal().setConstant(factor * (1 - nu));
  D.bottomRightCorner<3, 3>().diagonal().setConstant(factor * (1 - 2 * nu) / 2);
  Eigen::Matrix4d vertices;  // rows 1, x, y, z
  for (int v = 0; v < 4; ++v) vertices.col(v) << 1, mesh.nodes[Index(tet[Index(v)])];
  const Eigen::Matrix4d shape = vertices.inverse();  // row v: coefficients of N_v
  Eigen::Matrix<double, 6, 12> B = Eigen::Matrix<double, 6, 12>::Zero();
  for (int v = 0; v < 4; ++v) {
    const double x = shape(v, 1), y = shape(v, 2), z = shape(v, 3);
    B.block<6, 3>(0, 3 * v) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
  }
  return vertices.determinant() / 6 * B.transpose() * D * B;
}

Body Standing(SolidMesh mesh, int axis, double E, double nu) {
  double low = mesh.nodes.front()[axis];
  for (const auto& p : mesh.nodes) low = std::min(low, p[axis]);
  const double near = 1e-6 * Diagonal(mesh.nodes);
  HeldNodes held = FixedWhere(mesh, [&](const Vector3d& p) { return p[axis] <= low + near; });
  return {std::move(mesh), std::move(held), E, nu};
}

Body ShakenBox(std::array<int, 3> cells, double E, double nu) {
  SolidMesh mesh = MeshBox({0.06, 0.05, 0.04}, cells);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-1e-3, 1e-3);
  for (auto& p : mesh.nodes) {
    const bool inside = p.x() > 1e-9 && p.x() < 0.06 - 1e-9 && p.y() > 1e-9 && p.y() < 0.05 - 1e-9;
    const Vector3d by(shake(random), shake(random), shake(random));
    if (inside && p.z() > 1e-9) p += p.z() < 0.04 - 1e-9 ? by : Vector3d(by.x(), by.y(), 0);
  }
  return Standing(std::move(mesh), 2, E, nu);
}

SolidMesh FoamMesh(const std::string& name) {
  const auto file = SourcePath("/../shared/data/seed001_meshes/") + name + ".node";
  if (!std::filesystem::exists(file)) return {};
  return std::get<SolidMesh>(ReadMeshFile(file, 1).mesh);
}

DirectAnswer SolveDirectly(const Body& body, std::span<const Contact> contacts, bool frictionless,
                           bool whole_nodes) {
  const SurfaceMesh surface = SurfaceOf(body.mesh);
  const auto dofs = static_cast<int>(3 * body.mesh.nodes.size());
  VectorXd load = VectorXd::Zero(dofs);
  std::vector<Constraint> constraints;
  for (int d = 0; d < dofs; ++d) {
    if (body.held[Index(d / 3)][Index(d % 3)])
      constraints.push_back({{{d, 1.0}}, 0, -1, Vector3d::Zero()});
  }
  std::vector<Shares> shares;
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    const Contact& contact = contacts[Index(i)];
    bool point = true;
    std::map<int, Eigen::Matrix3d> springs;
    shares.push_back(SharesOf(surface, contact, body, whole_nodes, &point, &springs));
    if (contact.kind == Contact::Kind::kForce) {
      for (const auto& [n, w] : shares.back()) load.segment<3>(3 * n) += w * contact.prescribed_O;
      continue;
    }
    std::vector<Vector3d> directions{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    if (frictionless) directions = {NodeNormal(surface, FindPlace(surface, contact.p_O)->node)};
    for (const Vector3d& direction : directions) {
      Eigen::Index axis = 0;
      direction.maxCoeff(&axis);
      const bool is_node = point && shares.back().size() == 1 && !frictionless;
      if (is_node &&
          body.held[Index(shares.back().begin()->first)][Index(static_cast<int>(axis))]) {
        continue;  // fixed already
      }
      Constraint together{{}, direction.dot(contact.prescribed_O), i, direction};
      for (const auto& [n, w] : shares.back()) {
        Constraint alone{{}, together.value, i, direction};
        if (springs.contains(n)) {
          alone.node = n;
          alone.spring = springs[n];
        }
        auto& dofs_of = point ? together.dofs : alone.dofs;
        for (int c = 0; c < 3; ++c) dofs_of.emplace_back(3 * n + c, w * direction[c]);
        if (!point) constraints.push_back(alone);
      }
      if (point) constraints.push_back(together);
    }
  }
  const auto multipliers = static_cast<int>(constraints.size());
  MatrixXd A = MatrixXd::Zero(dofs + multipliers, dofs + multipliers);
  VectorXd b = VectorXd::Zero(dofs + multipliers);
  A.topLeftCorner(dofs, dofs) = DenseStiffness(body);
  const double scale = A(0, 0);
  b.head(dofs) = load;
  for (int m = 0; m < multipliers; ++m) {
    for (const auto& [dof, weight] : constraints[Index(m)].dofs) {
      A(dofs + m, dof) = scale * weight;
      A(dof, dofs + m) = scale * weight;
    }
    b[dofs + m] = scale * constraints[Index(m)].value;
    const Constraint& own = constraints[Index(m)];
    for (int k = 0; k < multipliers; ++k) {
      const Constraint& other = constraints[Index(k)];
      if (own.node < 0 || other.node != own.node || other.contact != own.contact) continue;
      A(dofs + m, dofs + k) = -scale * scale * own.direction.dot(own.spring * other.direction);
    }
  }
  const VectorXd x = A.partialPivLu().solve(b);
  DirectAnswer answer;
  for (int n = 0; n < dofs / 3; ++n) answer.displacement_O.emplace_back(x.segment<3>(3 * n));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    answer.force_O.push_back(Vector3d::Zero());
    Vector3d mean = Vector3d::Zero();
    for (const auto& [n, w] : shares[i]) mean += w * answer.displacement_O[Index(n)];
    answer.mean_O.push_back(mean);
  }
  for (int m = 0; m < multipliers; ++m) {
    const Constraint& constraint = constraints[Index(m)];
    if (constraint.contact < 0) continue;
    answer.force_O[Index(constraint.contact)] -= scale * x[dofs + m] * constraint.direction;
  }
  return answer;
}

}  // namespace palpate
