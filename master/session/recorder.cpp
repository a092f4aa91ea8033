#include "master/session/recorder.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "master/haptics/tick_message.h"
#include "shared/text/csv.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr int kDigits = 7;

// The vectors of a tick that are logged: the first fields of ForceTick.
constexpr int kLoggedVectors = v1::ForceTick::kSentFieldNumber;

const google::protobuf::FieldDescriptor* LoggedVector(int number) {
  return v1::ForceTick::descriptor()->FindFieldByNumber(number);
}

void AppendVector(std::string* row, const v1::Vec3f* v) {
  if (v == nullptr) {
    row->append(",,,");
    return;
  }
  for (const float number : {v->x(), v->y(), v->z()}) {
    row->push_back(',');
    AppendNumber(row, number, kDigits);
  }
}

constexpr double kMaxGap = 0.100;          // [s]
constexpr std::size_t kMaxRows = 1 << 16;  // unflushed rows [bytes]

}  // namespace

TickLog::TickLog(const std::filesystem::path& file) : file_(file), out_(file, std::ios::trunc) {
  rows_ = "t,state";
  const auto add = [this](const std::string& name) {
    for (const char* axis : {"_x", "_y", "_z"}) rows_.append(",").append(name).append(axis);
  };
  for (int number = 1; number <= kLoggedVectors; ++number) add(LoggedVector(number)->name());
  add("true");
  rows_.append(",age_s,reason\n");
  Flush();
  if (!trouble_.empty()) throw std::runtime_error(trouble_);
}

void TickLog::Add(double t, const TickRecord& record, const std::optional<Eigen::Vector3d>& truth) {
  ToProto(record, &tick_);
  AppendNumber(&rows_, t, kDigits + 2);
  rows_.append(",").append(ToString(record.state));
  const google::protobuf::Reflection& access = *tick_.GetReflection();
  for (int number = 1; number <= kLoggedVectors; ++number) {
    const auto* field = LoggedVector(number);
    const bool is_known = access.HasField(tick_, field);
    AppendVector(&rows_, is_known ? static_cast<const v1::Vec3f*>(&access.GetMessage(tick_, field))
                                  : nullptr);
  }
  v1::Vec3f true_force;
  if (truth) ToProto(*truth, &true_force);
  AppendVector(&rows_, truth ? &true_force : nullptr);
  rows_.push_back(',');
  if (tick_.has_state_age()) AppendNumber(&rows_, tick_.state_age(), kDigits);
  rows_.append(",").append(ToString(record.chain.reasons));
  if (std::exchange(marks_, record.marks) != record.marks) {
    rows_.append(record.chain.reasons.empty() ? "mark" : "+mark");
  }
  rows_.append("\n");
  if (rows_.size() > kMaxRows) Flush();
}

void TickLog::Flush() {
  if (trouble_.empty()) {
    out_ << rows_;
    out_.flush();
    if (!out_) trouble_ = file_.string() + ": cannot be written";
  }
  rows_.clear();
}

void TruthTrack::Add(Time at, const Eigen::Vector3d& force_S) {
  if (!samples_.empty() && at <= samples_.back().at) return;
  samples_.push_back({at, force_S});
}

std::optional<Eigen::Vector3d> TruthTrack::At(Time t) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t,
                                      [](const Sample& s, Time wanted) { return s.at < wanted; });
  if (after == samples_.end()) return std::nullopt;
  if (after->at == t) return after->force;
  if (after == samples_.begin()) return std::nullopt;
  const auto before = after - 1;
  const double gap = SecondsBetween(before->at, after->at);
  if (gap > kMaxGap) return std::nullopt;
  const double share = SecondsBetween(before->at, t) / gap;
  return before->force + share * (after->force - before->force);
}

void TruthTrack::DropBefore(Time t) {
  while (samples_.size() > 1 && samples_[1].at <= t) samples_.pop_front();
}

Recorder::Recorder(SpscRing<TickRecord>* ring, const std::filesystem::path& log,
                   TickObserver observer)
    : ring_(ring), observer_(std::move(observer)) {
  if (!log.empty()) log_ = std::make_unique<TickLog>(log);
}

void Recorder::Drain(Time now) {
  TickRecord record;
  while (ring_->Pop(&record)) {
    Take(record);
    // Completes ticks at once, because after a stall the ring contains seconds of ticks.
    while (!waiting_.empty() && IsKnown(waiting_.front())) FinishFirst();
  }
  const double max_wait = kMaxWait + kTrips * round_trip_;
  while (!waiting_.empty() &&
         (IsKnown(waiting_.front()) || SecondsBetween(waiting_.front().at, now) > max_wait)) {
    FinishFirst();
  }
  if (log_) log_->Flush();
}

bool Recorder::IsKnown(const TickRecord& record) const {
  return truth_.Reaches(record.at) && (placed_.empty() || placed_.Reaches(record.at));
}

void Recorder::Finish() {
  TickRecord record;
  while (ring_->Pop(&record)) Take(record);
  while (!waiting_.empty()) FinishFirst();
  summary_.Close();
  if (log_) log_->Flush();
}

void Recorder::Take(const TickRecord& record) {
  if (taken_++ == 0) begin_ = record.at;
  newest_ = record;
  if (observer_) observer_(record);
  waiting_.push_back(record);
  if (record.round_trip > 0) round_trip_ = record.round_trip;
  if (!record.has_truth) return;
  truth_.Add(record.truth_at, record.truth);
  if (record.truth_commanded_at != Time{}) placed_.Add(record.truth_commanded_at, record.truth);
  summary_.AddTruth(record.truth);
}

void Recorder::FinishFirst() {
  const TickRecord& record = waiting_.front();
  const auto truth = truth_.At(record.at);
  summary_.Add(record, truth);
  summary_.AddDelayCompensated(record, placed_.At(record.at));
  if (log_) log_->Add(SecondsBetween(begin_, record.at), record, truth);
  truth_.DropBefore(record.at);
  placed_.DropBefore(record.at);
  waiting_.pop_front();
}

}  // namespace palpate
