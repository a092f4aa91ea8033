// Interface of a clamped round plate whose shape under its contacts is available anywhere, and the
// nodes on which it is given.
#pragma once

#include <algorithm>
#include <new>
#include <span>
#include <stdexcept>
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
  // Of the nodes of MembraneGrid().
  void Displacements(std::vector<Eigen::Vector3d>* u_O) override;
  // Displacement along z [m] at (x, y) on the plate, frame O [m], under the contacts of the last
  // Respond; zero where it failed. No allocation.
  [[nodiscard]] double Displacement(const Eigen::Vector2d& p_O) noexcept {
    return DisplacementAt(p_O / radius());
  }
  // Respond to one disc of diameter `width` around p_O, moved or loaded by `value` along z [m],
  // [N].
  ContactResponse RespondTo(Contact::Kind kind, const Eigen::Vector2d& p_O, double width,
                            double value) noexcept;
  [[nodiscard]] double radius() const { return geometry_.radius; }        // a [m]
  [[nodiscard]] double thickness() const { return geometry_.thickness; }  // t [m]

 protected:
  explicit PlateSurface(const plate::Geometry& geometry);

  // The same at `x` [radii].
  [[nodiscard]] virtual double DisplacementAt(const Eigen::Vector2d& x) noexcept = 0;

  // Respond: checks the contacts, then calls `answer`, which returns a bool, to fill the responses.
  template <class Answer>
  void RespondBy(std::span<const Contact> contacts, std::span<ContactResponse> responses,
                 const Answer& answer) noexcept {
    failure_ = {};
    try {
      failure_ = plate::Check(contacts, geometry_, &touches_);
      answered_ = responses.size() == contacts.size() && failure_.empty() && answer();
    } catch (const std::bad_alloc&) {
      answered_ = prepared_ = Fail("out of memory");
    } catch (const std::runtime_error&) {
      answered_ = prepared_ =
          Fail("the plate's response to a central indentation of this width is not found");
    }
    if (!answered_) std::ranges::fill(responses, ContactResponse{});
  }
  // The preparation is valid for contacts at the same positions.
  [[nodiscard]] bool IsSameSet() const noexcept;

  bool answered_ = false, prepared_ = false;
  std::vector<plate::Touch> touches_, known_;  // of this set; of the one that is prepared

 private:
  plate::Geometry geometry_;
};

}  // namespace palpate
