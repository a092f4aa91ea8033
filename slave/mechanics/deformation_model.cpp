#include "slave/mechanics/deformation_model.h"

#include "shared/validation/validation.h"
#include "slave/mechanics/valid_responses.h"

namespace palpate {

void DeformationModel::Respond(std::span<const Contact> contacts,
                               std::span<ContactResponse> responses) noexcept {
  shown_ = ++queries_;
  ComputeResponses(contacts, responses);
  Validate(std::span<const ContactResponse>(responses), "DeformationModel::Respond");
}

void DeformationModel::Solve(std::span<const Contact> contacts, Solution* solution) noexcept {
  solution->contacts_.assign(contacts.begin(), contacts.end());
  solution->responses_.resize(contacts.size());
  Respond(contacts, solution->responses_);
  solution->query_ = queries_;
  solution->at_rest_.clear();
  if (const auto at_rest = ContactsAtRest(contacts); at_rest.data() != contacts.data()) {
    solution->at_rest_.assign(at_rest.begin(), at_rest.end());
  }
  if (keeps_displacements_) ComputeDisplacements(&solution->kept_u_O_);
}

void DeformationModel::Displacements(const Solution& solution, std::vector<Eigen::Vector3d>* u_O) {
  if (keeps_displacements_ && solution.query_ != 0) {
    *u_O = solution.kept_u_O_;
  } else if (Show(solution)) {
    ComputeDisplacements(u_O);
  } else {
    u_O->assign(field_mesh_.vertices.size(), Eigen::Vector3d::Zero());
  }
}

const PlanarCover& DeformationModel::cover() {
  if (!cover_) cover_ = MakeCover();
  return *cover_;
}

void DeformationModel::CoverDisplacements(const Solution& solution,
                                          std::vector<Eigen::Vector3d>* u_O) {
  Displacements(solution, u_O);
  const std::vector<Eigen::Vector2d>& inside = cover().inside;
  if (Show(solution)) ComputeInside(inside, u_O);
  u_O->resize(field_mesh_.vertices.size() + inside.size(), Eigen::Vector3d::Zero());
}

bool DeformationModel::Show(const Solution& solution) noexcept {
  if (solution.query_ == 0) return false;
  if (solution.query_ == shown_) return true;
  const bool in_time = !solution.at_rest_.empty();
  shown_responses_.resize(solution.contacts_.size());
  ComputeAtRest(in_time ? solution.at_rest_ : solution.contacts_, shown_responses_);
  shown_ = solution.query_;
  return true;
}

}  // namespace palpate
