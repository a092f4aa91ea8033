#include "tests/stability/extremes/sweep.h"

#include <algorithm>
#include <fstream>
#include <utility>

namespace palpate::extremes {
namespace {

constexpr int kSquare = 14, kRow = 18, kTop = 60, kLeft = 250;

const char* ColourOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::kAccurate:
      return "#2e8b57";
    case Outcome::kFlagged:
      return "#e0a020";
    case Outcome::kRefused:
      return "#7088b0";
    case Outcome::kWrong:
      break;
  }
  return "#c03030";
}

std::string Quoted(std::string text) {
  std::ranges::replace(text, '"', '\'');
  std::ranges::replace(text, '\n', ' ');
  return '"' + text + '"';
}

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

void WriteLegend(std::ostream& svg) {
  int x = kLeft;
  for (const Outcome outcome :
       {Outcome::kAccurate, Outcome::kFlagged, Outcome::kRefused, Outcome::kWrong}) {
    svg << "<rect x='" << x << "' y='30' width='12' height='12' fill='" << ColourOf(outcome)
        << "'/><text x='" << x + 18 << "' y='40'>" << ToString(outcome) << "</text>\n";
    x += 100;
  }
}

}  // namespace

const char* ToString(Outcome outcome) {
  switch (outcome) {
    case Outcome::kAccurate:
      return "accurate";
    case Outcome::kFlagged:
      return "flagged";
    case Outcome::kRefused:
      return "refused";
    case Outcome::kWrong:
      break;
  }
  return "WRONG";
}

Sweep& Sweep::Instance() {
  static Sweep sweep;
  return sweep;
}

void Sweep::Add(Cell cell) {
  cells_.push_back(std::move(cell));
}

void Sweep::Write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  WriteTable(folder / "extremes.csv");
  WriteMap(folder / "extremes.svg");
}

void Sweep::WriteTable(const std::filesystem::path& file) const {
  std::ofstream table(file);
  table << "model,axis,value,outcome,error,bound,seconds,detail\n";
  for (const Cell& c : cells_) {
    table << c.model << ',' << Quoted(c.axis) << ',' << Quoted(c.value) << ','
          << ToString(c.outcome) << ',' << c.error << ',' << c.bound << ',' << c.seconds << ','
          << Quoted(c.detail) << '\n';
  }
}

void Sweep::WriteMap(const std::filesystem::path& file) const {
  std::vector<std::pair<std::string, std::vector<const Cell*>>> rows;
  std::size_t longest = 0;
  for (const Cell& c : cells_) {
    const std::string name = c.model + ": " + c.axis;
    auto row = std::ranges::find(rows, name, [](const auto& r) { return r.first; });
    if (row == rows.end()) row = rows.insert(rows.end(), {name, {}});
    row->second.push_back(&c);
    longest = std::max(longest, row->second.size());
  }
  const auto width = kLeft + kSquare * static_cast<int>(longest) + 20;
  const auto height = kTop + kRow * static_cast<int>(rows.size()) + 20;
  std::ofstream svg(file);
  svg << "<svg xmlns='http://www.w3.org/2000/svg' width='" << std::max(width, kLeft + 420)
      << "' height='" << height << "' font-family='sans-serif' font-size='11'>\n"
      << "<rect width='100%' height='100%' fill='white'/>\n"
      << "<text x='10' y='20' font-size='14'>Every model at its extremes</text>\n";
  WriteLegend(svg);
  int y = kTop;
  for (const auto& [name, cells] : rows) {
    svg << "<text x='" << kLeft - 8 << "' y='" << y + 11 << "' text-anchor='end'>" << Escaped(name)
        << "</text>\n";
    int x = kLeft;
    for (const Cell* c : cells) {
      svg << "<rect x='" << x << "' y='" << y << "' width='" << kSquare - 2 << "' height='"
          << kSquare - 2 << "' fill='" << ColourOf(c->outcome) << "'><title>"
          << Escaped(c->value + ": " + c->detail) << "</title></rect>\n";
      x += kSquare;
    }
    y += kRow;
  }
  svg << "</svg>\n";
}

}  // namespace palpate::extremes
