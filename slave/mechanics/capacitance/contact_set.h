// The contacts that act together: what they touch, which forces are unknown, and what changed since
// the last time.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/capacitance/contact_places.h"
#include "slave/mechanics/capacitance/force_unknown.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"

namespace palpate {

// One contact of the set.
struct ContactSlot {
  Contact::Kind kind = Contact::Kind::kDisplacement;
  int element = -1;
  double width = 0;
  Eigen::Vector3d p_O{0, 0, 0};

  ContactFootprint footprint;
  int unknown = 0, unknowns = 0;  // in unknowns(); none for loads
  int row = 0, rows = 0;          // their components in the capacitance matrix
  int load = -1;                  // number among the loads; -1: none
  std::array<bool, 3> held{};     // components that a support holds somewhere under the contact
};

// Not thread-safe. Memory only grows.
class ContactSet {
 public:
  enum class Outcome : std::uint8_t { kSame, kChanged, kAnew, kFailed };
  // Rows that gave way to others; a change's row counts those before it as they are now.
  struct Change {
    int row = 0, removed = 0, inserted = 0;
    int unknown = 0, unknowns = 0;
    int slot = 0, slots = 0;
  };

  ContactSet(Compliance& compliance, ContactPlaces& places, ContactLaw law)
      : compliance_(compliance),
        places_(places),
        law_(law),
        touched_(static_cast<std::size_t>(compliance.places())) {}

  // Values of the contacts are not looked at. kChanged: changes() says what, provided the caller
  // kept up with every outcome before. kFailed: the set is forgotten, failure() says why.
  Outcome Update(std::span<const Contact> contacts);
  void Forget() { known_ = false; }

  [[nodiscard]] std::span<const ContactSlot> slots() const { return {slots_.data(), Count()}; }
  [[nodiscard]] std::span<const ForceUnknown> unknowns() const { return unknowns_; }
  [[nodiscard]] std::span<const Change> changes() const { return changes_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int loads() const { return loads_; }
  [[nodiscard]] std::string_view failure() const { return failure_; }
  [[nodiscard]] ContactLaw law() const { return law_; }

 private:
  // By place: what is asked often, close together.
  struct Touched {
    int set = 0;  // the last in which a contact moved it
    bool known = false;
    Eigen::Matrix3d self;  // its own block of the compliance
  };

  [[nodiscard]] std::size_t Count() const { return static_cast<std::size_t>(count_); }
  Outcome Fail(std::string_view why);
  bool FindChanged(std::span<const Contact> contacts);
  bool FindSpliced(std::span<const Contact> contacts);
  bool Find(const Contact& contact, ContactSlot* slot);
  void MakeRoom();
  bool Number();
  bool AddUnknown(std::span<const PlaceWeight> places, ContactSlot* slot);
  bool SelfBlock(const ForceUnknown& unknown, Eigen::Matrix3d* block);
  bool MarkMoved(const ContactSlot& slot);
  [[nodiscard]] bool LiesUnderContacts(const ContactSlot& load) const;

  Compliance& compliance_;
  ContactPlaces& places_;
  ContactLaw law_;
  std::vector<Touched> touched_;
  int set_ = 0;
  bool known_ = false;
  std::vector<ContactSlot> slots_;  // the first count_ are in use: footprints keep their memory
  int count_ = 0;
  std::size_t most_places_ = 1;  // of a footprint so far: all slots have that much room
  std::vector<ForceUnknown> unknowns_;
  std::vector<Change> changes_;
  int rows_ = 0, loads_ = 0;
  std::string_view failure_;
};

}  // namespace palpate
