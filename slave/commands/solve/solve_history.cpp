#include "slave/commands/solve/solve_history.h"

#include <algorithm>

namespace palpate {

PlaceHistory::PlaceHistory(const SolveRow& first) : contact_(first.contact) {
  Add(first);
}

bool PlaceHistory::Takes(const SolveRow& row) const {
  return row.contact.kind == contact_.kind && row.contact.p_O == contact_.p_O &&
         row.contact.width == contact_.width;
}

void PlaceHistory::Add(const SolveRow& row) {
  const double t = row.t.value_or(0);
  const auto later =
      std::ranges::upper_bound(values_, t, {}, [](const auto& v) { return v.first; });
  values_.emplace(later, t, row.contact.prescribed_O);
}

Contact PlaceHistory::At(double t) const {
  Contact contact = contact_;
  const auto after =
      std::ranges::upper_bound(values_, t, {}, [](const auto& v) { return v.first; });
  if (after == values_.begin()) {
    contact.prescribed_O = values_.front().second;
  } else if (after == values_.end()) {
    contact.prescribed_O = values_.back().second;
  } else {
    const auto& [t0, v0] = *std::prev(after);
    const auto& [t1, v1] = *after;
    contact.prescribed_O = v0 + (t - t0) / (t1 - t0) * (v1 - v0);
  }
  return contact;
}

std::vector<PlaceHistory> HistoriesOf(const std::vector<SolveRow>& rows,
                                      std::span<const std::size_t> of_case) {
  std::vector<PlaceHistory> histories;
  for (const std::size_t i : of_case) {
    const auto place =
        std::ranges::find_if(histories, [&](const PlaceHistory& h) { return h.Takes(rows[i]); });
    if (place == histories.end()) {
      histories.emplace_back(rows[i]);
    } else {
      place->Add(rows[i]);
    }
  }
  return histories;
}

}  // namespace palpate
