#include "slave/recording/step_messages.h"

#include <algorithm>
#include <cmath>

#include "shared/recording/recording.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"
#include "slave/scene/decided_model.h"

namespace palpate {
namespace {

constexpr int kPoseNumbers = 12;

void ToProto(const FingerReading& reading, v1::FingerSample* message) {
  message->set_present(reading.present);
  message->mutable_electrodes()->Add(reading.electrodes.begin(), reading.electrodes.end());
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
  if (message.electrodes_size() != kElectrodeCount || !is_finite ||
      !(is_posed || message.pose_size() == 0)) {
    throw InputError("a fingertip's sample: accepted are " + std::to_string(kElectrodeCount) +
                     " finite electrodes and a pose of 12 numbers or none");
  }
  reading.present = message.present();
  std::copy(message.electrodes().begin(), message.electrodes().end(), reading.electrodes.begin());
  reading.pac = message.pac();
  reading.pdc = message.pdc();
  if (!is_posed) return reading;
  reading.X_SF = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kPoseNumbers; ++i) (*reading.X_SF)(i / 4, i % 4) = message.pose(i);
  return reading;
}

void ToProto(const FingerState& finger, v1::FingerContact* message) {
  palpate::ToProto(finger.p_S_contact.cast<double>(), message->mutable_p_s_contact());
  if (finger.force) palpate::ToProto(finger.force->cast<double>(), message->mutable_force());
  message->set_in_contact(finger.in_contact);
  message->set_validity(ToProto(finger.validity));
}

}  // namespace

void ToProto(const Eigen::Vector3d& vector, v1::Exact3* message) {
  message->set_x(vector.x());
  message->set_y(vector.y());
  message->set_z(vector.z());
}

void ToProto(const ContactEstimate& felt, v1::FeltState* message) {
  message->Clear();
  message->set_sample(felt.sample);
  message->set_sensed_at_ns(Nanoseconds(felt.sensed_at));
  ToProto(felt.p_S_tip, message->mutable_p_s_tip());
  ToProto(felt.p_S_contact, message->mutable_p_s_contact());
  message->set_depth(felt.depth);
  if (felt.force) ToProto(*felt.force, message->mutable_force());
  message->set_sigma(felt.sigma);
  message->set_validity(ToProto(felt.validity));
  message->set_check(ToProto(felt.check));
  const LocalModel& local = felt.local_model;
  ToProto(local.reference, message->mutable_reference());
  ToProto(local.normal, message->mutable_normal());
  ToProto(local.force, message->mutable_reference_force());
  for (int i = 0; i < 9; ++i) message->add_stiffness(local.stiffness(i / 3, i % 3));
  message->set_valid_radius(local.valid_radius);
  message->set_revision(local.revision);
  message->set_in_contact(local.in_contact);
  ToProto(felt.events, message->mutable_events());
  for (int i = 0; i < felt.finger_count; ++i) {
    ToProto(felt.fingers[static_cast<std::size_t>(i)], message->add_fingers());
  }
  ToProto(felt.details, message->mutable_details());
  if (felt.moment) {
    ToProto(*felt.moment, message->mutable_moment());
    message->set_moment_sigma(felt.moment_sigma);
  }
}

void ToProto(const TactileFrame& frame, v1::TactileInstant* message) {
  message->Clear();
  message->set_sequence(frame.sequence);
  message->set_sensed_at_ns(Nanoseconds(frame.sensed_at));
  message->set_after_gap(frame.after_gap);
  for (const FingerReading& reading : frame.fingers) ToProto(reading, message->add_fingers());
}

TactileFrame FromProto(const v1::TactileInstant& message) {
  TactileFrame frame;
  frame.sequence = message.sequence();
  frame.sensed_at = StampFrom(message.sensed_at_ns());
  frame.after_gap = message.after_gap();
  if (message.fingers_size() > kMaxFingers) {
    throw InputError("a sample of " + std::to_string(message.fingers_size()) +
                     " fingertips: accepted are at most " + std::to_string(kMaxFingers));
  }
  for (int i = 0; i < message.fingers_size(); ++i) {
    frame.fingers[static_cast<std::size_t>(i)] = FromProto(message.fingers(i));
  }
  return frame;
}

void ToProto(const Scene& scene, v1::SenseStep::Settings* message) {
  message->set_kind(scene.model.kind);
  message->set_elements(scene.model.elements);
  message->set_plane(scene.model.plane == Plane::kStress ? "stress" : "strain");
  message->set_contact(std::string(WordOf(scene.model.contact)));
  message->set_young_modulus(scene.object.material.young_modulus);
  if (!scene.model.decision.reason.empty()) message->set_decided(DecidedText(scene));
}

Time StampFrom(std::uint64_t ns) {
  constexpr std::uint64_t kLatest = std::uint64_t{1} << 62;  // in the year 2116
  if (ns > kLatest)
    throw InputError("a stamp of " + std::to_string(ns) + " ns: accepted is before 2116");
  return FromNanoseconds(ns);
}

}  // namespace palpate
