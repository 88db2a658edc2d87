#include <gtest/gtest.h>

#include "extperfc/base/md5.hpp"
#include "extperfc/base/text.hpp"

namespace extperfc {
namespace {

TEST(EditDistance, CountsInsertionsRemovalsAndReplacements) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("rate_hz", "rate_hz"), 0U);
}

TEST(Hint, NamesTheNearestOrNothing) {
  const std::vector<std::string> known{"width", "height"};
  EXPECT_EQ(hint_for("hight", known), ", did you mean \"height\"?");
  EXPECT_EQ(hint_for("depth", {"colour"}), "");
  EXPECT_EQ(hint_for("ab", {"cd"}), "") << "as many edits as letters";
  EXPECT_EQ(hint_or_names("x", known), ": known are width and height");
}

TEST(Lists, AreWrittenForPeople) {
  EXPECT_EQ(joined({"a", "b", "c"}, "; "), "a; b; c");
  EXPECT_EQ(enumeration({}), "none");
  EXPECT_EQ(enumeration({"a"}), "a");
  EXPECT_EQ(enumeration({"a", "b", "c"}, " or "), "a, b or c");
  EXPECT_EQ(in_quotes("a\nb"), "\"a?b\"");
  EXPECT_TRUE(ends_with("a.rawlog", ".rawlog"));
  EXPECT_FALSE(ends_with("log", ".rawlog"));
}

TEST(Md5, IsThatOfTheRfc) {  // RFC 1321, appendix A.5
  EXPECT_EQ(md5_hex(""), "d41d8cd98f00b204e9800998ecf8427e");
  EXPECT_EQ(md5_hex("message digest"), "f96b697d7cb7938d525a2f31aaf161d0");
}

}  // namespace
}  // namespace extperfc
