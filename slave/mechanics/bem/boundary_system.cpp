#include "slave/mechanics/bem/boundary_system.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "shared/text/text.h"
#include "slave/mechanics/bem/kelvin_integrals.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kReportEvery = 16;  // elements

// Contributions of the element's Legendre modes at a point.
using ModeBlocks = std::array<KelvinBlocks<double>, kMaxNodeCount>;

void Integrate(const KelvinConstants& constants, const ElementView& view, int modes,
               ModeBlocks* blocks) {
  const KelvinIntegrals<double> mean(view.xi_a, view.d, view.length);
  (*blocks)[0] = Combine(constants, mean, view.length, view.t.x(), view.t.y());
  if (modes == 1) return;
  const LegendreMoments moments(view.z());
  for (std::size_t k = 1; k < Index(modes); ++k) {
    const auto integrals = KelvinMode(moments, k, 0.5 * view.length, view.d);
    (*blocks)[k] = Combine(constants, integrals, 0, view.t.x(), view.t.y());
  }
}

// Contribution of a node's values: H and G.
KelvinBlocks<double> NodeBlocks(const ElementNodes& local, std::size_t node,
                                const ModeBlocks& modes) {
  KelvinBlocks<double> blocks{local.mode[node][0] * modes[0].of_traction,
                              local.mode[node][0] * modes[0].of_displacement};
  for (std::size_t k = 1; k < Index(local.count); ++k) {
    blocks.of_displacement += local.mode[node][k] * modes[k].of_displacement;
    blocks.of_traction += local.mode[node][k] * modes[k].of_traction;
  }
  return blocks;
}

struct HoleCentre {
  Vector2d p_O{0, 0};  // [m]
  double radius = 0;   // of a circle around it that stays in the hole [m]
};

// Returns the point in a hole that is farthest from the body: the centre of the largest circle in
// it that touches the boundary at the midpoint of an element of `loop`. It also exists in slits.
// O(n^2). A circle of radius r that touches the boundary at m with its centre along the unit normal
// n excludes the point q if |q - m|^2 >= 2 r n . (q - m).
HoleCentre FindHoleCentre(const BoundaryMesh& mesh, int loop) {
  const auto first = mesh.elements.begin() + mesh.loop_begin[Index(loop)];
  const auto last = mesh.elements.begin() + mesh.loop_begin[Index(loop) + 1];
  HoleCentre best;
  for (auto touched = first; touched != last; ++touched) {
    const Vector2d m = touched->midpoint();
    const Vector2d n = touched->normal();
    double radius = std::numeric_limits<double>::infinity();
    for (auto other = first; other != last; ++other) {
      for (const Vector2d& q : {other->a, other->midpoint()}) {
        const double ahead = n.dot(q - m);
        if (ahead > 0) radius = std::min(radius, 0.5 * (q - m).squaredNorm() / ahead);
      }
    }
    if (radius > best.radius && radius < std::numeric_limits<double>::infinity()) {
      best = {m + radius * n, radius};
    }
  }
  return best;
}

}  // namespace

PlaneElasticity PlaneElasticity::From(double nu, Plane plane) {
  if (!(nu > -1 && nu <= 0.5)) RefuseValue("poisson_ratio", nu, "-1 < nu <= 0.5");
  return {1 / (2 * (1 + nu)), plane == Plane::kStress ? nu / (1 + nu) : nu};
}

std::vector<BoundaryNode> NodesOf(const ReferenceProblem& problem) {
  const ElementNodes& local = ElementNodes::Of(problem.order);
  std::vector<BoundaryNode> nodes;
  nodes.reserve(problem.mesh.elements.size() * Index(local.count));
  for (int i = 0; i < problem.mesh.size(); ++i) {
    const auto& e = problem.mesh.elements[Index(i)];
    const double length = e.length() / problem.mesh.length_unit;
    for (std::size_t m = 0; m < Index(local.count); ++m) {
      nodes.push_back({e.midpoint() + 0.5 * local.s[m] * (e.b - e.a), i, local.weight[m] * length});
    }
  }
  return nodes;
}

ElementView ViewOf(const BoundaryMesh& mesh, int element, const Vector2d& p_O) {
  const auto& e = mesh.elements[Index(element)];
  const Vector2d t = (e.b - e.a).normalized();
  const Vector2d n(t.y(), -t.x());
  const Vector2d r = e.a / mesh.length_unit - p_O / mesh.length_unit;
  return {t, n, r.dot(t), r.dot(n), e.length() / mesh.length_unit};
}

void BoundarySystem::Collocate(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar,
                               Progress* progress) const {
  const int elements = problem_.mesh.size();
  for (int j = 0; j < elements; ++j) {
    CollocateElement(j, A, Abar);
    if (j % kReportEvery == 0) {
      ReportProgress(progress, "boundary integrals", static_cast<double>(j) / elements);
    }
  }
}

