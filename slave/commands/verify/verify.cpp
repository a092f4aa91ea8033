#include "slave/commands/verify/verify.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/commands/running_scene.h"
#include "slave/commands/verify/card_report.h"
#include "slave/commands/verify/live_states.h"
#include "slave/live/offline_run.h"
#include "slave/recording/recorded_run.h"
#include "slave/recording/scene_files.h"

namespace palpate {
namespace {

constexpr const char* kUsualAddress = "127.0.0.1:50051";

bool IsRecording(const VerifyOptions& options) {
  return options.scene.extension() == ".mcap";
}

SetUp SetUpOf(const Scene& scene) {
  SetUp set_up;
  const bool fingertips = scene.sense.Find<Tactile>() != nullptr;
  set_up.is_planar = IsPlanar(scene.object.geometry);
  set_up.sigma_of_vector = fingertips;
  if (!fingertips) set_up.young_modulus = scene.object.material.young_modulus;
  set_up.position_source =
      fingertips ? "the encoders or the poses of the fingertips" : "the encoders";
  if (const auto* camera = scene.sense.Find<Camera>()) {
    set_up.pixel = camera->pixel;
    set_up.position_source = "the scale of the pixels";
    Eigen::AlignedBox2d box;
    for (const auto& point : OutlineOf(scene.object.geometry).outer) box.extend(point);
    if (!box.isEmpty()) set_up.object_size = box.diagonal().norm();
  }
  return set_up;
}

// Asks for one load after the other, and watches the slave while each is held. Each answer is
// written at once: it cannot be repeated.
LoadTable AskForLoads(const VerifyOptions& options, LiveStates* live, const std::stop_token& stop) {
  std::puts(
      "Apply one known load after the other and hold it still; five or more, of several sizes and\n"
      "along every axis that you use. Describe a load when it is held:\n"
      "  none                        nothing touches the tool\n"
      "  weight 100 g +y             a weight that the object carries through the tool\n"
      "  spring 200 N/m 5 mm +y      a spring between tool and frame, compressed\n"
      "  force 0 1.2 0               newtons, for example from a gauge\n"
      "  press 3 mm                  a known depth\n"
      "Directions are those in which the object pushes the tool, frame S. `at X Y Z` behind a "
      "load\n"
      "gives the known position of the tip in metres. `done` ends.");
  LoadTable table;
  while (!stop.stop_requested()) {
    std::printf("load %zu> ", table.loads.size() + 1);
    std::fflush(stdout);
    std::string line;
    if (!std::getline(std::cin, line) || Trimmed(line) == "done") break;
    if (Trimmed(line).empty()) continue;
    try {
      KnownLoad load = ParseLoad(line);
      live->Watch(0.2, stop);  // what was on its way belongs to the load before
      load.from = live->now();
      live->Watch(options.hold, stop);
      load.until = live->now();
      if (!(load.until > load.from)) throw NoState("no new state while it was held");
      const auto states = std::ranges::count_if(live->states(), [&](const ReportedState& state) {
        return state.t >= load.from && state.force.allFinite();
      });
      std::printf("  %td states with a force\n", states);
      table.loads.push_back(std::move(load));
      WriteLoads(table.loads, options.out / "loads.csv");
      WriteStates(live->states(), options.out / "states.csv");
    } catch (const std::invalid_argument& error) {
      std::printf("  %s\n", error.what());
    } catch (const NoState& error) {
      std::printf("  no state, try again: %s\n", error.what());
    }
  }
  if (table.loads.empty()) throw std::invalid_argument("verify: no load was described");
  return table;
}

struct Session {
  std::vector<ReportedState> states;
  LoadTable loads;
  std::string source;
};

Session WatchSlave(const VerifyOptions& options, const std::stop_token& stop) {
  const std::string address = options.connect.empty() ? kUsualAddress : options.connect;
  Session session;
  session.source = "slave " + address;
  LiveStates live(address, options.tls, options.insecure);
  if (options.sensor || !options.loads.empty()) {
    live.Watch(options.duration, stop);
  } else {
    live.Watch(0.5, stop);  // before anybody is asked: does it answer?
    session.loads = AskForLoads(options, &live, stop);
  }
  session.states = live.states();
  WriteStates(session.states, options.out / "states.csv");
  return session;
}

std::string Process(const VerifyOptions& options, const Scene& scene, const std::stop_token& stop) {
  if (IsRecording(options)) {
    ProcessRecording(options.scene, options.out, stop);
    return "recording " + options.scene.filename().string();
  }
  RunOffline(scene, {.out = options.out}, stop);
  return "scene " + options.scene.filename().string() + ", processed";
}

Scene SceneOf(const VerifyOptions& options, const std::stop_token& stop) {
  if (!IsRecording(options)) {
    return LoadRunningScene(options.scene, options.overrides, SceneUse::kFull, stop);
  }
  if (!options.overrides.empty()) {
    throw std::invalid_argument("--override: only with a scene; a recording contains its own");
  }
  const RecordedBeginning beginning(options.scene);
  return LoadScene(UnpackSceneFiles(beginning.files, options.out / "scene"), beginning.overrides());
}

void Check(const VerifyOptions& options) {
  if (options.sensor && !options.loads.empty()) {
    throw std::invalid_argument("--sensor, --loads: expected one of them");
  }
  if (!options.states.empty() && !options.connect.empty()) {
    throw std::invalid_argument("--states, --connect: expected one of them");
  }
  if (!options.states.empty() && !options.sensor && options.loads.empty()) {
    throw std::invalid_argument("--states: only with --loads or --sensor");
  }
  if (IsRecording(options) && options.loads.empty()) {
    throw std::invalid_argument(options.scene.string() +
                                ": with a recording, expected --loads FILE.csv");
  }
  const std::array inputs{options.scene, options.loads, options.states};
  RequireOtherThan("--out", options.out, {"report.json", "states.csv", "loads.csv", "summary.json"},
                   inputs);
}

int Report(const CardTitle& title, const std::vector<ForceCard>& cards,
           const std::filesystem::path& folder) {
  WriteCards(title, cards, folder);
  std::fputs(ToText(cards).c_str(), stdout);
  std::printf("written: %s\n", (folder / "report.json").c_str());
  return std::ranges::all_of(cards, &ForceCard::passes) ? 0 : 1;
}

int VerifyForces(const VerifyOptions& options) {
  if (!options.scene.empty() || !options.loads.empty() || !options.states.empty() ||
      !options.connect.empty() || options.sensor) {
    throw std::invalid_argument(
        "--forces: only without a scene, --loads, --states, --connect "
        "and --sensor");
  }
  RequireOtherThan("--out", options.out, {"report.json"}, std::array{options.forces});
  std::filesystem::create_directories(options.out);
  const auto pairs = ReadForcePairs(options.forces, options.columns);
  if (pairs.empty()) {
    throw InputError(options.forces.string() + ": no row has a measured and an estimated force");
  }
  const std::vector cards{
      MakeCard("", pairs, {.sigma_of_vector = true, .is_record = true, .has_scene = false})};
  return Report({"", options.forces.filename().string()}, cards, options.out);
}

}  // namespace

int RunVerify(const VerifyOptions& options, const std::stop_token& stop) {
  if (!options.forces.empty()) return VerifyForces(options);
  Check(options);
  std::filesystem::create_directories(options.out);
  const Scene scene = SceneOf(options, stop);
  const bool asks = !options.sensor && options.loads.empty();
  Session session;
  if (!options.loads.empty()) session.loads = ReadLoads(options.loads);
  if (!options.states.empty()) {
    session.states = ReadStates(options.states);
    session.source = options.states.filename().string();
  } else if (asks || !options.connect.empty()) {
    LoadTable loads = std::move(session.loads);
    session = WatchSlave(options, stop);
    if (!asks) session.loads = std::move(loads);
  } else {
    try {
      session.source = Process(options, scene, stop);
    } catch (const std::system_error&) {
      throw;  // the samples are not to blame: a file cannot be written
    } catch (const std::exception& refusal) {
      WriteRefusal(scene.name, refusal.what(), options.out);
      std::printf("does not pass: the slave refuses these samples\nlikely wrong: %s\nwritten: %s\n",
                  refusal.what(), (options.out / "report.json").c_str());
      return 1;
    }
    session.states = ReadStates(options.out / "states.csv");
  }
  if (stop.stop_requested()) return 1;
  const MatchedStates matched =
      options.sensor ? MatchSensor(session.states) : Match(session.states, session.loads);
  SetUp set_up = SetUpOf(scene);
  set_up.is_record = options.sensor || session.loads.is_record;
  std::vector<ForceCard> cards;
  for (const auto& [finger, states] : matched) cards.push_back(MakeCard(finger, states, set_up));
  return Report({scene.name, session.source}, cards, options.out);
}

}  // namespace palpate
