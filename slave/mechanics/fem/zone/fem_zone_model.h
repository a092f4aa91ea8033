// `fem-zone`: a held neo-Hookean body of linear tetrahedra, nonlinear in a zone around every
// contact and linear elsewhere. An update of a contact costs a fraction of a millisecond whatever
// the mesh size; the first touch of a place condenses the rest of the body onto its zone. Every
// force comes with a bound of the error that the linear rest causes.
//
// See linear_rest.h, zone_solver.h, zone_set.h, outside_error.h for the method and its sources.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/solid/contact_set.h"
#include "slave/mechanics/fem/zone/zone_set.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {

// Contacts act where those of SolidModel do. kExtrapolated: the bound exceeds the tolerance, an
// element is inside out, a mesh too coarse for a disc or for a part that bends, a Poisson ratio
// from 0.49 on. kFailed: a fixed node is moved, no equilibrium.
class FemZoneModel final : public DeformationModel {
 public:
  struct Options {
    double tolerance = 0.05;                          // of the force's bound, by the force [-]
    std::size_t memory_limit = std::size_t{1} << 30;  // for places [bytes]
  };
  // Throws std::invalid_argument: see AssembleTetStiffness; modulus or tolerance not positive.
  FemZoneModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
               double poisson_ratio, const Options& options, Progress* progress = nullptr);

  void Reset() override;
  // The places of the contacts.
  void Prefetch(std::span<const Contact> contacts) override;

 private:
  using Key = std::tuple<int, double, int>;  // a node of the surface, a contact's width, level
  struct Place {
    std::shared_ptr<const ZonePlace> zone;
    std::size_t bytes = 0;
  };

  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool PrepareSet(std::span<const Contact> contacts);
  [[nodiscard]] int NodeNear(const Eigen::Vector3d& p_O) const;
  [[nodiscard]] double RadiusAt(int node, double width, int level) const;
  [[nodiscard]] int LevelOf(std::span<const Contact> contacts, std::size_t contact) const;
  std::shared_ptr<const ZonePlace> PlaceAt(const Key& key);
  [[nodiscard]] std::vector<int> NodesNear(int node, double radius) const;
  void FindCrowded(const std::vector<ZoneSet::Touch>& touches);
  bool MakeTouch(std::span<const Contact> contacts, std::size_t i, ZoneSet::Touch* touch);
  bool Prescribe(std::span<const Contact> contacts, double part);
  bool SolveState(std::span<const Contact> contacts);
  bool Converge();
  [[nodiscard]] bool HasConverged(bool* finite) const;
  void LearnBending();
  void Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  [[nodiscard]] std::string_view DoubtOf(std::size_t contact,
                                         const ContactResponse& response) const;

  double young_modulus_, poisson_ratio_;
  Options options_;
  SolidMesh mesh_;
  HeldNodes held_;
  ZonePlaces places_;
  double unit_;  // larger side of the body [m]
  ElementMesh elements_;
  std::vector<bool> used_;
  SolidContacts contacts_;
  StrainResolution strain_;
  std::vector<double> edge_;  // per node of the surface: mean length of the edges around it [m]

  std::map<Key, Place> known_;
  std::size_t known_bytes_ = 0;
  std::vector<std::shared_ptr<const ZonePlace>> used_places_;
  std::optional<ZoneSet> set_;
  std::vector<Eigen::VectorXd> prescribed_;
  std::vector<Eigen::Vector3d> softness_;  // in bending, per contact and axis
  std::vector<char> crowded_;              // per contact: in another's zone, or the reverse
  bool inverted_ = false;
};

}  // namespace palpate
