#include "slave/mechanics/relaxation/relaxing_model.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "shared/mesh/solid_mesh.h"

namespace palpate {
namespace {

// Largest sliding distance of a contact without a width within a step, relative to the larger side
// of the body [-]. [by definition]
constexpr double kNearby = 0.05;

Wrench WrenchOf(const ContactResponse& response) {
  Wrench wrench = Wrench::Zero();
  wrench.head<3>() = response.force_O;
  if (response.moment_O) wrench.tail<3>() = *response.moment_O;
  return wrench;
}

}  // namespace

RelaxingModel::RelaxingModel(std::unique_ptr<DeformationModel> elastic,
                             std::span<const RelaxationTerm> terms, double step)
    : elastic_(std::move(elastic)),
      series_(terms, step),
      nearby_(kNearby * LargerSide(elastic_->field_mesh().vertices)) {
  field_mesh_ = elastic_->field_mesh();
  info_ = elastic_->info();
  info_.step = step;
}

void RelaxingModel::Reset() {
  elastic_->Reset();
  histories_.clear();
}

void RelaxingModel::Start(std::span<const Contact> contacts) {
  std::vector<ContactResponse> responses(contacts.size());
  elastic_->Respond(contacts, responses);
  histories_.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactResponse& response = responses[i];
    histories_.push_back({contacts[i], {}});
    if (response.validity == Validity::kFailed) continue;
    series_.Jump(WrenchOf(response), &histories_.back().memory);
  }
}

// Returns the history of the same contact, else of the nearest one from which it may have slid;
// nullptr: the contact is new.
RelaxingModel::History* RelaxingModel::Earlier(const Contact& contact, std::size_t number) {
  if (number < known_.size() && !known_[number].taken && known_[number].contact.IsAt(contact)) {
    return &known_[number];
  }
  History* nearest = nullptr;
  double distance = contact.width > 0 ? contact.width : nearby_;
  for (History& history : known_) {
    if (history.taken || history.contact.kind != contact.kind) continue;
    const double apart = (history.contact.p_O - contact.p_O).norm();
    if (apart > distance) continue;
    distance = apart;
    nearest = &history;
  }
  return nearest;
}

// Allocates only when the set of contacts is larger than ever before.
void RelaxingModel::Remember(std::span<const Contact> contacts) {
  const auto is_same = [](const History& history, const Contact& contact) {
    return history.contact.IsAt(contact);
  };
  if (std::ranges::equal(histories_, contacts, is_same)) return;
  std::swap(known_, histories_);
  for (History& history : known_) history.taken = false;
  histories_.clear();
  for (const Contact& contact : contacts) {
    History* earlier = Earlier(contact, histories_.size());
    histories_.push_back({contact, earlier != nullptr ? earlier->memory : RelaxationMemory()});
    if (earlier != nullptr) earlier->taken = true;
  }
}

void RelaxingModel::ComputeResponses(std::span<const Contact> contacts,
                                     std::span<ContactResponse> responses) noexcept {
  try {
    Remember(contacts);
    at_rest_.assign(contacts.begin(), contacts.end());
  } catch (const std::exception&) {  // out of memory
    Forget(responses);
    return;
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].kind != Contact::Kind::kForce) continue;
    Wrench force = Wrench::Zero();
    force.head<3>() = contacts[i].prescribed_O;
    at_rest_[i].prescribed_O = series_.ElasticFor(force, histories_[i].memory).head<3>();
  }
  elastic_->Respond(at_rest_, responses);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ContactResponse& response = responses[i];
    if (response.validity == Validity::kFailed) return Forget(responses);
    RelaxationMemory* memory = &histories_[i].memory;
    if (response.moment_O) {
      const Wrench wrench = series_.Advance(WrenchOf(response), memory);
      response.force_O = wrench.head<3>();
      *response.moment_O = wrench.tail<3>();
    } else {
      response.force_O = series_.Advance(response.force_O, memory);
    }
    if (contacts[i].kind == Contact::Kind::kForce) response.force_O = contacts[i].prescribed_O;
    response.stiffness_O *= series_.at_once();
  }
}

void RelaxingModel::Forget(std::span<ContactResponse> responses) noexcept {
  histories_.clear();
  std::ranges::fill(responses, ContactResponse{});
}

void RelaxingModel::ComputeAtRest(std::span<const Contact> contacts,
                                  std::span<ContactResponse> /*responses*/) noexcept {
  try {
    at_rest_.assign(contacts.begin(), contacts.end());
  } catch (const std::exception&) {  // out of memory
    at_rest_.clear();
  }
}

void RelaxingModel::ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) {
  Solution solution;
  elastic_->Solve(at_rest_, &solution);
  elastic_->Displacements(solution, u_O);
}

void RelaxingModel::ComputeInside(const std::vector<Eigen::Vector2d>& places,
                                  std::vector<Eigen::Vector3d>* u_O) {
  Solution solution;
  elastic_->Solve(at_rest_, &solution);
  std::vector<Eigen::Vector3d> all;
  elastic_->CoverDisplacements(solution, &all);
  u_O->insert(u_O->end(), all.end() - std::ssize(places), all.end());
}

}  // namespace palpate
