#include "slave/mechanics/relaxation/prony_series.h"

#include <stdexcept>
#include <string>

#include "shared/text/text.h"

namespace palpate {

PronySeries::PronySeries(std::span<const RelaxationTerm> terms, double step)
    : terms_(terms.begin(), terms.end()) {
  RequirePositive("step", step);
  if (terms.size() > Material::kMaxRelaxationTerms) {
    throw std::invalid_argument("relaxation = " + std::to_string(terms.size()) +
                                " terms: expected at most " +
                                std::to_string(Material::kMaxRelaxationTerms));
  }
  for (const RelaxationTerm& term : terms_) {
    RequirePositive("relaxation.share", term.share);
    RequirePositive("relaxation.time", term.time);
    const PronyStep one(step, term.time);
    steps_.push_back({one.fade, term.share * one.rise});
    left_ -= term.share;
    at_once_ -= term.share * (1 - one.rise);
  }
  RequirePositive("1 - sum of relaxation.share", left_);
}

Wrench PronySeries::Kept(const RelaxationMemory& memory) const {
  Wrench kept = left_ * memory.elastic;
  for (std::size_t i = 0; i < terms_.size(); ++i) kept += steps_[i].fade * memory.terms[i];
  return kept;
}

template <int kRows>
void PronySeries::AdvanceRows(const Wrench& elastic, RelaxationMemory* memory,
                              Wrench* force) const {
  using Rows = Eigen::Matrix<double, kRows, 1>;
  const Rows now = elastic.template head<kRows>();
  const Rows added = now - memory->elastic.template head<kRows>();
  Rows sum = left_ * now;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Rows kept =
        steps_[i].fade * memory->terms[i].template head<kRows>() + steps_[i].taken * added;
    memory->terms[i].template head<kRows>() = kept;
    sum += kept;
  }
  memory->elastic.template head<kRows>() = now;
  force->template head<kRows>() = sum;
}

Wrench PronySeries::Advance(const Wrench& elastic, RelaxationMemory* memory) const {
  Wrench force = Wrench::Zero();
  AdvanceRows<6>(elastic, memory, &force);
  return force;
}

Eigen::Vector3d PronySeries::Advance(const Eigen::Vector3d& elastic,
                                     RelaxationMemory* memory) const {
  Wrench wrench = Wrench::Zero(), force = Wrench::Zero();
  wrench.head<3>() = elastic;
  AdvanceRows<3>(wrench, memory, &force);
  return force.head<3>();
}

Wrench PronySeries::Jump(const Wrench& elastic, RelaxationMemory* memory) const {
  const Wrench added = elastic - memory->elastic;
  Wrench force = left_ * elastic;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    memory->terms[i] += terms_[i].share * added;
    force += memory->terms[i];
  }
  memory->elastic = elastic;
  return force;
}

Wrench PronySeries::ElasticFor(const Wrench& force, const RelaxationMemory& memory) const {
  return memory.elastic + (force - Kept(memory)) / at_once_;
}

}  // namespace palpate
