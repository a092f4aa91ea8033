#include "slave/live/driver_messages.h"

#include <algorithm>

#include "shared/text/text.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr double kMaxCoordinate = 100;        // [m]
constexpr double kMaxImageDelay = 1;          // of an image [s]
constexpr std::size_t kMaxFaultLength = 200;  // [characters]

std::optional<PushedImage> Pushed(const v1::Image& message, std::string_view name,
                                  FieldReader* reader) {
  using Encoding = PushedImage::Encoding;
  PushedImage pushed{.data = &message.data(), .width = message.width(), .height = message.height()};
  const int encoding = message.encoding();
  const bool is_known =
      encoding >= v1::Image::ENCODING_JPEG && encoding <= v1::Image::ENCODING_GREY16;
  reader->Require(is_known, std::string(name) + ".encoding = " + std::to_string(encoding),
                  "JPEG, PNG, GREY8, BGR8 or GREY16");
  if (!is_known) return std::nullopt;
  pushed.encoding = static_cast<Encoding>(encoding - v1::Image::ENCODING_JPEG);
  return pushed;
}

std::optional<Eigen::Isometry3d> ReadPose(const v1::TactileSample& message, FieldReader* reader) {
  if (!message.has_p_s_finger() && message.orientation().empty()) return std::nullopt;
  reader->Require(message.has_p_s_finger(), "p_S_finger is absent",
                  "a position with an orientation");
  reader->Require(!message.orientation().empty(), "orientation is absent",
                  "an orientation with p_S_finger");
  if (!reader->ok()) return std::nullopt;
  const Eigen::Vector3d p_S = reader->Vector("p_S_finger", message.p_s_finger(), kMaxLength);
  const auto R_SF = reader->Rotation("orientation", message.orientation());
  if (!reader->ok()) return std::nullopt;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate(p_S).rotate(*R_SF);
  return X_SF;
}

}  // namespace

std::optional<PushedSample> FromProto(const v1::ImageSample& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(message.has_image(), "image is absent", "an image");
  if (!reader.ok()) return std::nullopt;
  PushedSample sample;
  sample.sequence = message.sequence();
  sample.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  if (const auto image = Pushed(message.image(), "image", &reader)) sample.image = *image;
  if (message.has_right()) sample.right = Pushed(message.right(), "right", &reader);
  if (message.has_right_sensed_at()) {
    sample.right_sensed_at = reader.Stamp("right_sensed_at", message.right_sensed_at());
  }
  sample.delay = reader.NonNegative("delay", message.delay(), kMaxImageDelay);
  if (!reader.ok()) return std::nullopt;
  return sample;
}

std::optional<ArmReading> FromProto(const v1::ArmReport& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.sequence() != 0, "sequence = 0", "one above the last, from 1");
  reader.Require(message.has_measured_at(), "measured_at is absent", "a time");
  reader.Require(message.has_p_s_tip(), "p_S_tip is absent", "the position of the tool tip");
  if (!reader.ok()) return std::nullopt;
  ArmReading reading;
  reading.sequence = message.sequence();
  reading.measured_at = reader.Stamp("measured_at", message.measured_at());
  reading.p_S_tip = reader.Vector("p_S_tip", message.p_s_tip(), kMaxCoordinate);
  if (message.has_measured_force()) {
    reading.force = reader.Vector("measured_force", message.measured_force(), kMaxForce);
  }
  reading.R_S_tool = reader.Rotation("orientation", message.orientation());
  reading.at_limit = message.at_limit();
  reading.fault = Presentable(message.fault(), kMaxFaultLength);
  if (!reader.ok()) return std::nullopt;
  return reading;
}

std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason) {
  constexpr int kMaxPressures = 2;  // pdc, pac0
  const auto& electrodes = message.electrodes();
  const auto& pressure = message.pressure();
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(electrodes.size() >= 1 && electrodes.size() <= kMaxChannels,
                 std::to_string(electrodes.size()) + " channels",
                 "1 to " + std::to_string(kMaxChannels));
  reader.Require(pressure.size() <= kMaxPressures, std::to_string(pressure.size()) + " pressures",
                 "at most two: pdc, pac0");
  if (!reader.ok()) return std::nullopt;
  TactileSample sample;
  sample.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  sample.reading.channels.resize(static_cast<std::size_t>(electrodes.size()));
  std::copy(electrodes.begin(), electrodes.end(), sample.reading.channels.begin());
  if (pressure.size() > 0) sample.reading.pdc = pressure[0];
  if (pressure.size() > 1) sample.reading.pac = pressure[1];
  sample.reading.X_SF = ReadPose(message, &reader);
  if (!reader.ok()) return std::nullopt;
  return sample;
}

}  // namespace palpate
