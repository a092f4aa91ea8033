// Plays a simulated site to a slave that takes it for a real one: its pictures go without loss
// through FeedPictures, and the tool in it is where an arm's driver says by UDP, whom it answers
// with the force.
//   site_player SCENE HOST:PORT
// Prints `site on HOST:PORT`, where it hears of the tool, and plays until SIGTERM.
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <grpcpp/grpcpp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/wire/fields.h"
#include "slave/scene/scene_loader.h"
#include "slave/site/world.h"

namespace palpate {
namespace {

void Put(const cv::Mat& picture, v1::CameraPicture* message) {
  const bool is_deep = picture.depth() == CV_16U;
  message->set_encoding(is_deep                   ? v1::CameraPicture::ENCODING_GREY16
                        : picture.channels() == 3 ? v1::CameraPicture::ENCODING_BGR8
                                                  : v1::CameraPicture::ENCODING_GREY8);
  const cv::Mat whole = picture.isContinuous() ? picture : picture.clone();
  message->set_data(whole.data, whole.total() * whole.elemSize());
  message->set_width(static_cast<unsigned>(picture.cols));
  message->set_height(static_cast<unsigned>(picture.rows));
}

// The tool's place in, the force on it out.
class ToolSocket {
 public:
  explicit ToolSocket(World& world) : world_(world), socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    bind(socket_, reinterpret_cast<sockaddr*>(&here), size);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size);
    const timeval patience{0, 100'000};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::printf("site on 127.0.0.1:%d\n", ntohs(here.sin_port));
    std::fflush(stdout);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) Answer();
    });
  }
  ~ToolSocket() {
    thread_ = {};
    close(socket_);
  }

 private:
  void Answer() {
    char text[200] = "";
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto got =
        recvfrom(socket_, text, sizeof text - 1, 0, reinterpret_cast<sockaddr*>(&from), &size);
    Eigen::Vector3d p(0, 0, 0);
    if (got <= 0 || std::sscanf(text, "%lf %lf %lf", &p.x(), &p.y(), &p.z()) != 3) return;
    world_.MoveTool(p, Patience::kNone);
    const Truth truth = world_.truth();
    if (!truth.solved) return;
    const int length = std::snprintf(text, sizeof text, "%.9g %.9g %.9g", truth.force.x(),
                                     truth.force.y(), truth.force.z());
    sendto(socket_, text, static_cast<std::size_t>(length), 0, reinterpret_cast<sockaddr*>(&from),
           size);
  }

  World& world_;
  const int socket_;
  std::jthread thread_;
};

int Play(const std::string& file, const std::string& address) {
  const Scene scene = LoadScene(file, {});
  const auto world = MakeWorld(scene);
  world->SolveAhead();
  world->MoveTool(scene.manipulator.home, Patience::kNone);
  const bool is_pair = HasEyes(scene.sense);
  const auto camera = is_pair ? nullptr : world->OpenCamera(scene, {});
  const auto eyes = is_pair ? world->OpenPair(scene, {}) : nullptr;
  const ToolSocket tool(*world);

  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  const auto stub = v1::Teleoperation::NewStub(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  v1::FeedPicturesReply reply;
  const auto writer = stub->FeedPictures(&context, &reply);
  v1::PictureSample sample;
  for (;;) {
    sample.set_sequence(sample.sequence() + 1);
    if (is_pair) {
      const auto pair = eyes->Next({});
      Put(pair->left, sample.mutable_picture());
      if (!pair->right.empty()) Put(pair->right, sample.mutable_right());
      ToProto(pair->sensed_at, sample.mutable_sensed_at());
    } else {
      const auto frame = camera->Next({});
      Put(frame->image, sample.mutable_picture());
      ToProto(frame->sensed_at, sample.mutable_sensed_at());
    }
    if (!writer->Write(sample)) break;
  }
  std::fprintf(stderr, "%s\n", writer->Finish().error_message().c_str());
  return 1;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: site_player SCENE HOST:PORT\n");
    return 2;
  }
  try {
    return palpate::Play(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
