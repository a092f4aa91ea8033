#include "master/recording/session_recording.h"

#include <memory>
#include <utility>

#include "palpate/v1/recording.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "foxglove/schemas.pb.h"
#include "master/haptics/tick_message.h"
#include "master/session/tick_text.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kTipPeriod = 0.01;  // [s]

foxglove::CompressedImage ImageOf(const v1::ImageState& frame) {
  foxglove::CompressedImage image;
  *image.mutable_timestamp() = frame.sensed_at();
  image.set_format("jpeg");
  image.set_frame_id("camera");
  image.set_data(frame.jpeg());
  return image;
}

// Returns whether a message received `now` is kept, at about `rate` [Hz] after the one `*kept`
// before.
bool IsDue(Time now, double rate, Time* kept) {
  // Relative to the period, so that all messages at exactly this rate are kept.
  constexpr double kJitter = 0.9;
  if (SecondsBetween(*kept, now) < kJitter / rate) return false;
  *kept = now;
  return true;
}

// Alarms that differ only in numbers are the same alarm, as on the page.
std::string WithoutNumbers(std::string alarm) {
  std::erase_if(alarm, [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
  return alarm;
}

}  // namespace

SessionRecording::SessionRecording(Recording::Options options)
    : recording_(std::move(options)),
      tick_(recording_.Open(kTickTopic, v1::ForceTick())),
      command_(recording_.Open(kCommandTopic, v1::OperatorCommand())),
      state_(recording_.Open(kStateTopic, v1::SlaveState())),
      image_(recording_.Open(kImageTopic, foxglove::CompressedImage())),
      mesh_(recording_.Open(kMeshTopic, v1::MeshState())),
      trace_(recording_.Open(kTraceTopic, v1::TraceUpdate())),
      scene_(recording_.Open(kSceneTopic, v1::SceneDescription())),
      health_(recording_.Open(kHealthTopic, v1::Status())),
      hand_(recording_.Open(kTipTopic, foxglove::PoseInFrame())),
      log_(recording_.Open(kMasterLogTopic, foxglove::Log())) {}

SessionRecording::~SessionRecording() = default;

void SessionRecording::OnTick(const TickRecord& record) {
  LogChanges(record);
  if (!is_on_) return;
  v1::ForceTick message;
  ToProto(record, &message);
  recording_.Put(tick_, record.at, message);
  if (SecondsBetween(tip_written_, record.at) < kTipPeriod) return;
  tip_written_ = record.at;
  foxglove::PoseInFrame pose;
  ToProto(record.at, pose.mutable_timestamp());
  pose.set_frame_id("master");
  auto* position = pose.mutable_pose()->mutable_position();
  position->set_x(record.p_M.x());
  position->set_y(record.p_M.y());
  position->set_z(record.p_M.z());
  pose.mutable_pose()->mutable_orientation()->set_w(1);
  recording_.Put(hand_, record.at, pose);
}

void SessionRecording::LogChanges(const TickRecord& record) {
  for (const std::string& act : ActsInWords(last_, record)) Log(act, false, record.at);
  if (std::exchange(last_, record).state == record.state) return;
  const std::string why = InWords(record.chain.reasons);
  Log(std::string(ToString(record.state)) + (why.empty() ? "" : " (" + why + ")"), false,
      record.at);
}

void SessionRecording::Switch(bool on) {
  if (is_on_.exchange(on) != on) Log(on ? "recording is on" : "recording is off from here");
}

void SessionRecording::OnState(const StateRecord& received) {
  if (!is_on_) return;
  const std::shared_ptr<const v1::SlaveState>& message = received.message;
  recording_.Put(state_, received.received_at, message->ByteSizeLong(),
                 [message] { return message->SerializeAsString(); });
  for (const EventWords& event : InWords(FromProto(message->events()))) {
    Log("slave: " + std::string(event.words), event.weight == EventWords::Weight::kTrouble);
  }
}

void SessionRecording::OnCommand(const OperatorCommand& command) {
  if (!is_on_) return;
  v1::OperatorCommand message;
  ToProto(command, &message);
  recording_.Put(command_, command.sent_at, message);
}

void SessionRecording::OnObserved(const google::protobuf::Message& message) {
  const Time now = Clock::now();
  const auto* type = message.GetDescriptor();
  if (type == v1::SceneDescription::descriptor()) {
    recording_.PutStanding(scene_, now, message);
  } else if (!is_on_) {
    return;
  } else if (type == v1::ImageState::descriptor()) {
    if (!IsDue(now, kViews.image_rate, &image_kept_)) return;
    recording_.Put(image_, now, ImageOf(static_cast<const v1::ImageState&>(message)));
  } else if (type == v1::MeshState::descriptor()) {
    PutMesh(now, static_cast<const v1::MeshState&>(message));
  } else if (type == v1::TraceUpdate::descriptor()) {
    recording_.Put(trace_, now, message);
  } else if (type == v1::Status::descriptor()) {
    recording_.Put(health_, now, message);
    LogAlarms(message);
  }
}

void SessionRecording::PutMesh(Time now, const v1::MeshState& mesh) {
  const bool has_topology = mesh.rest_size() > 0;
  const bool begins_part = topology_part_ != recording_.part();
  if (!IsDue(now, kViews.mesh_rate, &mesh_kept_) && !has_topology && !begins_part) return;
  topology_part_ = recording_.part();
  if (has_topology) {
    topology_ = std::make_unique<v1::MeshState>(mesh);
  } else if (begins_part && topology_) {
    v1::MeshState whole = mesh;
    *whole.mutable_elements() = topology_->elements();
    *whole.mutable_rest() = topology_->rest();
    *whole.mutable_fixed_nodes() = topology_->fixed_nodes();
    whole.set_nodes_per_element(topology_->nodes_per_element());
    *whole.mutable_field()->mutable_triangles() = topology_->field().triangles();
    *whole.mutable_field()->mutable_rest() = topology_->field().rest();
    recording_.Put(mesh_, now, whole);
    return;
  }
  recording_.Put(mesh_, now, mesh);
}

void SessionRecording::LogAlarms(const google::protobuf::Message& status) {
  const auto& alarms = static_cast<const v1::Status&>(status).alarms();
  std::set<std::string> present;
  for (const std::string& alarm : alarms) {
    const std::string kind = WithoutNumbers(alarm);
    if (!alarms_.contains(kind)) Log("slave: " + alarm, true);
    present.insert(kind);
  }
  alarms_ = std::move(present);
}

void SessionRecording::Log(const std::string& line, bool is_alarm, Time at) {
  foxglove::Log log;
  ToProto(at, log.mutable_timestamp());
  log.set_level(is_alarm ? foxglove::Log::WARNING : foxglove::Log::INFO);
  log.set_message(line);
  log.set_name("palpate-master");
  recording_.Put(log_, at, log);
}

}  // namespace palpate
