// ProposeScene, UseScene, FindOutline, FindBoard.
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/live/scene_setup.h"
#include "slave/service/messages.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"
#include "slave/vision/outline_finder.h"

namespace palpate {
namespace {

SceneSetup& RequireSetup(Slave& slave) {
  if (SceneSetup* setup = slave.setup()) return *setup;
  throw RejectedCall(v1::ERROR_REASON_NOT_IN_SETUP,
                     "the slave accepts no set-up: expected palpate-slave serve --setup DIR");
}

SceneProposal FromProto(const v1::SceneProposal& message) {
  return {message.scene(), {message.files().begin(), message.files().end()}};
}

void ToProto(const ProposalReport& report, v1::ProposeSceneReply* message) {
  for (const SceneMistake& mistake : report.mistakes) {
    auto* error = message->add_errors();
    error->set_key(mistake.key);
    error->set_value(mistake.value);
    error->set_line(static_cast<std::uint32_t>(mistake.line));
    error->set_message(mistake.message);
    error->set_expected(mistake.expected);
  }
  if (!report.mistakes.empty()) return;
  message->set_report(report.text);
  ToProto(report.description, message->mutable_scene());
  if (!report.contact) return;
  auto* contact = message->mutable_contact();
  contact->set_depth(report.contact->depth);
  contact->set_force(report.contact->force);
  contact->set_largest_depth(report.contact->largest_depth);
  contact->set_update(report.contact->update);
}

cv::Mat Decoded(const std::string& bytes) {
  const Bytes file(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  try {
    auto picture = OpenPng(file);
    if (!picture) picture = OpenJpeg(file);
    if (picture) return picture->Decode();
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string("the image ") + error.what());
  }
  throw std::invalid_argument("image: expected a PNG or JPEG file");
}

// What a person can correct is an error of the request.
template <class Work>
auto AsRequest(const Work& work) {
  try {
    return work();
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace

grpc::Status TeleoperationService::SetUp(grpc::ServerContext* context,
                                         const std::function<void(SceneSetup&, Progress*)>& work) {
  return change_.Make(*context, [&](Progress* progress) {
    SceneSetup& setup = RequireSetup(slave_);
    lease_.RequireFree();
    work(setup, progress);
  });
}

grpc::Status TeleoperationService::ProposeScene(grpc::ServerContext* context,
                                                const v1::SceneProposal* request,
                                                v1::ProposeSceneReply* reply) {
  return SetUp(context, [&](SceneSetup& setup, Progress* progress) {
    ToProto(setup.Check(FromProto(*request), progress), reply);
  });
}

grpc::Status TeleoperationService::UseScene(grpc::ServerContext* context,
                                            const v1::SceneProposal* request,
                                            v1::SceneDescription* reply) {
  return SetUp(context, [&](SceneSetup& setup, Progress* progress) {
    lease_.WhileFree(setup.Prepare(FromProto(*request), progress));
    ToProto(slave_.Describe(), reply);
  });
}

grpc::Status TeleoperationService::FindOutline(grpc::ServerContext* context,
                                               const v1::FindOutlineRequest* request,
                                               v1::FindOutlineReply* reply) {
  return SetUp(context, [&](SceneSetup& setup, Progress* /*progress*/) {
    const cv::Mat image = request->image().empty() ? setup.StartImage() : Decoded(request->image());
    Curve near;
    for (const v1::ImagePoint& p : request->near()) near.emplace_back(p.u(), p.v());
    const FoundOutline found = AsRequest([&] { return FindOutlineNear(image, near); });
    for (const Eigen::Vector2d& p : found.polygon) {
      auto* point = reply->add_outline();
      point->set_u(p.x());
      point->set_v(p.y());
    }
    reply->set_clear(found.clear);
    reply->set_width(static_cast<std::uint32_t>(image.cols));
    reply->set_height(static_cast<std::uint32_t>(image.rows));
  });
}

}  // namespace palpate
