// Interface of the deformation models: contacts in, forces or displacements out.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/validity.h"
#include "slave/mechanics/model_info.h"
#include "slave/mesh/outline.h"
#include "slave/mesh/planar_cover.h"

namespace palpate {

// A patch of boundary that is fixed or loaded. Frame O.
struct Contact {
  enum class Kind : std::uint8_t { kDisplacement, kForce };
  Kind kind = Kind::kDisplacement;
  Eigen::Vector3d p_O{0, 0, 0};  // position at rest, centre of the contact [m]
  int element = -1;  // 2D: the boundary element there, 3D: the triangle; -1: found from p_O
  double width = 0;  // along the boundary, in 3D of a disc [m]; 0: the one element, node or point
                     // there (rules: slave/solve/README.md)
  Eigen::Vector3d prescribed_O{
      0, 0, 0};  // displacement of the patch [m], or total force of the tool on the object [N]
  // For a contact with a width on a plate: true for a rigid flat face, which is not glued and does
  // not tilt, and whose displacement is prescribed; false for a uniform load, whose displacement is
  // that of its centre.
  bool is_rigid = false;
  // If no contact of a set requests it, sets in which many contacts move together are solved
  // faster.
  bool wants_stiffness = true;
  // Of a round tool: a cylinder across the plane in 2D, a sphere in 3D [m]; 0: flat.
  double radius = 0;

  // Returns whether both contacts have the same patch, fixed or loaded, with any value.
  [[nodiscard]] bool IsAt(const Contact& other) const {
    return kind == other.kind && element == other.element && width == other.width &&
           p_O == other.p_O && is_rigid == other.is_rigid && radius == other.radius;
  }
};

// Width of the surface that a contact touches [m]: of a round tool at its depth (Hertz); 0: a
// point.
inline double WidthOfTouch(const Contact& contact) {
  if (!(contact.radius > 0)) return contact.width;
  const double depth = std::min(contact.radius, contact.prescribed_O.norm());
  return 2 * std::sqrt(contact.radius * depth);
}

// The most common `flag_reason`.
inline constexpr std::string_view kBeyondRange = "the displacement is beyond the model's range";

// See DeformationModel::SolveAside.
inline constexpr std::string_view kBeingComputed = "the answer at this place is being computed";

// Response of one contact. Frame O.
struct ContactResponse {
  Eigen::Vector3d force_O{0, 0, 0};         // of the tool on the object, whole thickness [N]
  Eigen::Vector3d displacement_O{0, 0, 0};  // mean over the patch [m]
  Eigen::Matrix3d stiffness_O =
      Eigen::Matrix3d::Zero();  // d force_O / d displacement_O of this contact alone [N/m]; zero if
                                // it costs more than the solution (fem) or is not requested
  Validity validity = Validity::kFailed;
  // Why it is kExtrapolated, one clause with static lifetime; may be empty.
  std::string_view flag_reason;
  // Moment of the force about the displaced centre of a contact with a width [N m]; nullopt: the
  // model or the mesh does not resolve how the force is distributed over the contact.
  std::optional<Eigen::Vector3d> moment_O{};
  double moment_sigma = 0;  // standard deviation of the moment due to the mesh [N m]
  // Estimated error of the force [N], or of the displacement under a load [m]: of the solution, and
  // of the mesh where the contact has a width; 0: not estimated. It is not a bound.
  double force_error = 0, displacement_error = 0;
  double mesh_error = 0;  // the mesh's part of either [N], [m]
  // Work of the springs at a flat face's rim (rim_share.h), relative to force times displacement.
  double spring_share = 0;
  double mesh_factor = 1;  // by which the force was corrected for the mesh (mesh_resolution.h) [-]
  // The response is that of a disc of the contact's width, although the mesh has no such disc.
  bool takes_width = false;
  int touching = 0;  // nodes or elements that a rigid tool touches; 0: no tool, or not counted
};

// The nodes and cells of a displacement field. Frame O.
struct FieldMesh {
  std::vector<Eigen::Vector3d> vertices{};  // p_O at rest [m]
  // The elements, by indices of vertices: one of the following three.
  std::vector<std::array<int, 2>> lines{};      // of an outline
  std::vector<std::array<int, 3>> triangles{};  // of a surface
  std::vector<std::array<int, 4>> tets{};       // of a volume
};

inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Answer of a model to one set of contacts. Its memory grows to the largest set, so reuse it.
class Solution {
 public:
  // One per contact.
  [[nodiscard]] const std::vector<ContactResponse>& responses() const { return responses_; }
  [[nodiscard]] const std::vector<Contact>& contacts() const { return contacts_; }

 private:
  friend class DeformationModel;
  std::vector<Contact> contacts_;
  std::vector<ContactResponse> responses_;
  std::vector<Contact> at_rest_;           // see DeformationModel::ContactsAtRest; empty: contacts_
  std::uint64_t query_ = 0;                // number of the model's query; 0: no solution yet
  std::vector<Eigen::Vector3d> kept_u_O_;  // see DeformationModel::keeps_displacements_
};

class DeformationModel {
 public:
  virtual ~DeformationModel() = default;
  DeformationModel() = default;
  DeformationModel(const DeformationModel&) = delete;
  DeformationModel& operator=(const DeformationModel&) = delete;

