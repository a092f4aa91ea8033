// Interface of a clamped round plate whose shape under its contacts is available anywhere, and the
// nodes on which it is given.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/plate/contacts.h"

namespace palpate {

// Rings of nodes around the centre: node 0 at the centre, ring k = 1..24 of radius k a / 24 with 6
// k nodes from the x axis on, counter-clockwise; the last ring is the clamped rim. Triangles face
// +z, all edges about a / 24 long. Frame O at the centre, z = 0 [m].
SurfaceMesh MembraneGrid(double radius);

// Frame O: origin at the plate's centre, z along the outward normal: a displacement along -z is an
// indentation.
class PlateSurface : public DeformationModel {
 public:
  // A flat round tool of both plate models: rigid, or with a uniform load.
  struct Tool {
    double width = 0;  // diameter [m]; 0: a point
    bool is_rigid = false;
  };
  // A tool around p_O, moved or loaded by `value` along z [m], [N].
  static Contact ToolContact(Contact::Kind kind, const Eigen::Vector2d& p_O, const Tool& tool,
                             double value) {
    return {.kind = kind,
            .p_O = {p_O.x(), p_O.y(), 0},
            .width = tool.width,
            .prescribed_O = {0, 0, value},
            .is_rigid = tool.is_rigid};
  }
  // Displacement along z [m] in a solution of this plate at (x, y) on it, frame O [m]; zero after a
  // failure or without a solution. No allocation.
  [[nodiscard]] double Displacement(const Solution& solution, const Eigen::Vector2d& p_O) noexcept {
    return Show(solution) && answered_ ? DisplacementAt(p_O / radius()) : 0;
  }
  [[nodiscard]] double radius() const { return geometry_.radius; }        // a [m]
  [[nodiscard]] double thickness() const { return geometry_.thickness; }  // t [m]

 protected:
  explicit PlateSurface(const plate::Geometry& geometry);

  // Fills the responses to touches_. Returns false on failure.
  virtual bool TryRespond(std::span<const Contact> contacts,
                          std::span<ContactResponse> responses) = 0;
  // Displacement along z [m] under the last contacts that were answered, at `x` [radii].
  [[nodiscard]] virtual double DisplacementAt(const Eigen::Vector2d& x) noexcept = 0;

  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  // Displacements of the nodes of MembraneGrid().
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  // The preparation is valid for contacts at the same positions.
  [[nodiscard]] bool IsSameSet() const noexcept;

  bool prepared_ = false;
  std::vector<plate::Touch> touches_, known_;  // of this set; of the one that is prepared

 private:
  plate::Geometry geometry_;
  bool answered_ = false;
};

}  // namespace palpate
