#include "slave/mechanics/fem/tool_contacts.h"

#include <algorithm>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

std::vector<double> EdgesAround(const SurfaceMesh& surface) {
  std::vector<double> sum(surface.nodes.size(), 0), count(surface.nodes.size(), 0);
  for (const auto& triangle : surface.triangles) {
    for (std::size_t v = 0; v < 3; ++v) {
      const auto a = Index(triangle[v]), b = Index(triangle[(v + 1) % 3]);
      const double length = (surface.nodes[a] - surface.nodes[b]).norm();
      for (const std::size_t node : {a, b}) sum[node] += length, ++count[node];
    }
  }
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] /= std::max(1.0, count[n]);
  return sum;
}

// Returns the mean normal of the surrounding triangles, weighted by their areas.
std::vector<Vector3d> NormalsAround(const SurfaceMesh& surface) {
  std::vector<Vector3d> normals(surface.nodes.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const int triangle = static_cast<int>(t);
    const Vector3d area = Area(surface, triangle) * Normal(surface, triangle);
    for (const int node : surface.triangles[t]) normals[Index(node)] += area;
  }
  for (Vector3d& normal : normals) normal.stableNormalize();
  return normals;
}

// Returns a third of the areas of the surrounding triangles [m^2].
std::vector<double> AreasAround(const SurfaceMesh& surface) {
  std::vector<double> areas(surface.nodes.size(), 0);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const double third = Area(surface, static_cast<int>(t)) / 3;
    for (const int node : surface.triangles[t]) areas[Index(node)] += third;
  }
  return areas;
}

// Returns the mean modulus of the elements around each node, weighted by their volumes.
std::vector<double> ModuliAround(const SolidMesh& mesh) {
  if (mesh.modulus.empty()) return std::vector<double>(mesh.nodes.size(), 1);
  std::vector<double> sum(mesh.nodes.size(), 0), volume(mesh.nodes.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double size = SignedVolume(mesh, static_cast<int>(t));
    for (const int node : mesh.tets[t]) {
      sum[Index(node)] += size * mesh.ModulusOf(t);
      volume[Index(node)] += size;
    }
  }
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] = volume[n] > 0 ? sum[n] / volume[n] : 1;
  return sum;
}

}  // namespace

ToolContacts::ToolContacts(const SolidMesh& mesh, double poisson_ratio, const FemBody& body,
                           Constraints& constraints)
    : body_(body),
      poisson_ratio_(poisson_ratio),
      constraints_(constraints),
      skin_(SurfaceOf(mesh)),
      normals_(NormalsAround(skin_)),
      owner_(Index(body.size()), ToolContact::kNoTool) {
  const std::vector<double> edges = EdgesAround(skin_), areas = AreasAround(skin_),
                            moduli = ModuliAround(mesh);
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const int node = body.Number(static_cast<int>(n));
    const double* free = At(body.free(), node).v;
    if (edges[n] == 0 || free[0] + free[1] + free[2] == 0) continue;
    const double unit = body.length_unit();
    surface_.push_back({node, skin_.nodes[n] / unit, normals_[n], edges[n] / unit,
                        PartRadius(areas[n]) / unit, body.Stiffness(node), moduli[n],
                        Vector3d(free[0], free[1], free[2])});
  }
  touched_.reserve(surface_.size());
  constraints.ReserveTouched(surface_.size());
}

