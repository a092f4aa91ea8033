#include "slave/commands/solve.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

#include "shared/scene/scene_loader.h"
#include "slave/commands/csv_table.h"
#include "slave/commands/field_file.h"
#include "slave/commands/solve_rows.h"
#include "slave/mechanics/make_model.h"

namespace palpate {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUnusable = 2;
constexpr int kSlowMesh = 1500;  // elements whose Green's functions take more than a second

using Case = std::vector<std::size_t>;  // rows

// Cases in the order of their first rows.
std::vector<Case> GroupByCase(const std::vector<SolveRow>& rows) {
  std::vector<Case> cases;
  std::map<std::string, std::size_t> known;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto [found, is_new] = known.try_emplace(rows[i].case_name, cases.size());
    if (is_new) cases.emplace_back();
    cases[found->second].push_back(i);
  }
  return cases;
}

// False: the case has no answer; the rows say so.
bool SolveCase(const Case& one, DeformationModel* model, std::vector<SolveRow>* rows) {
  std::vector<Contact> contacts;
  for (const std::size_t i : one) contacts.push_back((*rows)[i].contact);
  std::vector<ContactResponse> responses(contacts.size());
  const auto start = std::chrono::steady_clock::now();
  model->Respond(contacts, responses);
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
  for (std::size_t k = 0; k < one.size(); ++k) {
    (*rows)[one[k]].response = responses[k];
    (*rows)[one[k]].solve_us = spent.count();
  }
  return responses.front().validity != Validity::kFailed;
}

std::unique_ptr<DeformationModel> Build(const Scene& scene, const BoundaryMesh& mesh) {
  const bool slow = mesh.size() > kSlowMesh && isatty(STDERR_FILENO) != 0;
  if (slow) std::fprintf(stderr, "solve: Green's functions of %d elements ...\n", mesh.size());
  auto model = MakeModel(scene, mesh);
  const ModelInfo& info = model->info();
  std::fprintf(stderr, "solve: %s, %zu dof, condition %.3g, precomputed in %.3g s\n",
               info.kind.c_str(), info.dof, info.condition, info.precompute_s);
  return model;
}

// Told before anything is computed that would be lost.
void RequireWritable(const std::filesystem::path& file) {
  if (!std::ofstream(file, std::ios::app)) {
    throw InputError(file.string() + ": cannot be written");
  }
}

int Solve(const SolveOptions& options) {
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  if (options.contacts.empty() && options.loads.empty()) {
    throw InputError("solve: no input: accepted is --contacts, --loads or both");
  }
  const BoundaryMesh mesh = MeshOutline(scene, std::nullopt);
  std::vector<SolveRow> rows;
  if (!options.contacts.empty()) {
    AppendRows(options.contacts, Contact::Kind::kDisplacement, mesh, &rows);
  }
  if (!options.loads.empty()) AppendRows(options.loads, Contact::Kind::kForce, mesh, &rows);
  RequireWritable(options.out);
  if (!options.field.empty()) RequireWritable(options.field);

  const auto model = Build(scene, mesh);
  const auto* planar = dynamic_cast<const Bem2dModel*>(model.get());
  std::optional<FieldFile> field;
  if (!options.field.empty() && planar != nullptr) field.emplace(options.field, *planar);
  bool all_solved = true;
  for (const Case& one : GroupByCase(rows)) {
    const std::string& name = rows[one.front()].case_name;
    if (!SolveCase(one, model.get(), &rows)) {
      all_solved = false;
      std::fprintf(stderr, "solve: case %s failed: %s\n", name.c_str(),
                   std::string(model->failure()).c_str());
    } else if (field) {
      field->AddCase(name);
    }
  }
  const bool written = WriteRows(options.out, rows) && (!field || field->Write());
  if (!written) std::fprintf(stderr, "solve: writing failed\n");
  return all_solved && written ? kDone : kFailed;
}

}  // namespace

int RunSolve(const SolveOptions& options) noexcept {
  try {
    return Solve(options);
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
