#include "slave/service/publisher.h"

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kStatePeriod(static_cast<int>(1000 / Publisher::kStateRate));
// At most 1000 states per second, for every sensor.
constexpr std::chrono::microseconds kMinGap(1000);

// An observer's place in the publisher's list.
class Observer final : public StateReader {
 public:
  void Offer(const SlaveState& state) override { box.Put(state); }
  void Close() override { box.Close(); }

  StateMailbox box;
};

}  // namespace

Publisher::~Publisher() {
  Stop();
}

std::shared_ptr<StateMailbox> Publisher::Subscribe() {
  const auto observer = std::make_shared<Observer>();
  const std::scoped_lock lock(mutex_);
  if (stopped_) observer->Close();
  observers_.push_back(observer);
  joined_.notify_all();
  return {observer, &observer->box};
}

void Publisher::ServeFirst(const std::shared_ptr<StateReader>& reader) {
  bool stopped = false;
  {
    const std::scoped_lock lock(mutex_);
    operator_ = reader;
    stopped = stopped_;
    joined_.notify_all();
  }
  if (stopped) reader->Close();
}

void Publisher::Flag(Event event) {
  const std::scoped_lock lock(mutex_);
  flagged_.Add(event);
}

void Publisher::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Publisher::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  CollectReaders();
  for (const auto& reader : readers_) reader->Close();
  readers_.clear();
}

void Publisher::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kReadingPriority);
  while (!stop.stop_requested()) {
    const bool sensed = slave_.WaitForNewer(sensed_at_, kStatePeriod);
    const Time due = Clock::now() + kMinGap;
    const bool is_read = Publish(Clock::now());
    if (!is_read) AwaitReaders(stop);
    if (sensed && is_read) std::this_thread::sleep_until(Clock::ToSteady(due));
  }
}

bool Publisher::CollectReaders() {
  const std::scoped_lock lock(mutex_);
  readers_.clear();
  if (auto reader = operator_.lock()) readers_.push_back(std::move(reader));
  std::erase_if(observers_, [](const auto& observer) { return observer.expired(); });
  for (const auto& observer : observers_) {
    if (auto reader = observer.lock()) readers_.push_back(std::move(reader));
  }
  return !readers_.empty();
}

void Publisher::AwaitReaders(const std::stop_token& stop) {
  slave_.SetWatched(false);
  {
    std::unique_lock lock(mutex_);
    joined_.wait(lock, stop, [this] { return !operator_.expired() || !observers_.empty(); });
  }
  slave_.TakeEvents();  // discards events without a reader
  slave_.SetWatched(true);
}

bool Publisher::Publish(Time now) {
  if (!CollectReaders()) return false;
  SlaveState state = slave_.Compose(now);
  state.sequence = ++sequence_;
  state.events = slave_.TakeEvents();
  {
    const std::scoped_lock lock(mutex_);
    state.events.Add(flagged_);
    flagged_.Clear();
  }
  sensed_at_ = state.sensed_at;
  for (const auto& reader : readers_) reader->Offer(state);
  readers_.clear();
  return true;
}

}  // namespace palpate
