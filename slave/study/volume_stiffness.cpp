#include "slave/study/volume_stiffness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/fem/green/rest_stiffness.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"
#include "slave/study/mesh_division.h"
#include "slave/study/study_row.h"
#include "slave/study/width_mismatch.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;
using Edge = std::pair<int, int>;
using Around = std::map<Edge, std::vector<std::size_t>>;  // the tetrahedra of each edge

constexpr std::size_t kMaxTets = 50'000;  // 100,000 take 8 GB and many minutes
constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

Edge EdgeOf(const SolidMesh& mesh, std::size_t tet, std::size_t edge) {
  return std::minmax({mesh.tets[tet][kEdges[edge][0]], mesh.tets[tet][kEdges[edge][1]]});
}

double Length(const SolidMesh& mesh, const Edge& edge) {
  return (mesh.nodes[Index(edge.first)] - mesh.nodes[Index(edge.second)]).norm();
}

Vector3d Middle(const SolidMesh& mesh, const Edge& edge) {
  return 0.5 * (mesh.nodes[Index(edge.first)] + mesh.nodes[Index(edge.second)]);
}

Around TetsAround(const SolidMesh& mesh) {
  Around around;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t e = 0; e < kEdges.size(); ++e) around[EdgeOf(mesh, t, e)].push_back(t);
  }
  return around;
}

Edge MaxTimeOf(const SolidMesh& mesh, std::size_t tet) {
  Edge longest{};
  double length = 0;
  for (std::size_t e = 0; e < kEdges.size(); ++e) {
    const Edge edge = EdgeOf(mesh, tet, e);
    if (Length(mesh, edge) <= length * (1 + 1e-9)) continue;
    longest = edge;
    length = Length(mesh, edge);
  }
  return longest;
}

void Bisect(const Edge& edge, const std::vector<std::size_t>& tets, SolidMesh* mesh) {
  const int middle = static_cast<int>(mesh->nodes.size());
  mesh->nodes.push_back(Middle(*mesh, edge));
  for (const std::size_t t : tets) {
    auto half = mesh->tets[t];
    std::ranges::replace(half, edge.first, middle);
    std::ranges::replace(mesh->tets[t], edge.second, middle);
    mesh->tets.push_back(half);
    if (!mesh->modulus.empty()) mesh->modulus.push_back(mesh->modulus[t]);
  }
}

// Bisects edges that are longer than `allowed`, with all tetrahedra around them. Only the longest
// edge of a tetrahedron is bisected, which preserves the element quality.
void Refine(const std::function<double(const Vector3d&)>& allowed, SolidMesh* mesh) {
  for (bool more = true; more;) {
    more = false;
    Around around = TetsAround(*mesh);
    std::set<std::pair<double, Edge>> chosen;  // the longest first
    for (const auto& [edge, tets] : around) {
      if (Length(*mesh, edge) <= allowed(Middle(*mesh, edge))) continue;
      for (const std::size_t t : tets) {
        const Edge longest = MaxTimeOf(*mesh, t);
        chosen.emplace(-Length(*mesh, longest), longest);
      }
    }
    std::vector<char> taken(mesh->tets.size(), 0);
    for (const auto& [length, edge] : chosen) {
      const auto& tets = around[edge];
      if (std::ranges::any_of(tets, [&](std::size_t t) { return taken[t] != 0; })) continue;
      for (const std::size_t t : tets) taken[t] = 1;
      Bisect(edge, tets, mesh);
      more = true;
    }
  }
}

// Returns which nodes the tool moves.
std::vector<char> MovedNodes(const RestStiffness& stiffness, const Press& press, double width) {
  const TetMesh& elements = stiffness.elements;
  std::vector<char> moved(elements.nodes.size(), 0);
  for (int t = 0; t < static_cast<int>(elements.faces.size()); ++t) {
    if (Normal(elements.surface, t).dot(press.inward_O) > -0.5) continue;
    for (const int node : elements.faces[Index(t)]) {
      const Vector3d p_O = stiffness.length_unit * elements.nodes[Index(node)];
      if ((p_O - press.p_O).norm() <= 0.5 * width * (1 + 1e-9)) moved[Index(node)] = 1;
    }
  }
  return moved;
}

