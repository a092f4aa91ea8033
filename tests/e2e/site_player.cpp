// Simulates a site for a slave that cannot tell it from a real one. The images or tactile samples
// go without loss through FeedImages or FeedTactile, or to any client that connects as a stream of
// raw images. An arm's driver sends the position of the simulated tool by UDP and receives the
// force in return.
//   site_player SCENE HOST:PORT      feeds that slave
//   site_player SCENE y4m | raw      serves images by TCP, pairs side by side: YUV4MPEG2, which
//                                    FFmpeg knows by its first line, or bare rows of 8 bit grey
// Prints `site on HOST:PORT`, where it receives the tool's position, then `images on HOST:PORT`
// where it serves them, and plays until SIGTERM.
#include <cstdio>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <grpcpp/grpcpp.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <opencv2/core.hpp>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/wire/fields.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/simulator/program/driver_messages.h"
#include "slave/simulator/program/tool_socket.h"

namespace palpate {
namespace {

// Opens a socket on a free local port and prints it as `what on HOST:PORT`.
int SocketHere(int type, const char* what) {
  const int made = socket(AF_INET, type, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  bind(made, reinterpret_cast<sockaddr*>(&here), size);
  getsockname(made, reinterpret_cast<sockaddr*>(&here), &size);
  if (type == SOCK_STREAM) listen(made, 1);
  std::printf("%s on 127.0.0.1:%d\n", what, ntohs(here.sin_port));
  std::fflush(stdout);
  return made;
}

// The images in sequence; of a camera pair, the left image and then the right one.
class Images {
 public:
  Images(SimulatedEnvironment& environment, const Scene& scene)
      : camera_(HasStereoOrDepth(scene.sense) ? nullptr : environment.OpenCamera(scene, {})),
        pair_(HasStereoOrDepth(scene.sense) ? environment.OpenPair(scene, {}) : nullptr) {}

  struct Shot {
    std::vector<cv::Mat> images;
    Time sensed_at{};
  };
  Shot Next() {
    if (pair_ == nullptr) {
      const auto frame = camera_->Next({});
      return {{frame->image}, frame->sensed_at};
    }
    const auto pair = pair_->Next({});
    if (pair->right.empty()) return {{pair->left}, pair->sensed_at};
    return {{pair->left, pair->right}, pair->sensed_at};
  }

 private:
  std::unique_ptr<FrameSource> camera_;
  std::unique_ptr<StereoSource> pair_;
};

// Serves one reader at a time. Images that a reader does not take at once are dropped, so that no
// old image waits in a queue.
void Serve(Images images, bool is_y4m) {
  const int door = SocketHere(SOCK_STREAM, "images");
  for (;;) {
    const int reader = accept(door, nullptr, nullptr);
    const int at_once = 1;
    setsockopt(reader, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
    const auto send_all = [reader](const std::string& bytes) {
      for (std::size_t sent = 0; sent < bytes.size();) {
        const auto part = send(reader, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (part <= 0) return false;
        sent += static_cast<std::size_t>(part);
      }
      return true;
    };
    for (bool is_first = true;; is_first = false) {
      cv::Mat image;
      cv::hconcat(images.Next().images, image);
      std::string bytes;
      if (is_y4m && is_first) {
        bytes = "YUV4MPEG2 W" + std::to_string(image.cols) + " H" + std::to_string(image.rows) +
                " F30:1 Ip A1:1 Cmono\n";
      }
      if (is_y4m) bytes += "FRAME\n";
      bytes.append(reinterpret_cast<const char*>(image.data), image.total());
      int waiting = 0;
      if (ioctl(reader, SIOCOUTQ, &waiting) != 0 || waiting > 0) continue;
      if (!send_all(bytes)) break;
    }
    close(reader);
  }
}

template <typename Sample>
int Finish(grpc::ClientWriter<Sample>* writer) {
  std::fprintf(stderr, "%s\n", writer->Finish().error_message().c_str());
  return 1;
}

int FeedImages(Images images, v1::Teleoperation::Stub* stub) {
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  v1::FeedImagesReply reply;
  const auto writer = stub->FeedImages(&context, &reply);
  v1::ImageSample sample;
  do {
    const auto shot = images.Next();
    const cv::Mat right = shot.images.size() > 1 ? shot.images.back() : cv::Mat();
    sample =
        ToMessage(StereoPair{shot.images.front(), right, sample.sequence() + 1, shot.sensed_at, 0});
  } while (writer->Write(sample));
  return Finish(writer.get());
}

int FeedTactile(SimulatedEnvironment& environment, const Scene& scene,
                v1::Teleoperation::Stub* stub) {
  const auto source = environment.OpenFingertips(scene, {});
  const auto& fingers = scene.sense.Find<Tactile>()->fingers;
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  v1::FeedTactileReply reply;
  const auto writer = stub->FeedTactile(&context, &reply);
  for (bool is_taken = true; is_taken;) {
    const auto frame = source->Next({});
    for (const auto& sample : ToMessages(*frame, fingers)) {
      is_taken = is_taken && writer->Write(sample);
    }
  }
  return Finish(writer.get());
}

int Play(const std::string& file, const std::string& to) {
  const Scene scene = LoadScene(file, {});
  const auto environment = MakeSimulatedEnvironment(scene);
  environment->SolveAhead();
  environment->MoveTool(scene.manipulator.home, WhenUnsolved::kUseNearest);
  const ToolSocket tool(*environment);
  std::printf("site on %s\n", tool.address().c_str());
  std::fflush(stdout);
  if (to == "y4m" || to == "raw") Serve(Images(*environment, scene), to == "y4m");
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  const auto stub = v1::Teleoperation::NewStub(
      grpc::CreateCustomChannel(to, grpc::InsecureChannelCredentials(), arguments));
  if (scene.sense.Find<Tactile>()) return FeedTactile(*environment, scene, stub.get());
  return FeedImages(Images(*environment, scene), stub.get());
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: site_player SCENE HOST:PORT|y4m|raw\n");
    return 2;
  }
  try {
    return palpate::Play(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
