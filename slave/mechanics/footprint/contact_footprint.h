// Parts of a triangulated surface that a contact touches, with their shares (rules:
// slave/solve/README.md). All models of volumes use this rule.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {

struct MomentRule {
  // Places of a contact below which the moment of its force is unknown.
  std::size_t fewest = 4;
  // Error of the moment, divided by (force times width / number of places) [-]. [tuned:
  // contact_moment_test]
  double spread = 0.5;
};

struct PlaceWeight {
  int place = -1;     // a node or a triangle of a surface, a place of a Compliance
  double weight = 0;  // share [-]
};

// Whether a contact is a rigid tool, not a node, point or element that is moved, or a load.
inline bool IsTool(const Contact& contact) {
  return contact.kind == Contact::Kind::kDisplacement && (contact.width > 0 || contact.radius > 0);
}

// How a rigid tool touches one of its places.
struct ToolHold {
  double gap = 0;          // to the tool, along its axis, when it touches at its position [m]
  double share = 1;        // of the place's part of the surface under a flat face, see rim_share.h
  double part_radius = 0;  // of that part as a disc [m]; on an outline not used
};

inline constexpr std::string_view kFewTouched =
    "the tool touches too few nodes or elements: press more deeply, or use more of them there";
inline constexpr std::string_view kNotSettled = "it is not settled which places touch the tool";
// Estimated relative error of the compliance under a tool that touches `touching` places; below
// `fewest` it is flagged [-]. [measured: mesh_resolution.cpp]
// Places at the rim count by their share.
inline double FewTouchedError(double touching, std::size_t fewest, bool is_round) noexcept {
  constexpr double kNoDisc = 3;
  constexpr double kFewOff = 0.2;
  if (touching >= static_cast<double>(fewest)) return 0;
  return is_round || touching < kNoDisc ? 1 : kFewOff;
}

// The places of one contact.
//
// A load's force is distributed by the weights, which sum to one, and the reported displacement is
// the mean with the same weights (the work is then force times displacement). A contact that acts
// as a `point` uses the same weights: one unknown force, and a prescribed weighted mean. Otherwise
// all places have the same displacement, each with an unknown force, and the weights are not used.
struct ContactFootprint {
  std::vector<PlaceWeight> places;
  // Vectors from a disc's centre to its places [m], shifted together so that their centroid is that
  // of the true disc on the surface. Empty: a point, or a wider disc.
  std::vector<Eigen::Vector3d> arms;
  bool point = true;                  // at most kMaxPointPlaces places
  Eigen::Vector3d normal_O{0, 0, 0};  // outward, unit; the direction of frictionless contacts
  // Of a rigid tool, which touches its places one by one: one entry per place. Empty: all places
  // have the contact's displacement.
  std::vector<ToolHold> holds;
  double depth = 0;        // of a round tool: up to it no other places are touched [m]
  double patch_error = 0;  // PatchError (mesh_resolution.h)
  std::size_t fewest = 0;  // places under a tool below which its force is flagged
  // If the places represent a wider disc (SurfaceFootprints): its radius [m]; else 0.
  // `narrower`: the additional compliance of the contact's true disc in terms of DiscCompliance /
  // E: 1 / radius minus that of the places [1/m].
  double reach = 0, narrower = 0;
  SurfacePlace at;    // surface point at the contact's centre
  int triangle = -1;  // its triangle in the linear surface of a volume (VolumeFootprints); else -1
};
constexpr int kMaxPointPlaces = 3;

// Sets the moment of a response from the forces [N] and lever arms `arms` [m] of the places, if
// there are enough places to resolve a distribution. `force_at(i)`: force at place i.
template <class ForceAt>
void SetMoment(std::span<const Eigen::Vector3d> arms, double width, const ForceAt& force_at,
               ContactResponse* response, const MomentRule& rule = {}) {
  if (arms.size() < rule.fewest) return;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < arms.size(); ++i) moment += arms[i].cross(force_at(i));
  response->moment_O = moment;
  response->moment_sigma =
      rule.spread * width / static_cast<double>(arms.size()) * response->force_O.norm();
}
// Shifts the positions `arms` of a patch's places, weighted by `weight(i)` and relative to a disc's
// centre, onto the centroid of that disc on the surface.
template <class Weight>
void CentreArms(const DiscShare& disc, const Weight& weight, std::vector<Eigen::Vector3d>* arms) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double whole = 0;
  for (std::size_t i = 0; i < arms->size(); ++i) {
    sum += weight(i) * (*arms)[i];
    whole += weight(i);
  }
  if (!(whole > 0) || !(disc.area > 0)) return arms->clear();
  const Eigen::Vector3d shift = disc.first / disc.area - sum / whole;
  for (Eigen::Vector3d& arm : *arms) arm += shift;
}

// Contacts on one surface, from tables: the results of FindPlace and PatchAt, O(1) if a contact
// names its triangle and has no width. Both return empty text if found, else the reason, one clause
// with static lifetime. Both do not allocate if the footprint has enough capacity and contacts of
// that size occurred before. The contact must be finite; its kind, p_O, element and width are used,
// its value is not.
class SurfaceFootprints {
 public:
  // With `held`, one entry per node, a contact that is too small for the mesh gets the places of
  // the narrowest disc around it that the mesh resolves. Conditions: that disc is on a flat part of
  // the surface, the body there is at least as thick as the disc is wide, and no place is fixed. At
  // that scale the body is a half-space, whose disc compliances are known (disc_compliance.h).
  // `quarters`: the triangles are quarters of those of ten-node tetrahedra.
  explicit SurfaceFootprints(SurfaceMesh surface, std::vector<char> held = {},
                             bool quarters = false);
  void MayWiden(bool may) { may_widen_ = may; }

