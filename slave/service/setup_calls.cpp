// ProposeScene, UseScene, FindOutline, FindBoard.
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/capture/bounded_image.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/live/scene_setup.h"
#include "slave/service/messages.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

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

Eigen::Vector2d FromProto(const v1::ImagePoint& p) {
  return {p.u(), p.v()};
}

void ToProto(const Eigen::Vector2d& p_I, v1::ImagePoint* message) {
  message->set_u(p_I.x());
  message->set_v(p_I.y());
}

BoardImages ToBoard(const v1::FindBoardRequest& request) {
  constexpr std::uint32_t kMinCorners = 3, kMaxCorners = 100;
  constexpr double kMaxSquare = 1;  // [m]
  const auto is_count = [](std::uint32_t n) { return n >= kMinCorners && n <= kMaxCorners; };
  if (!is_count(request.columns()) || !is_count(request.rows())) {
    throw std::invalid_argument("columns, rows = " + std::to_string(request.columns()) + ", " +
                                std::to_string(request.rows()) + ": expected 3 to 100 each");
  }
  if (!(request.square() >= 1e-6 && request.square() <= kMaxSquare)) {
    throw std::invalid_argument(
        Formatted("square = %g m: expected 1e-6 to %g", request.square(), kMaxSquare));
  }
  return {{request.images().begin(), request.images().end()},
          static_cast<int>(request.columns()),
          static_cast<int>(request.rows()),
          request.square()};
}

// Reports mistakes that a person can correct as errors of the request.
template <class Work>
auto AsRequest(const Work& work) {
  try {
    return work();
  } catch (const Interrupted&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace

grpc::Status TeleoperationService::SetUp(grpc::ServerContext* context,
                                         const std::function<void(SceneSetup&, Progress*)>& work) {
  return change_.Run(*context, [&](Progress* progress) {
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
    const auto prepared = setup.Prepare(FromProto(*request), progress);
    SlaveDescription description = prepared->Describe();
    description.settings_revision += slave_.Describe().settings_revision;
    ToProto(description, reply);
    lease_.Close();
    try {
      prepared->Use();
    } catch (...) {
      lease_.Reopen();
      throw;
    }
  });
}

grpc::Status TeleoperationService::FindOutline(grpc::ServerContext* context,
                                               const v1::FindOutlineRequest* request,
                                               v1::FindOutlineReply* reply) {
  return SetUp(context, [&](SceneSetup& setup, Progress* progress) {
    const cv::Mat image = AsRequest([&] {
      return request->image().empty() ? setup.StartImage(StopOf(progress))
                                      : DecodeBounded(request->image());
    });
    ReportProgress(progress, "outline", 0.5);
    Curve near;
    for (const v1::ImagePoint& p : request->near()) near.push_back(FromProto(p));
    const FoundOutline found = AsRequest([&] { return setup.FindOutline(image, near); });
    for (const Eigen::Vector2d& p : found.polygon) ToProto(p, reply->add_outline());
    reply->set_clear(found.clear);
    reply->set_width(static_cast<std::uint32_t>(image.cols));
    reply->set_height(static_cast<std::uint32_t>(image.rows));
  });
}

grpc::Status TeleoperationService::FindBoard(grpc::ServerContext* context,
                                             const v1::FindBoardRequest* request,
                                             v1::FindBoardReply* reply) {
  return SetUp(context, [&](SceneSetup& setup, Progress* progress) {
    const BoardImages board = ToBoard(*request);
    const FoundBoard found = AsRequest([&] { return setup.FindBoard(board, progress); });
    for (const Eigen::Vector2d& p : found.corners) ToProto(p, reply->add_corners());
    reply->set_pixel(found.pixel);
    reply->set_rms_px(found.rms_px);
    reply->set_lens(found.lens);
    reply->set_remark(found.remark);
    if (!found.straight.empty()) reply->set_straight(EncodePng(found.straight));
  });
}

}  // namespace palpate
