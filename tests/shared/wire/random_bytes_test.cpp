// Random bytes: a message that parses is either refused or has only finite values.
#include <random>
#include <string>

#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include "shared/wire/state_message.h"
#include "tests/shared/wire/samples.h"

namespace palpate {
namespace {

bool AllFinite(const FingerState& finger) {
  return finger.p_S_contact.allFinite() && (!finger.force || finger.force->allFinite());
}

bool AllFinite(const SlaveState& s) {
  for (const FingerState& finger : s.fingers) {
    if (!AllFinite(finger)) return false;
  }
  return s.p_S_tip.allFinite() && (!s.force || s.force->allFinite()) &&
         (!s.true_force || s.true_force->allFinite()) && s.offset.allFinite() &&
         s.local_model.reference.allFinite() && s.local_model.normal.allFinite() &&
         s.local_model.force.allFinite() && s.local_model.stiffness.allFinite() &&
         std::isfinite(s.local_model.valid_radius) && std::isfinite(s.sigma) &&
         std::isfinite(s.echo_delay);
}

bool AllFinite(const OperatorCommand& c) {
  return c.p_M.allFinite() && c.velocity.allFinite();
}

// Flips up to eight bytes of a good message `rounds` times; what still parses is read. Returns how
// many were accepted.
template <class Message, class Domain>
int ReadDamaged(const Domain& good, int rounds) {
  const google::protobuf::LogSilencer silence;
  Message message;
  ToProto(good, &message);
  const std::string bytes = message.SerializeAsString();
  std::mt19937 random(1);
  int accepted = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string damaged = bytes;
    for (auto flips = random() % 8 + 1; flips > 0; --flips) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    if (!message.ParseFromString(damaged)) continue;
    std::string reason;
    const auto read = FromProto(message, &reason);
    EXPECT_NE(read.has_value(), !reason.empty()) << "round " << round;
    if (!read) continue;
    EXPECT_TRUE(AllFinite(*read)) << "round " << round;
    ++accepted;
  }
  return accepted;
}

TEST(RandomBytesTest, ADamagedStateIsRefusedOrFinite) {
  const int rounds = 100'000;
  const int accepted = ReadDamaged<v1::SlaveState>(FullState(), rounds);
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, rounds);
}

TEST(RandomBytesTest, ADamagedCommandIsRefusedOrFinite) {
  const int rounds = 100'000;
  const int accepted = ReadDamaged<v1::OperatorCommand>(FullCommand(), rounds);
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, rounds);
}

}  // namespace
}  // namespace palpate
