// The cells of a CSV file by column, for tests.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// Cells as text, since some are empty. Separated by commas, without quotes.
using CsvColumns = std::map<std::string, std::vector<std::string>, std::less<>>;

inline CsvColumns ReadColumns(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::vector<std::string> names;
  std::getline(stream, line);
  std::istringstream head(line);
  for (std::string name; std::getline(head, name, ',');) names.push_back(name);
  CsvColumns columns;
  while (std::getline(stream, line)) {
    std::istringstream row(line);
    for (const std::string& name : names) {
      std::string cell;
      std::getline(row, cell, ',');
      columns[name].push_back(cell);
    }
  }
  return columns;
}

// The cells of a column that are all numbers.
inline std::vector<double> NumbersOf(const CsvColumns& columns, std::string_view name) {
  std::vector<double> numbers;
  for (const std::string& cell : columns.find(name)->second) numbers.push_back(std::stod(cell));
  return numbers;
}

}  // namespace palpate
