// The program `coverage` checks whether the sigma that a sense reports is right: it draws presses
// at random and counts how often the true force lies within one sigma and within two sigma.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "shared/program/command_line.h"
#include "slave/pipeline/offline/offline_report.h"
#include "tests/campaigns/coverage/random_press.h"
#include "tests/campaigns/coverage/tally.h"
#include "tests/campaigns/robustness/trial.h"

namespace palpate::coverage {
namespace {

constexpr const char* kHelp = R"(Examples:
  coverage --sense camera --scenes 50 --seed 7     fifty presses that one camera sees

The error is that of the force's magnitude, of fingertips that of its vector, as sigma is. The
modulus that the sense is given differs from the true one by what the scene says it may
(material.tolerance): `material` is what that makes of the error, `rest` what is left; so do the
fingers' poses (pose_tolerance). Estimates count where the tool touches or is estimated to; `near the
edge` are those below a tenth of the press's largest force.

With --exact the modulus is no part of either: only the rest of sigma remains.

Exit codes: 0 the intervals of the `valid` ones' shares (95 %, bootstrap over presses) meet 63 to
73 % and 90 to 99 %; 1 one does not; 2 unusable arguments.)";

constexpr double kEdge = 0.1;  // of a press's largest force
// Limits for the intervals of the shares: 68 % -5 to +5 points, 95 % -5 to +4 points.
constexpr double kOneLow = 0.63, kOneHigh = 0.73, kTwoLow = 0.90, kTwoHigh = 0.99;

struct Options {
  std::string sense = "camera";
  std::uint32_t seed = 1;
  int scenes = 50;
  bool exact = false;
};

Phase PhaseOf(const StateRow& row, const robustness::Script& script, std::size_t index,
              double larger) {
  if (row.validity != Validity::kValid) return Phase::kFlagged;
  if (larger < kEdge) return Phase::kEdge;
  // The network uses a window of past samples, so a press counts as at rest after one window.
  const bool is_at_rest = index > script.hold + (script.back - script.hold) / 4;
  return is_at_rest && index < script.back ? Phase::kStill : Phase::kMoving;
}

std::vector<EstimateRow> TryPress(const Options& options, int number) {
  RandomPress press = DrawPress(options.sense, options.seed, number);
  if (options.exact) {
    press.modulus_error = 0;
    press.alteration.tell = [tell = press.alteration.tell](Scene& scene) {
      const double modulus = scene.object.material.young_modulus;  // of the scene that is true
      tell(scene);
      scene.object.material.young_modulus = modulus;
      scene.object.material.young_modulus_tolerance = 0;
    };
  }
  robustness::Stage& stage = *press.stage;
  std::vector<EstimateRow> rows;
  const auto take = [&](std::size_t index, const StateRow& row, const Eigen::Vector3d& truth) {
    if (!row.force) return;
    const double force = row.force->norm() / stage.peak(), right = truth.norm() / stage.peak();
    const double larger = std::fmax(force, right);
    // A force of a network is never zero.
    const bool touches = stage.sense() == "fingertips" ? right > 0 : larger > 0;
    if (!touches) return;
    const double e = press.modulus_error;
    const double material = stage.sense() == "fingertips" ? 0 : -e / (1 + e) * right;
    const double off = (*row.force - truth).norm() / stage.peak();
    const double error = stage.sense() == "fingertips" ? off : force - right;
    rows.push_back({PhaseOf(row, stage.script(), index, larger), error, off,
                    row.sigma / stage.peak(), material});
  };
  try {
    Replay(stage, press.alteration, take);
  } catch (const std::runtime_error& why) {  // the sense refuses: no force, no sigma
    std::printf("%s: refused: %s\n", stage.name().c_str(), why.what());
  }
  return rows;
}

int Run(const Options& options) {
  std::printf("%s\n", Headline().c_str());
  std::vector<std::vector<EstimateRow>> presses;
  for (int i = 0; i < options.scenes; ++i) presses.push_back(TryPress(options, i));
  const auto some = [&](const auto& chosen) {
    std::vector<std::vector<EstimateRow>> found = presses;
    for (auto& press : found) {
      std::erase_if(press, [&](const EstimateRow& one) { return !chosen(one.phase); });
    }
    return found;
  };
  const auto bands = [&](const std::string& name, const auto& chosen) {
    std::vector<EstimateRow> all;
    for (const auto& press : some(chosen)) all.insert(all.end(), press.begin(), press.end());
    const Bands found = BandsOf(all);
    std::printf("%s\n", InWords(options.sense + ", " + name, found).c_str());
    return found;
  };
  for (std::size_t i = 0; i < kPhaseNames.size(); ++i) {
    bands(kPhaseNames[i], [i](Phase phase) { return phase == static_cast<Phase>(i); });
  }
  const auto is_valid = [](Phase phase) { return phase != Phase::kFlagged; };
  const Bands valid = bands("valid", is_valid);
  const auto [one, two] = IntervalsOf(some(is_valid));
  const bool holds = one.Overlaps(kOneLow, kOneHigh) && two.Overlaps(kTwoLow, kTwoHigh);
  std::printf(
      "%s, %d presses, modulus %s: %.1f %% (%.1f to %.1f) within one sigma, %.1f %% (%.1f to %.1f) "
      "within two; %s; the larger part of the error is %s\n",
      options.sense.c_str(), options.scenes, options.exact ? "known" : "as stated", 100 * valid.one,
      100 * one.least, 100 * one.most, 100 * valid.two, 100 * two.least, 100 * two.most,
      holds ? "both bands hold" : "THE BANDS DO NOT HOLD",
      valid.material > valid.rest ? "the modulus as stated" : "what is sensed and modelled");
  return holds ? 0 : 1;
}

int Main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("coverage"));
  spdlog::set_level(spdlog::level::err);
  Options options;
  CLI::App app{"Counts how often the true force lies within the reported sigma."};
  app.footer(kHelp);
  app.add_option("--sense", options.sense, "camera, pairs or fingertips");
  app.add_option("--seed", options.seed, "of the series");
  app.add_option("--scenes", options.scenes, "how many presses");
  app.add_flag("--exact", options.exact, "the true modulus is given, as certain");
  try {
    app.parse(argc, argv);
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    return Run(options);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "coverage: %s\n", e.what());
    return 2;
  }
}

}  // namespace
}  // namespace palpate::coverage

int main(int argc, char** argv) {
  return palpate::coverage::Main(argc, argv);
}
