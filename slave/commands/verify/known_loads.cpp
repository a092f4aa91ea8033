#include "slave/commands/verify/known_loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kLargest = 1e12;
constexpr double kLongestGap = 1;       // between rows of a record [s]
constexpr std::size_t kStretches = 20;  // of a record, for one finger
constexpr double kLoadedShare = 0.05;   // of the largest known force

// `absent`: of an empty cell or an absent column.
double NumberOr(const CsvTable& table, std::string_view name, double absent = kUnknown) {
  return table.IsAbsent(name) ? absent : table.Number(*table.Find(name), kLargest);
}

std::string TextOf(const CsvTable& table, std::string_view name) {
  return table.IsAbsent(name) ? std::string() : table.Text(name);
}

Vector3d VectorOf(const CsvTable& table, const std::array<std::string_view, 3>& names) {
  return {NumberOr(table, names[0]), NumberOr(table, names[1]), NumberOr(table, names[2])};
}

void RequireColumns(const CsvTable& table, std::initializer_list<std::string_view> names) {
  for (const auto name : names) {
    if (!table.Has(name)) table.Fail("no column " + std::string(name), 1);
  }
}

void Append(std::string* text, double value) {
  AppendNumber(text, value, 9);
  *text += ',';
}

void Append(std::string* text, const Vector3d& values) {
  for (const double value : values) Append(text, value);
}

KnownLoad Between(const KnownLoad& a, const KnownLoad& b, double t) {
  const double share = b.from > a.from ? (t - a.from) / (b.from - a.from) : 0;
  KnownLoad between = a;
  between.force += share * (b.force - a.force);
  between.p_S_tip += share * (b.p_S_tip - a.p_S_tip);
  between.depth += share * (b.depth - a.depth);
  return between;
}

// Numbers the stretches of a record: the states under load, and apart from them those without.
void CutIntoStretches(std::vector<MatchedState>* matched) {
  double largest = 0;
  for (const auto& one : *matched) largest = std::fmax(largest, one.known.force.norm());
  const auto is_loaded = [&](const MatchedState& one) {
    return !(one.known.force.norm() < kLoadedShare * largest);
  };
  const auto loaded = static_cast<std::size_t>(std::ranges::count_if(*matched, is_loaded));
  const std::array all{matched->size() - loaded, loaded};
  std::array<std::size_t, 2> seen{0, 0};
  for (auto& one : *matched) {
    const std::size_t kind = is_loaded(one) ? 1 : 0;
    one.load = static_cast<int>(kStretches * (kind + 1) + kStretches * seen[kind] / all[kind]);
    ++seen[kind];
  }
}

// The finger that a load of `finger` acts on, among those of the states.
bool IsOn(const ReportedState& state, const std::string& finger, const std::string& first) {
  return state.finger == (finger.empty() ? first : finger);
}

}  // namespace

std::vector<ReportedState> ReadStates(const std::filesystem::path& file) {
  CsvTable table(file);
  std::vector<ReportedState> states;
  while (table.Next()) {
    if (states.empty()) RequireColumns(table, {"t", "fx", "fy", "fz", "sigma", "validity"});
    ReportedState state{.t = NumberOr(table, "t"),
                        .finger = TextOf(table, "finger"),
                        .p_S_tip = VectorOf(table, {"tip_x", "tip_y", "tip_z"}),
                        .force = VectorOf(table, {"fx", "fy", "fz"}),
                        .sigma = NumberOr(table, "sigma", 0),
                        .is_valid = TextOf(table, "validity") == "valid",
                        .validity = TextOf(table, "validity"),
                        .measured = VectorOf(table, {"true_fx", "true_fy", "true_fz"})};
    const Vector3d contact = VectorOf(table, {"contact_x", "contact_y", "contact_z"});
    state.depth = table.Has("depth")       ? NumberOr(table, "depth")
                  : state.force.norm() > 0 ? (state.p_S_tip - contact).norm()
                                           : kUnknown;
    if (!std::isfinite(state.t)) table.Fail("t is empty: expected a time in seconds");
    states.push_back(std::move(state));
  }
  return states;
}

