#include <gtest/gtest.h>

#include "extperfc/world/class_filter.hpp"

namespace extperfc {
namespace {

const std::vector<std::string> kNames{"cube", "sphere", "traffic light", "7"};

ClassFilter filter_of(const std::string& list, const std::vector<std::string>& names = kNames) {
  const auto filter = ClassFilter::make(list, names);
  EXPECT_TRUE(filter) << filter.error().message;
  return filter.value_or(ClassFilter());
}

TEST(ClassFilter, EmptyAllowsAll) {
  for (const char* list : {"", "  ", ",", " , ,"}) {
    EXPECT_TRUE(filter_of(list).allows_all()) << list;
    EXPECT_TRUE(filter_of(list).allows(-1)) << list;
  }
}

TEST(ClassFilter, NamesAndIndices) {
  const auto filter = filter_of("traffic light, 0");
  EXPECT_TRUE(filter.allows(0));
  EXPECT_FALSE(filter.allows(1));
  EXPECT_TRUE(filter.allows(2));
  EXPECT_FALSE(filter.allows(-1));
  EXPECT_FALSE(filter.allows_all());
  EXPECT_TRUE(filter_of("7").allows(3)) << "a name goes before an index";
}

TEST(ClassFilter, IndicesDoWithoutNames) {
  EXPECT_TRUE(filter_of("12", {}).allows(12));
  const auto unknown = ClassFilter::make("cube", {});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("not known yet"), std::string::npos) << unknown.error().message;
}

TEST(ClassFilter, WhatIsNoClassIsNamed) {
  for (const char* wrong : {"cubes", "4", "-1", "1.5", "cube sphere", "0x1", "99999999999"}) {
    const auto filter = ClassFilter::make(std::string("sphere, ") + wrong, kNames);
    ASSERT_FALSE(filter) << wrong;
    EXPECT_EQ(filter.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(filter.error().message.find(wrong), std::string::npos) << filter.error().message;
  }
  EXPECT_NE(ClassFilter::make("cubes", kNames).error().message.find("cube"), std::string::npos);
}

}  // namespace
}  // namespace extperfc
