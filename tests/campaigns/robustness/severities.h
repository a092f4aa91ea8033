// Helps to write tables of cases: an alteration with the severities at which it is tested.
#pragma once

#include <concepts>
#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "tests/campaigns/robustness/case.h"

namespace palpate::robustness {

class CaseTable {
 public:
  // At the severities of `right` the force stays right; at those of `flagged` it may be flagged.
  // `make`: severity -> Alteration, or -> Paint.
  template <typename Make>
  void Add(const std::string& name, const std::string& unit, std::initializer_list<double> right,
           std::initializer_list<double> flagged, const Make& make) {
    for (const double& severity : right) {
      Append(name, unit, severity, Demand::kRight, make);
      cases_.back().is_quick = !rarely_ && &severity == right.end() - 1;
    }
    for (const double& severity : flagged) {
      Append(name, unit, severity, Demand::kFlag, make);
      cases_.back().is_quick = !rarely_ && &severity == flagged.begin();
    }
  }
  // Adds a case without a severity.
  void Add(const std::string& name, Demand demand, Alteration alteration) {
    cases_.push_back({name, 0, "", demand, std::move(alteration), stage_});
  }

  // Cases added from now on are for this stage only. Empty: for all stages except special ones.
  void Only(const std::string& stage) { stage_ = stage; }
  // true: cases with a severity that are added from now on are left out of `--quick`.
  void Rarely(bool rarely) { rarely_ = rarely; }

  [[nodiscard]] std::vector<Case> Take() { return std::move(cases_); }

 private:
  template <typename Make>
  void Append(const std::string& name, const std::string& unit, double severity, Demand demand,
              const Make& make) {
    Alteration alteration;
    if constexpr (std::convertible_to<decltype(make(severity)), Paint>) {
      alteration.paint = make(severity);
    } else {
      alteration = make(severity);
    }
    cases_.push_back({name, severity, unit, demand, std::move(alteration), stage_});
  }

  std::string stage_;
  bool rarely_ = false;
  std::vector<Case> cases_;
};

// Alterations of one kind.
inline Alteration Shows(std::function<std::size_t(const Moment&)> shows) {
  Alteration alteration;
  alteration.shows = std::move(shows);
  return alteration;
}
inline Alteration AlterScene(std::function<void(Scene&)> tell) {
  Alteration alteration;
  alteration.tell = std::move(tell);
  return alteration;
}

// Adds the cases of damage_cases.cpp.
void AddCameraDamage(CaseTable* table);
void AddPairDamage(CaseTable* table);

}  // namespace palpate::robustness
