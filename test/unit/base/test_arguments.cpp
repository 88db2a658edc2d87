#include <gtest/gtest.h>

#include "extperfc/base/arguments.hpp"

namespace extperfc {
namespace {

const ArgumentSyntax kSyntax = {1, 2, {"--out", "--set"}, {"--json", "--help"}};

std::string complaint(const std::vector<std::string>& tokens) {
  const auto read = Arguments::read(tokens, kSyntax);
  return read ? "" : read.error().message;
}

TEST(Arguments, OptionsAndOperandsInAnyOrder) {
  const auto read = Arguments::read({"--json", "a", "--set", "x=1", "--set=y=2", "b"}, kSyntax);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->operands(), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(read->has("--json"));
  EXPECT_FALSE(read->has("--out"));
  EXPECT_EQ(read->all("--set"), (std::vector<std::string>{"x=1", "y=2"}));
  EXPECT_EQ(read->last("--set"), "y=2");
  EXPECT_FALSE(read->last("--out"));
}

TEST(Arguments, BehindTwoDashesNothingIsAnOption) {
  const auto read = Arguments::read({"--", "--json", "-h"}, kSyntax);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->operands(), (std::vector<std::string>{"--json", "-h"}));
}

TEST(Arguments, WhatDoesNotFitIsNamed) {
  EXPECT_EQ(complaint({"a", "--jsn"}), "unknown option --jsn, did you mean \"--json\"?");
  EXPECT_EQ(complaint({"a", "--something-else"}), "unknown option --something-else");
  EXPECT_EQ(complaint({"a", "--out"}), "--out needs a value");
  EXPECT_EQ(complaint({"a", "--json=1"}), "--json takes no value");
  EXPECT_EQ(complaint({"a", "b", "c"}), "unexpected argument c");
  EXPECT_EQ(complaint({}), "too few arguments");
  EXPECT_EQ(complaint({"-h"}), "");  // help needs nothing else
}

TEST(Arguments, Numbers) {
  const auto read = Arguments::read({"a", "--out", "2.5", "--set", "1,-2e0,3"}, kSyntax);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->number("--out", 0, 3)->value(), 2.5);
  EXPECT_FALSE(read->number("--missing", 0, 3)->has_value());
  EXPECT_EQ(read->number("--out", 0, 2).error().message, "--out must be a number from 0 to 2, not '2.5'");
  EXPECT_EQ(read->numbers("--set", 3)->value(), (std::vector<double>{1, -2, 3}));
  EXPECT_FALSE(read->numbers("--set", 2));
  const auto spaced = Arguments::read({"a", "--set", "1, -2,  3"}, kSyntax);
  EXPECT_EQ(spaced->numbers("--set", 3)->value(), (std::vector<double>{1, -2, 3}));
  for (const char* bad : {"", "x", "1x", "nan", "inf", "1,,2", "1,2,3,"}) {
    const auto other = Arguments::read({"a", "--set", bad}, kSyntax);
    EXPECT_FALSE(other->number("--set", 0, 10)) << bad;
    EXPECT_FALSE(other->numbers("--set", 2)) << bad;
  }
}

}  // namespace
}  // namespace extperfc
