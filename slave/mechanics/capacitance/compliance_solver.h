// Contacts on a body with known compliance: displacements and loads prescribed together.
//
//   C f = u - u_loads,   C = block of the compliance at the touched places
//
// A rigid tool touches its places one by one. With its axis n, the depth d = -n . u of its
// displacement u, and the gap g of a place at rest, the place has the displacement w along -n and
// the force f against it
//
//   f >= 0,  w >= d - g,  f (w - d + g) = 0
//
// A bonded place that touches also follows the tool across n, from where the tool has met it: on a
// straight path from rest by the part 1 - g / d. Places at the rim of a flat face are held by
// springs (rim_share.h). A flat tool that does not press, d <= 0, is glued to all its places; a
// round one has no force.
//
// Which places touch is found by block principal pivoting: all places that pull are released, all
// that penetrate are touched, and if their number does not fall only one of them, which ends after
// finitely many rounds without friction (Judice and Pires, Comput. Oper. Res. 21, 1994). Bonded
// places follow the same rule, without a proof; after kReleasing rounds none is released any more.
//
// Source: capacitance matrix of James and Pai (2003); paper A, eqs. (5)-(7), in the form of a
// compliance. ContactPlaces finds the places of a contact, so the same solver serves surface nodes
// (fem-green) and boundary elements (bem2d).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/linear/dense_factor.h"
#include "slave/scene/scene.h"

namespace palpate {

// A force on one place. Frame O.
struct PlaceForce {
  int place = -1;
  Eigen::Vector3d force_O{0, 0, 0};  // [N]
};

// Not thread-safe. Stores references to the compliance and the places.
class ComplianceSolver {
 public:
  struct Params {
    double young_modulus = 0;  // E [Pa]
    double larger_side = 0;    // of the body [m]
    double range = 0.1;        // largest |displacement| / larger side before `extrapolated` [-]
    ContactLaw contact = ContactLaw::kBonded;
    double poisson_ratio = 0;  // for springs of tools; of a plane body 0 in plane stress
    double thickness = 0;      // of a plane body [m]
    MomentRule moment{};
    double springs = 1;  // factor on the springs at the rim of a flat tool (rim_share.h)
  };

  // Throws std::invalid_argument: a parameter is not finite and > 0.
  ComplianceSolver(Compliance& compliance, ContactPlaces& places, const Params& params);

  // As DeformationModel::Respond. Frictionless contacts prescribe the displacement along the
  // outward normal at their place and are free across it; the response repeats the prescribed
  // value. kFailed: a place that is not found or has no column, a fixed place that is moved or
  // loaded (its compliance is zero), contacts that share a place, a load that lies completely under
  // contacts, values that are not finite or beyond 1e6 larger sides. kExtrapolated: too few places
  // of a tool touch, or it is not settled which do. Fixed components with zero
  // displacement are not unknowns: the support carries their force. Stiffness is computed when it
  // is first requested. O(m^2) if only values changed, O(m^3) otherwise, m unknown components.
  void Respond(std::span<const Contact> contacts, std::span<ContactResponse> responses) noexcept;

  // Measures the time of an update after a contact has moved [us], by moving the contacts one after
  // another on a separate solver; 0: one of them has no solution.
  static double MeasureUpdate(Compliance& compliance, ContactPlaces& places, const Params& params,
                              const std::array<Contact, 2>& contacts);
  [[nodiscard]] const Params& params() const { return params_; }

  [[nodiscard]] bool answered() const { return answered_; }
  // Why the last Respond failed, one clause.
  [[nodiscard]] std::string_view failure() const { return failure_; }

  // The parts of the surface that the contacts of the last Respond touch.
  [[nodiscard]] std::span<const ContactSlot> slots() const { return set_.slots(); }
  // Unknown components, those of free motions included.
  [[nodiscard]] int rows() const { return set_.rows(); }
  // Returns the forces at all places of the last Respond: of contacts, loads and free motions. A
  // place may appear more than once. Empty if Respond failed.
  void Forces(std::vector<PlaceForce>* forces) const;

