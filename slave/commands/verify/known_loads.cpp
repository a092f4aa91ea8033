#include "slave/commands/verify/known_loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kMaxValue = 1e12;
constexpr double kMaxGap = 1;         // largest gap between rows of a record [s]
constexpr double kUsualSigma = 0.01;  // default relative sigma of a known force

// NaN: an empty cell or an absent column.
double NumberOf(const CsvTable& table, std::string_view name) {
  return table.IsAbsent(name) ? kUnknown : table.Number(*table.Find(name), kMaxValue);
}

std::string TextOf(const CsvTable& table, std::string_view name) {
  return table.IsAbsent(name) ? std::string() : table.Text(name);
}

Vector3d VectorOf(const CsvTable& table, const std::array<std::string_view, 3>& names) {
  return {NumberOf(table, names[0]), NumberOf(table, names[1]), NumberOf(table, names[2])};
}

void RequireColumns(const CsvTable& table, std::initializer_list<std::string_view> names) {
  for (const auto name : names) {
    if (!table.Has(name)) table.Fail("no column " + std::string(name), 1);
  }
}

double TimeOf(const CsvTable& table) {
  const double t = NumberOf(table, "t");
  if (!std::isfinite(t)) table.Fail("t is empty: expected a time in seconds");
  return t;
}

// Returns the force of a record at `t`. `loads`: sorted by time.
std::optional<KnownLoad> RecordAt(const std::vector<KnownLoad>& loads, double t) {
  const auto after = std::ranges::lower_bound(loads, t, {}, &KnownLoad::from);
  if (after == loads.end()) return std::nullopt;
  if (after->from == t) return *after;
  if (after == loads.begin()) return std::nullopt;
  const KnownLoad &a = *std::prev(after), &b = *after;
  if (b.from - a.from > kMaxGap) return std::nullopt;
  const double share = (t - a.from) / (b.from - a.from);
  KnownLoad between = a;
  between.force += share * (b.force - a.force);
  between.p_S_tip += share * (b.p_S_tip - a.p_S_tip);
  between.depth += share * (b.depth - a.depth);
  return between;
}

}  // namespace

ForceTables ReadStates(const std::filesystem::path& file) {
  CsvTable table(file);
  ForceTables states;
  while (table.Next()) {
    if (states.empty()) RequireColumns(table, {"t", "fx", "fy", "fz", "sigma", "validity"});
    ForceRow state;
    state.t = TimeOf(table);
    state.measured = VectorOf(table, {"true_fx", "true_fy", "true_fz"});
    state.estimated = VectorOf(table, {"fx", "fy", "fz"});
    state.sigma = NumberOf(table, "sigma");
    state.is_valid = TextOf(table, "validity") == "valid";
    state.p_estimated = VectorOf(table, {"tip_x", "tip_y", "tip_z"});
    const Vector3d contact = VectorOf(table, {"contact_x", "contact_y", "contact_z"});
    if (state.estimated.norm() > 0) state.depth = (state.p_estimated - contact).norm();
    states[TextOf(table, "finger")].push_back(state);
  }
  return states;
}

LoadTable ReadLoads(const std::filesystem::path& file) {
  CsvTable table(file);
  LoadTable read;
  read.is_record = !table.Has("until");
  while (table.Next()) {
    if (read.loads.empty()) RequireColumns(table, {"t"});
    KnownLoad load{.from = TimeOf(table),
                   .until = NumberOf(table, "until"),
                   .finger = TextOf(table, "finger"),
                   .force = VectorOf(table, {"fx", "fy", "fz"}),
                   .sigma = NumberOf(table, "sigma"),
                   .p_S_tip = VectorOf(table, {"x", "y", "z"}),
                   .depth = NumberOf(table, "depth")};
    if (!read.is_record && !(load.until > load.from)) {
      table.Fail("until: expected a time after t");
    }
    if (load.sigma < 0) table.Fail("sigma: expected 0 or more");
    read.loads.push_back(std::move(load));
  }
  if (read.loads.empty()) {
    throw InputError(file.string() + ": no load: expected one row or more");
  }
  if (read.is_record) std::ranges::stable_sort(read.loads, {}, &KnownLoad::from);
  return read;
}

ForceRow WithLoad(ForceRow state, const KnownLoad& load, int hold) {
  state.hold = hold;
  state.measured = load.force;
  const double size =
      load.force.unaryExpr([](double x) { return std::isfinite(x) ? x : 0; }).norm();
  state.sigma =
      std::hypot(state.sigma, std::isfinite(load.sigma) ? load.sigma : kUsualSigma * size);
  state.p_known = load.p_S_tip;
  state.known_depth = load.depth;
  return state;
}

ForceTables WithLoads(const ForceTables& states, const LoadTable& table) {
  ForceTables rows;
  for (const auto& [finger, of_finger] : states) {
    std::vector<KnownLoad> loads;
    std::ranges::copy_if(table.loads, std::back_inserter(loads), [&](const KnownLoad& load) {
      return load.finger == finger || (load.finger.empty() && finger == states.begin()->first);
    });
    for (const ForceRow& state : of_finger) {
      if (table.is_record) {
        const auto load = RecordAt(loads, state.t);
        if (load) rows[finger].push_back(WithLoad(state, *load, -1));
        continue;
      }
      const auto held = std::ranges::find_if(loads, [&](const KnownLoad& load) {
        return load.from <= state.t && state.t <= load.until;
      });
      const auto number = static_cast<int>(held - loads.begin());
      if (held != loads.end()) rows[finger].push_back(WithLoad(state, *held, number));
    }
  }
  if (rows.empty()) {
    throw std::invalid_argument(
        "--loads: expected loads at times, and on fingers, of the states: none matches");
  }
  return rows;
}

ForceTables WithSensor(const ForceTables& states) {
  ForceTables rows;
  for (const auto& [finger, of_finger] : states) {
    for (const ForceRow& state : of_finger) {
      if (!state.measured.allFinite()) continue;
      rows[finger].push_back(WithLoad(state, {.force = state.measured}, -1));
    }
  }
  if (rows.empty()) {
    throw std::invalid_argument(
        "--sensor: expected states with the force of a sensor (ArmReport.measured_force) or "
        "of a simulator: these have none");
  }
  return rows;
}

}  // namespace palpate
