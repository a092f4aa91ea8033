#include "master/station/pointer_control_lock.h"

#include "master/device/pointer.h"

namespace palpate {

bool PointerControlLock::Hears(std::uint64_t page, bool engaged, Time now) {
  if (!engaged) too_early_.erase(page);
  const bool is_led =
      leader_ != 0 && leader_ != page && SecondsBetween(heard_at_, now) <= Pointer::kSilence;
  if (is_led || too_early_.contains(page)) {
    if (engaged) too_early_.insert(page);
    return false;
  }
  if (!engaged && leader_ != page && leader_ != 0) return false;
  leader_ = engaged ? page : 0;
  heard_at_ = now;
  return true;
}

bool PointerControlLock::Leaves(std::uint64_t page) {
  too_early_.erase(page);
  if (leader_ != page) return false;
  leader_ = 0;
  return true;
}

}  // namespace palpate