  // The nodes that a rigid tool may touch: a moved contact with a width or a radius. Those under a
  // flat face have their share of it. Others have a gap less than the depth at which a round tool
  // is, and somewhat more. Of ten-node tetrahedra only the mid-edge nodes touch: an even pressure
  // acts on them alone, and corners pull under it. `whole`: nodes within a flat face, without rim;
  // a face between nodes is then a point (OnNodes).
  std::string_view OnTool(const Contact& contact, bool whole, ContactFootprint* footprint);
  // A contact moves a node, a point between three nodes, or all nodes of a disc equally. A load
  // acts on a node, on three nodes by their barycentric weights, or uniformly on the triangles of a
  // disc, a third of each triangle's share per node. A point has the three nodes of its triangle,
  // including those with zero weight; nodes of a disc are in rising order.
  std::string_view OnNodes(const Contact& contact, ContactFootprint* footprint);
  // Finds the triangles of a uniform load: without width one, else all whose centroids are inside
  // the disc, in rising order. `basis`: coordinate axes of the disc.
  std::string_view OnTriangles(const Contact& contact, ContactFootprint* footprint,
                               PatchBasis basis);

  [[nodiscard]] const SurfaceMesh& surface() const { return surface_; }
  // The footprint of the last contact that had a width; nodes in rising order, triangles too.
  [[nodiscard]] const DiscPatch& patch() const { return patch_; }

 private:
  // The contact's triangle, or the nearest one; nullopt: farther than half its longest edge.
  [[nodiscard]] std::optional<SurfacePlace> Find(const Contact& contact) const;
  [[nodiscard]] std::optional<SurfacePlace> OnTriangle(int triangle,
                                                       const Eigen::Vector3d& p_O) const;
  // Mean of the normals of the triangles there, unit; zero where they cancel.
  [[nodiscard]] Eigen::Vector3d NormalAt(const SurfacePlace& place) const;
  // The same, interpolated between the nodes: the axis of a tool.
  [[nodiscard]] Eigen::Vector3d AxisAt(const SurfacePlace& place) const;
  // Adds the nodes of searched_ that a flat face of this width has a share of.
  void HoldUnder(const Contact& contact, double width, ContactFootprint* footprint);
  void HoldWhole(const Contact& contact, ContactFootprint* footprint);
  void HoldUnderSphere(const Contact& contact, ContactFootprint* footprint);
  // A node's part of the surface that faces `axis`, as a disc.
  struct Part {
    double radius = 0;                // [m]
    Eigen::Vector3d centre{0, 0, 0};  // its centroid, relative to the node [m]
  };
  [[nodiscard]] Part PartOf(int node, const Eigen::Vector3d& axis) const;
  // Makes a flat tool that has too few nodes wider; false: it is as before.
  bool WidenTool(const Contact& contact, ContactFootprint* footprint);
  // Collects connected triangles of the same orientation around the place. A part of the surface
  // beyond a gap or a step is not touched.
  void FindPatch(const SurfacePlace& place, const Eigen::Vector3d& p_O, double width);
  // Adds the part of a triangle within `radius` of p_O; false: there is none.
  bool AddShare(int triangle, const Eigen::Vector3d& p_O, double radius);
  // FindPatch, and whether the mesh follows it.
  void FindDisc(const Contact& contact, PatchBasis basis, ContactFootprint* footprint);
  bool FindWiderDisc(const Contact& contact, PatchBasis basis, ContactFootprint* footprint);
  [[nodiscard]] bool IsWholeAndPlane(double width) const;
  [[nodiscard]] bool HoldsPatch() const;
  // Returns the thickness along the ray from `p_O` into the body [m]; infinite: no intersection.
  [[nodiscard]] double ThicknessAt(const SurfacePlace& place, const Eigen::Vector3d& p_O) const;
  void AddTriangle(int triangle);
  [[nodiscard]] std::span<const int> TrianglesOf(int node) const { return around_.Of(node); }
  void ShareAmongNodes(ContactFootprint* footprint);
  template <class PositionOf>
  void SetArms(const Contact& contact, const PositionOf& at, ContactFootprint* footprint) const;

  SurfaceMesh surface_;
  double diagonal_ = 0;  // [m]
  std::vector<Eigen::Vector3d> normals_, centroids_;
  std::vector<double> areas_;
  NodeTriangles around_;
  DiscPatch patch_;
  std::vector<int> seen_;      // per node: the last patch that it is in
  std::vector<int> reached_;   // per triangle: the last patch whose search reached it
  std::vector<int> searched_;  // triangles of the present search
  int patches_ = 0;
  std::vector<double> load_;  // per node, zero between calls
  std::vector<char> held_;    // empty: no contact is widened
  bool quarters_;
  std::vector<char> is_corner_;  // per node, of quarters
  bool may_widen_ = true;
};

}  // namespace palpate
