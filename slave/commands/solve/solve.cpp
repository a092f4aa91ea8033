#include "slave/commands/solve/solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"
#include "slave/commands/solve/field_file.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/solve/case_solver.h"
#include "slave/solve/write_rows.h"

namespace palpate {
namespace {

constexpr int kDone = 0, kFailed = 1, kUnusable = 2;

// Cases in the order of their first rows.
std::vector<Case> GroupByCase(const std::vector<SolveRow>& rows, bool independent) {
  std::vector<Case> cases;
  for (std::size_t i = 0; independent && i < rows.size(); ++i) cases.push_back({i});
  if (independent) return cases;
  std::map<std::string, std::size_t> known;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto [found, is_new] = known.try_emplace(rows[i].case_name, cases.size());
    if (is_new) cases.emplace_back();
    cases[found->second].push_back(i);
  }
  return cases;
}

// Requires that the rows of a case follow one another in their file: a path visits a case once.
void RequireInOrder(const std::vector<SolveRow>& rows) {
  for (const auto kind : {Contact::Kind::kDisplacement, Contact::Kind::kForce}) {
    std::set<std::string_view> visited;
    std::string_view last;
    for (const SolveRow& row : rows) {
      if (row.contact.kind != kind || row.case_name == last) continue;
      last = row.case_name;
      if (visited.insert(last).second) continue;
      throw InputError("--path: case " + row.case_name +
                       " has rows before and after other cases: expected a new case for each step");
    }
  }
}

// Reports rows that act together: a scan with one case name for all rows would be a press at all
// positions at once.
void ReportTogether(const std::vector<SolveRow>& rows, const std::vector<Case>& cases) {
  const auto several = std::ranges::find_if(cases, [](const Case& one) { return one.size() > 1; });
  if (several == cases.end()) return;
  std::fprintf(stderr,
               "solve: the rows of a case act together, such as the %zu of case %s; --independent "
               "computes each row alone\n",
               several->size(), rows[several->front()].case_name.c_str());
}

// Solves one row per step and place, from rest at t = 0 to the last row's time. False: a step
// failed, and later ones were not solved.
bool SolveInTime(const Case& one, const std::vector<SolveRow>& rows, DeformationModel* model,
                 ProgressBar* progress, std::vector<SolveRow>* answers, Solution* solution) {
  constexpr double kRounding = 1e-9;  // tolerance relative to a time step
  const std::vector<PlaceHistory> histories = HistoriesOf(rows, one);
  const double step = model->info().step;
  double end = 0;
  for (const auto& history : histories) end = std::max(end, history.end());
  constexpr double kMaxRows = 1e7;
  if (end / step * static_cast<double>(histories.size()) > kMaxRows) {
    throw std::invalid_argument("case " + rows[one.front()].case_name +
                                ": a history of more than ten million rows: expected a shorter "
                                "one, or longer steps");
  }
  const auto steps = static_cast<long>(std::floor(end / step + kRounding));
  if (steps < 1) {
    throw std::invalid_argument(
        "case " + rows[one.front()].case_name +
        ": the history ends before the first time step: expected rows up to t = " +
        std::to_string(step) + " s or later");
  }
  const auto contacts_at = [&](double t) {
    std::vector<Contact> contacts;
    for (const auto& history : histories) contacts.push_back(history.At(t));
    return contacts;
  };
  if (end > (static_cast<double>(steps) + kRounding) * step) {
    progress->Clear();
    std::fprintf(stderr,
                 "solve: case %s: the history ends at %.6g s, between steps; the last step ends at "
                 "%.6g s\n",
                 rows[one.front()].case_name.c_str(), end, static_cast<double>(steps) * step);
  }
  model->Reset();
  model->Start(contacts_at(0));
  for (long k = 1; k <= steps; ++k) {
    const double t = static_cast<double>(k) * step;
    const std::vector<Contact> contacts = contacts_at(t);
    double solve_us = 0;
    const bool solved = SolveTogether(contacts, model, solution, &solve_us);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      answers->push_back(
          {rows[one.front()].case_name, contacts[i], t, solution->responses()[i], solve_us});
    }
    if (!solved) return false;
    if (!progress->Report("time steps", static_cast<double>(k) / static_cast<double>(steps))) {
      throw Interrupted();
    }
  }
  return true;
}

struct Built {
  std::unique_ptr<DeformationModel> model;
  std::unique_ptr<FieldFile> field;  // nullptr: not requested
};

// `field`: the field's file, empty: none.
Built Build(const Scene& scene, const ObjectMesh& mesh, const std::filesystem::path& field,
            ProgressBar* progress) {
  Built built;
  built.model = MakeModel(scene, mesh, progress);
  if (!field.empty()) built.field = std::make_unique<FieldFile>(field, *built.model);
  return built;
}

void PrintRemark(const std::string& remark) {
  if (!remark.empty()) std::fprintf(stderr, "solve: %s\n", remark.c_str());
}

