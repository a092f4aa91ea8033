// What a recording keeps of the slave beside its states: what it says of itself, each sample's
// way through it, pictures and the object's shape twice a second, its health once a second. On a
// connection of its own.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <google/protobuf/message.h>

namespace palpate {

class BulkWatch {
 public:
  struct Options {
    std::string target;         // HOST:PORT
    bool insecure = false;      // allow targets that are not loopback, in plain text
    std::filesystem::path tls;  // the folder of our certificate; empty: plain text
  };
  static constexpr double kPictureRate = 2, kMeshRate = 2;  // [Hz]
  static constexpr int kQuality = 75;                       // of the pictures, JPEG

  // A SceneDescription, Capabilities, Status, VideoFrame, MeshState or TraceUpdate. By several
  // threads.
  using OnMessage = std::function<void(const google::protobuf::Message&)>;

  // Keeps asking, reconnecting with back-off, until it ends. Throws std::invalid_argument: target
  // not understood, or not loopback without `insecure`.
  BulkWatch(const Options& options, OnMessage on_message);
  ~BulkWatch();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
