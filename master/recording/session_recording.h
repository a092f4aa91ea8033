// The master's recording of a session.
//
//   /master/tick           palpate.v1.ForceTick, 1000 a second: the force chain
//   /master/command        palpate.v1.OperatorCommand, as they left
//   /slave/state           palpate.v1.SlaveState, as they came: time of arrival, master's clock
//   /slave/picture         foxglove.CompressedImage, JPEG, at most two a second
//   /slave/mesh            palpate.v1.MeshState, at most two a second
//   /slave/trace           palpate.v1.TraceUpdate: when each sample came through the slave's stages
//   /slave/scene, /capabilities, /health   what the slave says of itself, at each change, each
//   second /master/tip            foxglove.PoseInFrame: the hand, a hundred a second /log
//   foxglove.Log: states of the operator, events and alarms, in words
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "master/haptics/record/tick_record.h"
#include "master/link/slave_link.h"
#include "shared/recording/recording.h"

namespace palpate {

namespace v1 {
class MeshState;
}  // namespace v1

inline constexpr std::string_view kTickTopic = "/master/tick", kCommandTopic = "/master/command",
                                  kStateTopic = "/slave/state", kPictureTopic = "/slave/picture",
                                  kMeshTopic = "/slave/mesh", kTraceTopic = "/slave/trace",
                                  kSceneTopic = "/slave/scene",
                                  kCapabilitiesTopic = "/slave/capabilities",
                                  kHealthTopic = "/slave/health", kHandTopic = "/master/tip",
                                  kMasterLogTopic = "/log";
// Of the note that says what the session went by.
inline constexpr const char* kSessionNote = "palpate.session";

// Thread-safe. Nothing here is for the haptic thread: its ticks come by the ring.
class SessionRecording {
 public:
  // Throws std::runtime_error: it cannot be written.
  explicit SessionRecording(Recording::Options options);
  ~SessionRecording();

  // Before anything else: what the session goes by.
  void Begin(const McapMap& session) { recording_.Note(kSessionNote, session); }
  void OnTick(const TickRecord& record);
  void OnState(const ReceivedState& received);
  void OnCommand(const OperatorCommand& command);
  // Of a BulkWatch.
  void OnBulk(const google::protobuf::Message& message);
  // A line of the log; `is_alarm`: something is not as it should be.
  void Log(const std::string& line, bool is_alarm = false, Time at = Clock::now());

  // Off: nothing is kept but what the slave says of its scene, and the log, which says so.
  // Thread-safe.
  void Switch(bool on);
  [[nodiscard]] bool is_on() const { return is_on_; }

  void Finish() { recording_.Finish(); }
  [[nodiscard]] Recording::Stats stats() const { return recording_.stats(); }

 private:
  void LogChanges(const TickRecord& record);
  void PutMesh(Time now, const v1::MeshState& mesh);
  void LogAlarms(const google::protobuf::Message& status);

  Recording recording_;
  std::uint16_t tick_, command_, state_, picture_, mesh_, trace_, scene_, capabilities_, health_,
      hand_, log_;
  std::atomic<bool> is_on_{true};
  // Of the thread that brings ticks.
  TickRecord last_;
  Time hand_told_{};
  std::set<std::string>
      alarms_;  // of the last status; of the thread that asks for the slave's health
  // Of the thread that watches the mesh.
  std::unique_ptr<v1::MeshState> topology_;  // the last mesh that had one
  int topology_part_ = 1;                    // that tells it
};

}  // namespace palpate
