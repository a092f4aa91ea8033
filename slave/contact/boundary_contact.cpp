#include "slave/contact/boundary_contact.h"

#include <optional>

#include "slave/contact/obb_tree.h"

namespace palpate {
namespace {

// Farther away than this many times the body's reach there is no tool, and squares of squares would
// leave the numbers.
constexpr double kFarthest = 1e9;

}  // namespace

struct BoundaryContact::Parts {
  explicit Parts(const BoundaryMesh& mesh) : tree(mesh) {}

  void Take(const ElementPlace& at) noexcept {
    place.element = at.element;
    place.s = at.s;
    place.p_O = at.p_O;
    place.normal_O = tree.normal(at.element);
  }
  [[nodiscard]] double GapOf(const Eigen::Vector2d& p) const noexcept {
    return (p - place.p_O).dot(place.normal_O);
  }

  // Out of contact so far, on the way from `from` to `to`.
  void Approach(const Eigen::Vector2d& from, const Eigen::Vector2d& to) noexcept {
    const auto entry = tree.FirstEntry(from, to);
    Take(entry ? *entry : tree.Nearest(to, place.element));
    place.gap = GapOf(to);
    in_contact = place.gap < 0;  // without an entry: inside all the same, by rounding or from start
  }

  ObbTree tree;
  BoundaryPlace place;
  std::optional<Eigen::Vector2d> last_tip;
  bool in_contact = false;
};

BoundaryContact::BoundaryContact(const BoundaryMesh& mesh)
    : parts_(std::make_unique<Parts>(mesh)) {}

BoundaryContact::~BoundaryContact() = default;

const BoundaryPlace& BoundaryContact::MoveTip(const Eigen::Vector2d& p_O_tip) noexcept {
  Parts& parts = *parts_;
  const bool is_usable =
      p_O_tip.allFinite() && p_O_tip.cwiseAbs().maxCoeff() <= kFarthest * parts.tree.reach();
  if (!is_usable) return parts.place;
  const Eigen::Vector2d from = parts.last_tip.value_or(p_O_tip);
  parts.last_tip = p_O_tip;
  if (!parts.in_contact) {
    parts.Approach(from, p_O_tip);
    return parts.place;
  }
  const double gap = parts.GapOf(p_O_tip);
  if (gap < 0) {
    parts.place.gap = gap;
    return parts.place;
  }
  // Out through the plane: the rest of the way may already lead in elsewhere.
  const double last_gap = parts.place.gap;
  const Eigen::Vector2d left_at = from + last_gap / (last_gap - gap) * (p_O_tip - from);
  parts.Approach(left_at, p_O_tip);
  return parts.place;
}

bool BoundaryContact::in_contact() const {
  return parts_->in_contact;
}

void BoundaryContact::Reset() noexcept {
  parts_->place = BoundaryPlace();
  parts_->last_tip.reset();
  parts_->in_contact = false;
}

}  // namespace palpate
