#include "slave/scene/model_kinds.h"

#include <set>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(ModelKinds, EveryKindIsFoundByItsOwnName) {
  std::set<std::string_view> names;
  for (const ModelKind& kind : kModelKinds) {
    EXPECT_EQ(FindModelKind(kind.name), &kind);
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name << " stands twice";
  }
  EXPECT_EQ(FindModelKind("auto"), nullptr);
  EXPECT_EQ(FindModelKind("fem-"), nullptr);
}

TEST(ModelKinds, AnObjectTakesItsOwnKindsAndAuto) {
  EXPECT_TRUE(IsKindFor(ObjectClass::kMembrane, "auto"));
  EXPECT_TRUE(IsKindFor(ObjectClass::kMembrane, "plate-large"));
  EXPECT_FALSE(IsKindFor(ObjectClass::kMembrane, "fem"));
  EXPECT_FALSE(IsKindFor(ObjectClass::kVolume, "bem2d"));
  EXPECT_FALSE(IsKindFor(ObjectClass::kVolume, ""));
  EXPECT_EQ(KindsFor(ObjectClass::kOutline), "auto or bem2d");
  EXPECT_EQ(KindsFor(ObjectClass::kMembrane), "auto, plate or plate-large");
}

// What a row says of an object it cannot compute would never be read, or be read wrongly.
TEST(ModelKinds, FactsFitTheObject) {
  for (const ModelKind& kind : kModelKinds) {
    const bool is_volume = kind.object == ObjectClass::kVolume;
    EXPECT_TRUE(is_volume || !(kind.has_tets || kind.iterates)) << kind.name;
    EXPECT_TRUE(kind.object == ObjectClass::kMembrane || kind.object == ObjectClass::kDome ||
                !kind.takes_tension)
        << kind.name;
    EXPECT_EQ(is_volume, kind.has_tets) << kind.name;
    EXPECT_TRUE(kind.iterates || kind.linearity != Linearity::kByLaw) << kind.name;
    EXPECT_TRUE(kind.takes_friction || !kind.shapes_tools) << kind.name;
    EXPECT_TRUE(kind.has_tets || !kind.estimates_error) << kind.name;
  }
}

}  // namespace
}  // namespace palpate
