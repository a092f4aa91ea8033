#include "slave/mechanics/plate/fit/load_fit.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

constexpr double kFitRadius = 0.039, kFitThickness = 0.001, kFitModulus = 27.2e6, kFitNu = 0.45;

// About thirty dots as in paper C, on a grid of 5 mm within 15 mm of the centre.
std::vector<Vector2d> Dots() {
  std::vector<Vector2d> dots;
  for (int i = -3; i <= 3; ++i) {
    for (int j = -3; j <= 3; ++j) {
      const Vector2d p(0.005 * i, 0.005 * j);
      if (p.norm() < 0.0155) dots.push_back(p);
    }
  }
  return dots;
}

struct Image {
  std::vector<Vector2d> points = Dots();
  std::vector<double> displacement, sigma;
};

// Returns the displacements of the dots under a load, with noise.
Image MakeImage(PlateSurface& plate, const Vector2d& p, double force, double width, double sigma,
                std::mt19937* random) {
  const Contact contact = PlateSurface::ToolContact(Contact::Kind::kForce, p, {width}, force);
  Solution solution;
  plate.Solve({&contact, 1}, &solution);
  EXPECT_NE(solution.responses()[0].validity, Validity::kFailed);
  Image image;
  std::normal_distribution<double> noise(0, sigma);
  for (const auto& point : image.points) {
    const double error = random == nullptr ? 0 : noise(*random);
    image.displacement.push_back(plate.Displacement(solution, point) + error);
    image.sigma.push_back(sigma);
  }
  return image;
}

LoadFit FitTo(LoadFitter& fitter, const Image& image) {
  return fitter.Fit(image.points, image.displacement, image.sigma);
}

