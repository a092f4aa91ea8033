#include "slave/commands/train/train_words.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/csv.h"

namespace palpate {
namespace {

// Numbers that are not known are dashes.
std::string Cell(double value, int width, int decimals) {
  return std::isfinite(value) ? fmt::format("{:>{}.{}f}", value, width, decimals)
                              : fmt::format("{:>{}}", "-", width);
}

}  // namespace

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
      "fz: RMSE {:.1f} mN, SMSE {}, correlation {}, peak {:.3f} N met within {:.1f} mN ({:.1f} %), "
      "largest error {:.1f} mN, {} samples",
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
