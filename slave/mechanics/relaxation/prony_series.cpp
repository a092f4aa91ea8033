#include "slave/mechanics/relaxation/prony_series.h"

#include <stdexcept>
#include <string>

#include "shared/text/text.h"

namespace palpate {

PronySeries::PronySeries(std::span<const RelaxationTerm> terms, double step)
    : terms_(terms.begin(), terms.end()) {
  RequirePositive("step", step);
  if (terms.size() > Material::kMostRelaxationTerms) {
    throw std::invalid_argument("relaxation = " + std::to_string(terms.size()) +
                                " terms: accepted are at most " +
                                std::to_string(Material::kMostRelaxationTerms));
  }
  for (const RelaxationTerm& term : terms_) {
    RequirePositive("relaxation.share", term.share);
    RequirePositive("relaxation.time", term.time);
    steps_.emplace_back(step, term.time);
    left_ -= term.share;
    at_once_ -= term.share * (1 - steps_.back().rise);
  }
  RequirePositive("1 - sum of relaxation.share", left_);
}

Wrench PronySeries::Kept(const RelaxationMemory& memory) const {
  Wrench kept = left_ * memory.elastic;
  for (std::size_t i = 0; i < terms_.size(); ++i) kept += steps_[i].fade * memory.terms[i];
  return kept;
}

Wrench PronySeries::Advance(const Wrench& elastic, RelaxationMemory* memory) const {
  const Wrench added = elastic - memory->elastic;
  const Wrench force = Kept(*memory) + at_once_ * added;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    memory->terms[i] = steps_[i].fade * memory->terms[i] + terms_[i].share * steps_[i].rise * added;
  }
  memory->elastic = elastic;
  return force;
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
