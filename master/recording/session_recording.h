// The master's recording of a session.
//
//   /master/tick           palpate.v1.ForceTick, 1000 a second: the force chain
//   /master/command        palpate.v1.OperatorCommand, as sent
//   /slave/state           palpate.v1.SlaveState, as received, without the keys of datagrams; time
//                          of arrival, master's clock
//   /slave/image           foxglove.CompressedImage, JPEG with overlays, at most two a second
//   /slave/mesh            palpate.v1.MeshState, at most two a second
//   /slave/trace           palpate.v1.TraceUpdate: times of each sample in the stages of the slave
//   /slave/scene           palpate.v1.SceneDescription, at each change
//   /slave/health          palpate.v1.Status, one a second
//   /master/tip            foxglove.PoseInFrame: the device, a hundred a second
//   /log                   foxglove.Log: operator states, events and alarms, as text
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "master/haptics/tick_record.h"
#include "master/link/observer.h"
#include "master/link/state_record.h"
#include "shared/recording/recording.h"

namespace palpate {

namespace v1 {
class MeshState;
}  // namespace v1

inline constexpr std::string_view kTickTopic = "/master/tick", kCommandTopic = "/master/command",
                                  kStateTopic = "/slave/state", kImageTopic = "/slave/image",
                                  kMeshTopic = "/slave/mesh", kTraceTopic = "/slave/trace",
                                  kSceneTopic = "/slave/scene", kHealthTopic = "/slave/health",
                                  kTipTopic = "/master/tip", kMasterLogTopic = "/log";
// Name of the metadata with the settings of the session.
inline constexpr const char* kSessionNote = "palpate.session";

// Thread-safe, but not for the haptic thread: its ticks arrive through the ring.
class SessionRecording {
 public:
  // Throws std::runtime_error if the file cannot be written.
  explicit SessionRecording(Recording::Options options);
  ~SessionRecording();

  // Writes the settings of the session. Call it first.
  void Begin(const McapMap& session) { recording_.Note(kSessionNote, session); }
  void OnTick(const TickRecord& record);
  void OnState(const StateRecord& received);
  void OnCommand(const OperatorCommand& command);
  // Views of the slave that a recording needs.
  static constexpr ObservedViews kViews{
      .image_rate = 2, .mesh_rate = 2, .traction = true, .field = true};
  // Records a message of an Observer. Keeps at most kViews of the images and meshes.
  void OnObserved(const google::protobuf::Message& message);
  // Writes a line of the log. `is_alarm`: it is a warning.
  void Log(const std::string& line, bool is_alarm = false, Time at = Clock::now());

  // Switches the recording on or off. While off, it keeps only scene and log. Thread-safe.
  void Switch(bool on);
  [[nodiscard]] bool is_on() const { return is_on_; }

  void Finish() { recording_.Finish(); }
  [[nodiscard]] Recording::Stats stats() const { return recording_.stats(); }
  // The file that is written, see UnusedFile.
  [[nodiscard]] const std::filesystem::path& file() const { return recording_.file(); }

 private:
  void LogChanges(const TickRecord& record);
  void PutMesh(Time now, const v1::MeshState& mesh);
  void LogAlarms(const google::protobuf::Message& status);

  Recording recording_;
  std::uint16_t tick_, command_, state_, image_, mesh_, trace_, scene_, health_, hand_, log_;
  std::atomic<bool> is_on_{true};
  // Used by the thread of the ticks.
  TickRecord last_;
  Time tip_written_{};
  std::set<std::string> alarms_;  // of the last status, without numbers; used by the status thread
  Time image_kept_{};             // used by the image thread
  // Used by the mesh thread.
  Time mesh_kept_{};
  std::unique_ptr<v1::MeshState> topology_;  // the last mesh with a topology
  int topology_part_ = 1;                    // part of the recording that contains it
};

}  // namespace palpate
