// `fem-green`: a fixed elastic body by surface Green's functions condensed from tetrahedra, and the
// capacitance of its contacts. Linear: small strains and rotations. A contact takes microseconds
// independent of the mesh size if the columns of its places are known; the first contact in a
// region takes milliseconds to a few tenths of a second (100k tetrahedra).
//
// Source: James and Pai (2003); see compliance_solver.h and green_columns.h.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/capacitance/compliance_solver.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/green/bending_table.h"
#include "slave/mechanics/fem/green/green_columns.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

// From nu = 0.4 on, up to 0.5, the pressure is an unknown (RestStiffness), and no element locks.
// The forces of tools contain the error of the mesh (mesh_resolution.h). Results are kExtrapolated
// if a part bends too strongly for the elements. Both are found at the first contact on a triangle
// by three more sparse solutions, unless they are in the cache (BendingTable). See
// SurfaceNodePlaces and ComplianceSolver. Pass `element` with p_O to save time: without it the
// whole surface is searched for a changed position.
class FemGreenModel final : public DeformationModel {
 public:
  struct Options {
    FemOptions::Element element = FemOptions::Element::kTet4;
    ContactLaw contact = ContactLaw::kBonded;
    double range = 0.1;  // largest |displacement| / larger side before `extrapolated` [-]
    std::filesystem::path cache{};  // folder for Green's functions; empty: none are kept
    double width = 0;  // width of the contacts whose bending is stored in the cache [m]
    std::size_t memory_limit = std::size_t{1} << 31;  // for Green's functions [bytes]
  };

  // `held`: per node and component, kept at zero. Throws std::invalid_argument: see AssembleAtRest;
  // modulus or range not positive; Interrupted.
  FemGreenModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
                double poisson_ratio, const Options& options, Progress* progress = nullptr);

  // Computes the columns of the contacts' places, and how the body bends there.
  void Prefetch(std::span<const Contact> contacts) override;
  [[nodiscard]] std::string_view failure() const override {
    return failure_.empty() ? solver_.failure() : failure_;
  }

  // The linear triangles of the surface.
  [[nodiscard]] const SurfaceMesh& surface() const { return surface_; }
  [[nodiscard]] GreenColumns& columns() { return columns_; }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  // Displacements of all nodes of the mesh, by one sparse solution.
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  void Describe(const Options& options, std::size_t tets);
  [[nodiscard]] double MeasureUpdate();
  void AssessMesh(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  void AssessMesh(const ContactSlot& slot, const Contact& contact, ContactResponse* response);

  [[nodiscard]] double MeshPart(const ContactSlot& slot, const Bending& bending,
                                const ContactResponse& response) const;
  const Bending& BendingOf(int triangle, double width);

  SurfaceMesh surface_;
  GreenColumns columns_;
  SurfaceNodePlaces places_;
  ComplianceSolver solver_;
  BendingTable bending_;
  double displacement_unit_ = 0;  // of a unit force in newtons: 1 / (E length unit) [m/N]
};

}  // namespace palpate
