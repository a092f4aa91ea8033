#include "shared/text/html_page.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: the test vectors of RFC 4648.
TEST(HtmlPageTest, PicturesAreInBase64) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

}  // namespace
}  // namespace palpate
