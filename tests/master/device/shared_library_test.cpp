#include "master/device/search/shared_library.h"

#include <clocale>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/device/registry/drivers.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(SharedLibraryTest, SaysWhyALibraryDoesNotLoad) {
  const LibrarySearch search{{"libno_such_device.so.7"}, {"/nowhere"}, false};
  const SharedLibrary library(search);
  EXPECT_EQ(library.file(), "");
  EXPECT_THAT(library.problem(), AllOf(HasSubstr("libno_such_device.so.7"), HasSubstr("No such")));
  EXPECT_THAT(InWords(search), AllOf(HasSubstr("libno_such_device.so.7"), HasSubstr("/nowhere")));
}

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

TEST(SharedLibraryTest, VendorsParseNumbersWithADot) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // where it is installed
  const SharedLibrary library({{"libm.so.6"}, {}, false});
  EXPECT_STREQ(std::localeconv()->decimal_point, ".");
  std::setlocale(LC_NUMERIC, before.c_str());
}

// Whatever is installed here: each driver says what it looked for, and what to do where it is not
// usable.
TEST(DriversTest, EachSaysWhatItSearchedAndWhatToDo) {
  for (const Driver& driver : Drivers()) {
    const DriverReport report = driver.examine();
    EXPECT_THAT(report.searched, Not(IsEmpty())) << driver.name;
    if (report.usable) continue;
    EXPECT_THAT(report.missing, Not(IsEmpty())) << driver.name;
    EXPECT_NE(report.next, "") << driver.name;
  }
}

TEST(DriversTest, RefuseOptionsThatTheyDoNotKnow) {
  for (const char* spec : {"dhd:first", "dhd:-1", "haply:0", "haply:x", "gamepad:fast", "gamepad:0",
                           "spacemouse:1e9"}) {
    EXPECT_THROW(OpenDevice(spec, 0.005, 0.02), std::invalid_argument) << spec;
  }
}

}  // namespace
}  // namespace palpate
