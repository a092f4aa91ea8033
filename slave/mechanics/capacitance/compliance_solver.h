// Contacts in 3D on a body with known compliance: displacements and loads prescribed together.
//
//   C f = u - u_loads,   C = block of the compliance at the touched places
//
// Source: capacitance matrix of James and Pai (2003); paper A, eqs. (5)-(7), in the form of a
// compliance. What a contact touches is told by ContactPlaces. Where few contacts changed, the
// inverse of C is up- and downdated; where many did, C is factorised again.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/linear/updated_inverse.h"
#include "slave/scene/scene.h"

namespace palpate {

// A force on one place. Frame O.
struct PlaceForce {
  int place = -1;
  Eigen::Vector3d force_O{0, 0, 0};  // [N]
};

// Not thread-safe. Keeps references to the compliance and the places.
class ComplianceSolver {
 public:
  struct Params {
    double young_modulus = 0;  // E [Pa]
    double larger_side = 0;    // of the body [m]
    double range = 0.1;        // largest |displacement| / larger side before `extrapolated` [-]
    ContactLaw contact = ContactLaw::kBonded;
    double poisson_ratio = 0;  // counts where contacts are narrower than the mesh (SoftenNarrow)
  };

  // Throws std::invalid_argument: a parameter is not finite and > 0.
  ComplianceSolver(Compliance& compliance, ContactPlaces& places, const Params& params);

  // As DeformationModel::Respond. Frictionless contacts prescribe the displacement along the
  // outward normal at their place and are free across it; the response repeats the prescribed
  // value. kFailed: a place that is not found or has no column, a fixed place that is moved or
  // loaded (its compliance is zero), contacts that share a place, a load that lies completely under
  // contacts, values that are not finite or beyond 1e6 larger sides. Fixed components that are not
  // moved are no unknowns: the support carries their force. Stiffness is computed when it is first
  // requested. O(m^2) if nothing or little changed, O(m^3) otherwise, m unknown components.
  void Respond(std::span<const Contact> contacts, std::span<ContactResponse> responses) noexcept;

  // What a moved contact costs [us]: the contacts in turn, on a solver of their own; 0: one of them
  // has no solution.
  static double MeasureUpdate(Compliance& compliance, ContactPlaces& places, const Params& params,
                              const std::array<Contact, 2>& contacts);
  [[nodiscard]] const Params& params() const { return params_; }

  // Why the last Respond failed, one clause.
  [[nodiscard]] std::string_view failure() const { return failure_; }

  // What the contacts of the last Respond touch.
  [[nodiscard]] std::span<const ContactSlot> slots() const { return set_.slots(); }
  // Every force on a place under the contacts of the last Respond, contacts and loads; a place may
  // appear more than once. Empty if it failed.
  void Forces(std::vector<PlaceForce>* forces) const;
  // Displacement of every place of the compliance [m], by its columns. O(N S).
  void Displacement(std::vector<Eigen::Vector3d>* displacement_O);

  [[nodiscard]] std::size_t memory_bytes() const { return inverse_.memory_bytes(); }

 private:
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool Refuse(std::string_view why);
  bool Fail(std::string_view why);  // and the contacts are forgotten
  [[nodiscard]] bool Acceptable(const Contact& contact) const noexcept;
  bool Prepare(std::span<const Contact> contacts);
  bool AnswerAgain(bool little_changed);
  [[nodiscard]] bool LittleChanged() const;
  bool InvertChanged();
  [[nodiscard]] Eigen::Matrix3d Lacking(const ContactSlot& slot) const;
  void SoftenNarrow(const ContactSlot& slot, bool lower_half);
  void SoftenLoads();
  void FillStiffness();
  [[nodiscard]] Eigen::Matrix3d StiffnessBySolving(const ContactSlot& slot);
  [[nodiscard]] Eigen::Matrix3d StiffnessByBlocks(const ContactSlot& slot) const;
  [[nodiscard]] Eigen::Matrix3d StiffnessOfLoad(const ContactSlot& slot);
  bool Prescribe(std::span<const Contact> contacts);
  [[nodiscard]] bool MovesWhatIsHeld(const ContactSlot& slot, const Contact& contact) const;
  [[nodiscard]] Eigen::Vector3d ForceOf(const ForceUnknown& unknown) const;
  [[nodiscard]] ContactResponse ResponseOf(const ContactSlot& slot, const Contact& contact) const;
  [[nodiscard]] Eigen::Vector3d DisplacementOfLoad(int load) const;
  void SetMomentOf(const ContactSlot& slot, ContactResponse* response) const;

  Compliance& compliance_;
  Params params_;
  double length_unit_ = 0;  // [m]
  double force_unit_ = 0;   // [N]
  ContactSet set_;
  UpdatedInverse inverse_;
  LoadCoupling loads_;

  std::string_view failure_;
  bool answered_ = false;
  // Nondimensional, per unknown component, zeros behind.
  AlignedArray prescribed_, forces_, scratch_;
  int vector_room_ = 0;
  std::vector<Eigen::Vector3d> load_forces_;  // nondimensional, per load
  bool stiffness_known_ = false;
  std::vector<Eigen::Matrix3d> stiffness_;  // nondimensional, per contact
};

}  // namespace palpate
