// From contacts to zones: which nodes a contact can touch, and how large its zone must be.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/zone/zone_set.h"
#include "slave/mechanics/footprint/volume_contacts.h"

namespace palpate {

class ZoneTouches {
 public:
  struct Params {
    double friction = 0;      // Coulomb's coefficient [-]; infinite: bonded
    Tool tool{};              // of every contact that is none of VolumeContacts
    double least_radius = 0;  // of every zone [m]
  };
  // Keeps references.
  ZoneTouches(const SolidMesh& mesh, const HeldNodes& held, const Params& params);

  // `at`: where VolumeContacts finds the contact. Empty: made; otherwise why not.
  [[nodiscard]] std::string_view Make(const Contact& contact, const ContactPlace& at,
                                      ZoneSet::Touch* touch) const;
  // The zone that goes with a tool that slides, or grows with one that goes deeper. nullopt: the
  // present one does.
  [[nodiscard]] std::optional<ZoneSet::Touch> Follow(const Contact& contact,
                                                     const ToolContact& tool,
                                                     const ZoneSet::Touch& touch) const;

  // Every node that zones of contacts of `width` [m] can have, and the largest radius of these.
  struct Cover {
    std::vector<int> nodes;
    double radius = 0, extent = 0;  // the latter of a zone's nodes [m]
  };
  [[nodiscard]] Cover CoverOf(double width) const;
  // Mean length of the edges around a node of the surface [m].
  [[nodiscard]] double edge(int node) const { return edge_[static_cast<std::size_t>(node)]; }

 private:
  [[nodiscard]] int NodeNear(const Eigen::Vector3d& p_O) const;
  [[nodiscard]] double ToolRadius(double width, double depth) const;
  [[nodiscard]] std::string_view MakeTool(const Contact& contact, int near,
                                          ZoneSet::Touch* touch) const;
  void AddToolPoints(double edge, ZoneSet::Touch* touch) const;

  const SolidMesh& mesh_;
  const HeldNodes& held_;
  Params params_;
  double unit_;  // larger side [m]
  SurfaceMesh surface_;
  std::vector<double> edge_;             // per node; 0: not on the surface
  std::vector<Eigen::Vector3d> normal_;  // outward, per node of the surface
};

}  // namespace palpate
