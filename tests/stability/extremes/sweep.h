// What becomes of every cell of a sweep: a table and a map of it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::extremes {

enum class Outcome {
  kAccurate,  // within the stated bound
  kFlagged,   // finite, and marked as not to be trusted
  kRefused,   // no answer, and a reason in words
  kWrong      // anything else: not finite, beyond the bound and unmarked, no reason
};

struct Cell {
  std::string model{};  // fem linear, bem2d quadratic, ...
  std::string axis{};   // what is varied: length, nu, contacts, ...
  std::string value{};  // of it
  Outcome outcome = Outcome::kWrong;
  double error = 0;      // relative, where there is an answer and a truth
  double bound = 0;      // stated beforehand
  std::string detail{};  // the reason, the place of the fault
  double seconds = 0;
};

const char* ToString(Outcome outcome);

// Every cell of the program's run, in the order they came.
class Sweep {
 public:
  static Sweep& Instance();
  void Add(Cell cell);
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }

  // extremes.csv, and extremes.svg: a row per model and axis, a square per value, coloured by
  // outcome.
  void Write(const std::filesystem::path& folder) const;

 private:
  void WriteTable(const std::filesystem::path& file) const;
  void WriteMap(const std::filesystem::path& file) const;

  std::vector<Cell> cells_;
};

}  // namespace palpate::extremes
