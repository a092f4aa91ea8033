#include "master/recording/replay.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "palpate/v1/recording.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "foxglove/schemas.pb.h"
#include "master/haptics/tick_message.h"
#include "master/recording/session_recording.h"
#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kStep = 0.01;   // of the player's time [s]
constexpr double kMaxGap = 0.2;  // without a tick, which is waited for [s]

template <class Message>
Message Parsed(const RecordingReader& reader) {
  Message message;
  reader.Read(&message);
  return message;
}

// Passes each message to its callback.
class MessageDispatcher {
 public:
  MessageDispatcher(const RecordingReader& reader, const ReplayFeed& feed,
                    std::shared_ptr<const MeshTopology> topology)
      : reader_(reader), feed_(feed), topology_(std::move(topology)) {}

  void Dispatch() {
    const std::string_view topic = reader_.topic();
    if (topic == kTickTopic && feed_.on_tick) {
      feed_.on_tick(FromProto(Parsed<v1::ForceTick>(reader_), reader_.at()));
    } else if (topic == kStateTopic && feed_.on_state) {
      DispatchState();
    } else if (topic == kImageTopic && feed_.on_image) {
      DispatchImage();
    } else if (topic == kMeshTopic && feed_.on_mesh) {
      DispatchMesh();
    } else if (topic == kTraceTopic && feed_.on_trace) {
      DispatchTraces();
    } else if (topic == kMasterLogTopic && feed_.on_log) {
      DispatchLog();
    } else if (topic == kSceneTopic && feed_.on_scene) {
      feed_.on_scene(Parsed<v1::SceneDescription>(reader_), reader_.at());
    } else if (topic == kHealthTopic && feed_.on_health) {
      feed_.on_health(Parsed<v1::Status>(reader_), reader_.at());
    }
  }

 private:
  static constexpr std::size_t kMaxLineLength = 300;

  void DispatchState() {
    std::string reason;
    const auto message = Parsed<v1::SlaveState>(reader_);
    if (const auto state = FromProto(message, &reason)) feed_.on_state(*state, message);
  }
  void DispatchTraces() {
    std::string reason;
    const auto update = Parsed<v1::TraceUpdate>(reader_);
    for (const v1::SampleTrace& sample : update.samples()) {
      if (const auto trace = FromProto(sample, &reason)) feed_.on_trace(*trace);
    }
  }
  void DispatchLog() {
    const auto log = Parsed<foxglove::Log>(reader_);
    feed_.on_log(Presentable(log.message(), kMaxLineLength), reader_.at(),
                 log.level() >= foxglove::Log::WARNING);
  }
  void DispatchImage() {
    const auto image = Parsed<foxglove::CompressedImage>(reader_);
    std::string reason;
    feed_.on_image(image.data(), FieldReader(&reason).Stamp("timestamp", image.timestamp()));
  }
  void DispatchMesh() {
    std::string reason;
    auto mesh = FromProto(Parsed<v1::MeshState>(reader_), topology_, &reason);
    if (!mesh) return;
    topology_ = mesh->topology;
    feed_.on_mesh(std::make_shared<const RemoteMesh>(*std::move(mesh)));
  }

  const RecordingReader& reader_;
  const ReplayFeed& feed_;
  std::shared_ptr<const MeshTopology> topology_;
};

}  // namespace

// The topology is recorded once, possibly long before the start of the replay.
Replay::Replay(std::filesystem::path file) : file_(std::move(file)) {
  RecordingReader reader(file_);
  while (reader.Next()) {
    if (reader.topic() == kMeshTopic && !topology_) {
      std::string reason;
      const auto mesh = FromProto(Parsed<v1::MeshState>(reader), nullptr, &reason);
      if (mesh) topology_ = mesh->topology;
    }
    if (reader.topic() != kTickTopic) continue;
    if (span_.ticks++ == 0) span_.first = reader.at();
    span_.last = std::max(span_.last, reader.at());
  }
  span_.damage = reader.damage();
  if (span_.ticks == 0) {
    throw InputError((span_.damage.empty() ? file_.string() : span_.damage) +
                     ": contains no tick: expected a master's recording (connect --record)");
  }
  const auto session = reader.mcap().notes().find(kSessionNote);
  if (session != reader.mcap().notes().end()) span_.session = session->second;
}

void Replay::Play(double from, double speed, const ReplayFeed& feed,
                  const std::stop_token& stop) const {
  RecordingReader reader(file_);
  MessageDispatcher dispatcher(reader, feed, topology_);
  const Time begin = span_.first + Seconds(from);
  if (from > 0) reader.SkipBefore(begin);
  Time started = Clock::now();
  double asked = -kStep;
  while (!stop.stop_requested() && reader.Next()) {
    // Only ticks define the time, because other messages have timestamps of another clock.
    const double played = SecondsBetween(begin, std::min(reader.at(), span_.last));
    if (reader.topic() == kTickTopic && played - asked >= kStep * (speed > 0 ? speed : 1)) {
      // Skips times in which nothing was recorded.
      if (speed > 0 && played - asked > kMaxGap) started -= Seconds((played - asked) / speed);
      asked = played;
      if (feed.goes_on && !feed.goes_on(from + played)) return;
      if (speed > 0) {
        std::this_thread::sleep_until(Clock::ToSteady(started + Seconds(played / speed)));
      }
    }
    dispatcher.Dispatch();
  }
}

}  // namespace palpate
