#include "slave/mechanics/plate/plate_surface.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

constexpr int kMeshRings = 24;

int FirstOf(int ring) {
  return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1);
}

int NodeOf(int ring, int place) {
  return ring == 0 ? 0 : FirstOf(ring) + place % (6 * ring);
}

// One of six equal sectors of the band between two rings: 2 ring - 1 triangles.
void AppendSector(int ring, int sector, SurfaceMesh* grid) {
  const int outer = sector * ring;
  const int inner = sector * (ring - 1);
  for (int i = 0; i < ring; ++i) {
    grid->triangles.push_back(
        {NodeOf(ring - 1, inner + i), NodeOf(ring, outer + i), NodeOf(ring, outer + i + 1)});
    if (i + 1 == ring) continue;
    grid->triangles.push_back({NodeOf(ring - 1, inner + i), NodeOf(ring, outer + i + 1),
                               NodeOf(ring - 1, inner + i + 1)});
  }
}

}  // namespace

SurfaceMesh MembraneGrid(double radius) {
  SurfaceMesh grid;
  grid.nodes.emplace_back(0, 0, 0);
  for (int ring = 1; ring <= kMeshRings; ++ring) {
    const double r = radius * ring / kMeshRings;
    for (int place = 0; place < 6 * ring; ++place) {
      const double angle = std::numbers::pi * place / (3 * ring);
      grid.nodes.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    for (int sector = 0; sector < 6; ++sector) AppendSector(ring, sector, &grid);
  }
  return grid;
}

PlateSurface::PlateSurface(const plate::Geometry& geometry) : geometry_(geometry) {
  SurfaceMesh grid = MembraneGrid(geometry.radius);
  field_mesh_ = {.vertices = std::move(grid.nodes), .triangles = std::move(grid.triangles)};
}

bool PlateSurface::IsSameSet() const noexcept {
  return prepared_ && std::ranges::equal(known_, touches_,
                                         [](const auto& a, const auto& b) { return a.IsAt(b); });
}

void PlateSurface::ComputeResponses(std::span<const Contact> contacts,
                                    std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  try {
    failure_ = plate::Check(contacts, geometry_, &touches_);
    answered_ =
        responses.size() == contacts.size() && failure_.empty() && TryRespond(contacts, responses);
  } catch (const std::bad_alloc&) {
    answered_ = prepared_ = Fail("out of memory");
  } catch (const std::runtime_error&) {
    answered_ = prepared_ =
        Fail("the plate's response to a central indentation of this width is not found");
  }
  if (!answered_) std::ranges::fill(responses, ContactResponse{});
}

void PlateSurface::ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) {
  u_O->clear();
  for (const auto& node : MembraneGrid(1).nodes) {
    u_O->emplace_back(0, 0, answered_ ? DisplacementAt(node.head<2>()) : 0);
  }
}

}  // namespace palpate
