#include "slave/simulator/program/driver_messages.h"

#include <variant>

#include "shared/wire/fields.h"

namespace palpate {
namespace {

v1::Image::Encoding EncodingOf(const cv::Mat& image) {
  if (image.depth() == CV_16U) return v1::Image::ENCODING_GREY16;
  return image.channels() == 3 ? v1::Image::ENCODING_BGR8 : v1::Image::ENCODING_GREY8;
}

void Put(const cv::Mat& image, v1::Image* message) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  message->set_encoding(EncodingOf(whole));
  message->set_data(whole.data, whole.total() * whole.elemSize());
  message->set_width(static_cast<unsigned>(whole.cols));
  message->set_height(static_cast<unsigned>(whole.rows));
}

// Steps from the centre of a membrane to its rim [-]. [measured on rubber-membrane: with 100 the
// rms of the displacement error changes by 0.12 %, the largest by 1 %]
constexpr int kHalfGrid = 50;

void Put(const Eigen::Isometry3d& pose, v1::Vec3* position,
         google::protobuf::RepeatedField<double>* orientation) {
  ToProto(pose.translation(), position);
  ToProto(Eigen::Quaterniond(pose.linear()), orientation);
}

void Put(const FingerTruth& finger, v1::SimulatedFingertip* message) {
  Put(finger.X_SF, message->mutable_p_s_finger(), message->mutable_orientation());
  message->set_in_contact(finger.in_contact);
  ToProto(finger.p_S_contact, message->mutable_p_s_contact());
  ToProto(finger.force, message->mutable_force());
  message->set_depth(finger.depth);
}

void Put(const TargetTruth& target, v1::SimulatedTarget* message) {
  message->set_seconds(target.seconds);
  Put(target.X_SB_first, message->mutable_p_s_first(), message->mutable_orientation_first());
  Put(target.X_SB, message->mutable_p_s(), message->mutable_orientation());
}

void Put(const GroundTruth& truth, double radius, v1::DisplacementGrid* message) {
  message->set_half_width(radius);
  for (int y = -kHalfGrid; y <= kHalfGrid; ++y) {
    for (int x = -kHalfGrid; x <= kHalfGrid; ++x) {
      const Eigen::Vector2d p_O = radius / kHalfGrid * Eigen::Vector2d(x, y);
      for (const double part : truth.TrueDisplacement(p_O)) {
        message->add_displacements(static_cast<float>(part));
      }
    }
  }
}

}  // namespace

v1::ImageSample ToMessage(const Frame& frame) {
  v1::ImageSample message;
  message.set_sequence(frame.sequence);
  ToProto(frame.sensed_at, message.mutable_sensed_at());
  Put(frame.image, message.mutable_image());
  return message;
}

v1::ImageSample ToMessage(const StereoPair& pair) {
  v1::ImageSample message;
  message.set_sequence(pair.sequence);
  ToProto(pair.sensed_at, message.mutable_sensed_at());
  Put(pair.left, message.mutable_image());
  if (!pair.right.empty()) Put(pair.right, message.mutable_right());
  return message;
}

std::vector<v1::TactileSample> ToMessages(const TactileFrame& frame,
                                          const std::vector<Finger>& fingers) {
  std::vector<v1::TactileSample> messages;
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    const FingerReading& reading = frame.fingers[i];
    v1::TactileSample& message = messages.emplace_back();
    message.set_sequence(frame.sequence);
    ToProto(frame.sensed_at, message.mutable_sensed_at());
    message.set_finger(fingers[i].name);
    message.mutable_electrodes()->Assign(reading.channels.begin(), reading.channels.end());
    message.add_pressure(reading.pdc);
    message.add_pressure(reading.pac);
  }
  return messages;
}

void PutTruth(const GroundTruth& truth, const Scene& scene, v1::SimulatedTruth* message) {
  const Truth now = truth.truth();
  ToProto(now.p_S_tip, message->mutable_p_s_tip());
  ToProto(now.force, message->mutable_force());
  message->set_depth(now.depth);
  message->set_in_contact(now.in_contact);
  message->set_solved(now.solved);
  message->set_punctured(now.punctured);
  if (const auto* tactile = scene.sense.Find<Tactile>()) {
    for (std::size_t i = 0; i < tactile->fingers.size(); ++i) {
      Put(now.fingers[i], message->add_fingertips());
    }
  }
  if (const auto target = truth.target()) Put(*target, message->mutable_target());
  if (const auto goal = truth.goal()) ToProto(*goal, message->mutable_goal());
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    Put(truth, membrane->radius, message->mutable_membrane());
  }
}

void PutSurface(const SurfaceMesh& surface, bool with_triangles, v1::SimulatedTruth* message) {
  for (const Eigen::Vector3d& p_S : surface.nodes) {
    for (const double x : p_S) message->add_surface_nodes(static_cast<float>(x));
  }
  if (!with_triangles) return;
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) message->add_surface_triangles(node);
  }
}

}  // namespace palpate
