// `bem2d`: a planar elastic body by constant, linear or quadratic boundary elements, precomputed
// Green's functions and the capacitance matrix (paper A, 3.3-3.4).
#pragma once

#include <span>
#include <vector>

#include "slave/mechanics/bem/element_places.h"
#include "slave/mechanics/bem/greens_functions.h"
#include "slave/mechanics/capacitance/compliance_solver.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

inline constexpr std::string_view kCoarseElements =
    "the elements are too coarse for how the body gives way here: the stiffness error is about 5 % "
    "or more; use more elements or a higher model.order";

// Displacements and tractions on the boundary, node by node: the elements' midpoints where they are
// constant, the points of ElementNodes in each element where not. Frame O.
struct BoundaryState {
  std::vector<Eigen::Vector2d> displacement;  // [m]
  std::vector<Eigen::Vector2d> traction;      // on the body [Pa]
};

// Frictionless contacts prescribe the displacement along the outward normal of the element at their
// place and leave the traction across it zero; the response repeats the prescribed value. A contact
// on fixed elements must have a zero displacement there and reports the reaction. A load that lies
// in part on fixed elements gives that part to the support. Loads on a body without fixed nodes
// must balance to 1e-6. Displacements beyond 1e6 times the larger side, and forces that would cause
// them, give kFailed. Results are also kExtrapolated if the elements under a contact change its
// width so much that the stiffness has an error of more than a tenth, or if the order of the
// elements causes more than a twentieth (element_error.h). With `element` -1 all elements are
// searched for the position, which takes longer.
class Bem2dModel final : public DeformationModel {
 public:
  struct Params {
    double young_modulus = 0;  // E [Pa]
    double thickness = 0;      // [m]
    ContactLaw contact = ContactLaw::kBonded;
    double range = 0.1;  // largest |displacement| / larger side before `extrapolated` [-]
  };

  // Reports expected cost and progress to `progress`, if there is one. Throws
  // std::invalid_argument: see GreensFunctions; modulus, thickness or range not positive;
  // Interrupted.
  Bem2dModel(ReferenceProblem problem, const Params& params, Progress* progress = nullptr);

  // Returns zero after a failure or without a solution.
  [[nodiscard]] BoundaryState Boundary(const Solution& solution);
  [[nodiscard]] const GreensFunctions& greens_functions() const { return greens_; }
  [[nodiscard]] const Params& params() const { return params_; }
  [[nodiscard]] std::string_view failure() const override {
    return failure_.empty() ? solver_.failure() : failure_;
  }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  // The weighted mean of the values of both elements at a vertex, with the larger weight for the
  // shorter one; for constant elements that is the straight line between their midpoints. The error
  // is O(h^2) on smooth boundary, O(h^3) with quadratic elements, one order less in corners of
  // constant ones.
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  [[nodiscard]] PlanarCover MakeCover() const override;
  void ComputeInside(const std::vector<Eigen::Vector2d>& places,
                     std::vector<Eigen::Vector3d>* u_O) override;
  // Returns the mean of both elements at a vertex; components fixed by supports are treated
  // separately.
  void ComputeTractions(std::vector<float>* pascals) override;
  [[nodiscard]] BoundaryState AtRest() const;
  [[nodiscard]] BoundaryState Shown() const;
  void Describe();
  [[nodiscard]] double MeasureUpdate();
  [[nodiscard]] bool Accept();
  // Returns the traction divided by E at a place, without reactions of supports, or the amplitude
  // of a free motion.
  [[nodiscard]] Eigen::Vector2d AmplitudeOf(const PlaceForce& at) const;
  [[nodiscard]] bool Balances() const;
  void AddReaction(const ContactSlot& slot, ContactResponse* response) const;
  // Returns whether the order of the elements causes too large an error of this answer
  // (element_error.h).
  [[nodiscard]] bool HasElementError(std::span<const ContactResponse> responses) noexcept;

  Params params_;
  GreensFunctions greens_;
  double larger_side_ = 0;  // [m]
  ElementPlaces places_;
  ComplianceSolver solver_;
  double force_unit_ = 0;  // E times length unit times thickness [N]
  int max_rows_ = 0;       // components that may be unknown
  bool answered_ = false;
  std::vector<PlaceForce> forces_;  // forces of the last answer, if they are needed
  std::vector<Eigen::Vector2d> probe_forces_;
  Eigen::MatrixXd inside_H_, inside_G_;  // see BoundarySystem::Inside; empty: not needed yet
};

}  // namespace palpate
