#include "slave/simulator/program/driver_messages.h"

#include "shared/wire/fields.h"

namespace palpate {
namespace {

v1::CameraPicture::Encoding EncodingOf(const cv::Mat& image) {
  if (image.depth() == CV_16U) return v1::CameraPicture::ENCODING_GREY16;
  return image.channels() == 3 ? v1::CameraPicture::ENCODING_BGR8
                               : v1::CameraPicture::ENCODING_GREY8;
}

void Put(const cv::Mat& image, v1::CameraPicture* message) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  message->set_encoding(EncodingOf(whole));
  message->set_data(whole.data, whole.total() * whole.elemSize());
  message->set_width(static_cast<unsigned>(whole.cols));
  message->set_height(static_cast<unsigned>(whole.rows));
}

}  // namespace

v1::PictureSample ToMessage(const Frame& frame) {
  v1::PictureSample message;
  message.set_sequence(frame.sequence);
  ToProto(frame.sensed_at, message.mutable_sensed_at());
  Put(frame.image, message.mutable_picture());
  return message;
}

v1::PictureSample ToMessage(const StereoPair& pair) {
  v1::PictureSample message;
  message.set_sequence(pair.sequence);
  ToProto(pair.sensed_at, message.mutable_sensed_at());
  Put(pair.left, message.mutable_picture());
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
    message.mutable_electrodes()->Assign(reading.electrodes.begin(), reading.electrodes.end());
    message.add_pressure(reading.pdc);
    message.add_pressure(reading.pac);
  }
  return messages;
}

}  // namespace palpate
