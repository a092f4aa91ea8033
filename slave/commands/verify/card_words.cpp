#include "slave/commands/verify/card_words.h"

#include <algorithm>
#include <numbers>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

bool IsWrong(const ForceCard& card, std::string_view key) {
  return card.line(key).finding == Finding::kWrong;
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
  } else {
    causes->push_back(
        Formatted("Forces are scaled by %.3f in every direction: the gain of the fingertip "
                  "(`palpate-slave train` fits it).",
                  force.gain.value));
  }
}

}  // namespace

std::vector<std::string> CausesOf(const ForceCard& card, const SetUp& set_up) {
  std::vector<std::string> causes;
  const MapFit& force = card.force;
  if (IsWrong(card, "zero")) {
    causes.emplace_back(
        "There is a force without a load: measure the baseline again with nothing in contact.");
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
  if (IsWrong(card, "sigma")) {
    causes.emplace_back(causes.empty()
                            ? "Only sigma is wrong, it is too small: state the tolerance of "
                              "the material (object.material.tolerance) or the noise."
                            : "Sigma is too small because of the errors above.");
  }
  return causes;
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
