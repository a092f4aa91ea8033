// A set of contacts: the places of each and the unknown forces. The boundary of the model defines
// the places of a contact and their shares.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/footprint/volume_footprints.h"
#include "slave/scene/scene.h"

namespace palpate {

class ContactPlaces {
 public:
  virtual ~ContactPlaces() = default;

  // Finds the places of `contact` from its kind, p_O, element, width and radius; of its value only
  // the depth of a round tool is used.
  // Returns empty, or the reason why none is found, one clause with static lifetime. Does not
  // allocate if `footprint` has enough capacity. Called only for contacts that changed; the contact
  // is finite.
  virtual std::string_view Find(const Contact& contact, ContactFootprint* footprint) = 0;
  // Permits wider discs (SurfaceFootprints) for contacts that are too narrow for the mesh. They are
  // permitted at first.
  virtual void MayWiden(bool /*may*/) {}
};

// Places are nodes of a volume's surface (fem-green).
class SurfaceNodePlaces final : public ContactPlaces {
 public:
  // `place_of_node`: -1 for nodes that are not places. The rest: see VolumeFootprints.
  SurfaceNodePlaces(const TetMesh& mesh, double unit, std::vector<int> place_of_node,
                    const std::vector<char>& uneven)
      : footprints_(mesh, unit, uneven), place_of_node_(std::move(place_of_node)) {}
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override;
  void MayWiden(bool may) override { footprints_.MayWiden(may); }

 private:
  VolumeFootprints footprints_;
  std::vector<int> place_of_node_;
};

// One contact of the set.
struct ContactSlot {
  Contact contact;  // its value is that of the set in which it was added
  ContactFootprint footprint;
  int unknown = 0, unknowns = 0;  // in unknowns(); none for loads
  int load = -1;                  // number among the loads; -1: none
  // A tool that is flagged for the few places that it touches, although the mesh has more there.
  [[nodiscard]] bool touches_few() const {
    return contact.radius > 0 || (is_tool() && footprint.patch_error == 0);
  }
  [[nodiscard]] bool is_tool() const { return !footprint.holds.empty(); }
  // Components that a support fixes somewhere under the contact, everywhere under a load.
  std::array<bool, 3> held{};
  bool on_support = false;  // see kOnSupport (mesh_resolution.h)
};

// Not thread-safe. Memory only grows.
class ContactSet {
 public:
  enum class Outcome : std::uint8_t { kSame, kChanged, kFailed };

  ContactSet(Compliance& compliance, ContactPlaces& places, ContactLaw law)
      : compliance_(compliance),
        places_(places),
        law_(law),
        moved_by_(static_cast<std::size_t>(compliance.places()), 0),
        moved_share_(static_cast<std::size_t>(compliance.places()), 0) {}

  // Ignores the values of the contacts, except a round tool that is deeper than before. Looks only
  // for the places of those that changed. kFailed: the set is cleared, failure() is the reason.
  Outcome Update(std::span<const Contact> contacts);
  void Forget() { known_ = false; }

  [[nodiscard]] std::span<const ContactSlot> slots() const { return {slots_.data(), Count()}; }
  // Returns the unknowns of contacts in their order, then the free rigid motions of the body.
  [[nodiscard]] std::span<const ForceUnknown> unknowns() const { return unknowns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int loads() const { return loads_; }
  [[nodiscard]] std::string_view failure() const { return failure_; }

 private:
  [[nodiscard]] std::size_t Count() const { return static_cast<std::size_t>(count_); }
  Outcome Fail(std::string_view why);
  bool Refuse(std::string_view why) {
    failure_ = why;
    return false;
  }
  bool FindChanged(std::span<const Contact> contacts);
  bool FindSpliced(std::span<const Contact> contacts);
  bool FindAsTheyAre(std::span<const Contact> contacts);
  [[nodiscard]] bool IsSame(std::span<const Contact> contacts) const;
  [[nodiscard]] bool IsCrowded() const;
  bool Find(const Contact& contact, ContactSlot* slot);
  // Gives each slot the storage of the largest contact, because contacts move from slot to slot.
  void MakeRoom() {
    for (auto& slot : slots_) {
      slot.footprint.places.reserve(max_places_);
      slot.footprint.arms.reserve(max_places_);
      slot.footprint.holds.reserve(max_places_);
    }
  }
  bool Number();
  bool FindHeld(ContactSlot* slot);
  bool IsHeldRim(const PlaceWeight& at, const ToolHold& hold);
  bool AddUnknowns(ContactSlot* slot);
  bool AddUnknown(std::span<const PlaceWeight> places, ContactSlot* slot);
  void AddMotions();
  bool MarkMoved(const ContactSlot& slot);
  [[nodiscard]] bool LiesUnderContacts(const ContactSlot& load) const;

  Compliance& compliance_;
  ContactPlaces& places_;
  ContactLaw law_;
  // For each place the number of the last set in which a contact moved it.
  std::vector<int> moved_by_;
  std::vector<double> moved_share_;  // of its area, by all contacts of that set [-]
  int set_ = 0;
  bool known_ = false;
  bool crowded_ = false;            // a neighbour prevented a wider disc for a contact
  std::vector<ContactSlot> slots_;  // the first count_ are in use: footprints keep their memory
  int count_ = 0;
  std::size_t max_places_ = 1;  // largest footprint so far, and capacity of every slot
  std::vector<ForceUnknown> unknowns_;
  int rows_ = 0, loads_ = 0;
  std::string_view failure_;
};

// Displacements by loads at the places of contacts and of the loads themselves. Nondimensional.
class LoadCoupling {
 public:
  explicit LoadCoupling(Compliance& compliance) : compliance_(compliance) {}

  // O(unknowns times loaded places). Memory only grows.
  void Fill(const ContactSet& set);

  // Displacement of the unknown components by a unit force `c` of a load.
  [[nodiscard]] std::span<const double> unknowns_by(int load, int c) const {
    return Row(by_, load, c);
  }
  // Mean displacement `c` of a load's places by unit unknown components.
  [[nodiscard]] std::span<const double> load_by_unknowns(int load, int c) const {
    return Row(at_, load, c);
  }
  // Mean displacement of a load's places by another load's unit force.
  [[nodiscard]] const Eigen::Matrix3d& between(int at, int by) const {
    return between_[static_cast<std::size_t>(at * loads_ + by)];
  }
  // Additional displacement of a load's own places.
  void Soften(int load, const Eigen::Matrix3d& compliance) {
    between_[static_cast<std::size_t>(load * (loads_ + 1))] += compliance;
  }

 private:
  [[nodiscard]] std::span<const double> Row(const std::vector<double>& rows, int load,
                                            int c) const {
    const auto count = static_cast<std::size_t>(rows_);
    return std::span(rows).subspan(static_cast<std::size_t>(3 * load + c) * count, count);
  }
  void AddToUnknown(const ForceUnknown& at, const double* column, int place, double weight,
                    int load);
  void AddToLoad(const ForceUnknown& by, int place, double weight, int load);

  Compliance& compliance_;
  int loads_ = 0, rows_ = 0;
  std::vector<double> by_, at_;  // 3 rows per load
  std::vector<Eigen::Matrix3d> between_;
};

}  // namespace palpate
