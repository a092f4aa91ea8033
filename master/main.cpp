// palpate-master: the operator's station.
#include <array>
#include <chrono>
#include <climits>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <thread>

#include <pwd.h>
#include <unistd.h>

#include "master/commands/arguments.h"
#include "master/commands/devices_command.h"
#include "master/commands/operate.h"
#include "master/commands/signals.h"
#include "master/link/channel.h"
#include "master/link/evict.h"
#include "shared/program/command_line.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kDone = 0, kFailed = 1, kUnusable = 2;
constexpr auto kSignalPoll = std::chrono::milliseconds(10);

// Runs `replay` or `export` until it is done, or a signal comes.
int ReadRecording(const CLI::App& app, const Arguments& a) {
  CatchSignals();
  std::stop_source source;
  const std::jthread watch([&](const std::stop_token& done) {
    while (!done.stop_requested() && !g_stop) std::this_thread::sleep_for(kSignalPoll);
    source.request_stop();
  });
  if (a.replay_views)
    return ViewReplay(a.replay, ViewPlace(a.view, a.link.tls), source.get_token());
  if (app.got_subcommand("replay")) return RunReplay(a.replay, source.get_token());
  RequireOtherThan("--out", a.exported.out, {"log.csv", "states.csv"}, std::array{a.exported.file});
  return RunExport(a.exported, source.get_token());
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

// Such as `ada@desk, process 4711`: a name that a reconnecting program has and no other.
std::string NameOfProcess() {
  const passwd* user = getpwuid(getuid());
  std::array<char, HOST_NAME_MAX + 1> host{};
  gethostname(host.data(), host.size() - 1);
  return std::string(user != nullptr ? user->pw_name : "operator") + "@" + host.data() +
         ", process " + std::to_string(getpid());
}

int Main(int argc, char** argv) {
  Arguments a;
  DoctorArguments doctor;
  CLI::App app("palpate-master: operates a slave and renders its contact force");
  Declare(&app, &a, &doctor);
  std::unique_ptr<ConnectRecorder> recorder;  // outlives the link
  std::unique_ptr<Line> line;
  std::unique_ptr<Device> device;
  Health health;
  try {
    app.parse(argc, argv);
    if (app.got_subcommand("doctor")) {
      RequireTimely(doctor.link.tls);
      if (!doctor.link.target.empty()) doctor.options.line = doctor.link;
      return RunDoctor(doctor.options);
    }
    if (app.got_subcommand("devices")) return ListDevices();
    if (app.got_subcommand("replay") || app.got_subcommand("export")) return ReadRecording(app, a);
    if (app.got_subcommand("evict")) return Evict(a);
    CheckBeforehand(a);
    if (a.link.operator_name.empty()) a.link.operator_name = NameOfProcess();
    NameCalls(a.link.operator_name);
    if (!a.metrics.empty()) {
      health.page.emplace(a.metrics, a.link.insecure, [&] { return health.seen.Collect(); });
    }
    if (!a.record.empty()) {
      recorder =
          std::make_unique<ConnectRecorder>(a.record, a.record_limit, a.record_part, &a.link);
    }
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
    return Operate(a, line.get(), std::move(device), recorder.get(), &health);
  } catch (const std::exception& error) {
    if (g_stop) return kDone;  // before anything moved
    std::fprintf(stderr, "palpate-master: %s\n", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
