// `fem-zone`: a held neo-Hookean body of linear tetrahedra, nonlinear in a zone around every
// contact and linear elsewhere. An update of a contact costs a fraction of a millisecond whatever
// the mesh size; the first touch of a region computes its Green's functions. Every force comes with
// a bound of the error that the linear rest causes.
//
// See near_green.h, zone_part.h, zone_set.h, outside_error.h for the method and its sources.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/zone/zone_set.h"
#include "slave/mechanics/fem/zone/zone_touches.h"
#include "slave/mechanics/footprint/volume_contacts.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/program/progress.h"
#include "slave/scene/options/model.h"

namespace palpate {

// Flat bonded discs, single nodes and loads act where those of SolidModel do. Every other contact
// is a rigid tool that is pressed on the surface and may slide, first touching at p_O: its forces
// depend on its way, which is taken as straight from one query to the next. kExtrapolated: the
// bound exceeds the tolerance, an element is inside out, a mesh too coarse for a disc or for a part
// that bends, a Poisson ratio below 0 or from 0.49 on. kFailed: a fixed node is moved, no
// equilibrium, more than 16 contacts.
class FemZoneModel final : public DeformationModel {
 public:
  struct Options {
    double tolerance = 0.05;  // of the force's bound, by the force [-]
    ContactLaw contact = ContactLaw::kBonded;
    double friction = 0;      // Coulomb's coefficient, with kFriction [-]
    Tool tool{};              // of every kDisplacement contact with a width, or that is round
    double least_radius = 0;  // of every zone [m]
    double deadline = 0;  // of an update, after which the best answer so far is given [s]; 0: none
    std::filesystem::path cache{};                    // folder for Green's functions; empty: none
    std::size_t memory_limit = std::size_t{1} << 30;  // for Green's functions [bytes]
  };
  // Throws std::invalid_argument: see AssembleAtRest; modulus or tolerance not positive.
  FemZoneModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
               double poisson_ratio, const Options& options, Progress* progress = nullptr);

  void Reset() override;
  // The Green's functions around the contacts.
  void Prefetch(std::span<const Contact> contacts) override;
  // Those of every zone that a contact of `width` [m] can need, anywhere. False: the memory limit
  // is reached. Throws Interrupted; what was finished stays, on disk too.
  bool PrefetchSurface(double width, Progress* progress = nullptr);
  // Keeps a share of the same in `Options::cache`, and none in memory. Throws Interrupted;
  // std::runtime_error: the folder cannot be written.
  CacheFilling FillCache(double width, const CacheShare& share, Progress* progress);

 private:
  // How soft in bending the body is along each axis, under a contact with a zone of this radius.
  struct Bending {
    Eigen::Vector3d p_O, softness;
    double radius;  // [m]
  };
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool PrepareSet(std::span<const Contact> contacts);
  void FollowTools(std::span<const Contact> contacts);
  [[nodiscard]] const ToolContact* ToolOf(int contact) const {
    return set_->part(contact).contact_forces().tool();
  }
  bool MoveTools(std::span<const Contact> contacts);
  void Prescribe(std::span<const Contact> contacts, double part);
  bool SolveState(std::span<const Contact> contacts);
  bool Converge();
  [[nodiscard]] bool HasConverged(double within, bool* finite) const;
  void LearnBending();
  [[nodiscard]] const Bending* BendingAt(const ZoneSet::Touch& touch) const;
  void Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  [[nodiscard]] std::string_view DoubtOf(std::size_t contact,
                                         const ContactResponse& response) const;

  [[nodiscard]] bool IsLate() const;

  double young_modulus_, poisson_ratio_;
  Options options_;
  SolidMesh mesh_;
  HeldNodes held_;
  NearGreen green_;
  double unit_;  // larger side of the body [m]
  TetMesh elements_;
  VolumeContacts contacts_;
  StrainResolution strain_;
  ZoneTouches touches_at_;

  std::optional<ZoneSet> set_;
  std::vector<ZoneSet::Touch> touches_;
  std::vector<Eigen::Vector3d> moved_;  // of tools, accepted [units]
  std::vector<Eigen::VectorXd> prescribed_;
  std::vector<Bending> learned_;
  std::vector<Eigen::Vector3d> softness_;  // per contact and axis
  bool is_stretched_ = false;              // some element
  bool inverted_ = false;
  bool follows_ = false;                         // the state is that of the last query
  std::chrono::steady_clock::time_point begun_;  // of the update
};

}  // namespace palpate