void WriteStates(const std::vector<ReportedState>& states, const std::filesystem::path& file) {
  std::string text =
      "t,finger,tip_x,tip_y,tip_z,fx,fy,fz,sigma,depth,true_fx,true_fy,true_fz,validity\n";
  for (const ReportedState& state : states) {
    Append(&text, state.t);
    text += state.finger + ',';
    Append(&text, state.p_S_tip);
    Append(&text, state.force);
    Append(&text, state.sigma);
    Append(&text, state.depth);
    Append(&text, state.measured);
    text += state.validity + '\n';
  }
  WriteWholeFile(file, text);
}

LoadTable ReadLoads(const std::filesystem::path& file) {
  CsvTable table(file);
  LoadTable read;
  read.is_record = !table.Has("until");
  while (table.Next()) {
    if (read.loads.empty()) RequireColumns(table, {"t"});
    const double from = NumberOr(table, "t");
    KnownLoad load{.from = from,
                   .until = NumberOr(table, "until", from),
                   .finger = TextOf(table, "finger"),
                   .force = VectorOf(table, {"fx", "fy", "fz"}),
                   .sigma = NumberOr(table, "sigma"),
                   .p_S_tip = VectorOf(table, {"x", "y", "z"}),
                   .depth = NumberOr(table, "depth")};
    if (!std::isfinite(from)) table.Fail("t is empty: expected a time in seconds");
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

void WriteLoads(const std::vector<KnownLoad>& loads, const std::filesystem::path& file) {
  std::string text = "t,until,fx,fy,fz,sigma,x,y,z,depth,finger\n";
  for (const KnownLoad& load : loads) {
    Append(&text, load.from);
    Append(&text, load.until);
    Append(&text, load.force);
    Append(&text, load.sigma);
    Append(&text, load.p_S_tip);
    Append(&text, load.depth);
    text += load.finger + '\n';
  }
  WriteWholeFile(file, text);
}

MatchedStates Match(const std::vector<ReportedState>& states, const LoadTable& table) {
  MatchedStates matched;
  const std::string first = states.empty() ? "" : states.front().finger;
  const auto& loads = table.loads;
  for (const ReportedState& state : states) {
    const KnownLoad* before = nullptr;  // the row of a record
    for (std::size_t i = 0; i < loads.size(); ++i) {
      const KnownLoad& load = loads[i];
      if (!IsOn(state, load.finger, first)) continue;
      if (!table.is_record && load.from <= state.t && state.t <= load.until) {
        matched[state.finger].push_back({state, load, static_cast<int>(i)});
        break;
      }
      if (!table.is_record) continue;
      if (load.from < state.t) {
        before = &load;
        continue;
      }
      if (load.from == state.t) {
        matched[state.finger].push_back({state, load, 0});
      } else if (before != nullptr && load.from - before->from <= kLongestGap) {
        matched[state.finger].push_back({state, Between(*before, load, state.t), 0});
      }
      break;
    }
  }
  if (matched.empty()) {
    throw std::invalid_argument(
        "--loads: expected loads at times, and on fingers, of the states: none matches");
  }
  if (table.is_record) {
    for (auto& [finger, of_finger] : matched) CutIntoStretches(&of_finger);
  }
  return matched;
}

MatchedStates MatchSensor(const std::vector<ReportedState>& states) {
  MatchedStates matched;
  for (const ReportedState& state : states) {
    if (!state.measured.allFinite()) continue;
    matched[state.finger].push_back({state, {.force = state.measured}, 0});
  }
  if (matched.empty()) {
    throw std::invalid_argument(
        "--sensor: expected states with the force of a sensor (ArmReport.measured_force) or "
        "of a simulator: these have none");
  }
  for (auto& [finger, of_finger] : matched) CutIntoStretches(&of_finger);
  return matched;
}

}  // namespace palpate
