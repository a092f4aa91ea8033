// log.csv: one row per tick, readable up to the last flush whatever happens.
//
//   t,state,p_M_*,p_S_*,estimated_*,local_*,scaled_*,passive_*,limited_*,sent_*,true_*,age_s,reason
//
// `*` stands for _x, _y, _z. SI; what is unknown is empty; `reason` is joined by `+`. About 0.2 MB
// per second.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "master/haptics/record/tick_record.h"

namespace palpate {

class TickLog {
 public:
  // Begins the file anew. Throws std::runtime_error: it cannot be written.
  explicit TickLog(const std::filesystem::path& file);
  // `t` [s] since the run began.
  void Add(double t, const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // Whole rows reach the file.
  void Flush();
  // Empty, or why rows are missing.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  std::filesystem::path file_;
  std::ofstream out_;
  std::string rows_;  // not yet flushed
  std::string trouble_;
};

}  // namespace palpate