void PrintModelInfo(const ModelInfo& info) {
  std::fprintf(stderr,
               "solve: %s, %zu degrees of freedom, precomputed in %.3g s, %.3g MB of memory",
               info.kind.c_str(), info.dof, info.precompute_s,
               1e-6 * static_cast<double>(info.memory_bytes));
  if (info.condition > 0) std::fprintf(stderr, ", condition number %.3g", info.condition);
  if (info.update_us > 0) std::fprintf(stderr, ", about %.3g us per update", info.update_us);
  if (!info.remark.empty()) std::fprintf(stderr, "; %s", info.remark.c_str());
  std::fputc('\n', stderr);
}

std::vector<SolveRow> ReadRows(const SolveOptions& options, const ObjectMesh& mesh,
                               const RowRules& rules) {
  std::vector<SolveRow> rows;
  if (!options.contacts.empty()) {
    AppendRows(options.contacts, Contact::Kind::kDisplacement, mesh, rules, &rows);
  }
  if (!options.loads.empty()) {
    AppendRows(options.loads, Contact::Kind::kForce, mesh, rules, &rows);
  }
  if (rules.dynamic &&
      std::ranges::none_of(rows, [](const SolveRow& row) { return row.t.has_value(); })) {
    throw InputError(
        "solve: no column t: with model.time = dynamic or material.relaxation, expected a "
        "history");
  }
  return rows;
}

int Solve(const SolveOptions& options, const std::stop_token& stop) {
  const Scene scene = LoadRunningScene(options.scene, options.overrides, SceneUse::kSolve);
  if (options.contacts.empty() && options.loads.empty()) {
    throw InputError("solve: no input: expected --contacts, --loads or both");
  }
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const bool dynamic = MovesInTime(scene);
  if (dynamic && options.follows_path) {
    throw InputError("--path: expected a static model; the column t is the path of others");
  }
  const RowRules rules = RulesOf(scene);
  std::vector<SolveRow> rows = ReadRows(options, mesh, rules);
  const std::vector<Case> cases = GroupByCase(rows, options.independent);
  if (dynamic && options.independent) {
    throw InputError("--independent: only with a static model, whose rows are no history");
  }
  if (options.follows_path) RequireInOrder(rows);
  if (!options.independent && !rules.shaped) RequireAlone(rows);
  if (dynamic && !rules.shaped && std::ranges::any_of(rows, IsPressedRound)) {
    throw InputError("solve: tool.shape = round: expected flat with a model that moves in time");
  }
  if (!dynamic) ReportTogether(rows, cases);
  std::vector<std::filesystem::path> inputs = InputFilesOf(scene);
  inputs.insert(inputs.end(), {options.contacts, options.loads});
  RequireOtherThan("--out", options.out, inputs);
  RequireOtherThan("--field", options.field, inputs);
  RequireWritable(options.out);
  RequireWritable(options.field);

  ProgressBar progress("solve", stop);
  const auto [model, field] = Build(scene, mesh, options.field, &progress);
  progress.Clear();
  CaseSolver solver(scene, mesh, model.get());
  std::vector<SolveRow> answers;
  Solution solution;
  bool all_solved = true;
  try {
    for (const Case& one : cases) {
      const std::string& name = rows[one.front()].case_name;
      const CaseStart start =
          options.follows_path && &one != &cases.front() ? CaseStart::kLastCase : CaseStart::kRest;
      const bool solved = dynamic
                              ? SolveInTime(one, rows, model.get(), &progress, &answers, &solution)
                              : solver.Solve(one, start, &rows, &solution);
      if (!solved) {
        all_solved = false;
        progress.Clear();
        std::fprintf(stderr, "solve: case %s failed: %s\n", name.c_str(),
                     std::string(dynamic ? model->failure() : solver.failure()).c_str());
      } else if (field) {
        field->AddCase(name, solution);
      }
      if (stop.stop_requested()) throw Interrupted();
    }
  } catch (const Interrupted&) {
    all_solved = false;
    progress.Clear();
    std::fprintf(stderr, "solve: interrupted; the rows solved so far are written\n");
  }
  progress.Clear();
  PrintModelInfo(model->info());
  PrintRemark(WidthRemark(scene, rows));
  PrintRemark(PlaceRemark(mesh, rows));
  for (const std::string& remark : FlagRemarks(dynamic ? answers : rows)) PrintRemark(remark);
  const bool written = WriteRows(options.out, dynamic ? answers : rows, options.moments) &&
                       (!field || field->Write());
  if (!written) std::fprintf(stderr, "solve: writing failed\n");
  return all_solved && written ? kDone : kFailed;
}

}  // namespace

int RunSolve(const SolveOptions& options, const std::stop_token& stop) noexcept {
  try {
    return Solve(options, stop);
  } catch (const SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "%s: %s\n", options.scene.c_str(), error.what());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "solve: %s\n", error.what());
    return kFailed;
  }
  return kUnusable;
}

}  // namespace palpate
