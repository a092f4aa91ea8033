// A progress listener that requests a stop after `reports` reports.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "slave/program/progress.h"

namespace palpate {

class StopAfter final : public Progress {
 public:
  explicit StopAfter(int reports) : left_(reports) {}
  bool Report(std::string_view stage, double /*done*/) override {
    stages_.emplace_back(stage);
    return left_-- > 0;
  }
  [[nodiscard]] const std::vector<std::string>& stages() const { return stages_; }

 private:
  int left_;
  std::vector<std::string> stages_;
};

}  // namespace palpate
