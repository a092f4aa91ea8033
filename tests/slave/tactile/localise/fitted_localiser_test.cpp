#include "slave/tactile/localise/fitted_localiser.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kRadius = 7e-3;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Lesson {
  std::vector<TactileSignals> changes;
  std::vector<Vector3d> normals;
};

// Contacts that wander over the tip; electrodes fall the more the nearer they are, those that
// `gain` makes deaf less than they should. Normals are turned by `R`.
Lesson Wander(const ElectrodeLayout& layout, int count, double deaf_gain, const Eigen::Matrix3d& R,
              double phase) {
  Lesson lesson;
  for (int k = 0; k < count; ++k) {
    const double s = 0.02 * k + phase;
    const double elevation = 0.7 + 0.4 * std::sin(1.7 * s), azimuth = 0.9 * std::sin(s);
    const Vector3d n(std::sin(elevation), std::cos(elevation) * std::sin(azimuth),
                     -std::cos(elevation) * std::cos(azimuth));
    TactileSignals change{};
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const double near = std::exp(-(kRadius * n - layout.p_F[i]).squaredNorm() / 2e-5);
      const double gain = i % 3 == 0 ? deaf_gain : 1;
      change[i] = static_cast<float>(-400 * gain * near);
    }
    lesson.changes.push_back(change);
    lesson.normals.push_back(R * n);
  }
  return lesson;
}

