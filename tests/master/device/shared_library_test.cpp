#include "master/device/search/shared_library.h"

#include <clocale>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/device/registry/drivers.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(SharedLibraryTest, NamesTheMissingSymbolAndTheFile) {
  SharedLibrary library({{"libm.so.6"}, {}, false});
  double (*cosine)(double) = nullptr;
  library.Bind("cos", &cosine);
  ASSERT_NE(cosine, nullptr);
  EXPECT_EQ(cosine(0), 1);
  EXPECT_EQ(library.problem(), "");
  int (*none)() = nullptr;
  library.BindOptional("dhdOpen", &none);
  EXPECT_EQ(library.problem(), "");
  library.Bind("dhdOpen", &none);
  EXPECT_EQ(none, nullptr);
  EXPECT_THAT(library.problem(), AllOf(HasSubstr("libm"), HasSubstr("has no dhdOpen")));
}

TEST(DriversTest, RefuseOptionsThatTheyDoNotKnow) {
  for (const char* spec : {"dhd:first", "dhd:-1", "haply:0", "haply:x", "spacemouse:fast",
                           "spacemouse:0", "spacemouse:1e9"}) {
    EXPECT_THROW(OpenDevice(spec, 0.005, 0.02), std::invalid_argument) << spec;
  }
}

}  // namespace
}  // namespace palpate
