// A model of an elastic body whose moduli all relax alike: the forces of prescribed displacements
// relax, and loaded contacts creep. One Respond is one time step, in which the prescribed values
// change linearly.
//
// Every contact keeps the history of its force (prony_series.h). For a prescribed load the elastic
// load is computed that gives this force after relaxation. For a linear model both are exact while
// the contacts stay the same. A new contact has no history; a sliding one keeps the history of the
// last contact within its width. The history of a contact that ends is lost: the surface returns to
// rest at once.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/relaxation/prony_series.h"

namespace palpate {

class RelaxingModel final : public DeformationModel {
 public:
  // `elastic`: a static model with the instantaneous moduli, whose answers are independent of
  // earlier ones. `step` [s]. Throws: see PronySeries.
  RelaxingModel(std::unique_ptr<DeformationModel> elastic, std::span<const RelaxationTerm> terms,
                double step);

  void Reset() override;
  // Contacts that act already at the start reach their values at once.
  void Start(std::span<const Contact> contacts) override;
  void Prefetch(std::span<const Contact> contacts) override { elastic_->Prefetch(contacts); }
  [[nodiscard]] std::string_view failure() const override { return elastic_->failure(); }

 private:
  struct History {
    Contact contact;
    RelaxationMemory memory;
    bool taken = false;
  };

  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  [[nodiscard]] PlanarCover MakeCover() const override { return elastic_->cover(); }
  void ComputeInside(const std::vector<Eigen::Vector2d>& places,
                     std::vector<Eigen::Vector3d>* u_O) override;
  [[nodiscard]] std::span<const Contact> ContactsAtRest(std::span<const Contact>) const override {
    return at_rest_;
  }
  void ComputeAtRest(std::span<const Contact> contacts,
                     std::span<ContactResponse> responses) noexcept override;
  void Remember(std::span<const Contact> contacts);
  void Forget(std::span<ContactResponse> responses) noexcept;
  [[nodiscard]] History* Earlier(const Contact& contact, std::size_t number);

  std::unique_ptr<DeformationModel> elastic_;
  PronySeries series_;
  double nearby_;                           // how far a contact without a width slides [m]
  std::vector<History> histories_, known_;  // of the contacts now, of those before
  std::vector<Contact> at_rest_;            // contacts of the elastic body at the last Respond
};

}  // namespace palpate
