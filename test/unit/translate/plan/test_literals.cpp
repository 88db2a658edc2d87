#include <cmath>

#include <gtest/gtest.h>

#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/definitions.hpp"
#include "test/unit/translate/plan/literal_of.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

Literal list(std::vector<Literal> items) {
  Literal literal;
  literal.kind = Literal::Kind::kList;
  literal.list = std::move(items);
  return literal;
}

/// The bytes of a literal in a field such as "int8[] v", or "error: ...".
std::string bytes_of(const Literal& literal, const std::string& field) {
  Definitions definitions;
  definitions.define_common();
  const auto schema = definitions.define("p/T", field);
  ByteBuffer out;
  out.append("x", 1);
  const auto done = serialize(literal, schema->fields().front(), out);
  if (done) return string_of(out).substr(1);
  EXPECT_EQ(string_of(out), "x") << "nothing is written after an error";
  return "error: " + done.error().message;
}

bool refused(const std::string& text, const std::string& field) {
  return bytes_of(scalar(text), field).rfind("error: ", 0) == 0;
}

}  // namespace

TEST(Literals, Integers) {
  EXPECT_EQ(bytes_of(scalar("-3"), "int8 v"), "\xFD");
  EXPECT_EQ(bytes_of(scalar("0x10"), "uint16 v"), Bytes().put<std::uint16_t>(16).str());
  EXPECT_EQ(bytes_of(scalar("18446744073709551615"), "uint64 v"), Bytes().put(~std::uint64_t{0}).str());
  for (const auto* text : {"256", "-1", "1.5", "", "one", "1 ", "0x"})
    EXPECT_TRUE(refused(text, "uint8 v")) << text;
}

TEST(Literals, FloatingPoint) {
  EXPECT_EQ(bytes_of(scalar("-1.5e3"), "float64 v"), Bytes().put(-1500.0).str());
  EXPECT_EQ(bytes_of(scalar("+2"), "float32 v"), Bytes().put(2.0F).str());
  EXPECT_EQ(bytes_of(scalar("inf"), "float32 v"), Bytes().put(HUGE_VALF).str());
  for (const auto* text : {"1e39", "", "1,5"}) EXPECT_TRUE(refused(text, "float32 v")) << text;
}

TEST(Literals, BoolsAndStrings) {
  EXPECT_EQ(bytes_of(scalar("true"), "bool v"), "\x01");
  EXPECT_EQ(bytes_of(scalar("0"), "bool v"), std::string(1, '\0'));
  EXPECT_TRUE(refused("2", "bool v"));
  EXPECT_EQ(bytes_of(scalar("a b"), "string v"), Bytes().text("a b").str());
}

TEST(Literals, TimesAndDurationsInSeconds) {
  EXPECT_EQ(bytes_of(scalar("1.000000002"), "time v"), Bytes().put(1U).put(2U).str());
  EXPECT_EQ(bytes_of(scalar("-0.25"), "duration v"), Bytes().put(-1).put(750'000'000).str());
  EXPECT_EQ(bytes_of(scalar("4294967295"), "time v"), Bytes().put(0xFFFFFFFFU).put(0U).str());
  for (const auto* text : {"-1", "1.0000000001", "4294967296", "."})
    EXPECT_TRUE(refused(text, "time v")) << text;
}

TEST(Literals, ArraysAndMessages) {
  EXPECT_EQ(bytes_of(list({scalar("1"), scalar("2")}), "uint8[] v"),
            Bytes().count(2).put('\1').put('\2').str());
  EXPECT_EQ(bytes_of(list({scalar("1"), scalar("2")}), "uint8[2] v"), "\x01\x02");
  EXPECT_EQ(bytes_of(list({scalar("1")}), "uint8[2] v").rfind("error: ", 0), 0U);
  EXPECT_TRUE(refused("1", "uint8[] v"));
  Literal point;
  point.kind = Literal::Kind::kFields;
  point.fields = {{"y", scalar("2")}};
  EXPECT_EQ(bytes_of(point, "geometry_msgs/Point v"), Bytes().put(0.0).put(2.0).put(0.0).str());
  point.fields = {{"q", scalar("2")}};
  EXPECT_NE(bytes_of(point, "geometry_msgs/Point v").find("no field q"), std::string::npos);
}

TEST(Literals, Defaults) {
  Definitions definitions;
  definitions.define_common();
  ByteBuffer out;
  serialize_default(*definitions.define("p/T", "std_msgs/Header h\nstring[] s\nint16[3] v\nstring[2] t"),
                    out);
  EXPECT_EQ(string_of(out), std::string(16 + 4 + 6 + 8, '\0'));
}
