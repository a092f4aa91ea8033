#include "master/haptics/record/tick_log.h"

#include <stdexcept>

#include "shared/text/csv.h"

namespace palpate {
namespace {

constexpr int kDigits = 7;

void AppendVector(std::string* row, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) {
    row->push_back(',');
    AppendNumber(row, v[i], kDigits);
  }
}

void AppendVectorOrNothing(std::string* row, bool known, const Eigen::Vector3d& v) {
  if (known) {
    AppendVector(row, v);
  } else {
    row->append(",,,");
  }
}

}  // namespace

TickLog::TickLog(const std::filesystem::path& file) : file_(file), out_(file, std::ios::trunc) {
  rows_ = "t,state";
  for (const char* name :
       {"p_M", "p_S", "estimated", "local", "scaled", "passive", "limited", "sent", "true"}) {
    for (const char* axis : {"_x", "_y", "_z"}) rows_.append(",").append(name).append(axis);
  }
  rows_.append(",age_s,reason\n");
  Flush();
  if (!trouble_.empty()) throw std::runtime_error(trouble_);
}

void TickLog::Add(double t, const TickRecord& record, const std::optional<Eigen::Vector3d>& truth) {
  const ForceChain& chain = record.chain;
  AppendNumber(&rows_, t, kDigits + 2);
  rows_.append(",").append(ToString(record.state));
  AppendVector(&rows_, record.p_M);
  AppendVector(&rows_, record.p_S);
  AppendVectorOrNothing(&rows_, chain.force_known, chain.estimated);
  for (const auto* force :
       {&chain.local, &chain.scaled, &chain.passive, &chain.limited, &chain.sent}) {
    AppendVector(&rows_, *force);
  }
  AppendVectorOrNothing(&rows_, truth.has_value(), truth.value_or(Eigen::Vector3d::Zero()));
  rows_.push_back(',');
  if (record.state_age >= 0) AppendNumber(&rows_, record.state_age, kDigits);
  rows_.append(",").append(ToString(chain.reasons)).append("\n");
}

void TickLog::Flush() {
  if (trouble_.empty()) {
    out_ << rows_;
    out_.flush();
    if (!out_) trouble_ = file_.string() + ": cannot be written";
  }
  rows_.clear();
}

}  // namespace palpate
