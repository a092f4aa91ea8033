#include "slave/commands/train/train.h"

#include <algorithm>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/train/train_data.h"
#include "slave/tactile/network/network_file.h"
#include "slave/tactile/network/network_weights.h"
#include "slave/tactile/recordings/recordings.h"

namespace palpate {
namespace {

// Without repetitions, `all` spelt out.
std::vector<std::string> Architectures(const std::vector<std::string>& networks) {
  std::vector<std::string> chosen;
  const auto add = [&](const std::string& name) {
    if (std::ranges::find(chosen, name) == chosen.end()) chosen.push_back(name);
  };
  for (const std::string& name : networks) {
    if (name == "all") {
      for (const char* each : {"dnn_19", "dnn_21", "rnn_19", "rnn_21"}) add(each);
    } else if (InputsOf(name) > 0) {
      add(name);
    } else {
      throw std::invalid_argument("--network " + name + ": accepted is " +
                                  std::string(kArchitectures) + " or all");
    }
  }
  if (chosen.empty()) chosen.emplace_back("rnn_21");
  return chosen;
}

void Check(const TrainOptions& o) {
  if (o.data.empty()) throw std::invalid_argument("train: no DATA");
  const auto require = [](bool usable, const std::string& given, const char* accepted) {
    if (!usable) throw std::invalid_argument(given + ": accepted is " + accepted);
  };
  require(o.optimiser == "adam" || o.optimiser == "sgd", "--optimiser " + o.optimiser,
          "adam or sgd");
  require(o.seed >= 0, "--seed " + std::to_string(o.seed), "0 or more");
  require(o.rest >= 1, "--rest " + std::to_string(o.rest), "1 or more");
  require(o.presses >= 1, "--presses " + std::to_string(o.presses), "1 or more");
  RefuseRepetitions(o.data);
  RefuseRepetitions(o.test);
}

void RequireOtherThanInputs(const TrainOptions& options) {
  std::vector<std::filesystem::path> inputs{options.from, options.from / kNetworkFileName};
  for (const auto* arguments : {&options.data, &options.test}) {
    for (const std::string& argument : *arguments) {
      const DataArgument data = ParseDataArgument(argument);
      inputs.insert(inputs.end(), {data.tactile, data.wrench});
    }
  }
  std::vector<std::filesystem::path> folders{options.out};
  for (const std::string& network : options.networks) folders.push_back(options.out / network);
  for (const auto& folder : folders) {
    RequireOtherThan("--out", folder, {"training.csv", kNetworkFileName}, inputs);
  }
}

}  // namespace

const char* const kTrainHelp = R"(DATA is one of
  TACTILE.csv              with force columns fx,fy,fz (or fx_N,fy_N,fz_N) [N]
  TACTILE.csv+WRENCH.csv   force from a second file, interpolated to the tactile times
  simulated                contacts of the simulated fingertip, 0 to 5 N
A file may end with @FROM:TO to use these seconds only. The force is that of the fingertip on the
object, in the fingertip frame: x points to the tip and a contact on the pad has fz < 0. A force
sensor under the object measures this force if it is aligned with that frame. The baseline is the
mean of a recording's first samples. The force offset is the mean of its first half second. Start
every recording without contact.

A fifth of the contacts is used for the test. A fifth of the others is used for validation. With
five or more recordings the split is by whole recordings, otherwise by whole contacts. Every window
lies inside its slice. With --from only a gain is fitted. Its slices must begin and end without
contact, because it uses the rest before and after each contact.

Examples:
  palpate-slave train simulated --network all --out build/fingertip
  palpate-slave train day1.csv day2.csv+wrench2.csv --finger rf --out build/rf
  palpate-slave train rec.csv+wrench.csv@0:9.5 --test rec.csv+wrench.csv@9.5:15 --finger rf --out build/rf
  palpate-slave train rec.csv+wrench.csv@0:9.5 --test rec.csv+wrench.csv@9.5:15 --from authors-network --finger rf --out build/gain)";

int RunTrain(const TrainOptions& options, const std::stop_token& stop) {
  Check(options);
  TrainOptions chosen = options;
  chosen.networks = Architectures(options.networks);
  RequireOtherThanInputs(chosen);
  MakeWritable(options.out);
  if (!options.from.empty()) return TrainForceGain(chosen);
  return TrainForceNetworks(chosen, stop);
}

}  // namespace palpate
