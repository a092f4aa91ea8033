// The program `robustness` tests the senses under disturbances of light, lens, time, geometry and
// scene. Every case has a severity and a required result, both written beforehand. No force may be
// wrong without a flag.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "shared/program/command_line.h"
#include "shared/text/text.h"
#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/mixed.h"
#include "tests/campaigns/robustness/stage.h"
#include "tests/campaigns/robustness/table.h"
#include "tests/campaigns/robustness/trial.h"

namespace palpate::robustness {
namespace {

constexpr const char* kHelp = R"(Examples:
  robustness --quick --out build/robustness
  robustness --only 'glint|wire'                      every severity, short presses
  robustness --full --out build/robustness-full        goes on where it was stopped
  robustness --mixed 100 --seed 7 --only '^camera'    two at a time, drawn at random
  robustness --list

Writes OUT/table.csv and OUT/table.txt. A row holds if none of its estimates is an undetected
error (`valid`, off by more than 3 sigma and more than 5 % of the largest true force), and where
the force must be right, if 80 % are `valid` and these within 5 % rms.

Exit codes: 0 every row holds, or is in the list of --known; 1 one does not; 2 unusable arguments.)";

struct Options {
  bool quick = false, full = false, list = false;
  std::size_t mixed = 0;
  std::uint64_t seed = 1;
  std::string only;
  std::filesystem::path out, known;

  [[nodiscard]] Extent extent() const { return full ? Extent::kFull : Extent::kQuick; }
};

std::vector<Case> CasesOf(const std::string& sense) {
  if (sense == "camera") return CameraCases();
  return sense == "pairs" ? PairCases() : FingertipCases();
}

// The cases to run, in order.
class Suite {
 public:
  explicit Suite(const Options& options) : options_(options), only_(options.only) {
    if (options.out.empty()) return;
    std::filesystem::create_directories(options.out);
    // A full run continues with the results that it has already; a quick run starts again.
    if (!options.full) std::filesystem::remove(table());
    rows_ = ReadRows(table());
  }

  int Run() {
    if (!options_.list) std::printf("%s\n", Headline().c_str());
    for (const StageMaker& maker : StagesOf(options_.extent())) RunOn(maker);
    if (options_.list) return 0;
    std::printf("\n%s", Summary(rows_).c_str());
    if (!options_.out.empty()) WriteAll();
    return Evaluate();
  }

 private:
  [[nodiscard]] std::filesystem::path table() const { return options_.out / "table.csv"; }

  [[nodiscard]] bool IsDone(const std::string& key) const {
    return std::ranges::any_of(rows_, [&](const Row& row) { return row.key() == key; });
  }

  [[nodiscard]] std::vector<Case> CasesFor(const std::string& sense) const {
    const std::vector<Case> cases = CasesOf(sense);
    return options_.mixed > 0 ? Mixed(cases, options_.mixed, options_.seed) : cases;
  }

  void RunOn(const StageMaker& maker) {
    std::unique_ptr<Stage> stage;  // made when the first case needs it
    for (const Case& tried : CasesFor(maker.sense)) {
      Row row{maker.sense, maker.name, tried.title(), tried.demand, {}};
      if (!maker.Suits(tried) || IsDone(row.key())) continue;
      if (options_.quick && !tried.is_quick) continue;
      if (!std::regex_search(row.sense + " " + row.key(), only_)) continue;
      if (options_.list) {
        std::printf("%-10s %s\n", maker.sense.c_str(), row.key().c_str());
        continue;
      }
      if (!stage) stage = maker.make(options_.extent());
      row.score = Try(*stage, tried);
      std::printf("%s\n", InWords(row).c_str());
      std::fflush(stdout);
      if (!options_.out.empty()) Append(row, table());
      rows_.push_back(std::move(row));
    }
  }

  void WriteAll() const {
    std::string text = Headline() + "\n";
    for (const Row& row : rows_) text += InWords(row) + "\n";
    WriteWholeFile(options_.out / "table.txt", text + "\n" + Summary(rows_));
  }

  [[nodiscard]] int Evaluate() const {
    const std::set<std::string> known = ReadKnown(options_.known);
    int broken = 0;
    for (const Row& row : rows_) {
      const bool is_known = known.contains(row.key());
      if (row.holds() && is_known) std::printf("holds now: %s\n", row.key().c_str());
      if (row.holds()) continue;
      std::printf("%s: %s\n", is_known ? "does not hold, as is known" : "DOES NOT HOLD",
                  row.key().c_str());
      broken += is_known ? 0 : 1;
    }
    if (broken > 0) std::printf("%d rows do not hold\n", broken);
    return broken > 0 ? 1 : 0;
  }

  const Options& options_;
  std::regex only_;
  std::vector<Row> rows_;
};

int Main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("robustness"));
  spdlog::set_level(spdlog::level::warn);
  Options options;
  CLI::App app{"Tries the senses on altered samples of the shipped scenes."};
  app.footer(kHelp);
  app.add_flag("--quick", options.quick, "Of each case two severities");
  app.add_flag("--full", options.full,
               "Whole presses on all scenes; without it short ones on a scene per sense");
  app.add_flag("--list", options.list, "Name the rows only");
  app.add_option("--only", options.only, "Rows that match this: SENSE SCENE: CASE");
  app.add_option("--mixed", options.mixed,
                 "Instead of the table: so many pairs of its rows for each sense, both at once")
      ->check(CLI::Range(1, 100000));
  app.add_option("--seed", options.seed, "By which they are drawn");
  app.add_option("--out", options.out, "Folder for table.csv and table.txt");
  app.add_option("--known", options.known, "File of rows that are known not to hold, a line each");
  try {
    app.parse(argc, argv);
    return Suite(options).Run();
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::regex_error& e) {
    std::fprintf(stderr, "--only = %s: %s\n", options.only.c_str(), e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "robustness: %s\n", e.what());
    return 2;
  }
}

}  // namespace
}  // namespace palpate::robustness

int main(int argc, char** argv) {
  return palpate::robustness::Main(argc, argv);
}
