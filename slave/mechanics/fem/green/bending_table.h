// How accurately the elements of a body represent its strain under a contact, for each triangle of
// its surface.
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/green/green_groups.h"
#include "slave/mechanics/fem/green/rest_stiffness.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {

// Returns the nodes around which the body does not resemble a uniform half-space at the scale of a
// widened disc (SurfaceFootprints): fixed ones, and those within a few edges of a region.
std::vector<char> UnevenNodes(const RestStiffness& stiffness);

// Under a unit force along each axis of O, evenly on the places of a contact.
struct Bending {
  Eigen::Vector3d softness{0, 0, 0};    // StrainResolution::Softness [-]
  Eigen::Vector3d compliance{0, 0, 0};  // along the force, mean over the places; nondimensional
  Eigen::Vector3d shear{0, 0, 0}, volume{0, 0, 0};  // MeshShare [-]
};

// The entry of a contact is computed for a disc of its width that is moved around the centroid of
// its triangle, independent of earlier contacts. An entry needs three sparse solutions; those of
// one width can be stored on disk. Not thread-safe.
class BendingTable {
 public:
  static constexpr int kGroup = 64;  // triangles of one file

  // Stores references to its arguments. `width`: width of the contacts [m] stored on disk in the
  // folder `cache` (empty: none). Reads the stored entries.
  BendingTable(const RestStiffness& stiffness, const GreenGroups& layout, double width,
               const std::filesystem::path& cache);

  // False: no contact bends the body.
  [[nodiscard]] bool body_bends() const { return strain_.body_bends(); }
  // Every entry of the width on disk is there.
  [[nodiscard]] bool is_complete() const;
  // Returns nullptr if the entry must be computed first: none is there, or one for a width that
  // differs by more than a sixth.
  [[nodiscard]] const Bending* Find(int triangle, double width) const noexcept;
  const Bending& Learn(int triangle, double width, RestFactor* factor);

  // Number of files.
  [[nodiscard]] int groups() const;
  [[nodiscard]] bool HasGroup(int group) const;
  // Learns the entries of a file and writes it. Throws std::runtime_error: the folder cannot be
  // written.
  void KeepGroup(int group, RestFactor* factor);

 private:
  struct Entry {
    double width = -1;  // [m]; -1: not computed
    Bending bending;
  };
  [[nodiscard]] int triangles() const { return static_cast<int>(entries_.size()); }
  [[nodiscard]] int first(int group) const { return kGroup * group; }
  [[nodiscard]] int last(int group) const { return std::min(kGroup * (group + 1), triangles()); }
  void LoadGroup(int group);

  const RestStiffness& stiffness_;
  const GreenGroups& layout_;
  double width_;
  ColumnCache cache_;
  StrainResolution strain_;
  SurfaceNodePlaces places_;    // of the surface nodes
  std::vector<Entry> entries_;  // per triangle of the linear surface
};

}  // namespace palpate