// Rotates the unknowns of nodes moved by the tool from the axes of O to the directions along and
// across the press. Only a sliding tool needs it, because its tangential components are free.
Eigen::SparseMatrix<double> AlongPress(const RestStiffness& stiffness,
                                       const std::vector<char>& moved, const Vector3d& inward) {
  const Vector3d across = inward.unitOrthogonal();
  Eigen::Matrix3d R;
  R << inward, across, inward.cross(across);
  Eigen::SparseMatrix<double> T(stiffness.lower.rows(), stiffness.lower.rows());
  T.setIdentity();
  for (std::size_t n = 0; n < moved.size(); ++n) {
    const auto& row = stiffness.row[n];
    if (moved[n] == 0 || std::ranges::min(row) < 0) continue;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) T.coeffRef(row[Index(i)], row[Index(k)]) = R(i, k);
    }
  }
  T.makeCompressed();
  return T;
}

// Returns the lower triangle of T^T K T. `lower` is the lower triangle of K.
Eigen::SparseMatrix<double> Turned(const Eigen::SparseMatrix<double>& lower,
                                   const Eigen::SparseMatrix<double>& T) {
  const Eigen::SparseMatrix<double> whole = lower.selfadjointView<Eigen::Lower>();
  return Eigen::SparseMatrix<double>(T.transpose() * whole * T).triangularView<Eigen::Lower>();
}

// Returns the rows and columns with an index >= 0, in this order.
Eigen::SparseMatrix<double> Picked(const Eigen::SparseMatrix<double>& lower,
                                   const std::vector<Eigen::Index>& index, Eigen::Index count) {
  Eigen::SparseMatrix<double> picked(count, count);
  picked.reserve(lower.nonZeros());
  for (Eigen::Index j = 0; j < lower.cols(); ++j) {
    if (index[static_cast<std::size_t>(j)] < 0) continue;
    picked.startVec(index[static_cast<std::size_t>(j)]);
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      const Eigen::Index i = index[static_cast<std::size_t>(it.row())];
      if (i >= 0) picked.insertBack(i, index[static_cast<std::size_t>(j)]) = it.value();
    }
  }
  picked.finalize();
  return picked;
}

// Returns u^T K u of the state in which unknowns with `given` != NaN have this value and the others
// are in equilibrium.
double EnergyOf(const RestStiffness& stiffness, const Eigen::VectorXd& given) {
  std::vector<Eigen::Index> index(static_cast<std::size_t>(given.size()), -1);
  Eigen::VectorXd u = given;
  Eigen::Index count = 0;
  for (Eigen::Index k = 0; k < given.size(); ++k) {
    if (std::isfinite(given[k])) continue;
    index[static_cast<std::size_t>(k)] = count++;
    u[k] = 0;
  }
  const auto K = stiffness.lower.selfadjointView<Eigen::Lower>();
  RestStiffness free;
  free.lower = Picked(stiffness.lower, index, count);
  if (stiffness.has_pressure()) free.regularised = Picked(stiffness.regularised, index, count);
  const Eigen::VectorXd load = K * u;
  Eigen::VectorXd x(count);
  for (std::size_t k = 0; k < index.size(); ++k) {
    if (index[k] >= 0) x[index[k]] = -load[static_cast<Eigen::Index>(k)];
  }
  RestFactor(free).Solve(x);
  for (std::size_t k = 0; k < index.size(); ++k) {
    if (index[k] >= 0) u[static_cast<Eigen::Index>(k)] = x[index[k]];
  }
  return u.dot(K * u);
}

}  // namespace

