#include <gtest/gtest.h>

#include "extperfc/base/problems.hpp"

namespace extperfc {
namespace {

TEST(Problems, AreListedInTheOrderOfTheFile) {
  Problems problems("lab.yaml");
  EXPECT_TRUE(problems.empty());
  problems.add(12, "objects[3].size", "is missing: add it");
  problems.add(3, "", "not YAML", ErrorCode::kCorrupt);
  problems.add(0, "file", "does not exist");
  EXPECT_EQ(problems.size(), 3U);
  const Error error = problems.to_error();
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument) << "that of the first one added";
  EXPECT_EQ(error.message,
            "lab.yaml: file: does not exist\nlab.yaml:3: not YAML\n"
            "lab.yaml:12: objects[3].size: is missing: add it");
}

TEST(Problems, TheFirstOneGivesTheCode) {
  Problems problems("a", ErrorCode::kCorrupt);
  EXPECT_EQ(problems.to_error().code, ErrorCode::kCorrupt);
  problems.add(1, "", "x", ErrorCode::kNotFound);
  problems.add(2, "", "y");
  EXPECT_EQ(problems.to_error().code, ErrorCode::kNotFound);
}

TEST(Problems, BeyondAHundredAreCounted) {
  Problems problems("a");
  for (int i = 1; i <= 103; ++i) problems.add(i, "", "wrong");
  const auto lines = problems.lines();
  ASSERT_EQ(lines.size(), Problems::kMax + 1);
  EXPECT_EQ(lines.back(), "a: and 3 more problems");
}

}  // namespace
}  // namespace extperfc
