// Operates a slave: lease, clutch, watchdog, and motions of the tool in frame S.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <palpate/v1/teleoperation.grpc.pb.h>

#include "palpate/state.h"

namespace palpate {
// Its symbols are not those of the programs, whose classes have some of the same names.
inline namespace client {

// Holds the lease of a slave while it exists, and moves its tool. Slave::Operate makes it.
//
// A thread sends the newest target every 4 ms, with the sequence of the newest state. A motion
// advances only while states arrive and the tool follows. So a lost link, a held tool or an
// emergency stop pause it and never make the tool jump. Calls are for one thread.
class Operator {
 public:
  Operator(v1::Teleoperation::Stub* stub, std::string name) : stub_(stub), name_(std::move(name)) {
    context_.AddMetadata("palpate-operator-bin", name_);
    stream_ = stub->Operate(&context_);
    reader_ = std::thread([this] { Read(); });
    sender_ = std::thread([this] { Send(); });
    try {
      Await([] { return true; }, "no state arrived");
    } catch (...) {
      Close();
      throw;
    }
  }
  ~Operator() { Close(); }
  Operator(const Operator&) = delete;
  Operator& operator=(const Operator&) = delete;

  // The newest state.
  [[nodiscard]] State state() {
    const std::lock_guard lock(mutex_);
    Check();
    return states_.back();
  }
  // Commanded tool tip [m]; before the first engagement the measured one.
  [[nodiscard]] Vector position() {
    const std::lock_guard lock(mutex_);
    return offset_ ? Sum(*offset_, moved_) : states_.back().tip();
  }

  // Closes the clutch: from now on the tool follows. It does not move by this. The settings of the
  // slave may have changed since the last engagement: they are read again.
  void Engage() {
    const v1::SceneDescription scene = ReadScene();
    {
      const std::lock_guard lock(mutex_);
      Use(scene);
      ++epoch_;
      engaged_ = true;
      offset_.reset();
      moved_ = goal_ = {};
    }
    Await([this] { return IsFollowing(); }, "the slave does not follow");
    const std::lock_guard lock(mutex_);
    offset_ = ToVector(states_.back().message().offset());
  }
  // Opens the clutch: the tool is stationary.
  void Release() {
    const std::lock_guard lock(mutex_);
    engaged_ = false;
  }
  // Moves the commanded tip in a straight line to `tip` [m] at `speed` [m/s]. Returns the states
  // received meanwhile. Engages if needed.
  std::vector<State> MoveTo(const Vector& tip, double speed) {
    if (!std::isfinite(Norm(tip)) || !(speed > 0) || std::isinf(speed)) {
      throw std::invalid_argument("tip and speed: expected finite numbers, and a speed > 0");
    }
    if (!engaged_ || !offset_) Engage();
    std::unique_lock lock(mutex_);
    const Motion motion(this);
    goal_ = Difference(tip, *offset_);
    speed_ = speed;
    auto held = Clock::now();
    while (moved_ != goal_) {
      if (IsAlive()) held = Clock::now();
      if (Clock::now() - held > kHeld) {
        goal_ = moved_;  // an interrupted motion does not go on by itself
        throw Interrupted(grpc::ABORTED, WithReason("the tool does not follow"));
      }
      changed_.wait_for(lock, kPeriod);
      Check();
    }
    return states_;
  }
  // Moves the tip by `step` [m], like MoveTo.
  std::vector<State> MoveBy(const Vector& step, double speed) {
    if (!engaged_ || !offset_) Engage();
    return MoveTo(Sum(position(), step), speed);
  }
  // Stays. Returns the states received meanwhile.
  std::vector<State> Hold(std::chrono::duration<double> time) {
    const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(time);
    std::unique_lock lock(mutex_);
    const Motion motion(this);
    while (Clock::now() < end) {
      changed_.wait_until(lock, end);
      Check();
    }
    return states_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPeriod{4};
  static constexpr double kSilent = 0.5;  // without a state: a link that is cut [s]
  static constexpr std::chrono::seconds kHeld{1}, kAnswer{10}, kGoodbye{1};

  // Requires the lock. While an object exists, all states from the newest on are kept; between
  // motions they would fill the memory.
  class Motion {
   public:
    explicit Motion(Operator* of) : of_(of) {
      of_->states_.erase(of_->states_.begin(), of_->states_.end() - 1);
      of_->is_moving_ = true;
    }
    ~Motion() { of_->is_moving_ = false; }
    Motion(const Motion&) = delete;
    Motion& operator=(const Motion&) = delete;

   private:
    Operator* of_;
  };

  // Row-major, of a unit quaternion w, x, y, z.
  template <class Numbers>
  static std::array<double, 9> RotationMatrix(const Numbers& q) {
    const double w = q.Get(0), x = q.Get(1), y = q.Get(2), z = q.Get(3);
    return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  }
  static Vector Sum(const Vector& a, const Vector& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
  }
  static Vector Difference(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }
  // From frame S to the device's frame M.
  [[nodiscard]] Vector ToDevice(const Vector& v) const {
    Vector device{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) device[i] += rotation_[3 * j + i] * v[j] / scale_;
    }
    return device;
  }

  [[nodiscard]] v1::SceneDescription ReadScene() const {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kAnswer);
    v1::SceneDescription scene;
    const auto status = stub_->GetScene(&context, v1::GetSceneRequest(), &scene);
    if (!status.ok()) throw Error(status);
    return scene;
  }
  void Use(const v1::SceneDescription& scene) {
    const auto& mapping = scene.operator_();
    scale_ = mapping.position_scale();
    rotation_ = RotationMatrix(mapping.orientation());
    silence_ = mapping.dead_after() > 0 ? mapping.dead_after() : 0.030;
    revision_ = scene.settings_revision();
  }
  [[nodiscard]] bool IsFollowing() const {
    const auto& message = states_.back().message();
    return engaged_ && message.epoch() == epoch_ && message.phase() == v1::PHASE_FOLLOWING;
  }
  // The tool follows, and states arrive.
  [[nodiscard]] bool IsAlive() const {
    return offset_ && IsFollowing() &&
           std::chrono::duration<double>(Clock::now() - received_at_).count() < silence_;
  }
  void Check() const {
    if (!ended_) return;
    const Error error(status_);
    if (error.reason() == "LEASE_HELD" || error.reason() == "LEASE_LOST") throw LeaseHeld(status_);
    throw error;
  }
  // `what`, and why according to the newest state.
  [[nodiscard]] std::string WithReason(std::string what) const {
    if (states_.empty()) return what;
    const double silent = std::chrono::duration<double>(Clock::now() - received_at_).count();
    if (silent > kSilent)
      return "no state of the slave for " + std::to_string(silent) + " s: the link is cut";
    const auto& newest = states_.back().message();
    what += ": " + v1::Phase_Name(newest.phase()) + ", " + v1::Validity_Name(newest.validity());
    if (revision_ != 0 && newest.settings_revision() != revision_) {
      what += "; the settings changed: revision " + std::to_string(revision_) + ", now " +
              std::to_string(newest.settings_revision());
    }
    return what;
  }
  template <typename Condition>
  void Await(const Condition& condition, const char* otherwise) {
    const auto end = Clock::now() + kAnswer;
    std::unique_lock lock(mutex_);
    while (states_.empty() || !condition()) {
      Check();
      if (Clock::now() > end) throw Interrupted(grpc::DEADLINE_EXCEEDED, WithReason(otherwise));
      changed_.wait_for(lock, kPeriod);
    }
  }

  void Read() {
    v1::SlaveState message;
    while (stream_->Read(&message)) {
      const std::lock_guard lock(mutex_);
      if (!is_moving_) states_.clear();
      states_.emplace_back(message);
      received_at_ = Clock::now();
      changed_.notify_all();
    }
    const auto status = stream_->Finish();
    const std::lock_guard lock(mutex_);
    status_ = status;
    ended_ = true;
    changed_.notify_all();
  }
  void Send() {
    for (auto last = Clock::now(); !closing_;) {
      const auto now = Clock::now();
      const double dt = std::min(std::chrono::duration<double>(now - last).count(), 0.02);
      last = now;
      if (!stream_->Write(Next(dt))) return;
      std::this_thread::sleep_for(kPeriod);
    }
    Release();
    stream_->Write(Next(0));
    stream_->WritesDone();
  }
  v1::OperatorCommand Next(double dt) {
    const std::lock_guard lock(mutex_);
    const Vector left = Difference(goal_, moved_);
    const double distance = Norm(left);
    Vector velocity{};
    if (distance > 0 && IsAlive()) {
      for (std::size_t i = 0; i < 3; ++i) velocity[i] = speed_ * left[i] / distance;
      const bool arrives = distance <= speed_ * dt;
      for (std::size_t i = 0; i < 3; ++i)
        moved_[i] = arrives ? goal_[i] : moved_[i] + dt * velocity[i];
      changed_.notify_all();
    }
    v1::OperatorCommand command;
    command.set_sequence(++sequence_);
    *command.mutable_sent_at() = Now();
    command.set_epoch(epoch_);
    command.set_engaged(engaged_);
    command.set_settings_revision(revision_);
    Set(ToDevice(moved_), command.mutable_p_m());
    Set(ToDevice(velocity), command.mutable_velocity());
    if (sequence_ == 1) command.set_operator_name(name_);
    if (!states_.empty()) {
      command.set_state_sequence(states_.back().message().sequence());
      *command.mutable_echo() = states_.back().message().sent_at();
    }
    return command;
  }
  void Close() {
    closing_ = true;
    {
      // A slave that is reached ends the stream by itself.
      std::unique_lock lock(mutex_);
      if (!changed_.wait_for(lock, kGoodbye, [this] { return ended_; })) context_.TryCancel();
    }
    if (sender_.joinable()) sender_.join();
    if (reader_.joinable()) reader_.join();
  }

  v1::Teleoperation::Stub* const stub_;
  const std::string name_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>> stream_;
  std::thread reader_, sender_;
  std::atomic<bool> closing_ = false;

  std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::vector<State> states_;  // the newest, and during a motion all since it began
  bool is_moving_ = false;
  Clock::time_point received_at_{};
  // The settings of the scene as of the last engagement. Before the first one no motion needs them.
  double scale_ = 1;
  std::array<double, 9> rotation_{1, 0, 0, 0, 1, 0, 0, 0, 1};  // R_SM, row-major
  double silence_ = 0.030;                                     // [s]
  std::uint32_t revision_ = 0;
  std::optional<Vector> offset_;  // tip at the engagement
  Vector moved_{}, goal_{};       // from there: at present, at the end; frame S
  double speed_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint32_t epoch_ = 0;
  bool engaged_ = false, ended_ = false;
  grpc::Status status_;
};

}  // namespace client
}  // namespace palpate
