// Localisers against a measured contact normal: another laboratory's presses of such a fingertip on
// a plate that is followed by motion capture. Errors are medians after the best single rotation.
#include <cstdio>
#include <filesystem>

#include <gtest/gtest.h>

#include "slave/tactile/localise/contact_point.h"
#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/localise/localiser.h"
#include "tests/slave/tactile/localise/plate_presses.h"

namespace palpate {
namespace {

class ContactDirectionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    layout_ = presses::Layout();
    trial_ = presses::Read("trial1", 2440);
    short_ = presses::Read("short_15258", 2460);  // the only short take that has contact
    if (!layout_ || !trial_ || !short_) GTEST_SKIP() << "../shared/data is absent";
  }
  [[nodiscard]] std::unique_ptr<Localiser> Make(const std::string& variant) const {
    Tactile tactile;
    tactile.localise = variant;
    return MakeLocaliser(tactile, *layout_);
  }
  static void Print(const char* name, const char* what, const presses::Errors& e) {
    std::printf(
        "  %-18s %-12s %4zu of %4d rows: median %5.2f, 68%% %5.2f, 90%% %5.2f degrees, 68%% within "
        "%4.2f sigma\n",
        name, what, e.degrees.size(), e.rows, e.median(), e.Quantile(0.68), e.Quantile(0.9),
        e.of_sigma[e.of_sigma.size() * 68 / 100]);
  }

  std::optional<ElectrodeLayout> layout_;
  std::optional<presses::Presses> trial_, short_;
};

TEST_F(ContactDirectionTest, Table) {
  const std::size_t half = trial_->change.size() / 2;
  for (const char* variant : {"paper", "polarity-free", "pressure-weighted"}) {
    const auto localiser = Make(variant);
    Print(variant, "trial 1", presses::ErrorsOf(*localiser, *trial_));
    Print(variant, "first half", presses::ErrorsOf(*localiser, presses::Part(*trial_, 0, half)));
    Print(variant, "second half",
          presses::ErrorsOf(*localiser, presses::Part(*trial_, half, 2 * half)));
    Print(variant, "short take", presses::ErrorsOf(*localiser, *short_));
  }
  const auto first = presses::Part(*trial_, 0, half),
             second = presses::Part(*trial_, half, trial_->change.size());
  const auto a = FitLocaliser(first.change, first.normal_F, *layout_, {});
  const auto b = FitLocaliser(second.change, second.normal_F, *layout_, {});
  const auto c = FitLocaliser(trial_->change, trial_->normal_F, *layout_, {});
  for (const auto& w : {a, b, c}) std::printf("cv %g share %g ridge %g\n", w.median_error * 57.3, 0.0, w.ridge);
  Print("fitted", "1 -> 2", presses::ErrorsOf(*MakeFittedLocaliser(a, 7e-3), second));
  Print("fitted", "2 -> 1", presses::ErrorsOf(*MakeFittedLocaliser(b, 7e-3), first));
  Print("fitted", "1 -> short", presses::ErrorsOf(*MakeFittedLocaliser(a, 7e-3), *short_));
  Print("fitted", "2 -> short", presses::ErrorsOf(*MakeFittedLocaliser(b, 7e-3), *short_));
  Print("fitted", "all -> short", presses::ErrorsOf(*MakeFittedLocaliser(c, 7e-3), *short_));
}

}  // namespace
}  // namespace palpate
