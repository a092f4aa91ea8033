// Observes the slave beside the states of SlaveLink: images, meshes, local contact models, traces,
// scene and status. All use one separate connection. Each stream is open once while a user needs
// it, and its messages are passed to all such users.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "palpate/v1/scene.pb.h"
#include "palpate/v1/telemetry.pb.h"

#include "master/haptics/received.h"
#include "master/link/remote_mesh.h"
#include "master/link/remote_scene.h"
#include "master/link/slave_link.h"
#include "shared/link/latest_value.h"
#include "shared/state/sample_trace.h"

namespace google::protobuf {
class Message;
}

namespace palpate {

// A received image.
struct RemoteImage {
  std::uint64_t number = 0;   // rises by one per image
  Time sensed_at{};           // slave's clock
  int width = 0, height = 0;  // [px]
  std::string jpeg;
};

// Scene and status of the slave as received; empty: not yet.
struct SlaveHealth {
  std::uint64_t version = 0;  // increases with each answer
  std::optional<v1::SceneDescription> scene = {};
  std::optional<v1::Status> status = {};
  std::string trouble = {};                // why no answer is received
  std::optional<RemoteScene> remote = {};  // of `scene`; empty: not received, or out of range
};

// Views that cost the slave work, as needed by one user. Rates [Hz], 1 to 120; 0: not needed.
struct ObservedViews {
  double image_rate = 0;  // of images with the slave's overlays
  double mesh_rate = 0;
  bool nodal_forces = false, traction = false, field = false;
  bool operator==(const ObservedViews&) const = default;
};

class Observer {
 public:
  enum class User : std::uint8_t { kPage, kTable, kRecording };
  static constexpr std::size_t kUsers = 3;

  struct Options {
    LatestValue<ReceivedPatch>* patches = nullptr;  // must outlive the observer; null: no patches
    bool health = false;                            // traces, scene and status
    // Receives each SceneDescription that changed, and each Status, ImageState, MeshState
    // (with positions) and TraceUpdate. Called by several threads. Empty: not needed.
    std::function<void(const google::protobuf::Message&)> on_message = {};
  };
  struct MeshStats {
    std::uint64_t meshes = 0, refused = 0;  // received; rejected as invalid
    double deflection_peak = 0;             // largest deflection so far [m]
    std::string trouble;                    // why no mesh arrives, or why the last was rejected
  };

  // Opens the streams of `options` and keeps them open, reconnecting with back-off. Throws
  // std::invalid_argument for an invalid target, or one beyond loopback without `insecure`.
  Observer(const SlaveLink::Options& link, Options options);
  ~Observer();

  // Opens, changes or ends the streams of images and meshes, so that they serve all users. May wait
  // for the end of a stream. Thread-safe, like the functions below.
  void Need(User user, const ObservedViews& views);

  // Null: none received yet, or none needed.
  [[nodiscard]] std::shared_ptr<const RemoteImage> image() const;
  [[nodiscard]] std::string image_trouble() const;  // why none is received; empty: no problem
  // Null: none received yet. The last one stays when none is needed any more.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> mesh() const;
  [[nodiscard]] MeshStats mesh_stats() const;
  [[nodiscard]] PatchStats patch_stats() const;
  // Trace of the sample that was sensed at this time, slave's clock. nullopt: not received, or
  // older than a second.
  [[nodiscard]] std::optional<SampleTrace> TraceOf(Time sensed_at) const;
  [[nodiscard]] SlaveHealth health() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