 private:
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool Refuse(std::string_view why);
  bool Fail(std::string_view why);  // and the contacts are forgotten
  [[nodiscard]] bool Acceptable(const Contact& contact) const noexcept;
  [[nodiscard]] bool WantsColumns(std::span<const Contact> contacts) const;
  bool Prepare(std::span<const Contact> contacts);
  void FillCapacitance(double* first, int stride);
  [[nodiscard]] double SpringShare(const ContactSlot& slot, const ContactResponse& response) const;
  void AddSprings(const ContactSlot& slot, double* first, int stride) const;
  bool FactoriseTouching();
  bool Settle(std::span<const Contact> contacts);
  bool StartTouching(std::span<const Contact> contacts);
  void GuessTouching(std::size_t tool);
  bool FindInfeasible(bool releases);
  void SwitchInfeasible();
  [[nodiscard]] double DisplacementAlong(const Eigen::Vector3d& n, const ForceUnknown& at) const;
  // The part of a tool's displacement that a place follows.
  [[nodiscard]] double FollowedPart(std::size_t contact, const ForceUnknown& at) const;
  [[nodiscard]] std::span<const ForceUnknown> UnknownsOf(const ContactSlot& slot) const {
    return set_.unknowns().subspan(static_cast<std::size_t>(slot.unknown),
                                   static_cast<std::size_t>(slot.unknowns));
  }
  [[nodiscard]] Eigen::Matrix3d Lacking(const ContactSlot& slot) const;
  void SoftenNarrow(const ContactSlot& slot, double* first, int stride);
  void SoftenLoads();
  void AddPrescribed(std::size_t contact);
  // `first`: of the contact's columns.
  void FillUnitColumns(const ContactSlot& slot, double* first) const;
  void SolveColumns();
  [[nodiscard]] Eigen::Matrix3d StiffnessOf(const ContactSlot& slot, const double* first) const;
  [[nodiscard]] Eigen::Matrix3d StiffnessOfLoad(const ContactSlot& slot, const double* first) const;
  bool SetValues(std::span<const Contact> contacts);
  void SolveForces();
  [[nodiscard]] bool TouchesGaps() const;
  [[nodiscard]] int TouchingOf(const ContactSlot& slot) const;
  [[nodiscard]] double EdgeError(const ContactSlot& slot) const;
  [[nodiscard]] double TouchError(const ContactSlot& slot) const;
  [[nodiscard]] Eigen::Vector3d Value(std::size_t contact) const;
  [[nodiscard]] bool MovesWhatIsHeld(const ContactSlot& slot, const Contact& contact) const;
  [[nodiscard]] Eigen::Vector3d ForceOf(const ForceUnknown& unknown) const;
  [[nodiscard]] ContactResponse ResponseOf(const ContactSlot& slot, const Contact& contact) const;
  [[nodiscard]] Eigen::Vector3d DisplacementOfLoad(int load) const;
  void SetMomentOfTool(const ContactSlot& slot, ContactResponse* response) const;
  void SetMomentOf(const ContactSlot& slot, ContactResponse* response) const;

  Compliance& compliance_;
  Params params_;
  double length_unit_ = 0;  // [m]
  double force_unit_ = 0;   // [N]
  ContactSet set_;
  DenseFactor factor_;  // of the rows that touch
  bool factored_ = false;

  // How a tool moves its places: all, the nearest one, or those that it touches.
  enum class Touching : std::uint8_t { kAll, kNearest, kSome };
  struct ToolState {
    bool is_known = false;  // touches_ has an earlier answer
    Touching touching = Touching::kAll;
    double depth = 0;  // [length units]
  };
  bool has_tools_ = false;
  bool is_settled_ = true;
  std::vector<ToolState> tools_;  // per contact
  std::vector<double> whole_;     // capacitance matrix of all rows, if there are tools
  int whole_stride_ = 0;
  std::vector<char> touches_;            // per unknown
  std::vector<int> position_;            // per row: its row in factor_; -1: it does not touch
  std::vector<std::size_t> infeasible_;  // unknowns
  std::size_t fewest_infeasible_ = 0;
  int blocks_left_ = 0;
  LoadCoupling loads_;

  std::string_view failure_;
  bool answered_ = false;
  // Nondimensional. Values: components() per contact, displacement or force; forces: amplitudes of
  // the unknown components.
  std::vector<double> values_, forces_, right_;
  // Amplitudes for unit values, in the rows of factor_, row-major; known if a stiffness was
  // requested or contacts are few.
  std::vector<double> columns_;
  int column_stride_ = 0;
  bool columns_known_ = false;
  std::vector<Eigen::Matrix3d> stiffness_;  // per contact
};

}  // namespace palpate
