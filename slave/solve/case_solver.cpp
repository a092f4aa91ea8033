#include "slave/solve/case_solver.h"

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <variant>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr std::string_view kWholeElements =
    "the elements under the tool or in a held arc change the force by more than model.tolerance: "
    "use more of them";

// Requires supports: without them a body would follow a single contact as a whole.
void RequireHeld(const Scene& scene, const Case& one, const std::vector<SolveRow>& rows) {
  const SolveRow& row = rows[one.front()];
  if (one.size() > 1 || row.contact.kind != Contact::Kind::kDisplacement) return;
  if (IsHeld(scene.object) || !scene.model.fem.gravity_O.isZero()) return;
  throw std::invalid_argument(
      "object.fixed: nothing holds the object against the contact of case " + row.case_name +
      ": expected supports, or other contacts with it");
}

bool IsSame(const Tool& a, const Tool& b) {
  return a.shape == b.shape && a.width == b.width && a.radius == b.radius && a.depth == b.depth;
}

}  // namespace

bool SolveTogether(std::span<const Contact> contacts, DeformationModel* model, Solution* solution,
                   double* solve_us) {
  const auto start = std::chrono::steady_clock::now();
  model->Solve(contacts, solution);
  *solve_us = 1e6 * SecondsSince(start);
  return solution->responses().front().validity != Validity::kFailed;
}

bool CaseSolver::Solve(const Case& one, CaseStart start, std::vector<SolveRow>* rows,
                       Solution* solution) {
  RequireHeld(scene_, one, *rows);
  if (start == CaseStart::kRest) {
    model_->Reset();
  } else if (!has_state_) {
    for (const std::size_t i : one) (*rows)[i].response = {};
    failure_ = "an earlier case of the path has no solution";
    return false;
  }
  has_state_ = SolveRows(one, rows, solution);
  failure_ = has_state_ ? std::string_view() : model_->failure();
  return has_state_;
}

bool CaseSolver::SolveRows(const Case& one, std::vector<SolveRow>* rows, Solution* solution) {
  if (SolveRow& row = (*rows)[one.front()]; IsPressedRound(row)) {
    const auto start = std::chrono::steady_clock::now();
    row.response = round_.Press(row, model_, solution);
    row.solve_us = 1e6 * SecondsSince(start);
    return row.response.validity != Validity::kFailed;
  }
  contacts_.clear();
  for (const std::size_t i : one) contacts_.push_back((*rows)[i].contact);
  double solve_us = 0;
  model_->Prefetch(contacts_);
  const bool solved = SolveTogether(contacts_, model_, solution, &solve_us);
  for (std::size_t k = 0; k < one.size(); ++k) {
    SolveRow& row = (*rows)[one[k]];
    row.response = solution->responses()[k];
    row.solve_us = solve_us;
    FitTool(one.size() == 1, &row);
  }
  return solved;
}

void CaseSolver::TakeTool(const Tool& tool) {
  if (domain_ && IsSame(domain_->tool, tool)) return;
  domain_.emplace(Domain{tool, ToolDomain(scene_, tool, mesh_), std::nullopt});
  const auto* outline = std::get_if<BoundaryMesh>(&mesh_);
  if (outline == nullptr || !KindOf(scene_).is_plane) return;
  Scene pressed = scene_;
  pressed.tool = tool;
  domain_->width.emplace(*outline, pressed);
}

// The correction is that of a single contact: several, which change each other's compliance, need
// elements that are fine enough without it.
void CaseSolver::FitTool(bool acts_alone, SolveRow* row) {
  TakeTool(row->tool);
  if (row->response.validity == Validity::kFailed) return;
  const ToolWidth::Share share = WidthShareOf(*row);
  if (acts_alone) share.Correct(&row->response);
  const double error = 2 * share.sigma + (acts_alone ? 0 : std::abs(share.factor - 1));
  domain_->where.FlagOutside(row->contact, &row->response);
  // The elements' error is independent of that of the plane.
  row->response.force_error =
      std::hypot(row->response.force_error, error * row->response.force_O.norm());
  if (row->response.validity != Validity::kValid || error <= scene_.model.tolerance) return;
  row->response.validity = Validity::kExtrapolated;
  row->response.flag_reason = kWholeElements;
}

ToolWidth::Share CaseSolver::WidthShareOf(const SolveRow& row) {
  const bool moved = row.contact.kind == Contact::Kind::kDisplacement;
  if (!domain_->width || !moved || row.contact.width == 0) return {};
  const auto& outline = std::get<BoundaryMesh>(mesh_);
  BoundaryPlace place;
  place.p_O = row.contact.p_O.head<2>();
  place.element = FindElement(outline, place.p_O);
  if (place.element < 0) return {};
  place.normal_O = outline.elements[Index(place.element)].normal();
  return domain_->width->At(place, model_);
}

}  // namespace palpate