// The columns of one element's nodes. Unknown displacement: H to the left, G to the right; unknown
// traction: -G and -H.
void BoundarySystem::CollocateElement(int element, Eigen::MatrixXd* A,
                                      Eigen::MatrixXd* Abar) const {
  const KelvinConstants constants(elasticity_.shear_modulus, elasticity_.effective_nu);
  const ElementNodes& local = ElementNodes::Of(problem_.order);
  const double unit = problem_.mesh.length_unit;
  const Vector2d a = problem_.mesh.elements[Index(element)].a / unit;
  ElementView view = ViewOf(problem_.mesh, element, problem_.mesh.elements[Index(element)].a);
  ModeBlocks modes;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vector2d r = a - nodes_[i].p_O / unit;
    const bool self = nodes_[i].element == element;
    const std::size_t own = i - Index(element) * Index(local.count);
    view.xi_a = self ? -0.5 * view.length * (1 + local.s[own]) : r.dot(view.t);
    view.d = self ? 0 : r.dot(view.n);
    Integrate(constants, view, local.count, &modes);
    const auto row = static_cast<Eigen::Index>(2 * i);
    for (std::size_t m = 0; m < Index(local.count); ++m) {
      auto [g, h] = NodeBlocks(local, m, modes);
      if (self && m == own) h.diagonal().array() += 0.5;
      for (int c = 0; c < 2; ++c) {
        const Eigen::Index column =
            2 * (Eigen::Index{element} * local.count + static_cast<Eigen::Index>(m)) + c;
        const bool fixed = held(Index(element), c);
        const double sign = fixed ? -1 : 1;
        A->block<2, 1>(row, column) = sign * (fixed ? g : h).col(c);
        Abar->block<2, 1>(row, column) = sign * (fixed ? h : g).col(c);
      }
    }
  }
}

void BoundarySystem::Inside(const std::vector<Vector2d>& places, Eigen::MatrixXd* H,
                            Eigen::MatrixXd* G) const {
  const KelvinConstants constants(elasticity_.shear_modulus, elasticity_.effective_nu);
  const ElementNodes& local = ElementNodes::Of(problem_.order);
  const auto rows = static_cast<Eigen::Index>(2 * places.size());
  const auto columns = static_cast<Eigen::Index>(2 * nodes_.size());
  H->resize(rows, columns);
  G->resize(rows, columns);
  ModeBlocks modes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t node = 0; node < nodes_.size(); ++node) {
      const std::size_t own = node % Index(local.count);
      if (own == 0) {
        Integrate(constants, ViewOf(problem_.mesh, nodes_[node].element, places[i]), local.count,
                  &modes);
      }
      const KelvinBlocks<double> blocks = NodeBlocks(local, own, modes);
      const auto row = static_cast<Eigen::Index>(2 * i),
                 column = static_cast<Eigen::Index>(2 * node);
      H->block<2, 2>(row, column) = blocks.of_displacement;
      G->block<2, 2>(row, column) = blocks.of_traction;
    }
  }
}

void BoundarySystem::AppendHolePressures(Eigen::Index first, Eigen::MatrixXd* A,
                                         Eigen::MatrixXd* Abar) const {
  const ElementNodes& local = ElementNodes::Of(problem_.order);
  const BoundaryMesh& mesh = problem_.mesh;
  A->rightCols(holes()).setZero();
  A->bottomRows(holes()).setZero();
  Abar->bottomRows(holes()).setZero();
  for (int hole = 0; hole < holes(); ++hole) {
    const HoleCentre centre = FindHoleCentre(mesh, hole + 1);
    // The row's entries are of the order of one, as those of H are.
    const double scale = centre.radius / (2 * std::numbers::pi * mesh.length_unit);
    const Eigen::Index row = first + hole;
    for (int j = 0; j < mesh.size(); ++j) {
      const ElementView view = ViewOf(mesh, j, centre.p_O);
      const double h = 0.5 * view.length;
      const LegendreMoments moments(view.z());
      for (std::size_t m = 0; m < Index(local.count); ++m) {
        std::complex<double> pole, dipole;
        for (std::size_t k = 0; k < Index(local.count); ++k) {
          pole += local.mode[m][k] * moments.pole[k];
          dipole += local.mode[m][k] * moments.dipole[k];
        }
        const Vector2d g = scale * (pole.real() * view.t - pole.imag() * view.n);
        const Vector2d u = 2 * elasticity_.shear_modulus * scale / h *
                           (dipole.imag() * view.t + dipole.real() * view.n);
        for (int c = 0; c < 2; ++c) {
          const Eigen::Index column =
              2 * (Eigen::Index{j} * local.count + static_cast<Eigen::Index>(m)) + c;
          const bool fixed = held(Index(j), c);
          (*A)(row, column) = fixed ? -g[c] : u[c];
          (*Abar)(row, column) = fixed ? -u[c] : g[c];
        }
      }
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const int element = nodes_[i].element;
      const bool on_hole =
          element >= mesh.loop_begin[Index(hole) + 1] && element < mesh.loop_begin[Index(hole) + 2];
      if (!on_hole) continue;
      A->block<2, 1>(static_cast<Eigen::Index>(2 * i), row) =
          mesh.elements[Index(element)].normal();
    }
  }
}

}  // namespace palpate
