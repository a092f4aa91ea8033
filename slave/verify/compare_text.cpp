#include "slave/verify/compare_text.h"

#include <algorithm>
#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

bool IsWrong(const ForceComparison& comparison, std::string_view key) {
  return std::ranges::any_of(comparison.lines, [&](const ComparisonLine& line) {
    return line.key == key && line.finding == Judgement::kWrong;
  });
}

std::string ValueOf(const ForceComparison& comparison, std::string_view key) {
  return comparison.line(key).value;
}

void AddChangeCauses(const ForceComparison& comparison, std::vector<std::string>* causes) {
  if (IsWrong(comparison, "delay")) {
    const bool is_late = comparison.line("delay").interval->value > 0;
    causes->push_back("Reported forces come " + ValueOf(comparison, "delay") +
                      (is_late ? " after" : " before (negative: earlier than)") +
                      " the known ones: a delay, or two clocks that differ.");
  }
  if (IsWrong(comparison, "time")) {
    causes->push_back("The error drifts by " + ValueOf(comparison, "time") +
                      " during the record: the baseline of the sensor, or warming.");
  }
  if (IsWrong(comparison, "hysteresis")) {
    causes->push_back("Hysteresis: loading and unloading differ by " +
                      ValueOf(comparison, "hysteresis") + " at the same force.");
  }
  if (IsWrong(comparison, "size")) {
    causes->push_back("The error depends on the size of the force, " + ValueOf(comparison, "size") +
                      " beside scale and offset: saturation, a dead zone, or a law that is not "
                      "linear.");
  }
}

void AddSigmaCauses(const ForceComparison& comparison, const ForceSource& source,
                    std::vector<std::string>* causes) {
  if (!IsWrong(comparison, "sigma")) return;
  constexpr double kCovers = 1.5;
  if (comparison.sigma_ratio < 1) {
    causes->push_back(
        Formatted("Sigma is too large: errors are %.2g of it.", comparison.sigma_ratio));
  } else if (causes->empty()) {
    causes->push_back(
        source.kind == ForceSource::Kind::kAny
            ? Formatted("Sigma is too small: errors are %.2g times as large.",
                        comparison.sigma_ratio)
            : "Only sigma is wrong, it is too small: state the tolerance of the material "
              "(object.material.tolerance) or the noise.");
  } else if (comparison.corrected_sigma_ratio > kCovers) {
    causes->push_back(
        Formatted("Sigma is too small by itself: with the errors above corrected, "
                  "errors still are %.2g times as large.",
                  comparison.corrected_sigma_ratio));
  } else {
    causes->emplace_back("Sigma is too small because of the errors above.");
  }
}

// Returns the power of ten that equals `gain` within the tolerance of a force; 1: there is none.
double PowerOfTen(double gain) {
  const double power = std::pow(10.0, std::round(std::log10(gain)));
  return std::abs(gain / power - 1) <= kForceTolerance ? power : 1;
}

std::string ModulusCause(const ForceComparison& comparison, const ForceSource& source) {
  const Interval& gain = comparison.map.gain.forth;
  const double E = 1e-3 * source.young_modulus;
  std::string cause = Formatted(
      "Forces are scaled by %.3f in every direction: the modulus "
      "(object.material.young_modulus: %.4g kPa, %.4g to %.4g, instead of %.4g kPa would fit)",
      gain.value, E / gain.value, E / gain.high, E / gain.low, E);
  if (PowerOfTen(gain.value) != 1) cause += ", perhaps in the wrong power of ten";
  if (source.pixel == 0) {
    cause += ", or the scale of the rig (focal length, baseline), which forces do not tell apart";
  } else if (!comparison.position) {
    cause += ", or the scale of the pixels: known positions would tell";
  }
  return cause + ".";
}

