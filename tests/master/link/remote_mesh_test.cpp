#include "master/link/remote_mesh.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpate/v1/state.pb.h"

namespace palpate {
namespace {

using testing::HasSubstr;

// A tetrahedron's surface, its top pressed down by 0.25 m.
v1::MeshState Tetrahedron() {
  v1::MeshState message;
  message.set_sequence(7);
  message.mutable_sensed_at()->set_seconds(1000);
  message.set_nodes_per_element(3);
  for (const unsigned node : {0U, 2U, 1U, 0U, 1U, 3U, 1U, 2U, 3U, 2U, 0U, 3U}) {
    message.add_elements(node);
  }
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F})
    message.add_rest(x);
  message.mutable_positions()->CopyFrom(message.rest());
  message.set_positions(11, 0.75F);
  message.set_validity(v1::VALIDITY_VALID);
  return message;
}

v1::MeshState Later() {
  v1::MeshState message = Tetrahedron();
  message.clear_elements();
  message.clear_rest();
  message.clear_nodes_per_element();
  message.set_positions(11, 0.5F);
  return message;
}

TEST(RemoteMeshTest, TheTopologyOfTheFirstMessageStaysForThoseThatFollow) {
  std::string reason;
  v1::MeshState message = Tetrahedron();
  message.add_fixed_nodes(1);
  message.add_fixed_nodes(3);
  const auto first = FromProto(message, nullptr, &reason);
  ASSERT_TRUE(first) << reason;
  EXPECT_EQ(first->topology->fixed_nodes, (std::vector<std::uint32_t>{1, 3}));
  EXPECT_EQ(first->sequence, 7U);
  EXPECT_EQ(first->validity, Validity::kValid);
  EXPECT_EQ(first->topology->surface.triangles.size(), 4U);
  EXPECT_TRUE(first->topology->lines.empty());
  EXPECT_EQ(first->LargestDeflection(), 0.25);
  const auto second = FromProto(Later(), first->topology, &reason);
  ASSERT_TRUE(second) << reason;
  EXPECT_EQ(second->topology, first->topology);
  EXPECT_EQ(second->LargestDeflection(), 0.5);
  EXPECT_EQ(second->positions[3], Eigen::Vector3d(0, 0, 0.5));
}

// Reference: a float resolves 6e-8 of the tetrahedron's size of about a metre.
TEST(RemoteMeshTest, RoundingIsNoDeflection) {
  v1::MeshState message = Tetrahedron();
  message.set_positions(11, 1.F);
  message.set_positions(0, 3e-9F);
  std::string reason;
  EXPECT_EQ(FromProto(message, nullptr, &reason)->LargestDeflection(), 0);
  message.set_positions(0, 1e-6F);
  EXPECT_NEAR(FromProto(message, nullptr, &reason)->LargestDeflection(), 1e-6, 1e-12);
}

TEST(RemoteMeshTest, TractionIsThereWhereItIsSent) {
  v1::MeshState message = Tetrahedron();
  std::string reason;
  EXPECT_TRUE(FromProto(message, nullptr, &reason)->traction.empty());
  for (const float pascals : {0.F, 0.F, 150.F, 12750.F}) message.add_traction(pascals);
  const auto mesh = FromProto(message, nullptr, &reason);
  ASSERT_TRUE(mesh) << reason;
  EXPECT_THAT(mesh->traction, testing::ElementsAre(0, 0, 150, 12750));
}

struct Damage {
  const char* reason;
  std::function<void(v1::MeshState*)> apply;
};

class DamagedMeshTest : public testing::TestWithParam<Damage> {};

TEST_P(DamagedMeshTest, IsRefusedWithAReason) {
  v1::MeshState message = Tetrahedron();
  GetParam().apply(&message);
  std::string reason;
  EXPECT_FALSE(FromProto(message, nullptr, &reason));
  EXPECT_THAT(reason, HasSubstr(GetParam().reason));
}

constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    OneEach, DamagedMeshTest,
    testing::Values(Damage{"rest is absent", [](auto* m) { *m = Later(); }},
                    Damage{"nodes_per_element", [](auto* m) { m->set_nodes_per_element(4); }},
                    Damage{"elements", [](auto* m) { m->set_elements(5, 4); }},
                    Damage{"fixed_nodes", [](auto* m) { m->add_fixed_nodes(4); }},
                    Damage{"positions", [](auto* m) { m->set_positions(2, kFloatNan); }},
                    Damage{"positions", [](auto* m) { m->mutable_positions()->Truncate(9); }},
                    Damage{"traction", [](auto* m) { m->add_traction(1); }},
                    Damage{"traction", [](auto* m) {
                             for (const float pascals : {1.F, 2.F, 3.F, kFloatNan})
                               m->add_traction(pascals);
                           }}));

// A triangle of the tetrahedron as a camera sees it.
v1::MeshState WithField() {
  v1::MeshState message = Tetrahedron();
  v1::DisplacementField* field = message.mutable_field();
  for (const unsigned node : {0U, 1U, 2U}) field->add_triangles(node);
  for (int i = 0; i < 9; ++i) field->add_rest(static_cast<float>(i));
  for (int i = 0; i < 9; ++i) field->add_displacement(0.125F * static_cast<float>(i));
  for (int i = 0; i < 6; ++i) field->add_image(static_cast<float>(10 * i));
  return message;
}

TEST(RemoteMeshTest, AFieldHasItsOwnNodesAndTheirPlacesInTheImage) {
  std::string reason;
  v1::MeshState message = WithField();
  message.mutable_field()->set_image(0, std::numeric_limits<float>::quiet_NaN());
  const auto first = FromProto(message, nullptr, &reason);
  ASSERT_TRUE(first) << reason;
  EXPECT_EQ(first->topology->field_triangles, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(first->topology->field_rest.size(), 9U);
  ASSERT_EQ(first->displacement.size(), 9U);
  EXPECT_EQ(first->displacement[8], 1);
  ASSERT_EQ(first->image.size(), 6U);
  EXPECT_TRUE(std::isnan(first->image[0])) << "behind the camera";
  v1::MeshState later = Later();
  for (int i = 0; i < 9; ++i) later.mutable_field()->add_displacement(2);
  const auto second = FromProto(later, first->topology, &reason);
  ASSERT_TRUE(second) << reason;
  EXPECT_EQ(second->displacement[0], 2);
  EXPECT_TRUE(second->image.empty()) << "no camera";
  const auto plain = FromProto(Tetrahedron(), nullptr, &reason);
  const auto unknown = FromProto(later, plain->topology, &reason);
  ASSERT_TRUE(unknown) << reason;
  EXPECT_TRUE(unknown->displacement.empty()) << "its nodes are not known";
}

TEST(RemoteMeshTest, AFieldThatCannotBeIsRejected) {
  using Alter = std::function<void(v1::DisplacementField*)>;
  for (const Alter& alter : {Alter([](auto* field) { field->add_rest(0); }),
                             Alter([](auto* field) { field->set_triangles(1, 3); }),
                             Alter([](auto* field) { field->add_triangles(0); }),
                             Alter([](auto* field) { field->set_displacement(0, NAN); }),
                             Alter([](auto* field) { field->add_displacement(0); }),
                             Alter([](auto* field) { field->add_image(0); })}) {
    v1::MeshState message = WithField();
    alter(message.mutable_field());
    std::string reason;
    EXPECT_FALSE(FromProto(message, nullptr, &reason));
    EXPECT_THAT(reason, HasSubstr("field"));
  }
}

}  // namespace
}  // namespace palpate
