#include "master/link/operator_calls.h"

#include "master/link/channel.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kModelDeadline(15000);

}  // namespace

void SetDeadline(grpc::ClientContext* context, milliseconds from_now) {
  context->set_deadline(std::chrono::system_clock::now() + from_now);
}

std::string Refusal(const grpc::Status& status) {
  if (status.ok()) return {};
  if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED) {
    return "the slave's release does not support this: install the same release at both ends";
  }
  const std::string words = WordsOf(status);
  return words.empty() ? "rejected without a reason" : words;
}

OperatorCalls::Scope::Scope(OperatorCalls* calls, grpc::ClientContext* context)
    : calls_(calls), context_(context) {
  const std::scoped_lock lock(calls_->mutex_);
  calls_->running_.insert(context_);
  if (calls_->is_over_) context_->TryCancel();
}

OperatorCalls::Scope::~Scope() {
  const std::scoped_lock lock(calls_->mutex_);
  calls_->running_.erase(context_);
}

void OperatorCalls::End() {
  const std::scoped_lock lock(mutex_);
  is_over_ = true;
  for (grpc::ClientContext* call : running_) call->TryCancel();
}

void OperatorCalls::Announce(grpc::ClientContext* call, grpc::ClientContext** place) {
  const std::scoped_lock lock(mutex_);
  *place = call;
}

void OperatorCalls::Cancel(grpc::ClientContext* const* place) {
  const std::scoped_lock lock(mutex_);
  if (*place != nullptr) (*place)->TryCancel();
}

std::uint64_t OperatorCalls::EmergencyStop(const std::string& reason) {
  grpc::ClientContext context;
  SetDeadline(&context, deadline_);
  v1::StopRequest request;
  request.set_reason(reason);
  v1::Status reply;
  Announce(&context, &stop_call_);
  const bool acted = stub_->Stop(&context, request, &reply).ok();
  Announce(nullptr, &stop_call_);
  return acted ? reply.stops() : 0;
}

void OperatorCalls::GiveUpStop() {
  Cancel(&stop_call_);
}

std::string OperatorCalls::Reset(std::uint64_t stops) {
  grpc::ClientContext context;
  SetDeadline(&context, deadline_);
  const Scope runs(this, &context);
  v1::ResetRequest request;
  request.set_stops(stops);
  v1::Status reply;
  Announce(&context, &reset_call_);
  const grpc::Status status = stub_->Reset(&context, request, &reply);
  Announce(nullptr, &reset_call_);
  if (status.error_code() == grpc::StatusCode::CANCELLED) return "a stop was requested meanwhile";
  return Refusal(status);
}

void OperatorCalls::CancelReset() {
  Cancel(&reset_call_);
}

std::string OperatorCalls::ReinitializeTracking() {
  grpc::ClientContext context;
  SetDeadline(&context, deadline_);
  const Scope runs(this, &context);
  v1::Status reply;
  return Refusal(stub_->ReinitializeTracking(&context, {}, &reply));
}

std::string OperatorCalls::SetMapping(const SlaveLink::Mapping& mapping) {
  grpc::ClientContext context;
  SetDeadline(&context, deadline_);
  v1::SetParametersRequest request;
  if (mapping.position_scale) request.set_position_scale(*mapping.position_scale);
  if (mapping.force_scale) request.set_force_scale(*mapping.force_scale);
  if (mapping.force_limit) request.set_force_limit(*mapping.force_limit);
  if (mapping.young_modulus) request.set_young_modulus(*mapping.young_modulus);
  const Scope runs(this, &context);
  v1::SettingsReply reply;
  return Refusal(stub_->SetParameters(&context, request, &reply));
}

std::string OperatorCalls::SetModel(const std::string& kind) {
  grpc::ClientContext context;
  SetDeadline(&context, kModelDeadline);
  v1::SetModelRequest request;
  request.set_kind(kind);
  const Scope runs(this, &context);
  v1::SettingsReply reply;
  return Refusal(stub_->SetModel(&context, request, &reply));
}

}  // namespace palpate
