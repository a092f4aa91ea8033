#include "slave/commands/verify/verify.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <system_error>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/commands/scene_remarks.h"
#include "slave/commands/verify/known_loads.h"
#include "slave/commands/verify/live_states.h"
#include "slave/live/offline_run.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/recording/recorded_run.h"
#include "slave/recording/scene_files.h"
#include "slave/verify/report.h"

namespace palpate {
namespace {

constexpr const char* kUsualAddress = "127.0.0.1:50051";

bool IsRecording(const VerifyOptions& options) {
  return options.scene.extension() == ".mcap";
}

ForceSource SourceOf(const Scene& scene) {
  if (scene.sense.Find<Tactile>() != nullptr) {
    return {.kind = ForceSource::Kind::kFingertips,
            .position_source = "the encoders or the poses of the fingertips"};
  }
  ForceSource source{.kind = ForceSource::Kind::kCamera,
                     .young_modulus = scene.object.material.young_modulus,
                     .position_source = "the encoders"};
  if (const auto* camera = scene.sense.Find<Camera>()) {
    source.pixel = camera->pixel;
    source.position_source = "the scale of the pixels";
    Eigen::AlignedBox2d box;
    for (const auto& point : OutlineOf(scene.object.geometry).outer) box.extend(point);
    if (!box.isEmpty()) source.object_size = box.diagonal().norm();
  }
  return source;
}

// Prompts for one load after the other, and records the slave's states while each is held. `rows`
// are written after each answer.
ForceTables AskForLoads(const VerifyOptions& options, LiveStates* live,
                        const std::stop_token& stop) {
  std::puts(
      "Apply one known load after the other and hold it still; six or more, of several sizes and\n"
      "along every axis that you use. Describe a load when it is held:\n"
      "  none                        nothing touches the tool\n"
      "  weight 100 g +y             a weight that the object carries through the tool\n"
      "  spring 200 N/m 5 mm +y      a spring between tool and frame, compressed\n"
      "  force 0 1.2 0               newtons, for example from a gauge\n"
      "  press 3 mm                  a known depth\n"
      "Directions are those in which the object pushes the tool, frame S. `at X Y Z` behind a "
      "load\n"
      "gives the known position of the tip in metres. `done` ends.");
  constexpr double kSettling = 0.2;  // states in transit belong to the previous load [s]
  ForceTables tables;
  std::vector<ForceRow>& rows = tables[""];
  int hold = 0;
  while (!stop.stop_requested()) {
    std::printf("load %d> ", hold + 1);
    std::fflush(stdout);
    std::string line;
    if (!std::getline(std::cin, line) || Trimmed(line) == "done") break;
    if (Trimmed(line).empty()) continue;
    try {
      const KnownLoad load = ParseLoad(line);
      const std::vector<ForceRow> states = live->Watch(kSettling + options.hold, stop);
      const std::size_t before = rows.size();
      for (const ForceRow& state : states) {
        if (state.t >= states[0].t + kSettling) rows.push_back(WithLoad(state, load, hold));
      }
      if (rows.size() == before) throw std::runtime_error("no new state while it was held");
      const auto count =
          std::count_if(rows.begin() + static_cast<std::ptrdiff_t>(before), rows.end(),
                        [](const ForceRow& row) { return row.estimated.allFinite(); });
      std::printf("  %td states with a force\n", count);
      WriteForces(tables, options.out / "forces.csv");
      ++hold;
    } catch (const std::invalid_argument& error) {
      std::printf("  %s\n", error.what());
    } catch (const std::system_error&) {
      throw;  // a file cannot be written
    } catch (const std::runtime_error& error) {
      std::printf("  try again: %s\n", error.what());
    }
  }
  if (rows.empty()) throw std::invalid_argument("verify: no load was described");
  return tables;
}

Scene SceneOf(const VerifyOptions& options, const std::stop_token& stop) {
  if (!IsRecording(options)) {
    return LoadRunningScene(options.scene, options.overrides);
  }
  if (!options.overrides.empty()) {
    throw std::invalid_argument("--override: only with a scene; a recording contains its own");
  }
  const RecordedBeginning beginning(options.scene);
  return WithChosenModel(
      LoadScene(UnpackSceneFiles(beginning.files, options.out / "scene"), beginning.overrides()));
}

void Check(const VerifyOptions& options) {
  const bool is_judged = !options.forces.empty();
  if (is_judged && (!options.loads.empty() || !options.states.empty() || !options.connect.empty() ||
                    options.sensor)) {
    throw std::invalid_argument("--forces: only without --loads, --states, --connect and --sensor");
  }
  if (options.scene.empty() && !is_judged) {
    throw std::invalid_argument("scene: expected a scene file, a recording or --forces");
  }
  if (options.sensor && !options.loads.empty()) {
    throw std::invalid_argument("--sensor, --loads: expected one of them");
  }
  if (!options.states.empty() && !options.connect.empty()) {
    throw std::invalid_argument("--states, --connect: expected one of them");
  }
  if (!options.states.empty() && !options.sensor && options.loads.empty()) {
    throw std::invalid_argument("--states: only with --loads or --sensor");
  }
  if (IsRecording(options) && options.loads.empty() && !is_judged) {
    throw std::invalid_argument(options.scene.string() +
                                ": with a recording, expected --loads FILE.csv");
  }
  const std::array inputs{options.scene, options.loads, options.states, options.forces};
  RequireOtherThan("--out", options.out, {"report.json"}, inputs);
  if (is_judged) return;
  RequireOtherThan("--out", options.out, {"forces.csv", "states.csv", "summary.json"}, inputs);
}

// Thrown if the slave refuses the samples of the scene.
class Refusal : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Forces of a planar scene have no z.
void ForgetZ(ForceTables* tables) {
  for (auto& [finger, rows] : *tables) {
    for (ForceRow& row : rows) row.measured.z() = kUnknown;
  }
}

// Describes the source of a scene's forces, and their table.
struct Run {
  std::string source;
  ForceTables tables;
};

Run RunScene(const VerifyOptions& options, const Scene& scene, const std::stop_token& stop) {
  const bool asks = !options.sensor && options.loads.empty();
  std::optional<LoadTable> loads;
  if (!options.loads.empty()) loads = ReadLoads(options.loads);
  const auto with_known = [&](const ForceTables& states) {
    return loads ? WithLoads(states, *loads) : WithSensor(states);
  };
  if (!options.states.empty()) {
    return {options.states.filename().string(), with_known(ReadStates(options.states))};
  }
  if (asks || !options.connect.empty()) {
    const std::string address = options.connect.empty() ? kUsualAddress : options.connect;
    LiveStates live(address, options.tls, options.insecure);
    if (!asks) return {"slave " + address, with_known({{"", live.Watch(options.duration, stop)}})};
    live.Watch(0.5, stop);  // checks that the slave answers before the first prompt
    return {"slave " + address, AskForLoads(options, &live, stop)};
  }
  const std::string name = options.scene.filename().string();
  try {
    if (IsRecording(options)) {
      ProcessRecording(options.scene, options.out, stop);
    } else {
      RunOffline(scene, {.out = options.out}, stop);
    }
  } catch (const std::system_error&) {
    throw;  // a file cannot be written, which is no error of the samples
  } catch (const std::exception& refusal) {
    throw Refusal(refusal.what());
  }
  return {IsRecording(options) ? "recording " + name : "scene " + name + ", processed",
          with_known(ReadStates(options.out / "states.csv"))};
}

}  // namespace

int RunVerify(const VerifyOptions& options, const std::stop_token& stop) {
  Check(options);
  std::filesystem::create_directories(options.out);
  std::optional<Scene> scene;
  if (!options.scene.empty()) scene = SceneOf(options, stop);
  const std::string name = scene ? scene->name : "";
  std::filesystem::path forces = options.forces;
  std::string source = forces.filename().string();
  if (forces.empty()) {
    try {
      Run run = RunScene(options, *scene, stop);
      if (stop.stop_requested()) return 1;
      if (IsPlanar(scene->object.geometry)) ForgetZ(&run.tables);
      forces = options.out / "forces.csv";
      WriteForces(run.tables, forces);
      source = run.source;
    } catch (const Refusal& refusal) {
      WriteRefusal(name, refusal.what(), options.out);
      std::printf("does not pass: the slave refuses these samples\nlikely wrong: %s\nwritten: %s\n",
                  refusal.what(), (options.out / "report.json").c_str());
      return 1;
    }
  }
  Comparisons comparisons;
  for (const auto& [finger, rows] : ReadForces(forces, options.columns)) {
    comparisons[finger] = CompareForces(rows, scene ? SourceOf(*scene) : ForceSource{});
  }
  WriteWholeFile(options.out / "report.json", ToJson(name, source, comparisons));
  std::fputs(ToText(comparisons).c_str(), stdout);
  std::printf("written: %s\n", (options.out / "report.json").c_str());
  return Pass(comparisons) ? 0 : 1;
}

}  // namespace palpate