double MedianError(const Localiser& localiser, const Lesson& lesson) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < lesson.changes.size(); ++k) {
    FingerReading raw;
    raw.electrodes.fill(3000);
    const TouchPlace place = localiser.Locate(lesson.changes[k], raw);
    EXPECT_TRUE(place.usable());
    errors.push_back(std::acos(std::clamp(place.n_F.dot(lesson.normals[k]), -1.0, 1.0)));
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

class FittedLocaliserTest : public ::testing::Test {
 protected:
  ElectrodeLayout layout_ = SimulatedLayout(kRadius);
  Eigen::Matrix3d turned_ =
      Eigen::AngleAxisd(0.15, Vector3d(0.2, 0.9, 0.1).normalized()).toRotationMatrix();
  Lesson lesson_ = Wander(layout_, 800, 0.2, turned_, 0);
};

// Reference: the formula itself, on contacts between those that were learnt. The frame is turned by
// 0.15 rad and a third of the electrodes are half deaf: the formula misses by both.
TEST_F(FittedLocaliserTest, LearnsWhatTheFormulaGetsWrong) {
  const LocaliserWeights weights = FitLocaliser(lesson_.changes, lesson_.normals, layout_, {});
  const Lesson exam = Wander(layout_, 300, 0.2, turned_, 20.01);
  const double formula = MedianError(*MakeLocaliser(Tactile{}, layout_), exam);
  const double fitted = MedianError(*MakeFittedLocaliser(weights, kRadius), exam);
  EXPECT_LT(fitted, 0.25 * formula);
  EXPECT_EQ(weights.samples, 800);
  // What the fit says of itself, from stretches it left out, is of that size.
  EXPECT_LT(fitted, 2 * weights.median_error);
  EXPECT_GT(fitted, 0.2 * weights.median_error);
  EXPECT_GT(weights.sigma_angle, weights.median_error);
}

// Law: normals that are the formula's, turned, leave nothing to correct: the rotation is found.
TEST_F(FittedLocaliserTest, FindsHowTheRecordingsFrameLies) {
  const Lesson fair = Wander(layout_, 400, 1.0, Eigen::Matrix3d::Identity(), 0);
  const auto formula = MakeLocaliser(Tactile{}, layout_);
  std::vector<Vector3d> normals;
  for (const TactileSignals& change : fair.changes) {
    FingerReading raw;
    raw.electrodes.fill(3000);
    const TouchPlace place = formula->Locate(change, raw);
    ASSERT_GT(place.n_F.x(), std::sin(8 * std::numbers::pi / 180))
        << "on the tip, where n_F is the mean's";
    normals.push_back(turned_ * place.n_F);
  }
  const LocaliserWeights weights = FitLocaliser(fair.changes, normals, layout_, {});
  EXPECT_LT((weights.R - turned_).norm(), 1e-12);
  EXPECT_LT(weights.corrections.norm(), 1e-12);
  EXPECT_LT(weights.median_error, 1e-7);
}

// Signals that resemble nothing learnt: the correction has died away, exp(-5 * 0.5) at most.
TEST_F(FittedLocaliserTest, AnswersAsTheFormulaDoesWhereNothingWasLearnt) {
  LocaliserWeights weights = FitLocaliser(lesson_.changes, lesson_.normals, layout_, {});
  weights.R.setIdentity();
  TactileSignals change{};
  change[18] = -300;  // the hindmost electrode of the pad
  FingerReading raw;
  raw.electrodes.fill(3000);
  const auto fitted = MakeFittedLocaliser(weights, kRadius)->Locate(change, raw);
  const auto formula = MakeLocaliser(Tactile{}, layout_)->Locate(change, raw);
  EXPECT_LT(std::acos(std::min(1.0, fitted.n_F.dot(formula.n_F))), 0.03);
}

TEST_F(FittedLocaliserTest, IsTheSameAfterAFileAndAfterAnotherFit) {
  const Scratch scratch;
  const LocaliserWeights weights = FitLocaliser(lesson_.changes, lesson_.normals, layout_, {});
  const LocaliserWeights again = FitLocaliser(lesson_.changes, lesson_.normals, layout_, {});
  EXPECT_EQ(weights.corrections, again.corrections);
  WriteLocaliser(weights, scratch.path() / "localiser.json");
  Tactile tactile;
  tactile.localise = (scratch.path() / "localiser.json").string();
  const auto read = MakeLocaliser(tactile, SimulatedLayout(1));  // its own layout counts
  const auto fitted = MakeFittedLocaliser(weights, kRadius);
  for (const TactileSignals& change : lesson_.changes) {
    FingerReading raw;
    raw.electrodes.fill(3000);
    const TouchPlace a = fitted->Locate(change, raw), b = read->Locate(change, raw);
    EXPECT_EQ(a.p_F, b.p_F);
    EXPECT_EQ(a.sigma, b.sigma);
  }
}

std::string Complaint(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST_F(FittedLocaliserTest, SaysWhatIsWrongWithAFile) {
  const Scratch scratch;
  const auto file = scratch.path() / "localiser.json";
  WriteLocaliser(FitLocaliser(lesson_.changes, lesson_.normals, layout_, {.centres = 3}), file);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  const std::string sound = text.str();
  const auto complaint_after = [&](const std::string& from, const std::string& to) {
    std::string changed = sound;
    const auto at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    scratch.Write("localiser.json", changed);
    return Complaint([&] { ReadLocaliser(file); });
  };
  EXPECT_THAT(complaint_after("palpate-localiser/1", "palpate-localiser/9"),
              HasSubstr("localiser.json: format: accepted is palpate-localiser/1"));
  EXPECT_THAT(complaint_after("\"gamma\":5.0", "\"gamma\":-5.0"), HasSubstr("gamma = -5.0"));
  EXPECT_THAT(complaint_after("\"gamma\":5.0", "\"gamma\":\"much\""), HasSubstr("type"));
  EXPECT_THAT(complaint_after("\"gamma\":5.0,", ""), HasSubstr("gamma"));
  EXPECT_THAT(complaint_after("\"rotation\":[[", "\"rotation\":[[1,"), HasSubstr("row 0 has 4"));
  EXPECT_THAT(complaint_after("\"rotation\":[[", "\"rotation\":[[1,0,0],["),
              HasSubstr("rotation: accepted is"));
  EXPECT_THAT(complaint_after("\"corrections\":[[", "\"corrections\":[[0,0,0],["),
              HasSubstr("as many of both"));
  EXPECT_THAT(complaint_after("\"corrections\":[[", "\"corrections\":[[1e300,0,0],["),
              HasSubstr("corrections: accepted are numbers up to 1e6"));
  EXPECT_THAT(complaint_after("\"electrodes\":[[", "\"electrodes\":[[0,0,0],["),
              HasSubstr("electrodes has 20 rows"));
  EXPECT_THAT(complaint_after("{", ""), HasSubstr("parse error"));
  EXPECT_THAT(Complaint([&] { ReadLocaliser(scratch.path()); }), HasSubstr("cannot be read"));
  EXPECT_THAT(Complaint([&] { WriteLocaliser({}, scratch.path() / "absent" / "file.json"); }),
              HasSubstr("cannot be written"));
}

TEST_F(FittedLocaliserTest, SaysWhatIsWrongWithALesson) {
  const auto complaint = [&](const FitLocaliserOptions& options = {}) {
    return Complaint([&] { FitLocaliser(lesson_.changes, lesson_.normals, layout_, options); });
  };
  EXPECT_THAT(complaint({.threshold = 0}), HasSubstr("threshold"));
  EXPECT_THAT(complaint({.centres = 0}), HasSubstr("centres = 0"));
  EXPECT_THAT(complaint({.folds = 1}), HasSubstr("folds = 1"));
  EXPECT_THAT(complaint({.threshold = 1e6}), HasSubstr("0 samples are in contact"));
  lesson_.normals[7] *= 2;
  EXPECT_THAT(complaint(), HasSubstr("sample 7"));
  lesson_.normals[7] = {0, kNan, 1};
  EXPECT_THAT(complaint(), HasSubstr("sample 7"));
  lesson_.normals.pop_back();
  EXPECT_THAT(complaint(), HasSubstr("800 samples and 799 normals"));
}

}  // namespace
}  // namespace palpate
