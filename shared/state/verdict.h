// Result of the checks of one sample: how far the numbers can be used, and why.
#pragma once

#include <string_view>

#include "shared/state/failed_check.h"
#include "shared/state/validity.h"

namespace palpate {

// `check` and `reason` explain `validity`. By default nothing is known.
struct Verdict {
  constexpr Verdict() = default;
  constexpr Verdict(Validity how, FailedCheck failed = FailedCheck::kNone,
                    std::string_view why = {})
      : validity(how), check(failed), reason(why) {}

  Validity validity = Validity::kFailed;
  FailedCheck check = FailedCheck::kNone;
  std::string_view reason;  // one clause with static lifetime; empty: none

  // Adds another result. The worse validity decides; of equal ones the check with the higher Rank,
  // of equal ranks the first.
  constexpr void Add(const Verdict& other) noexcept {
    const bool decides =
        other.validity != validity ? other.validity > validity : Rank(other.check) > Rank(check);
    if (decides) Set(other);
  }
  // A check failed. Numbers stay.
  constexpr void Fail(FailedCheck failed, std::string_view why = {}) noexcept {
    Add({Validity::kExtrapolated, failed, why});
  }
  constexpr void Set(const Verdict& other) noexcept {
    validity = other.validity;
    check = other.check;
    reason = other.reason;
  }
};

}  // namespace palpate
