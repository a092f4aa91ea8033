#include "slave/commands/train/train_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <stdexcept>

#include "slave/site/fingertips/simulated_presses.h"
#include "slave/tactile/recordings/recordings.h"

namespace palpate {
namespace {

constexpr std::string_view kSimulated = "simulated";
constexpr std::uint64_t kTestSeed = 1'000'000;  // simulated tests are other starts

std::vector<LabelledRecording> Read(std::span<const std::string> arguments,
                                    const TrainOptions& options, std::uint64_t seed) {
  std::vector<LabelledRecording> all;
  for (const std::string& argument : arguments) {
    std::vector<LabelledRecording> some;
    if (argument == kSimulated) {
      SimulatedPresses presses;
      presses.presses = options.presses;
      presses.rest_samples = options.rest;
      presses.seed = seed;
      some = SimulatePresses(presses);
    } else {
      some = ReadRecordedForces(ParseDataArgument(argument), {options.finger, options.rest});
    }
    std::ranges::move(some, std::back_inserter(all));
  }
  return all;
}

void WarnOfOverlap(const TrainingData& data) {
  for (const LabelledRecording& test : data.test) {
    for (const LabelledRecording& train : data.data) {
      if (!Overlap(test, train)) continue;
      std::fprintf(stderr, "train: warning: %s and %s share samples: the test flatters\n",
                   test.name.c_str(), train.name.c_str());
    }
  }
}

bool ShareSamples(const std::string& one, const std::string& other) {
  if (one == kSimulated || other == kSimulated) return one == other;
  const DataArgument a = ParseDataArgument(one), b = ParseDataArgument(other);
  std::error_code missing;
  return std::filesystem::equivalent(a.tactile, b.tactile, missing) && a.from < b.to &&
         b.from < a.to;
}

}  // namespace

void RefuseRepetitions(std::span<const std::string> data) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!ShareSamples(data[k], data[i])) continue;
      throw std::invalid_argument(data[k] + " and " + data[i] +
                                  " share samples: accepted is every sample once");
    }
  }
}

void RequireSignals(const TrainingData& data, const std::string& network, int inputs) {
  if (inputs <= kElectrodeCount) return;
  for (const auto* recordings : {&data.data, &data.test}) {
    for (const LabelledRecording& r : *recordings) {
      if (r.missing_column.empty()) continue;
      throw std::invalid_argument(r.name + ": no column " + r.missing_column + ": network " +
                                  network + " takes E1 to E19, pac0 and pdc");
    }
  }
}

TrainingData ReadTrainingData(const TrainOptions& options) {
  try {
    TrainingData read{Read(options.data, options, options.seed),
                      Read(options.test, options, options.seed + kTestSeed)};
    WarnOfOverlap(read);
    return read;
  } catch (const std::runtime_error& e) {
    throw std::invalid_argument(e.what());
  }
}

std::string NamesOf(std::span<const std::string> data) {
  std::string names;
  for (const std::string& argument : data) {
    if (!names.empty()) names.append(", ");
    if (argument == kSimulated) {
      names.append(argument);
      continue;
    }
    const DataArgument parsed = ParseDataArgument(argument);
    names.append(parsed.tactile.filename().string());
    if (!parsed.wrench.empty()) names.append("+").append(parsed.wrench.filename().string());
    const bool sliced = std::isfinite(parsed.from) || std::isfinite(parsed.to);
    if (sliced) names.append(argument, argument.rfind('@'));
  }
  return names;
}

}  // namespace palpate
