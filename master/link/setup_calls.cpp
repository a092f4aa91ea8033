#include "master/link/setup_calls.h"

#include <chrono>
#include <utility>

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include "master/link/stream_keeper.h"
#include "shared/wire/errors.h"
#include "shared/wire/message_json.h"

namespace palpate {
namespace {

// The check of a scene with `model.kind: auto` takes long.
constexpr std::chrono::seconds kCallWithin(90);
constexpr std::chrono::seconds kImageWithin(5);  // two images of a camera
constexpr std::uint32_t kBestQuality = 100;      // of a JPEG: the tip's template is cut from it

using Stub = v1::Teleoperation::Stub;

int HttpStatusOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::INVALID_ARGUMENT:
      return 400;
    case grpc::StatusCode::PERMISSION_DENIED:
    case grpc::StatusCode::UNAUTHENTICATED:
      return 403;
    case grpc::StatusCode::FAILED_PRECONDITION:
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::UNIMPLEMENTED:
      return 409;
    default:
      return 502;
  }
}

// Returns the name of the ErrorReason without its prefix; empty: the status has none.
std::string ReasonName(const grpc::Status& status) {
  constexpr std::string_view kPrefix = "ERROR_REASON_";
  const v1::ErrorReason reason = ReasonOf(status);
  if (reason == v1::ERROR_REASON_UNSPECIFIED) return {};
  return v1::ErrorReason_Name(reason).substr(kPrefix.size());
}

// The codes of a connection that failed or was rejected, which carry no reason; others are empty.
std::string_view CodeName(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return "DEADLINE_EXCEEDED";
    case grpc::StatusCode::UNAVAILABLE:
      return "UNAVAILABLE";
    case grpc::StatusCode::PERMISSION_DENIED:
      return "PERMISSION_DENIED";
    case grpc::StatusCode::UNAUTHENTICATED:
      return "UNAUTHENTICATED";
    default:
      return "";
  }
}

std::string ErrorJson(std::string_view why, std::string_view reason, std::string_view code) {
  google::protobuf::Struct answer;
  (*answer.mutable_fields())["error"].set_string_value(std::string(why));
  if (!reason.empty()) (*answer.mutable_fields())["reason"].set_string_value(std::string(reason));
  if (!code.empty()) (*answer.mutable_fields())["code"].set_string_value(std::string(code));
  return JsonOf(answer);
}

SetupCalls::Answer AnswerOf(const grpc::Status& status, const google::protobuf::Message& reply) {
  if (status.ok()) return {200, JsonOf(reply)};
  const std::string words = WordsOf(status);
  return {HttpStatusOf(status.error_code()),
          ErrorJson(words.empty() ? "rejected without a reason" : words, ReasonName(status),
                    CodeName(status.error_code()))};
}

class TimedCall {
 public:
  explicit TimedCall(const std::stop_token& stop, std::chrono::seconds within = kCallWithin)
      : cancel_(stop, Cancel{&context_}) {
    context_.set_deadline(std::chrono::system_clock::now() + within);
  }
  [[nodiscard]] grpc::ClientContext* context() { return &context_; }

 private:
  struct Cancel {
    grpc::ClientContext* context;
    void operator()() const { context->TryCancel(); }
  };
  grpc::ClientContext context_;
  std::stop_callback<Cancel> cancel_;
};

template <class Request, class Reply>
SetupCalls::Answer MakeCall(Stub* stub,
                            grpc::Status (Stub::*call)(grpc::ClientContext*, const Request&,
                                                       Reply*),
                            const std::string& json, const std::stop_token& stop) {
  Request request;
  const auto read = google::protobuf::util::JsonStringToMessage(json, &request);
  if (!read.ok()) {
    return {400, SetupErrorJson("not understood: expected " + Request::descriptor()->name() +
                                " as JSON: " + std::string(read.message()))};
  }
  TimedCall timed(stop);
  Reply reply;
  const grpc::Status status = (stub->*call)(timed.context(), request, &reply);
  return AnswerOf(status, reply);
}

// The first image of the stream may be the last one that the camera gave before it stopped.
SetupCalls::Answer RequestImage(Stub* stub, const std::stop_token& stop) {
  v1::WatchImagesRequest request;
  request.set_quality(kBestQuality);
  TimedCall timed(stop, kImageWithin);
  const auto reader = stub->WatchImages(timed.context(), request);
  v1::ImageState image;
  const bool has_first = reader->Read(&image);
  if (!has_first || !reader->Read(&image)) {
    const grpc::Status status = reader->Finish();
    const bool is_late = has_first && status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
    return is_late ? SetupCalls::Answer{502, SetupErrorJson("the slave's camera gives no image")}
                   : AnswerOf(status, image);
  }
  timed.context()->TryCancel();
  reader->Finish();
  return AnswerOf(grpc::Status::OK, image);
}

}  // namespace

struct SetupCalls::Parts {
  explicit Parts(const SlaveLink::Options& link) : stub(BulkStub(link)) {}

  const std::unique_ptr<Stub> stub;
};

SetupCalls::SetupCalls(const SlaveLink::Options& link) : parts_(std::make_unique<Parts>(link)) {}
SetupCalls::~SetupCalls() = default;

SetupCalls::Answer SetupCalls::Make(std::string_view name, const std::string& json,
                                    const std::stop_token& stop) const {
  Stub* stub = parts_->stub.get();
  if (name == "propose") return MakeCall(stub, &Stub::ProposeScene, json, stop);
  if (name == "use") return MakeCall(stub, &Stub::UseScene, json, stop);
  if (name == "outline") return MakeCall(stub, &Stub::FindOutline, json, stop);
  if (name == "board") return MakeCall(stub, &Stub::FindBoard, json, stop);
  if (name == "image") return RequestImage(stub, stop);
  return {400, SetupErrorJson("not understood: expected propose, use, outline, board or image")};
}

std::string SetupErrorJson(std::string_view why) {
  return ErrorJson(why, {}, {});
}

}  // namespace palpate
