#include <algorithm>
#include <cctype>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/verify/known_loads.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

constexpr double kGravity = 9.80665;  // standard [m/s^2]

class LoadWords {
 public:
  explicit LoadWords(const std::string& line) {
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      // A unit belongs to the number before it.
      const bool is_unit =
          !words_.empty() && std::isalpha(static_cast<unsigned char>(word[0])) != 0;
      if (is_unit && ParseFinite(words_.back()) && word != "at") {
        words_.back() += " " + word;
      } else {
        words_.push_back(word);
      }
    }
  }
  [[nodiscard]] bool empty() const { return next_ == words_.size(); }
  bool Take(const std::string& word) {
    const bool is_next = !empty() && words_[next_] == word;
    if (is_next) ++next_;
    return is_next;
  }
  double Quantity(Dimension dimension) {
    const std::string text = empty() ? "" : words_[next_++];
    const auto value = ParseQuantity(text, dimension);
    if (!value) Refuse("'" + text + "': expected " + ExpectedQuantity(dimension));
    return *value;
  }
  double Mass() {
    std::string text = empty() ? "" : words_[next_++];
    double unit = 1;
    if (text.ends_with("kg")) {
      text.resize(text.size() - 2);
    } else if (text.ends_with('g')) {
      text.resize(text.size() - 1);
      unit = 1e-3;
    } else {
      Refuse("'" + text + "': expected a mass in g or kg");
    }
    const auto value = ParseFinite(Trimmed(text));
    if (!value || *value < 0) Refuse("'" + text + "': expected a mass in g or kg");
    return unit * *value;
  }
  Eigen::Vector3d Direction() {
    const std::string text = empty() ? "" : words_[next_++];
    const bool is_direction =
        text.size() == 2 && (text[0] == '+' || text[0] == '-') && text[1] >= 'x' && text[1] <= 'z';
    if (!is_direction) Refuse("'" + text + "': expected +x -x +y -y +z -z");
    return (text[0] == '-' ? -1 : 1) * Eigen::Vector3d::Unit(text[1] - 'x');
  }
  Eigen::Vector3d Vector(Dimension dimension) {
    const double x = Quantity(dimension), y = Quantity(dimension), z = Quantity(dimension);
    return {x, y, z};
  }
  [[noreturn]] static void Refuse(const std::string& what) { throw std::invalid_argument(what); }

 private:
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

}  // namespace

KnownLoad ParseLoad(const std::string& line) {
  LoadWords words(line);
  KnownLoad load;
  if (words.Take("none")) {
    load.force.setZero();
  } else if (words.Take("weight")) {
    const double mass = words.Mass();
    load.force = mass * kGravity * words.Direction();
  } else if (words.Take("spring")) {
    const double stiffness = words.Quantity(Dimension::kTension);
    const double compression = words.Quantity(Dimension::kLength);
    load.force = stiffness * compression * words.Direction();
  } else if (words.Take("force")) {
    load.force = words.Vector(Dimension::kForce);
  } else if (words.Take("press")) {
    load.depth = words.Quantity(Dimension::kLength);
  } else {
    LoadWords::Refuse("'" + Shown(line) +
                      "': expected none, weight MASS DIRECTION, spring STIFFNESS COMPRESSION "
                      "DIRECTION, force X Y Z or press DEPTH");
  }
  if (words.Take("at")) load.p_S_tip = words.Vector(Dimension::kLength);
  if (!words.empty()) LoadWords::Refuse("'" + Shown(line) + "': too many words");
  return load;
}

}  // namespace palpate