void AddScaleCauses(const ForceComparison& comparison, const ForceSource& source,
                    std::vector<std::string>* causes) {
  const VectorMap& force = comparison.map;
  const Interval gain = force.gain.forth;
  bool follows = false;  // whether the force's scale follows from that of positions
  if (comparison.position &&
      FindingOfInterval(comparison.position->gain.forth, 1 - kPositionTolerance,
                        1 + kPositionTolerance) == Judgement::kWrong) {
    const Interval& scale = comparison.position->gain.forth;
    std::string cause = "Positions are " + Words(scale, "", 1, 3) +
                        " times the known ones: " + source.position_source;
    if (source.pixel > 0) {
      cause += Formatted(" (sense.camera.pixel: %.4g um instead of %.4g um would fit)",
                         1e6 * source.pixel / scale.value, 1e6 * source.pixel);
    }
    causes->push_back(cause + ".");
    // A depth that is scaled by s scales the force by s, or with a membrane by up to its cube.
    constexpr double kMargin = 0.03;
    const double cube = scale.value * scale.value * scale.value;
    follows =
        gain.high >= std::min(1.0, cube) - kMargin && gain.low <= std::max(1.0, cube) + kMargin;
  }
  if (!IsWrong(comparison, "magnitude") || follows) return;
  if (force.directions == 0) {
    causes->emplace_back("No force is reported under load: is this the tool that was loaded?");
    return;
  }
  const auto in_one_axis = std::ranges::any_of(force.axis_gain, [&](const auto& one) {
    return one && (one->forth.low > gain.high || one->forth.high < gain.low);
  });
  if (in_one_axis) {
    causes->emplace_back(
        "The scale differs between the axes: the sensor's gain, or the reference's, is wrong on "
        "one of them; no modulus explains it.");
  } else if (source.young_modulus > 0) {
    causes->push_back(ModulusCause(comparison, source));
  } else if (source.kind == ForceSource::Kind::kFingertips) {
    causes->push_back(
        Formatted("Forces are scaled by %.3f in every direction: the gain of the fingertip "
                  "(`python3 -m palpate.train --from` fits it).",
                  gain.value));
  } else {
    causes->push_back("Forces are scaled by " + ValueOf(comparison, "magnitude") +
                      " in every direction: divide them by it, or train again.");
  }
}

}  // namespace

std::vector<std::string> CausesOf(const ForceComparison& comparison, const ForceSource& source) {
  std::vector<std::string> causes;
  const VectorMap& force = comparison.map;
  if (IsWrong(comparison, "rate")) {
    causes.push_back("Rows are " + ValueOf(comparison, "rate") +
                     " apart: the time is in another unit (--time-unit), such as ms for s.");
  }
  if (IsWrong(comparison, "channel")) {
    causes.push_back("The estimate along " + ValueOf(comparison, "channel") +
                     " while the measured force changes: a dead channel, a stuck value or "
                     "saturation.");
  }
  if (IsWrong(comparison, "unit")) {
    const double factor = comparison.unit;
    std::string cause = Formatted("A unit is wrong by a factor of %.4g: %s", factor,
                                  UnitOf({factor, factor, factor}).words);
    if (source.young_modulus > 0 && PowerOfTen(factor) != 1) {
      cause += ", or the modulus (object.material.young_modulus) is in the wrong power of ten";
    }
    causes.push_back(cause + ".");
  }
  if (IsWrong(comparison, "zero")) {
    causes.push_back("There is a force without a load, an offset of " +
                     ValueOf(comparison, "zero") +
                     ": measure the baseline again with nothing in contact.");
  }
  constexpr double kFollows = 0.5;
  if (force.is_decided && force.explained < kFollows) {
    causes.push_back(
        Formatted("Only %.0f %% of the reported force follows the loads: check the times of the "
                  "loads, and which tool they act on.",
                  100 * force.explained));
  }
  if (IsWrong(comparison, "sign") && !force.relation.is_permuted()) {
    causes.push_back("The sign is " + RelationWords(force.relation, comparison.axes) +
                     ": expected is the force of the object on the tool.");
  }
  if (IsWrong(comparison, "frame")) {
    causes.push_back(
        force.relation.is_permuted()
            ? "Axes are exchanged: " + RelationWords(force.relation, comparison.axes) + "."
            : Formatted("Forces are turned by %.1f degrees: the pose of camera, object or "
                        "fingertip in frame S.",
                        force.turn.value / kDegree));
  }
  AddScaleCauses(comparison, source, &causes);
  if (comparison.position && IsWrong(comparison, "position") && causes.empty()) {
    causes.emplace_back("Positions are turned or mirrored: the pose of the camera.");
  }
  if (IsWrong(comparison, "place")) {
    causes.push_back("The tip is " + ValueOf(comparison, "place") +
                     ": the pose of camera or object, or the template of the tip.");
  }
  AddChangeCauses(comparison, &causes);
  AddSigmaCauses(comparison, source, &causes);
  return causes;
}

UnitMistake UnitOf(const Interval& gain) {
  constexpr double kGravity = 9.80665, kPound = 4.4482216152605;  // [m/s^2], [N]
  static constexpr std::array kMistakes{
      UnitMistake{1000, "reported in mN, or known in kN"},
      UnitMistake{1000 / kGravity, "reported in g"},
      UnitMistake{kGravity, "known in kgf, or reported times 9.81 once too often"},
      UnitMistake{kPound, "known in lbf"},
      UnitMistake{1 / kPound, "reported in lbf"},
      UnitMistake{1 / kGravity, "reported in kgf, or known times 9.81 once too often"},
      UnitMistake{kGravity / 1000, "known in g"},
      UnitMistake{0.001, "known in mN, or reported in kN"}};
  for (const UnitMistake& mistake : kMistakes) {
    if (gain.low <= mistake.factor && mistake.factor <= gain.high) return mistake;
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

}  // namespace palpate
