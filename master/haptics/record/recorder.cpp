#include "master/haptics/record/recorder.h"

namespace palpate {

Recorder::Recorder(SpscRing<TickRecord>* ring, const std::filesystem::path& log) : ring_(ring) {
  if (!log.empty()) log_ = std::make_unique<TickLog>(log);
}

void Recorder::Drain(Time now) {
  TickRecord record;
  while (ring_->Pop(&record)) Take(record);
  while (!waiting_.empty() && (truth_.Reaches(waiting_.front().at) ||
                               SecondsBetween(waiting_.front().at, now) > kPatience)) {
    FinishFirst();
  }
  if (log_) log_->Flush();
}

void Recorder::Finish() {
  TickRecord record;
  while (ring_->Pop(&record)) Take(record);
  while (!waiting_.empty()) FinishFirst();
  if (log_) log_->Flush();
}

void Recorder::Take(const TickRecord& record) {
  if (taken_++ == 0) begin_ = record.at;
  newest_ = record;
  waiting_.push_back(record);
  if (!record.has_truth) return;
  truth_.Add(record.truth_at, record.truth);
  summary_.SeeTruth(record.truth);
}

void Recorder::FinishFirst() {
  const TickRecord& record = waiting_.front();
  const auto truth = truth_.At(record.at);
  summary_.Add(record, truth);
  if (log_) log_->Add(SecondsBetween(begin_, record.at), record, truth);
  truth_.DropBefore(record.at);
  waiting_.pop_front();
}

}  // namespace palpate
