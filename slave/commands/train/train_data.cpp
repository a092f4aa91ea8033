#include "slave/commands/train/train_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/csv.h"
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
      std::fprintf(stderr, "train: warning: %s and %s share samples: the test error is too small\n",
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

// Numbers that are not known are dashes.
std::string Cell(double value, int width, int decimals) {
  return std::isfinite(value) ? fmt::format("{:>{}.{}f}", value, width, decimals)
                              : fmt::format("{:>{}}", "-", width);
}

}  // namespace

void RefuseRepetitions(std::span<const std::string> data) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!ShareSamples(data[k], data[i])) continue;
      throw std::invalid_argument(data[k] + " and " + data[i] +
                                  " share samples: accepted is each sample once");
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

std::string ForceTable(std::span<const TestedNetwork> networks) {
  std::string table =
      "                 RMSE [mN]                     SMSE\n"
      "              fx       fy       fz        fx       fy       fz\n";
  for (const TestedNetwork& network : networks) {
    table += fmt::format("{:<8}", network.architecture);
    for (const double rmse : network.errors.rmse) table += Cell(1e3 * rmse, 9, 2);
    table += " ";
    for (const double smse : network.errors.smse) table += Cell(smse, 9, 4);
    table += "\n";
  }
  return table;
}

std::string AlongNormal(const ForceErrors& errors) {
  return fmt::format(
      "fz: RMSE {:.1f} mN, SMSE {}, correlation {}, peak {:.3f} N with an error of {:.1f} mN "
      "({:.1f} %), largest error {:.1f} mN, {} samples",
      1e3 * errors.rmse.z(), Cell(errors.smse.z(), 0, 4), Cell(errors.correlation.z(), 0, 4),
      errors.peak.z(), 1e3 * errors.at_peak.z(),
      errors.peak.z() > 0 ? 100 * errors.at_peak.z() / errors.peak.z() : 0.0,
      1e3 * errors.worst.z(), errors.count);
}

void WriteEpochs(const std::filesystem::path& file, std::span<const TrainingEpoch> epochs) {
  std::string text = "epoch,loss,validation_loss\n";
  for (const TrainingEpoch& e : epochs) {
    text += std::to_string(e.epoch) + ",";
    AppendNumber(&text, e.loss, 9);
    text += ",";
    AppendNumber(&text, e.validation_loss, 9);
    text += "\n";
  }
  WriteWholeFile(file, text);
}

void MakeWritable(const std::filesystem::path& dir) {
  std::error_code failed;
  std::filesystem::create_directories(dir, failed);
  try {
    RequireWritable(dir / "training.csv");
  } catch (const std::invalid_argument&) {
    throw std::runtime_error("--out " + dir.string() + ": cannot be written");
  }
}

}  // namespace palpate
