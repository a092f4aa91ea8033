#include "slave/recording/step_messages.h"

#include <algorithm>
#include <cmath>

#include "shared/recording/recording.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr int kPoseNumbers = 12;

void ToProto(const FingerReading& reading, v1::FingerSample* message) {
  message->set_present(reading.present);
  message->mutable_electrodes()->Add(reading.channels.begin(), reading.channels.end());
  message->set_pac(reading.pac);
  message->set_pdc(reading.pdc);
  if (!reading.X_SF) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) message->add_pose((*reading.X_SF)(row, column));
  }
}

FingerReading FromProto(const v1::FingerSample& message) {
  FingerReading reading;
  const bool is_finite =
      std::ranges::all_of(message.electrodes(), [](float x) { return std::isfinite(x); }) &&
      std::ranges::all_of(message.pose(), [](double x) { return std::isfinite(x); });
  const bool is_posed = message.pose_size() == kPoseNumbers;
  if (message.electrodes_size() < 1 || message.electrodes_size() > kMaxChannels || !is_finite ||
      !(is_posed || message.pose_size() == 0)) {
    throw InputError("a fingertip's sample: expected 1 to " + std::to_string(kMaxChannels) +
                     " finite channels and a pose of 12 numbers or none");
  }
  reading.present = message.present();
  reading.channels.resize(static_cast<std::size_t>(message.electrodes_size()));
  std::copy(message.electrodes().begin(), message.electrodes().end(), reading.channels.begin());
  reading.pac = message.pac();
  reading.pdc = message.pdc();
  if (!is_posed) return reading;
  reading.X_SF = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kPoseNumbers; ++i) (*reading.X_SF)(i / 4, i % 4) = message.pose(i);
  return reading;
}

}  // namespace

void ToProto(const ContactEstimate& estimate, v1::SenseStep::Estimate* message) {
  ToProto(estimate, message->mutable_state());
  ToProto(estimate.details, message->mutable_state()->mutable_details());
  message->set_sample(estimate.sample);
}

void ToProto(const TactileFrame& frame, v1::TactileInstant* message) {
  message->Clear();
  message->set_sequence(frame.sequence);
  ToProto(frame.sensed_at, message->mutable_sensed_at());
  message->set_after_gap(frame.after_gap);
  for (const FingerReading& reading : frame.fingers) ToProto(reading, message->add_fingers());
}

TactileFrame FromProto(const v1::TactileInstant& message) {
  TactileFrame frame;
  frame.sequence = message.sequence();
  frame.sensed_at = RecordedTime(message.sensed_at());
  frame.after_gap = message.after_gap();
  if (message.fingers_size() > kMaxFingers) {
    throw InputError("a sample of " + std::to_string(message.fingers_size()) +
                     " fingertips: expected at most " + std::to_string(kMaxFingers));
  }
  for (int i = 0; i < message.fingers_size(); ++i) {
    frame.fingers[static_cast<std::size_t>(i)] = FromProto(message.fingers(i));
  }
  return frame;
}

void ToProto(const Scene& scene, v1::SenseStep::Settings* message) {
  message->set_kind(scene.model.kind);
  message->set_young_modulus(scene.object.material.young_modulus);
}

Eigen::Vector3d RecordedPosition(const v1::Vec3& message) {
  std::string reason;
  FieldReader reader(&reason);
  const Eigen::Vector3d position = reader.Vector("a recorded position", message, kMaxLength);
  if (!reader.ok()) throw InputError(reason);
  return position;
}

Time RecordedTime(const google::protobuf::Timestamp& message) {
  std::string reason;
  FieldReader reader(&reason);
  const Time time = reader.Stamp("a recorded time", message);
  if (!reader.ok()) throw InputError(reason);
  return time;
}

}  // namespace palpate
