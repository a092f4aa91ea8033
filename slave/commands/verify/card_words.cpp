#include "slave/commands/verify/card_words.h"

#include <algorithm>

#include "shared/text/text.h"

namespace palpate {
namespace {

bool IsWrong(const ForceCard& card, std::string_view key) {
  return std::ranges::any_of(card.lines, [&](const CardLine& line) {
    return line.key == key && line.finding == Finding::kWrong;
  });
}

std::string ValueOf(const ForceCard& card, std::string_view key) {
  return card.line(key).value;
}

void AddChangeCauses(const ForceCard& card, std::vector<std::string>* causes) {
  if (IsWrong(card, "delay")) {
    const bool is_late = card.line("delay").interval->value > 0;
    causes->push_back("Reported forces come " + ValueOf(card, "delay") +
                      (is_late ? " after" : " before (negative: earlier than)") +
                      " the known ones: a delay, or two clocks that differ.");
  }
  if (IsWrong(card, "time")) {
    causes->push_back("The error drifts by " + ValueOf(card, "time") +
                      " during the record: the baseline of the sensor, or warming.");
  }
  if (IsWrong(card, "hysteresis")) {
    causes->push_back("Hysteresis: loading and unloading differ by " + ValueOf(card, "hysteresis") +
                      " at the same force.");
  }
  if (IsWrong(card, "size")) {
    causes->push_back("The error depends on the size of the force, " + ValueOf(card, "size") +
                      " beside scale and offset: saturation, a dead zone, or a law that is not "
                      "linear.");
  }
}

void AddSigmaCauses(const ForceCard& card, const SetUp& set_up, std::vector<std::string>* causes) {
  if (!IsWrong(card, "sigma")) return;
  constexpr double kCovers = 1.5;
  if (card.sigma_ratio < 1) {
    causes->push_back(Formatted("Sigma is too large: errors are %.2g of it.", card.sigma_ratio));
  } else if (causes->empty()) {
    causes->emplace_back(
        set_up.has_scene
            ? "Only sigma is wrong, it is too small: state the tolerance of "
              "the material (object.material.tolerance) or the noise."
            : Formatted("Sigma is too small: errors are %.2g times as large.", card.sigma_ratio));
  } else if (card.corrected_sigma_ratio > kCovers) {
    causes->push_back(
        Formatted("Sigma is too small by itself: with the errors above corrected, "
                  "errors still are %.2g times as large.",
                  card.corrected_sigma_ratio));
  } else {
    causes->emplace_back("Sigma is too small because of the errors above.");
  }
}

void AddScaleCauses(const ForceCard& card, const SetUp& set_up, std::vector<std::string>* causes) {
  const MapFit& force = card.force;
  const bool position_is_wrong = card.position && card.position->is_decided &&
                                 Judged(card.position->gain, 1 - kPositionTolerance,
                                        1 + kPositionTolerance) == Finding::kWrong;
  bool follows = false;  // the force's scale from that of positions
  if (position_is_wrong) {
    const Interval& scale = card.position->gain;
    std::string cause = "Positions are " + Words(scale, "", 1, 3) +
                        " times the known ones: " + set_up.position_source;
    if (set_up.pixel > 0) {
      cause += Formatted(" (sense.camera.pixel: %.4g um instead of %.4g um would fit)",
                         1e6 * set_up.pixel / scale.value, 1e6 * set_up.pixel);
    }
    causes->push_back(cause + ".");
    // A depth that is scaled by s scales the force by s, or with a membrane by up to its cube.
    constexpr double kMargin = 0.03;
    const double cube = scale.value * scale.value * scale.value;
    follows = force.gain.high >= std::min(1.0, cube) - kMargin &&
              force.gain.low <= std::max(1.0, cube) + kMargin;
  }
  if (!IsWrong(card, "magnitude") || follows) return;
  if (force.directions == 0) {
    causes->emplace_back("No force is reported under load: is this the tool that was loaded?");
    return;
  }
  const auto in_one_axis = std::ranges::any_of(force.axis_gain, [&](const auto& gain) {
    return gain && (gain->low > force.gain.high || gain->high < force.gain.low);
  });
  if (in_one_axis) {
    causes->push_back(
        "The scale differs between the axes: the sensor's gain, or the reference's, is wrong on "
        "one of them; no modulus explains it.");
  } else if (set_up.young_modulus > 0) {
    const double E = 1e-3 * set_up.young_modulus;
    std::string cause = Formatted(
        "Forces are scaled by %.3f in every direction: the modulus "
        "(object.material.young_modulus: %.4g kPa, %.4g to %.4g, instead of %.4g kPa would fit)",
        force.gain.value, E / force.gain.value, E / force.gain.high, E / force.gain.low, E);
    if (set_up.pixel == 0) {
      cause += ", or the scale of the rig (focal length, baseline), which forces do not tell apart";
    } else if (!card.position) {
      cause += ", or the scale of the pixels: known positions would tell";
    }
    causes->push_back(cause + ".");
  } else if (set_up.has_scene) {
    causes->push_back(
        Formatted("Forces are scaled by %.3f in every direction: the gain of the fingertip "
                  "(`python3 -m palpate.train --from` fits it).",
                  force.gain.value));
  } else {
    const Interval& scale = *card.line("magnitude").interval;
    causes->push_back("Forces are scaled by " + Words(scale) +
                      Formatted(" in every direction: divide them by it, or train again."));
  }
}

}  // namespace

std::vector<std::string> CausesOf(const ForceCard& card, const SetUp& set_up) {
  std::vector<std::string> causes;
  const MapFit& force = card.force;
  if (IsWrong(card, "unit")) {
    causes.push_back(
        Formatted("A unit is wrong by a factor of %.4g: %s.", card.unit, UnitOf(card.unit).words));
  }
  if (IsWrong(card, "zero")) {
    causes.push_back("There is a force without a load, an offset of " + ValueOf(card, "zero") +
                     ": measure the baseline again with nothing in contact.");
  }
  constexpr double kFollows = 0.5;
  if (force.is_decided && force.explained < kFollows) {
    causes.push_back(
        Formatted("Only %.0f %% of the reported force follows the loads: check the times of the "
                  "loads, and which tool they act on.",
                  100 * force.explained));
  }
  if (IsWrong(card, "sign") && !force.relation.is_permuted()) {
    causes.push_back("The sign is " + RelationWords(force.relation, card.axes) +
                     ": expected is the force of the object on the tool.");
  }
  if (IsWrong(card, "frame")) {
    causes.push_back(
        force.relation.is_permuted()
            ? "Axes are exchanged: " + RelationWords(force.relation, card.axes) + "."
            : Formatted("Forces are turned by %.1f degrees: the pose of camera, object or "
                        "fingertip in frame S.",
                        force.turn.value / kDegree));
  }
  AddScaleCauses(card, set_up, &causes);
  if (card.position && IsWrong(card, "position") && causes.empty()) {
    causes.emplace_back("Positions are turned or mirrored: the pose of the camera.");
  }
  if (IsWrong(card, "place")) {
    causes.push_back("The tip is " + ValueOf(card, "place") +
                     ": the pose of camera or object, or the template of the tip.");
  }
  AddChangeCauses(card, &causes);
  AddSigmaCauses(card, set_up, &causes);
  return causes;
}

UnitMistake UnitOf(double gain) {
  constexpr double kGravity = 9.80665, kReach = 1.5;
  static constexpr std::array kMistakes{
      UnitMistake{1000, "reported in mN, or known in kN"},
      UnitMistake{1000 / kGravity, "reported in g"},
      UnitMistake{kGravity, "known in kgf, or reported times 9.81 once too often"},
      UnitMistake{1 / kGravity, "reported in kgf, or known times 9.81 once too often"},
      UnitMistake{kGravity / 1000, "known in g"},
      UnitMistake{0.001, "known in mN, or reported in kN"}};
  for (const UnitMistake& mistake : kMistakes) {
    const double rest = gain / mistake.factor;
    if (rest < kReach && rest > 1 / kReach) return mistake;
  }
  return {};
}

std::string AxisNames(const std::vector<int>& axes) {
  std::string names;
  for (const int axis : axes) {
    names += (names.empty() ? "" : ", ") + std::string(kAxisNames[static_cast<std::size_t>(axis)]);
  }
  return names;
}

std::string RelationWords(const AxisRelation& relation, const std::vector<int>& axes) {
  std::string words;
  std::vector<int> flipped;
  for (const int axis : axes) {
    const auto j = static_cast<std::size_t>(axis);
    if (relation.sign[j] < 0) flipped.push_back(axis);
    if (relation.axis[j] == axis) continue;
    words += words.empty() ? "" : ", ";
    words += std::string("known ") + kAxisNames[j] + " is reported as " +
             (relation.sign[j] < 0 ? "-" : "") +
             kAxisNames[static_cast<std::size_t>(relation.axis[j])];
  }
  if (flipped.empty() || !words.empty()) return words;
  return flipped == axes ? "reversed on every axis" : "reversed along " + AxisNames(flipped);
}

std::string Words(const Interval& interval, const char* unit, double scale, int digits) {
  return Formatted("%.*f%s (%.*f to %.*f)", digits, scale * interval.value, unit, digits,
                   scale * interval.low, digits, scale * interval.high);
}

Finding Judged(const Interval& interval, double low, double high) {
  if (interval.low >= low && interval.high <= high) return Finding::kRight;
  return interval.high < low || interval.low > high ? Finding::kWrong : Finding::kOpen;
}

}  // namespace palpate
