// Fields that were renamed before the first release keep number and type, so that recordings and
// programs from before are still understood. Reference: bytes after the encoding of protobuf.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"

namespace palpate {
namespace {

template <class Message>
Message Read(const std::string& bytes) {
  Message message;
  EXPECT_TRUE(message.ParseFromString(bytes));
  return message;
}

TEST(RenamedFieldsTest, SampleTraceHasItsStagesAsFourAndFive) {
  // float seen = 4; float felt = 5;
  const auto trace =
      Read<v1::SampleTrace>(std::string("\x25\x00\x00\x80\x3f\x2d\x00\x00\x00\x40", 10));
  EXPECT_EQ(trace.processed(), 1);
  EXPECT_EQ(trace.solved(), 2);
}

TEST(RenamedFieldsTest, MeshStateHasItsFixedNodesAsNine) {
  // repeated uint32 held = 9;
  const auto mesh = Read<v1::MeshState>("\x4a\x02\x01\x03");
  EXPECT_THAT(mesh.fixed_nodes(), testing::ElementsAre(1, 3));
}

TEST(RenamedFieldsTest, DatagramCountHasWhatWasReceivedAsTwo) {
  // uint64 newest = 1; uint64 came = 2;
  const auto count = Read<v1::DatagramCount>("\x08\x05\x10\x04");
  EXPECT_EQ(count.newest(), 5);
  EXPECT_EQ(count.received(), 4);
}

TEST(RenamedFieldsTest, StatusHasItsCamerasAsThirtyOneAndTheModelBuildAsThirtyTwo) {
  // EyesStatus eyes = 31 {uint64 taken = 2}; Making making = 32 {string stage = 1};
  const auto status = Read<v1::Status>("\xfa\x01\x02\x10\x07\x82\x02\x03\x0a\x01x");
  EXPECT_EQ(status.cameras().taken(), 7);
  EXPECT_EQ(status.making().stage(), "x");
}

}  // namespace
}  // namespace palpate
