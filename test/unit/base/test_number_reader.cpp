#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/number_reader.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc {
namespace {

TEST(NumberReader, ReadsWhatTheLibraryReads) {
  Rng rng(6);
  for (int i = 0; i < 20000; ++i) {
    char text[64];
    const char* formats[] = {"%.2f", "%.6f", "%.17g", "%.3e", "%.0f"};
    (void)std::snprintf(text, sizeof text, formats[rng.integer(0, 4)],
                        rng.uniform(-1, 1) * std::pow(10, rng.integer(-20, 20)));
    const auto read = parse_number(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(*read, std::strtod(text, nullptr)) << text;
  }
}

TEST(NumberReader, OddNumbers) {
  EXPECT_EQ(parse_number("976052857.337284"), 976052857.337284);
  EXPECT_EQ(parse_number("-0"), 0.0);
  EXPECT_EQ(parse_number(".5"), 0.5);
  EXPECT_EQ(parse_number("5."), 5.0);
  EXPECT_EQ(parse_number("+7"), 7.0);
  EXPECT_EQ(parse_number("123456789012345678901234567890"), 123456789012345678901234567890.0);
  for (const char* none :
       {"", "-", ".", "-.", "1x", "x", "nan", "inf", "1e999", "0x10", "1,5", "--1", "1 2", "1e", "1.2.3"})
    EXPECT_FALSE(parse_number(none)) << none;
}

TEST(NumberReader, TokensAreSeparated) {
  TokenReader tokens(" \tab  12 \r");
  EXPECT_EQ(tokens.token(), "ab");
  EXPECT_EQ(tokens.number(), 12.0);
  EXPECT_EQ(tokens.token(), "");
  EXPECT_FALSE(tokens.number());
}

}  // namespace
}  // namespace extperfc
