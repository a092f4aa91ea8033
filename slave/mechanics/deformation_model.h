// What every deformation model answers: contacts in, forces or displacements out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"
#include "shared/state/validity.h"

namespace palpate {

// A patch of boundary that is held or loaded. Frame O.
struct Contact {
  enum class Kind : std::uint8_t { kDisplacement, kForce };
  Kind kind = Kind::kDisplacement;
  Eigen::Vector3d p_O{0, 0, 0};  // the place at rest, centre of the patch [m]
  int element = -1;              // the boundary element there; -1: found from p_O
  double width = 0;  // along the boundary [m]; 0: the one element there (contracts, solve)
  Eigen::Vector3d value_O{
      0, 0, 0};  // displacement of the patch [m], or total force of the tool on the object [N]
};

// The answer for one contact. Frame O.
struct ContactResponse {
  Eigen::Vector3d force_O{0, 0, 0};         // of the tool on the object, whole thickness [N]
  Eigen::Vector3d displacement_O{0, 0, 0};  // mean over the patch [m]
  Eigen::Matrix3d stiffness_O =
      Eigen::Matrix3d::Zero();  // d force_O / d displacement_O of this patch alone [N/m]
  Validity validity = Validity::kFailed;
};

// What a model says of itself.
struct ModelInfo {
  std::string kind;  // bem2d, ...
  std::size_t dof = 0;
  int elements = 0;
  double precompute_s = 0;       // measured [s]
  std::size_t memory_bytes = 0;  // kept after precompute
  double condition = 0;  // estimated condition number of the reference system [-]; 0: not known
  double range = 0;      // largest |displacement| / larger side before `extrapolated` [-]
};

class DeformationModel {
 public:
  virtual ~DeformationModel() = default;
  DeformationModel() = default;
  DeformationModel(const DeformationModel&) = delete;
  DeformationModel& operator=(const DeformationModel&) = delete;

  // Answers all contacts acting together. responses.size() == contacts.size(). Allocation-free
  // after the first call with as many boundary unknowns; not thread-safe. Loads add up where they
  // overlap. Not finite or impossible contacts, and such that overlap with others: kFailed.
  virtual void Respond(std::span<const Contact> contacts,
                       std::span<ContactResponse> responses) noexcept = 0;

  // Displacement of every boundary element (2D: midpoint) under the contacts of the last Respond:
  // 3 numbers per element, frame O [m]. Costs O(N S); computed only when asked for.
  virtual void BoundaryDisplacement(std::vector<Eigen::Vector3d>* displacement_O) = 0;

  // Why the last Respond failed, one clause; empty where it did not or where no more is known.
  [[nodiscard]] virtual std::string_view failure() const { return {}; }

  [[nodiscard]] virtual const ModelInfo& info() const = 0;
};

}  // namespace palpate
