#include "slave/mechanics/fem/green/bending_table.h"

#include <algorithm>
#include <cmath>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr int kNumbers = 12;  // of an entry on disk
// Displacement at which strains are evaluated, relative to the larger side.
constexpr double kSmall = 1e-9;

StrainResolution ResolutionOf(const RestStiffness& stiffness) {
  // If the pressure is a separate unknown, only bending is evaluated.
  const bool pressure = stiffness.has_pressure();
  return {stiffness.elements, pressure ? HeldNodes{} : stiffness.held,
          pressure ? 0.0 : stiffness.poisson_ratio};
}

}  // namespace

std::vector<char> UnevenNodes(const RestStiffness& stiffness) {
  // Edge lengths across a disc that the mesh can represent: two to three. [derived: PatchStiffness
  // within 10 %]
  constexpr int kEdges = 3;
  const TetMesh& elements = stiffness.elements;
  std::vector<char> uneven(elements.nodes.size(), 0);
  for (int ring = 0; ring < kEdges && !elements.modulus.empty(); ++ring) {
    const std::vector<char> inner = uneven;
    for (int e = 0; e < elements.element_count(); ++e) {
      const auto nodes = elements.element(e);
      const auto is_inner = [&](int node) { return inner[Index(node)] != 0; };
      if (elements.ModulusOf(e) == 1 && std::ranges::none_of(nodes, is_inner)) continue;
      for (const int node : nodes) uneven[Index(node)] = 1;
    }
  }
  for (std::size_t n = 0; n < uneven.size(); ++n) {
    if (std::ranges::min(stiffness.row[n]) < 0) uneven[n] = 1;
  }
  return uneven;
}

BendingTable::BendingTable(const RestStiffness& stiffness, const GreenGroups& layout, double width,
                           const std::filesystem::path& cache)
    : stiffness_(stiffness),
      layout_(layout),
      width_(width),
      strain_(ResolutionOf(stiffness)),
      places_(stiffness.elements, stiffness.length_unit, layout.place_of_node(),
              UnevenNodes(stiffness)),
      entries_(stiffness.elements.surface.triangles.size()) {
  if (cache.empty()) return;
  constexpr std::size_t kVersion = 2;  // version of the format on disk
  cache_ =
      ColumnCache(cache, Hash().Add(kVersion).Add(kGroup).Add(stiffness.inputs).Add(width).value());
  for (int g = 0; g < groups(); ++g) LoadGroup(g);
}

bool BendingTable::is_complete() const {
  return std::ranges::all_of(entries_, [this](const Entry& e) { return e.width == width_; });
}

const Bending* BendingTable::Find(int triangle, double width) const noexcept {
  const Entry& entry = entries_[Index(triangle)];
  const bool is_near = std::abs(entry.width - width) <= width / 6;
  return is_near ? &entry.bending : nullptr;
}

const Bending& BendingTable::Learn(int triangle, double width, RestFactor* factor) {
  Entry& entry = entries_[Index(triangle)];
  entry = {};
  const SurfaceMesh& surface = stiffness_.elements.surface;
  const Contact contact{.p_O = stiffness_.length_unit * Centroid(surface, triangle),
                        .element = triangle,
                        .width = width};
  ContactFootprint footprint;
  std::vector<int> nodes;
  if (places_.Find(contact, &footprint).empty()) {
    for (const auto& [place, weight] : footprint.places) {
      nodes.push_back(layout_.node_of_place()[Index(place)]);
    }
  }
  // Even on the parts of the surface of a tool's nodes.
  std::vector<double> shares;
  double whole = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const ToolHold* hold = footprint.holds.empty() ? nullptr : &footprint.holds[k];
    const bool has_part = hold != nullptr && hold->part_radius > 0;
    shares.push_back(has_part ? hold->share * hold->part_radius * hold->part_radius : 1);
    whole += shares.back();
  }
  for (double& share : shares) share /= whole;
  Eigen::MatrixX3d x = Eigen::MatrixX3d::Zero(stiffness_.lower.rows(), 3);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    for (int c = 0; c < 3; ++c) {
      const int row = stiffness_.row[Index(nodes[k])][Index(c)];
      if (row >= 0) x(row, c) += shares[k];
    }
  }
  factor->Solve(x);
  std::vector<Eigen::Vector3d> u;
  for (int c = 0; c < 3; ++c) {
    stiffness_.Spread(x.col(c), &u);
    double& compliance = entry.bending.compliance[c];
    for (std::size_t k = 0; k < nodes.size(); ++k) compliance += shares[k] * u[Index(nodes[k])][c];
    if (!(compliance > 0)) continue;  // fixed by a support
    for (auto& moved : u) moved *= kSmall / compliance;
    strain_.Take(u);
    entry.bending.softness[c] = strain_.Softness(nodes);
    const MeshShare near =
        strain_.ShareNear(0, {contact.p_O / stiffness_.length_unit, width / stiffness_.length_unit},
                          kSmall * kSmall / compliance);
    entry.bending.shear[c] = near.shear;
    entry.bending.volume[c] = near.volume;
  }
  entry.width = width;
  return entry.bending;
}

int BendingTable::groups() const {
  return (triangles() + kGroup - 1) / kGroup;
}

bool BendingTable::HasGroup(int group) const {
  return std::all_of(entries_.begin() + first(group), entries_.begin() + last(group),
                     [this](const Entry& entry) { return entry.width == width_; });
}

void BendingTable::LoadGroup(int group) {
  std::vector<double> values(Index(kNumbers * (last(group) - first(group))));
  if (!cache_.Load(group, values)) return;
  for (int t = first(group); t < last(group); ++t) {
    const double* at = &values[Index(kNumbers * (t - first(group)))];
    entries_[Index(t)] = {width_,
                          {Eigen::Vector3d(at), Eigen::Vector3d(at + 3), Eigen::Vector3d(at + 6),
                           Eigen::Vector3d(at + 9)}};
  }
}

void BendingTable::KeepGroup(int group, RestFactor* factor) {
  std::vector<double> values;
  for (int t = first(group); t < last(group); ++t) {
    const Bending* known = Find(t, width_);
    const Bending& bending = known != nullptr ? *known : Learn(t, width_, factor);
    values.insert(values.end(), bending.softness.begin(), bending.softness.end());
    values.insert(values.end(), bending.compliance.begin(), bending.compliance.end());
    values.insert(values.end(), bending.shear.begin(), bending.shear.end());
    values.insert(values.end(), bending.volume.begin(), bending.volume.end());
  }
  cache_.Keep(group, values);
}

}  // namespace palpate
