#include "slave/tactile/localise/localiser.h"

#include <limits>
#include <memory>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Status = TouchPlace::Status;

constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kRestValue = 3000;
constexpr std::size_t kPdc = kElectrodeCount + 1;

// On the simulated layout.
class LocaliserTest : public ::testing::Test {
 protected:
  static FingerReading RawOf(const TactileSignals& change) {
    FingerReading raw;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      raw.channels[i] = kRestValue + static_cast<float>(change[i]);
    }
    return raw;
  }
  [[nodiscard]] TouchPlace Locate(const TactileSignals& change) const {
    return localiser_->Locate(change, RawOf(change));
  }

  ElectrodeLayout layout_ = SimulatedLayout(7e-3);
  std::unique_ptr<Localiser> localiser_ = MakeLocaliser({}, layout_);
};

TEST_F(LocaliserTest, FindsAContactOverTheElectrodeThatFalls) {
  const FingerSurface surface{7e-3};
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    TactileSignals change{};
    change[i] = -80;
    const TouchPlace place = Locate(change);
    EXPECT_EQ(place.status, Status::kFound) << i;
    EXPECT_EQ(place.active, 1);
    EXPECT_LT((place.p_F - *surface.Project(layout_.p_F[i])).norm(), 1e-15) << i;
    EXPECT_LT((place.n_F - surface.Normal(place.p_F)).norm(), 1e-15) << i;
    EXPECT_GT(place.sigma, 0.2e-3);
    EXPECT_LT(place.sigma, 4e-3);
  }
}

TEST_F(LocaliserTest, SaysThatTheContactHasNoDirection) {
  layout_.p_F[0] = {2e-3, 0, 4e-3};
  layout_.p_F[1] = {-2e-3, 0, -4e-3};
  layout_.p_F[0].x() = -2e-3;
  const auto localiser = MakeLocaliser({}, layout_);
  TactileSignals change{};
  change[0] = change[1] = -50;
  EXPECT_EQ(localiser->Locate(change, RawOf(change)).status, Status::kAtOrigin);
}

TEST_F(LocaliserTest, FailsOnSignalsThatAreNotFinite) {
  for (std::size_t i = 0; i < kSignalCount; ++i) {
    TactileSignals change{};
    change[2] = -50;
    FingerReading raw = RawOf(change);
    change[i] = kFloatNan;
    EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFailed) << i;
    change[i] = std::numeric_limits<float>::infinity();
    EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFailed) << i;
  }
  TactileSignals change{};
  FingerReading raw = RawOf(change);
  raw.channels[4] = kFloatNan;
  EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFailed);
}

TEST_F(LocaliserTest, FlagsSaturatedElectrodes) {
  TactileSignals change{};
  change[6] = -80;
  FingerReading raw = RawOf(change);
  raw.channels[11] = 4095;
  EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFlawed);
  raw.channels[11] = 0;
  EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFlawed);
  EXPECT_TRUE(localiser_->Locate(change, raw).usable());
  raw.channels[11] = 1;
  EXPECT_EQ(localiser_->Locate(change, raw).status, Status::kFound);
}

// All electrodes change except one. The correction for pressure alone would make the faulty
// electrode active; it must not be, because its neighbours rose at least as much as the pressure
// explains.
TEST_F(LocaliserTest, FlagsAndLeavesOutADeadElectrode) {
  TactileSignals change{};
  change.fill(90);
  change[kPdc] = 500;
  change[13] = -200;
  EXPECT_EQ(Locate(change).status, Status::kFound);
  const Vector3d sound = Locate(change).p_F;
  change[6] = 0;
  const TouchPlace place = Locate(change);
  EXPECT_EQ(place.status, Status::kFlawed);
  EXPECT_LT((place.p_F - sound).norm(), 1e-15);
}

TEST_F(LocaliserTest, AllocatesNothing) {
  TactileSignals change{};
  const FingerReading raw = RawOf(change);
  const long before = AllocationCount();
  for (int k = 0; k < 100; ++k) {
    change[static_cast<std::size_t>(k) % kElectrodeCount] = static_cast<float>(-k);
    (void)localiser_->Locate(change, raw);
  }
  EXPECT_EQ(AllocationCount(), before);
}

// A soft contact: the pressure rises and all electrodes with it, least at the finger's side at +y.
TEST_F(LocaliserTest, FindsASoftContactUnderWhichNoElectrodeFalls) {
  TactileSignals change{};
  change[kPdc] = 200;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    change[i] = layout_.n_F[i].y() > 0.5 ? 2.0F : 40.0F;
  }
  FingerReading raw;
  raw.channels.fill(kRestValue);
  const TouchPlace place = localiser_->Locate(change, raw);
  EXPECT_TRUE(place.usable());
  EXPECT_GT(place.n_F.y(), 0.7);
}

}  // namespace
}  // namespace palpate
