#include "master/recording/session_recording.h"

#include <utility>

#include "palpate/v1/recording.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "foxglove/schemas.pb.h"
#include "master/haptics/record/tick_words.h"
#include "master/recording/tick_message.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kHandEvery = 0.01;  // [s]

foxglove::CompressedImage ImageOf(const v1::VideoFrame& frame) {
  foxglove::CompressedImage image;
  *image.mutable_timestamp() = frame.sensed_at();
  image.set_format("jpeg");
  image.set_frame_id("camera");
  image.set_data(frame.jpeg());
  return image;
}

}  // namespace

SessionRecording::SessionRecording(Recording::Options options)
    : recording_(std::move(options)),
      tick_(recording_.Open(kTickTopic, v1::ForceTick())),
      command_(recording_.Open(kCommandTopic, v1::OperatorCommand())),
      state_(recording_.Open(kStateTopic, v1::SlaveState())),
      picture_(recording_.Open(kPictureTopic, foxglove::CompressedImage())),
      mesh_(recording_.Open(kMeshTopic, v1::MeshState())),
      trace_(recording_.Open(kTraceTopic, v1::TraceUpdate())),
      scene_(recording_.Open(kSceneTopic, v1::SceneDescription())),
      capabilities_(recording_.Open(kCapabilitiesTopic, v1::Capabilities())),
      health_(recording_.Open(kHealthTopic, v1::Status())),
      hand_(recording_.Open(kHandTopic, foxglove::PoseInFrame())),
      log_(recording_.Open(kMasterLogTopic, foxglove::Log())) {}

SessionRecording::~SessionRecording() = default;

void SessionRecording::OnTick(const TickRecord& record) {
  LogChanges(record);
  if (!is_on_) return;
  v1::ForceTick message;
  ToProto(record, &message);
  recording_.Put(tick_, record.at, message);
  if (SecondsBetween(hand_told_, record.at) < kHandEvery) return;
  hand_told_ = record.at;
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

void SessionRecording::OnState(const ReceivedState& received) {
  if (!is_on_) return;
  v1::SlaveState message;
  ToProto(received.state, &message);
  recording_.Put(state_, received.received_at, message);
  for (const EventWords& told : InWords(received.state.events)) {
    Log("slave: " + std::string(told.words), told.weight == EventWords::Weight::kTrouble);
  }
}

void SessionRecording::OnCommand(const OperatorCommand& command) {
  if (!is_on_) return;
  v1::OperatorCommand message;
  ToProto(command, &message);
  recording_.Put(command_, command.sent_at, message);
}

void SessionRecording::OnBulk(const google::protobuf::Message& message) {
  const Time now = Clock::now();
  const auto* type = message.GetDescriptor();
  if (type == v1::SceneDescription::descriptor()) {
    recording_.PutStanding(scene_, now, message);
  } else if (type == v1::Capabilities::descriptor()) {
    recording_.PutStanding(capabilities_, now, message);
  } else if (!is_on_) {
    return;
  } else if (type == v1::VideoFrame::descriptor()) {
    recording_.Put(picture_, now, ImageOf(static_cast<const v1::VideoFrame&>(message)));
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
  const int before = std::exchange(topology_part_, recording_.part());
  if (mesh.rest_size() > 0) {
    topology_ = std::make_unique<v1::MeshState>(mesh);
  } else if (before != topology_part_ && topology_) {
    v1::MeshState whole = mesh;
    *whole.mutable_elements() = topology_->elements();
    *whole.mutable_rest() = topology_->rest();
    *whole.mutable_fixed_nodes() = topology_->fixed_nodes();
    whole.set_nodes_per_element(topology_->nodes_per_element());
    recording_.Put(mesh_, now, whole);
    return;
  }
  recording_.Put(mesh_, now, mesh);
}

void SessionRecording::LogAlarms(const google::protobuf::Message& status) {
  const auto& told = static_cast<const v1::Status&>(status).alarms();
  for (const std::string& alarm : told) {
    if (!alarms_.contains(alarm)) Log("slave: " + alarm, true);
  }
  alarms_ = {told.begin(), told.end()};
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
