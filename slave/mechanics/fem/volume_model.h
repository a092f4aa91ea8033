// Base class of models that solve for all nodes of a meshed volume. It answers, flags and refuses
// by one rule for every element, law and solver.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/tool_contact.h"
#include "slave/mechanics/footprint/volume_contacts.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {

// Rules for positions and widths: slave/solve/README.md. A contact with a prescribed displacement
// moves the nodes of its patch, or the weighted point of its triangle, and reports the force for
// this; on supports the displacement must be zero, and the reaction is reported (in motion: its
// elastic part). In statics an object without fixed boundary requires balanced loads (to 1e-6) and
// moves without mean displacement and rotation.
//
// kExtrapolated: inverted elements (their number is in info().remark), elements that lock, a
// deadline before the residual was reached, the linear law out of range, a time step that created
// energy, a mesh too coarse for a patch or for a part that bends (mesh_resolution.h). kFailed:
// contacts that are not finite, overlap or are not on the body, unbalanced loads, no convergence,
// interruption, displacements beyond a million larger sides, of rigid tools beyond ten; failure()
// says which. After a failure a static body starts from rest again; a moving body, and one under
// rigid tools, is in the state before the query.
class VolumeModel : public DeformationModel {
 public:
  void Reset() final;

  struct Traits {
    int nodes_per_element = 4;
    double length_unit = 0, force_unit = 0;  // the larger side [m], E times its square [N]
    double poisson_ratio = 0;
    bool has_pressure = false;  // whether the pressure is a separate unknown
    bool is_dynamic = false;
    bool finds_tools = false;  // see VolumeContacts
    bool weighs = false;       // gravity acts
    double range = 0;  // largest |displacement| [length units] before `extrapolated`; 0: none
    double step = 0;   // of time [s]; 0: static
  };

 protected:
  // `held`: per node of `mesh`, the components that supports fix.
  VolumeModel(const SolidMesh& mesh, const HeldNodes& held, const Traits& traits);

  // The virtual functions below are nondimensional and use the mesh's node numbers, including
  // mid-edge nodes. Those that return bool call Fail. Rest() sets the body to rest without loads.
  virtual void Rest() = 0;
  // Takes new places() of contacts that prescribe displacements.
  virtual bool Hold(std::span<const Contact> contacts) = 0;
  // Equilibrium under the contacts, or the end of one more step of time.
  virtual bool SolveUnder(std::span<const Contact> contacts) = 0;
  // Makes the last step of time undone, or the last path of tools, after SolveUnder had made it.
  virtual void TakeBack() = 0;
  [[nodiscard]] virtual Eigen::Vector3d DisplacementAt(int node) const = 0;
  // Returns the force of contacts and supports on a constrained node, or the force of a contact
  // that moves a point.
  [[nodiscard]] virtual Eigen::Vector3d ReactionAt(int node) const = 0;
  [[nodiscard]] virtual Eigen::Vector3d PointForce(std::size_t contact) const = 0;
  struct Inversion {
    int elements = 0, first = -1;  // number of elements with det F <= 0; number of the first one
  };
  [[nodiscard]] virtual Inversion FindInversion() const = 0;
  [[nodiscard]] virtual bool gained_energy() const = 0;
  // Estimated error of a contact's force, or displacement if it is a load, without the mesh's; 0:
  // none is estimated.
  [[nodiscard]] virtual double ErrorOf(std::size_t /*contact*/) const { return 0; }
  // Returns the rigid tool of a contact; nullptr: the contact is no tool.
  [[nodiscard]] virtual const fem::ToolContact* ToolOf(std::size_t /*contact*/) const {
    return nullptr;
  }
  // Of a tool whose nodes the model finds itself (ContactPlace::holds): the nodes that it touches,
  // and whether it is settled which they are.
  [[nodiscard]] virtual int Touching(std::size_t /*contact*/) const { return 0; }
  [[nodiscard]] virtual bool settles() const { return true; }
  // The answer depends on the path of the contacts, as under rigid tools. A query that fails then
  // leaves the body as it was.
  [[nodiscard]] virtual bool follows_path() const { return false; }
  // Returns whether the deadline passed before the requested residual was reached.
  [[nodiscard]] virtual bool ended_early() const { return false; }

  // Returns whether a rigid tool moves so far that its path is not computed: the limit bounds the
  // number of its increments.
  [[nodiscard]] bool IsFar(const Contact& tool) const {
    constexpr double kFarthest = 10;  // [larger sides]
    return tool.prescribed_O.norm() > kFarthest * traits_.length_unit;
  }
  static constexpr std::string_view kFarTool =
      "a tool moves by more than ten times the object's larger side";

  [[nodiscard]] std::span<const ContactPlace> places() const { return contacts_.places(); }
  [[nodiscard]] const Inversion& inversion() const { return inversion_; }
  // Four-node elements without a pressure unknown are too stiff at a point from
  // kLocksAtPoint on.
  [[nodiscard]] bool locks() const;
  // Sets the part of info().remark that does not depend on the last answer.
  void SetRemark(std::string remark);

  const Traits traits_;

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept final;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) final;
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool FillResponses(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool PrepareSet(std::span<const Contact> contacts);
  bool TakeState();
  // Compares the strains of the elements with recovered ones.
  void AssessMesh(std::span<const Contact> contacts);
  void CorrectForMesh(std::size_t contact, const Contact& at, ContactResponse* response);
  [[nodiscard]] std::string_view FlagReasonOf() const;
  [[nodiscard]] ContactResponse ResponseOf(std::size_t contact, const Contact& at) const;
  [[nodiscard]] ContactResponse ToolResponse(const fem::ToolContact& tool, const Contact& at) const;
  [[nodiscard]] std::string_view FlagReasonOfPlace(std::size_t contact, const Contact& at,
                                                   const ContactResponse& response) const;
  void RemarkInversion();

  VolumeContacts contacts_;
  StrainResolution strain_;
  double softness_ = 0;             // of the last answer, see StrainResolution; 0 without load
  std::vector<Eigen::Vector3d> u_;  // of the nodes, in length units
  double largest_ = 0;              // largest number of them
  std::vector<int> touched_;        // nodes of contacts
  Inversion inversion_;
  std::string remark_;
};

}  // namespace palpate