// Reference: the load itself, without noise, by points that are trusted to a micrometre.
TEST(LoadFit, FindsEccentricLoadsThatTheLargestDotMisses) {
  PlateModel small({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  PlateLargeModel large({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  for (PlateSurface* plate :
       {static_cast<PlateSurface*>(&small), static_cast<PlateSurface*>(&large)}) {
    for (const double width : {0.0, 0.004}) {
      LoadFitter fitter(*plate, {width});
      for (const Vector2d& p : {Vector2d(0, 0), Vector2d(0.0123, -0.004), Vector2d(-0.019, 0.008),
                                Vector2d(0.001, 0.020), Vector2d(0, 1e-5)}) {
        for (const double force : {-1e-2, -0.05, -1.0, 0.3}) {
          const Image image = MakeImage(*plate, p, force, width, 1e-6, nullptr);
          fitter.Reset();
          const LoadFit fit = FitTo(fitter, image);
          ASSERT_NE(fit.validity, Validity::kFailed)
              << fit.reason << " " << p.transpose() << " " << force << " " << width;
          EXPECT_LT((fit.p_O - p).norm(), 1e-4 * kFitRadius) << p.transpose() << " " << force;
          EXPECT_NEAR(fit.force / force, 1, 1e-3) << p.transpose() << " " << force;
          EXPECT_LT(fit.residual, 0.1);
        }
      }
    }
  }
}

// A live image cannot wait. Points that no load explains would otherwise press the plate thousands
// of times.
TEST(LoadFit, PressesNoMoreThanItIsAllowed) {
  PlateLargeModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  LoadFitter fitter(plate, {0.004});
  const Image clear = MakeImage(plate, {0.0123, -0.004}, -1, 0.004, 1e-6, nullptr);
  Image mirrored = clear;
  for (std::size_t i = 0; i < clear.points.size(); ++i) {
    if (clear.points[i].x() > 0) mirrored.displacement[i] *= -1;
  }
  constexpr long kEnough = 200;
  fitter.Allow(kEnough);
  EXPECT_EQ(FitTo(fitter, clear).validity, Validity::kValid);
  fitter.Reset();
  fitter.Allow(kEnough);
  const LoadFit none = FitTo(fitter, mirrored);
  EXPECT_EQ(none.validity, Validity::kFailed);
  EXPECT_THAT(none.reason, HasSubstr("no load explains the points"));
  EXPECT_EQ(FitTo(fitter, clear).validity, Validity::kFailed);  // no solutions are left
  fitter.Allow(kEnough);
  EXPECT_EQ(FitTo(fitter, clear).validity, Validity::kValid);
}

// Reference: chi-square. Over many noisy images of the same load the squared errors, weighted by
// the inverse of their stated covariance, have a mean of three, and the residual is one. With 200
// images the mean has a standard deviation of sqrt(2 * 3 / 200) = 0.17; four of them are allowed.
TEST(LoadFit, ErrorsAgreeWithTheStatedCovariance) {
  PlateModel small({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  PlateLargeModel large({kFitRadius, kFitThickness, kFitModulus, kFitNu, 0, 8});
  for (PlateSurface* plate :
       {static_cast<PlateSurface*>(&small), static_cast<PlateSurface*>(&large)}) {
    LoadFitter fitter(*plate, {0.004});
    std::mt19937 random(7);
    const Vector2d p(0.011, 0.006);
    const double force = -0.1;
    double chi_square = 0, residual = 0;
    constexpr int kImages = 200;
    for (int i = 0; i < kImages; ++i) {
      const Image image = MakeImage(*plate, p, force, 0.004, 2e-5, &random);
      const LoadFit fit = FitTo(fitter, image);
      ASSERT_NE(fit.validity, Validity::kFailed) << fit.reason;
      const Eigen::Vector3d error(fit.p_O.x() - p.x(), fit.p_O.y() - p.y(), fit.force - force);
      chi_square += error.dot(fit.covariance.inverse() * error);
      residual += fit.residual * fit.residual;
    }
    EXPECT_NEAR(chi_square / kImages, 3, 0.7);
    EXPECT_NEAR(residual / kImages, 1, 0.1);
  }
}

// The search does not need the last answer as its start, and a wrong start does not harm.
TEST(LoadFit, FollowsALoadThatJumps) {
  PlateModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  LoadFitter fitter(plate, {0});
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-0.02, 0.02);
  for (int i = 0; i < 100; ++i) {
    const Vector2d p(unit(random), unit(random));
    const LoadFit fit = FitTo(fitter, MakeImage(plate, p, -0.02, 0, 1e-6, &random));
    ASSERT_EQ(fit.validity, Validity::kValid) << fit.reason << p.transpose();
    EXPECT_LT((fit.p_O - p).norm(), 6 * std::sqrt(fit.covariance.topLeftCorner<2, 2>().trace()));
  }
}

TEST(LoadFit, SaysWhenTheLoadIsNotIdentified) {
  PlateModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  LoadFitter fitter(plate, {0});
  std::mt19937 random(11);
  int invented = 0;
  for (int i = 0; i < 100; ++i) {
    const LoadFit fit = FitTo(fitter, MakeImage(plate, {0.01, 0}, -1e-9, 0, 2e-5, &random));
    if (fit.validity != Validity::kFailed) ++invented;
  }
  EXPECT_EQ(invented, 0);

  const Image clear = MakeImage(plate, {0.01, 0}, -0.1, 0, 1e-6, nullptr);
  const auto reason = [&](const Image& seen) {
    const LoadFit fit = FitTo(fitter, seen);
    EXPECT_EQ(fit.validity, Validity::kFailed);
    return std::string(fit.reason);
  };
  const std::vector<std::pair<void (*)(Image*), const char*>> mistakes{
      {[](Image* p) {
         p->points.resize(3);
         p->displacement.resize(3);
         p->sigma.resize(3);
       },
       "four"},
      {[](Image* p) { p->sigma.pop_back(); }, "number"},
      {[](Image* p) { p->points[0].x() = 0.05; }, "off the plate"},
      {[](Image* p) { p->displacement[3] = std::nan(""); }, "finite"},
      {[](Image* p) { p->sigma[3] = 0; }, "sigma"},
      {[](Image* p) { std::ranges::fill(p->displacement, 0.0); }, "no load"}};
  for (const auto& [change, words] : mistakes) {
    Image image = clear;
    change(&image);
    EXPECT_THAT(reason(image), HasSubstr(words));
  }
  // The dots on one side alone do not separate a weak distant load from a strong near one.
  Image blurred = MakeImage(plate, {-0.03, 0}, -0.3, 0, 1e-4, &random);
  std::ranges::fill(blurred.sigma, 1e-4);
  blurred.points = {{0.02, 0}, {0.021, 0}, {0.02, 0.001}, {0.021, 0.001}, {0.0205, 0}};
  blurred.displacement.assign(5, -7e-4);
  blurred.sigma.assign(5, 1e-4);
  EXPECT_THAT(reason(blurred), HasSubstr("determine"));
}

TEST(LoadFit, FitsWithoutAllocatingAfterTheFirstCall) {
  PlateLargeModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  LoadFitter fitter(plate, {0.004});
  std::mt19937 random(13);
  const Image first = MakeImage(plate, {0.01, 0.003}, -0.5, 0.004, 1e-5, &random);
  const Image second = MakeImage(plate, {-0.012, 0.001}, -0.2, 0.004, 1e-5, &random);
  EXPECT_NE(FitTo(fitter, first).validity, Validity::kFailed);
  const long before = AllocationCount();
  for (int i = 0; i < 20; ++i) {
    EXPECT_NE(FitTo(fitter, i % 2 == 0 ? first : second).validity, Validity::kFailed);
  }
  EXPECT_EQ(AllocationCount(), before);
}

// A plate whose answers are three times too deep. Its second call fails, and all calls from the
// seventh on: the fit gets its derivatives and then no further answer.
class UnreliablePlate final : public PlateSurface {
 public:
  UnreliablePlate() : PlateSurface({kFitRadius, kFitThickness}) {}
  [[nodiscard]] int calls() const { return calls_; }

 private:
  bool TryRespond(std::span<const Contact> contacts,
                  std::span<ContactResponse> responses) override {
    ++calls_;
    if (calls_ == 2 || calls_ >= 7) return false;
    plate_.Solve(contacts, &solution_);
    std::ranges::copy(solution_.responses(), responses.begin());
    return true;
  }
  [[nodiscard]] double DisplacementAt(const Vector2d& x) noexcept override {
    return 3 * plate_.Displacement(solution_, kFitRadius * x);
  }

  PlateLargeModel plate_{{kFitRadius, kFitThickness, kFitModulus, kFitNu}};
  Solution solution_;
  int calls_ = 0;
};

// Reference: the fit without the finer plate. Its derivatives may be from the previous step, so
// that the covariances agree within a few percent; with derivatives of the finer plate they would
// be a ninth.
TEST(LoadFit, WithoutAFineSolutionTheCoarseOneIsUsed) {
  PlateLargeModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  UnreliablePlate finer;
  LoadFitter fitter(plate, {0.004}, &finer);
  std::mt19937 random(17);
  const Image image = MakeImage(plate, {0.02, 0.003}, -30, 0.004, 2e-5, &random);
  const LoadFit coarse =
      fitter.FitCoarsely(image.points, image.displacement, image.sigma, Rim::kStays);
  fitter.Reset();
  const LoadFit fit = FitTo(fitter, image);
  ASSERT_GE(finer.calls(), 7);
  ASSERT_EQ(coarse.validity, Validity::kValid) << coarse.reason;
  EXPECT_EQ(fit.validity, Validity::kExtrapolated);
  EXPECT_THAT(std::string(fit.reason), HasSubstr("more modes"));
  const Eigen::Vector3d sigma =
      coarse.covariance.diagonal().cwiseSqrt();  // a fit ends within 1e-3 of it
  EXPECT_LT((fit.p_O - coarse.p_O).norm(), 1e-2 * sigma.head<2>().norm());
  EXPECT_NEAR(fit.force, coarse.force, 1e-2 * sigma[2]);
  EXPECT_NEAR(fit.residual, coarse.residual, 1e-3);
  EXPECT_LT((fit.covariance - coarse.covariance).norm(), 0.1 * coarse.covariance.norm());
}

TEST(LoadFit, RefusesAnImpossibleWidth) {
  PlateModel plate({kFitRadius, kFitThickness, kFitModulus, kFitNu});
  EXPECT_THROW(LoadFitter(plate, {-1}), std::invalid_argument);
  EXPECT_THROW(LoadFitter(plate, {0.078}), std::invalid_argument);
  EXPECT_THROW(LoadFitter(plate, {std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
