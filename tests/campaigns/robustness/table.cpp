#include "tests/campaigns/robustness/table.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "shared/text/csv.h"

namespace palpate::robustness {
namespace {

constexpr const char* kHeader =
    "sense,stage,case,demand,samples,valid,touching,silent,rms_percent,worst_percent,"
    "sigma_percent,z,holds,why\n";

// Removes characters that separate cells and rows.
std::string Cell(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == ',' || c == '\n' || c == '\r' || c == '"'; }, ';');
  return text;
}

double Percent(std::size_t part, std::size_t whole) {
  return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

const char* InWords(Demand demand) {
  return demand == Demand::kRight ? "right" : "may doubt";
}

}  // namespace

void Append(const Row& row, const std::filesystem::path& file) {
  const bool is_new = !std::filesystem::exists(file);
  std::ofstream stream(file, std::ios::app);
  if (is_new) stream << kHeader;
  const Score& s = row.score;
  stream << fmt::format("{},{},{},{},{},{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{},{}\n", row.sense,
                        row.stage, Cell(row.name), InWords(row.demand), s.samples, s.valid,
                        s.touching, s.silent, 100 * s.rms, 100 * s.worst, 100 * s.sigma, s.z,
                        row.holds() ? "yes" : "no", Cell(s.why))
         << std::flush;
  if (!stream.good()) throw std::runtime_error(file.string() + ": cannot be written");
}

std::vector<Row> ReadRows(const std::filesystem::path& file) {
  std::vector<Row> rows;
  if (!std::filesystem::exists(file)) return rows;
  CsvTable csv(file);
  while (csv.Next()) {
    const auto text = [&](const char* column) {
      return std::string(csv.Text(csv.Find(column).value()));
    };
    const auto number = [&](const char* column) {
      return csv.Number(csv.Find(column).value(), 1e12);
    };
    const auto count = [&](const char* column) { return static_cast<std::size_t>(number(column)); };
    Row row{text("sense"),
            text("stage"),
            text("case"),
            text("demand") == "right" ? Demand::kRight : Demand::kFlag,
            {}};
    row.score = {count("samples"),
                 count("valid"),
                 count("touching"),
                 count("silent"),
                 number("rms_percent") / 100,
                 number("worst_percent") / 100,
                 number("sigma_percent") / 100,
                 number("z"),
                 text("why")};
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string Headline() {
  return fmt::format("{:<24} {:<48} {:<9} {:>6} {:>6} {:>9} {:>7} {:>5}  {}", "scene", "case",
                     "demand", "rms %", "sigma%", "not valid", "silent", "holds", "why not valid");
}

std::string InWords(const Row& row) {
  const Score& s = row.score;
  return fmt::format("{:<24} {:<48} {:<9} {:>6.1f} {:>6.1f} {:>7.1f} % {:>5.1f} % {:>5}  {}",
                     row.stage, row.name, InWords(row.demand), 100 * s.rms, 100 * s.sigma,
                     Percent(s.samples - s.valid, s.samples), Percent(s.silent, s.samples),
                     row.holds() ? "yes" : "NO", s.why);
}

std::string Summary(std::span<const Row> rows) {
  struct Sum {
    std::size_t rows = 0, held = 0, touching = 0, silent = 0;
  };
  std::map<std::string, Sum> sums;
  for (const Row& row : rows) {
    for (const std::string& of : {row.sense, std::string("together")}) {
      Sum& sum = sums[of];
      ++sum.rows;
      sum.held += row.holds() ? 1 : 0;
      sum.touching += row.score.touching;
      sum.silent += row.score.silent;
    }
  }
  std::string text;
  for (const auto& [sense, sum] : sums) {
    text += fmt::format(
        "{}: {} of {} rows hold; undetected errors: {} of {} valid forces in contact ({:.2f} %)\n",
        sense, sum.held, sum.rows, sum.silent, sum.touching, Percent(sum.silent, sum.touching));
  }
  return text;
}

std::set<std::string> ReadKnown(const std::filesystem::path& file) {
  std::set<std::string> known;
  if (file.empty()) return known;
  CsvLines lines(file);
  while (lines.Next()) known.emplace(lines.text());
  return known;
}

}  // namespace palpate::robustness