bool ToolContacts::Set(std::span<const Touch> touches) {
  std::vector<Vector3d> normals;
  for (const Touch& touch : touches) {
    const auto at = FindPlace(skin_, touch.p_O);
    if (!at) return false;
    normals.push_back(at->node >= 0 ? normals_[Index(at->node)] : Normal(skin_, at->triangle));
  }
  std::vector<ToolContact> former = std::exchange(tools_, {});
  const double unit = body_.length_unit();
  for (std::size_t k = 0; k < touches.size(); ++k) {
    const Touch& touch = touches[k];
    const auto known = std::ranges::find_if(former, [&](const ToolContact& tool) {
      const ToolContact::Placement& before = tool.placement();
      return before.p == touch.p_O / unit && before.width == touch.width / unit &&
             before.radius == touch.radius / unit;
    });
    if (known != former.end()) {
      tools_.push_back(std::move(*known));
      former.erase(known);
      continue;
    }
    Tool tool = touch.tool;
    tool.radius /= unit;
    tool.length /= unit;
    tools_.emplace_back(tool,
                        ToolContact::Placement{touch.p_O / unit, normals[k], touch.width / unit,
                                               touch.radius / unit},
                        touch.friction, poisson_ratio_, surface_);
  }
  for (int i = 0; i < body_.size(); ++i) {
    owner_[Index(i)] = constraints_.IsTaken(i) ? ToolContact::kTaken : ToolContact::kNoTool;
  }
  touched_.clear();
  return true;
}

void ToolContacts::Reset() noexcept {
  for (ToolContact& tool : tools_) tool.Reset();
  for (const TouchedNode& at : touched_) owner_[Index(at.node)] = ToolContact::kNoTool;
  touched_.clear();
  constraints_.HoldTouched(touched_);
}

bool ToolContacts::UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack,
                                  ToolContact::After after) noexcept {
  for (const TouchedNode& at : touched_) owner_[Index(at.node)] = ToolContact::kNoTool;
  for (int k = 0; k < size(); ++k) tools_[Index(k)].Claim(k, &owner_);
  bool changes = false;
  for (int k = 0; k < size(); ++k) {
    changes = tools_[Index(k)].UpdateTouching(u, reaction, slack, after, k, &owner_) || changes;
  }
  HoldTouched();
  return changes;
}

void ToolContacts::HoldTouched() noexcept {
  touched_.clear();
  for (const ToolContact& tool : tools_) tool.AddTouched(&touched_);
  constraints_.HoldTouched(touched_);
}

void ToolContacts::UpdateSprings(const NodeVector& u) noexcept {
  for (ToolContact& tool : tools_) tool.UpdateSprings(u);
}

void ToolContacts::UpdateFriction(const NodeVector& u, const NodeVector& reaction) noexcept {
  for (ToolContact& tool : tools_) tool.UpdateFriction(u, reaction);
}

void ToolContacts::AddFrictionOf(const NodeVector& motion, const BlockMatrix& tangent,
                                 NodeVector* change) const noexcept {
  for (const ToolContact& tool : tools_) tool.AddFrictionOf(motion, tangent, change);
}

double ToolContacts::UpdateShares(const NodeVector& u) noexcept {
  double largest = 0;
  for (ToolContact& tool : tools_) largest = std::max(largest, tool.UpdateShares(u));
  return largest;
}

void ToolContacts::EstimateErrors(const NodeVector& reaction, const NodeVector& u) noexcept {
  for (ToolContact& tool : tools_) tool.EstimateError(reaction, u);
}

void ToolContacts::Retreat() noexcept {
  for (ToolContact& tool : tools_) tool.Retreat();
  HoldTouched();
}

void ToolContacts::Keep() noexcept {
  for (ToolContact& tool : tools_) tool.Keep();
}

void ToolContacts::TakeBack() noexcept {
  for (ToolContact& tool : tools_) tool.TakeBack();
  HoldTouched();
}

void ToolContacts::Carry(std::span<const Vector3d> ways, NodeVector* moved) const noexcept {
  for (std::size_t k = 0; k < std::min(ways.size(), tools_.size()); ++k) {
    tools_[k].Carry(ways[k], moved);
  }
}

void ToolContacts::AddStiffness(double times, BlockMatrix* tangent) const noexcept {
  for (const ToolContact& tool : tools_) tool.AddStiffness(times, tangent);
}

void ToolContacts::Load(const NodeVector& base, NodeVector* f_ext) const noexcept {
  for (const ToolContact& tool : tools_) tool.Unload(base, f_ext);
  for (const ToolContact& tool : tools_) tool.Load(f_ext);
}

void ToolContacts::Accept(const NodeVector& u, const NodeVector& reaction) noexcept {
  for (ToolContact& tool : tools_) tool.Accept(u, reaction);
}

}  // namespace palpate::fem