  // Computes the responses of all contacts acting together. responses.size() == contacts.size().
  // Allocation-free after the first call with as many boundary unknowns; not thread-safe. Loads add
  // up where they overlap. kFailed: contacts that are not finite, impossible, or overlap with
  // others.
  void Respond(std::span<const Contact> contacts, std::span<ContactResponse> responses) noexcept;
  // Responds for a caller that may then query displacements or tractions. Solutions do not depend
  // on other queries in between, apart from warm starts and time steps. Allocates no more than
  // Respond if `solution` had as many contacts before.
  void Solve(std::span<const Contact> contacts, Solution* solution) noexcept;

  // The mesh of the displacements; constant. An outline's vertex i is the start of element i. For a
  // volume or its surface, vertex i is node i of the object's mesh; nodes without an element
  // stay at zero. A membrane has MembraneGrid().
  [[nodiscard]] const FieldMesh& field_mesh() const { return field_mesh_; }
  // Computes the displacement of every vertex of field_mesh() in a solution of this model, frame O
  // [m]; zero after a failure or without a solution. O(N S).
  void Displacements(const Solution& solution, std::vector<Eigen::Vector3d>* u_O);

  // The cover of a planar body, made at the first call; constant. Empty for other models.
  [[nodiscard]] const PlanarCover& cover();
  // Displacements at its nodes: at the vertices of field_mesh(), then at the places inside, frame O
  // [m].
  void CoverDisplacements(const Solution& solution, std::vector<Eigen::Vector3d>* u_O);

  // Computes the magnitude of the contacts' traction at every vertex of field_mesh() in a solution
  // of this model [Pa], per area at rest, zero without contact or after a failure. Left unchanged
  // without a solution, and by models that provide only the force of a contact.
  void Tractions(const Solution& solution, std::vector<float>* pascals) {
    if (Show(solution)) ComputeTractions(pascals);
  }

  // Resets motion and warm starts: the body is at rest again, and the next Respond does not depend
  // on earlier ones. With `time: dynamic` a Respond is one time step, and its contacts apply at its
  // end.
  virtual void Reset() {}
  // Sets the contacts at the instant at which the body at rest begins to relax, before the first
  // step. Call it after Reset. Invalid contacts are ignored here and fail in Respond.
  virtual void Start(std::span<const Contact> /*contacts*/) {}
  // Completes the precompute for contacts at these positions.
  virtual void Prefetch(std::span<const Contact> /*contacts*/) {}

  // From now on no query waits until a position is solved: until then it gets the answer of another
  // one, flagged with kBeingComputed. Call it after the first query.
  virtual void SolveAside() {}

  // Returns why the last query failed, as one clause; empty if it did not fail or the reason is
  // unknown.
  [[nodiscard]] virtual std::string_view failure() const { return failure_; }

  [[nodiscard]] const ModelInfo& info() const { return info_; }

 protected:
  virtual void ComputeResponses(std::span<const Contact> contacts,
                                std::span<ContactResponse> responses) noexcept = 0;
  // Computes the displacements under the contacts of the last ComputeResponses.
  virtual void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) = 0;
  virtual void ComputeTractions(std::vector<float>* /*pascals*/) {}
  // Planar models: the cover, and the displacements at its `places` inside under the same contacts,
  // which are appended.
  [[nodiscard]] virtual PlanarCover MakeCover() const { return {}; }
  virtual void ComputeInside(const std::vector<Eigen::Vector2d>& /*places*/,
                             std::vector<Eigen::Vector3d>* /*u_O*/) {}
  // For models in time, after ComputeResponses to `contacts`: returns contacts under which
  // ComputeAtRest reproduces the displacements. Other models return `contacts`.
  [[nodiscard]] virtual std::span<const Contact> ContactsAtRest(
      std::span<const Contact> contacts) const {
    return contacts;
  }
  virtual void ComputeAtRest(std::span<const Contact> contacts,
                             std::span<ContactResponse> responses) noexcept {
    ComputeResponses(contacts, responses);
  }
  // Restores the state of the solution's contacts, as if they had been computed last. Returns false
  // without a solution.
  bool Show(const Solution& solution) noexcept;
  // Discards the result of the last ComputeResponses.
  void Hide() { shown_ = 0; }

  // Stores the reason of a failure. Returns false.
  bool Fail(std::string_view why) {
    failure_ = why;
    return false;
  }
  // Stores the time since the start of the model's construction as its precompute time.
  void NotePrecompute() { info_.precompute_s = SecondsSince(started_); }

  static constexpr int kCoverPlaces = 300;  // of a planar body's cover, about

  FieldMesh field_mesh_;
  ModelInfo info_;
  std::string_view failure_;
  // true: the answer depends on earlier queries, so a solution stores its displacements.
  bool keeps_displacements_ = false;

 private:
  std::uint64_t queries_ = 0;                     // so far
  std::uint64_t shown_ = 0;                       // the one of the last ComputeResponses
  std::vector<ContactResponse> shown_responses_;  // scratch memory
  std::optional<PlanarCover> cover_;              // nullopt: not made yet
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

}  // namespace palpate
