// Receives what a recording keeps besides states: scene, capabilities, traces, images and shapes
// twice a second, and the status once a second. Uses a separate connection.
#pragma once

#include <functional>
#include <memory>

#include <google/protobuf/message.h>

#include "master/link/slave_link.h"

namespace palpate {

class BulkWatch {
 public:
  static constexpr double kPictureRate = 2, kMeshRate = 2;  // [Hz]
  static constexpr int kQuality = 75;                       // JPEG quality of images

  // Receives a SceneDescription, Capabilities, Status, VideoFrame, MeshState or TraceUpdate. Called
  // by several threads.
  using OnMessage = std::function<void(const google::protobuf::Message&)>;

  // Receives until destruction, reconnecting with back-off. Throws std::invalid_argument for an
  // invalid target, or one beyond loopback without `insecure`.
  BulkWatch(const SlaveLink::Options& link, OnMessage on_message);
  ~BulkWatch();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
