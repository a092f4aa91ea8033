// palpate-master: the operator's station.
#include <array>
#include <chrono>
#include <climits>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <pwd.h>
#include <unistd.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/commands/arguments.h"
#include "master/commands/devices_command.h"
#include "master/commands/operate.h"
#include "master/link/channel.h"
#include "master/link/slave_link.h"
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// Ends the lease of the slave's operator because of `reason`, and returns the operator's name.
// Throws std::runtime_error: no answer within `link.wait`, no operator, or not permitted.
std::string EvictOperator(const SlaveLink::Options& link, const std::string& reason) {
  const auto target = PermittedTarget(link.target, link.insecure || !link.tls.empty());
  const auto stub = v1::Teleoperation::NewStub(OpenChannel(target, Traffic::kTicks, link.tls));
  const auto deadline = std::chrono::system_clock::now() +
                        std::chrono::milliseconds(static_cast<int>(1000 * link.wait));
  const auto require = [](const grpc::Status& status) {
    if (!status.ok()) throw std::runtime_error(WordsOf(status));
  };
  grpc::ClientContext first, second;
  first.set_deadline(deadline);
  first.set_wait_for_ready(true);
  second.set_deadline(deadline);
  v1::Status status, after;
  require(stub->GetStatus(&first, {}, &status));
  v1::EvictOperatorRequest request;
  request.set_reason(reason);
  require(stub->EvictOperator(&second, request, &after));
  return status.operator_name();
}

constexpr int kDone = 0, kFailed = 1, kUnusable = 2;

// Runs `replay` until a signal comes.
int ShowRecording(const Arguments& a) {
  CatchSignals();
  std::stop_source source;
  const std::jthread watch([&](const std::stop_token& done) {
    while (!done.stop_requested() && !g_stop) std::this_thread::sleep_for(kSignalPoll);
    source.request_stop();
  });
  return RunReplay(a.replay, ViewPlace(a.view, a.link.tls), source.get_token());
}

int Evict(const Arguments& a) {
  try {
    const std::string name = EvictOperator(a.link, a.reason);
    std::printf("evicted %s\n", name.empty() ? "the operator" : name.c_str());
    return kDone;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "palpate-master: %s: %s\n", a.link.target.c_str(), error.what());
    return kFailed;
  }
}

// Returns for example `ada@desk`.
std::string NameOfUser() {
  const passwd* user = getpwuid(getuid());
  std::array<char, HOST_NAME_MAX + 1> host{};
  gethostname(host.data(), host.size() - 1);
  return std::string(user != nullptr ? user->pw_name : "operator") + "@" + host.data();
}

int Main(int argc, char** argv) {
  Arguments a;
  DoctorArguments doctor;
  CLI::App app("palpate-master: operates a slave and renders its contact force");
  Declare(&app, &a, &doctor);
  std::unique_ptr<ConnectRecorder> recorder;  // outlives the link
  std::unique_ptr<Line> line;
  std::unique_ptr<Device> device;
  try {
    app.parse(argc, argv);
    if (app.got_subcommand("doctor")) {
      RequireTimely(doctor.link.tls);
      if (!doctor.link.target.empty()) doctor.options.line = doctor.link;
      return RunDoctor(doctor.options);
    }
    if (app.got_subcommand("devices")) return ListDevices();
    if (app.got_subcommand("replay")) return ShowRecording(a);
    if (app.got_subcommand("evict")) return Evict(a);
    CheckBeforehand(a);
    if (FindInvalidUtf8(a.link.operator_name) != std::string::npos) {
      throw std::invalid_argument("the operator's name: expected UTF-8");
    }
    if (a.link.operator_name.empty()) a.link.operator_name = NameOfUser();
    NameCalls(a.link.operator_name);
    if (!a.record.empty()) {
      recorder =
          std::make_unique<ConnectRecorder>(a.record, a.record_limit, a.record_part, &a.link);
    }
    a.link.details = a.views;
    line = std::make_unique<Line>(a.link);
    if (!IsMadeForScene(a)) device = OpenDevice(a.device, 0, 0);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUnusable;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate-master: %s\n", error.what());
    return kUnusable;
  }
  CatchSignals();
  try {
    return Operate(a, line.get(), std::move(device), recorder.get());
  } catch (const std::exception& error) {
    if (g_stop) return kDone;  // before anything moved
    std::fprintf(stderr, "palpate-master: %s\n", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  const int code = palpate::Main(argc, argv);
  if (code != palpate::kDone || !palpate::OutputIsOnFullDisk()) return code;
  std::fputs("palpate-master: standard output cannot be written\n", stderr);
  return palpate::kFailed;
}
