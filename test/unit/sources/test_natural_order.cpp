#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sources/natural_order.hpp"

namespace extperfc::sources {
namespace {

TEST(NaturalOrder, NumbersCompareAsNumbers) {
  std::vector<std::string> names{"10", "2",        "frame12b", "frame2",
                                 "1",  "frame12a", "frame",    "99999999999999999999999"};
  std::sort(names.begin(), names.end(), natural_less);
  const std::vector<std::string> expected{"1",     "2",      "10",       "99999999999999999999999",
                                          "frame", "frame2", "frame12a", "frame12b"};
  EXPECT_EQ(names, expected);
}

TEST(NaturalOrder, StampsKeepTheirOrder) {
  EXPECT_TRUE(natural_less("1305031102.175304", "1305031102.211214"));
  EXPECT_TRUE(natural_less("999.9", "1000.1"));
}

TEST(NaturalOrder, IsAStrictWeakOrder) {
  const std::vector<std::string> names{"", "0", "00", "1", "01", "001a", "1a", "a", "a1", "a01", "a1b", "b"};
  for (const auto& a : names) {
    EXPECT_FALSE(natural_less(a, a));
    for (const auto& b : names) {
      EXPECT_EQ(natural_less(a, b) || natural_less(b, a), a != b) << a << " " << b;
      EXPECT_FALSE(natural_less(a, b) && natural_less(b, a)) << a << " " << b;
      for (const auto& c : names) {
        const bool chain = natural_less(a, b) && natural_less(b, c);
        EXPECT_TRUE(!chain || natural_less(a, c)) << a << " " << b << " " << c;
      }
    }
  }
}

}  // namespace
}  // namespace extperfc::sources
