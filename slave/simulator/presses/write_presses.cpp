#include "slave/simulator/presses/write_presses.h"

#include <cstdio>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/simulator/presses/simulated_presses.h"

namespace palpate {
namespace {

constexpr int kDigits = 9;  // single precision

std::string Csv(const SimulatedStart& start) {
  std::string text = "t";
  for (int i = 1; i <= kElectrodeCount; ++i) text += fmt::format(",E{}", i);
  text += ",pac0,pdc,fx,fy,fz\n";
  for (std::size_t i = 0; i < start.readings.size(); ++i) {
    const FingerReading& reading = start.readings[i];
    AppendNumber(&text, static_cast<double>(i) / kPressRate, kDigits);
    const auto append = [&](double value) {
      text += ',';
      AppendNumber(&text, value, kDigits);
    };
    for (const float electrode : reading.channels) append(static_cast<double>(electrode));
    append(static_cast<double>(reading.pac));
    append(static_cast<double>(reading.pdc));
    for (const double component : start.force[i]) append(component);
    text += '\n';
  }
  return text;
}

}  // namespace

int WritePresses(const PressesOptions& options, const std::stop_token& stop) {
  if (options.seed < 0) {
    throw std::invalid_argument(fmt::format("--seed {}: expected 0 or more", options.seed));
  }
  const SimulatedPresses presses{.presses = options.presses,
                                 .seed = static_cast<std::uint64_t>(options.seed)};
  const int starts = CountStarts(presses);
  std::filesystem::create_directories(options.out);
  ProgressBar bar("presses", stop);
  for (int start = 0; start < starts; ++start) {
    if (!bar.Report("simulated contacts", static_cast<double>(start) / starts)) return 1;
    ReplaceFile(options.out / fmt::format("start{:05}.csv", start + 1),
                Csv(SimulateStart(presses, start)));
  }
  return 0;
}

}  // namespace palpate