SolidMesh GradedUnder(const Scene& scene, const Press& press, double width, double finest,
                      double growth) {
  SolidMesh mesh = std::get<SolidMesh>(MeshObject(scene, std::nullopt));
  Refine(
      [&](const Vector3d& p) {
        return std::max(finest, growth * ((p - press.p_O).norm() - 0.55 * width));
      },
      &mesh);
  return mesh;
}

bool HasVolumeStiffness(const Scene& scene) {
  return !HoldsByNumber(scene) &&
         std::holds_alternative<SolidMesh>(MeshObject(scene, std::nullopt));
}

std::optional<double> VolumeStiffness(const Scene& scene, const Press& press, double width,
                                      double finest, double growth) {
  if (HoldsByNumber(scene)) return std::nullopt;  // new nodes between them would be free
  try {
    const SolidMesh mesh = GradedUnder(scene, press, width, finest, growth);
    if (mesh.tets.size() > kMaxTets) return std::nullopt;
    RestStiffness stiffness =
        AssembleAtRest(mesh, FixedNodeDofs(scene, mesh.nodes), scene.object.material.poisson_ratio,
                       FemOptions::Element::kTet10);
    const auto moved = MovedNodes(stiffness, press, width);
    const bool slides = scene.model.contact == ContactLaw::kFrictionless;
    if (slides) {
      const auto T = AlongPress(stiffness, moved, press.inward_O);
      stiffness.lower = Turned(stiffness.lower, T);
      if (stiffness.has_pressure()) stiffness.regularised = Turned(stiffness.regularised, T);
    }
    Eigen::VectorXd given = Eigen::VectorXd::Constant(stiffness.lower.rows(), kUnknown);
    for (std::size_t n = 0; n < moved.size(); ++n) {
      const auto& row = stiffness.row[n];
      const bool is_free = std::ranges::min(row) >= 0;
      for (int c = 0; c < 3 && moved[n] != 0; ++c) {
        const double along = !slides || !is_free ? press.inward_O[c] : c == 0 ? 1 : kUnknown;
        if (row[Index(c)] >= 0) given[row[Index(c)]] = along;
      }
    }
    ModelOptions quadratic;
    quadratic.kind = "fem";
    quadratic.fem.element = FemOptions::Element::kTet10;
    const double seen = 1 + WidthMismatch(mesh, quadratic, press, width);
    const double force = scene.object.material.young_modulus * stiffness.length_unit *
                         EnergyOf(stiffness, given) / seen;
    return force > 0 && std::isfinite(force) ? std::optional(force) : std::nullopt;
  } catch (const std::exception&) {  // this formulation is not applicable; others remain
    return std::nullopt;
  }
}

std::optional<double> VolumeRoundForce(const Scene& scene, const Press& press, double depth,
                                       int across, double growth) {
  if (HoldsByNumber(scene)) return std::nullopt;
  try {
    const double R = scene.tool->radius, width = 2 * std::sqrt(R * std::min(depth, R));
    const SolidMesh mesh = GradedUnder(scene, press, width, width / across, growth);
    if (mesh.tets.size() > kMaxTets) return std::nullopt;
    Scene graded = scene;
    graded.model.kind = "fem-green";
    graded.model.fem.element = FemOptions::Element::kTet10;
    graded.model.fem.time = FemOptions::Time::kStatic;
    graded.model.cache.clear();
    graded.object.material.relaxation.clear();
    const auto model = MakeModel(graded, mesh);
    Solution solution;
    const ContactResponse response =
        ToolPress(graded, *scene.tool, mesh)
            .Press({.p_O = press.p_O, .prescribed_O = depth * press.inward_O}, model.get(),
                   &solution);
    const double force = press.inward_O.dot(response.force_O);
    const bool known = IsForceKnown(response.validity) && force > 0 && std::isfinite(force);
    return known ? std::optional(force) : std::nullopt;
  } catch (const std::exception&) {  // as above
    return std::nullopt;
  }
}

}  // namespace palpate::study
