// Fields that pair by name: kept, added, dropped, moved, widened, narrowed.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/definitions.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

class PlanFields : public testing::Test {
 protected:
  PlanFields() { definitions.define_common(); }

  PlanPtr plan(const std::string& from, const std::string& to, const PlanOptions& options = {}) {
    auto compiled =
        Plan::compile(definitions.define("p/From", from), definitions.define("p/To", to), RuleSet(), options);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return compiled ? *compiled : nullptr;
  }
  std::string refusal(const std::string& from, const std::string& to) {
    auto compiled =
        Plan::compile(definitions.define("p/From", from), definitions.define("p/To", to), RuleSet());
    return compiled ? "compiled" : compiled.error().message;
  }
  std::string result(const std::string& from, const std::string& to, const Bytes& message) {
    return converted(*plan(from, to), message.str());
  }

  Definitions definitions;
};

void expect_says(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace

TEST_F(PlanFields, TheSameLayoutPassesAndIsChecked) {
  const auto same =
      plan("int32 A=1\nHeader header\nstring[] names", "int32 A=2\nHeader header\nstring[] names");
  EXPECT_EQ(same->kind(), Plan::Kind::kPass);
  const auto message = Bytes().put(7U).put(1U).put(2U).text("base").count(1).text("arm").str();
  EXPECT_EQ(converted(*same, message), message);
  expect_says(converted(*same, message + "x"), "1 byte left");
}

TEST_F(PlanFields, ByteAndCharAreOtherNamesOfIntegers) {
  EXPECT_EQ(plan("byte a\nchar b", "int8 a\nuint8 b")->kind(), Plan::Kind::kPass);
  EXPECT_EQ(plan("bool a", "uint8 a")->kind(), Plan::Kind::kConvert) << "a bool is no number";
}

TEST_F(PlanFields, EqualMd5sDoNotMeanEqualLayouts) {
  const auto single = definitions.define("p/T", "geometry_msgs/Point p");
  const auto several = definitions.define("p/T", "geometry_msgs/Point[] p");
  ASSERT_EQ(single->md5(), several->md5());
  const auto compiled = Plan::compile(single, several, RuleSet());
  ASSERT_FALSE(compiled);
  expect_says(compiled.error().message, "field p: geometry_msgs/Point does not become geometry_msgs/Point[]");
}

TEST_F(PlanFields, AddedFieldsAreZeroOrEmpty) {
  EXPECT_EQ(result("uint8 a", "uint8 a\nstring s\nfloat64[] v\nHeader header\nint16[3] f",
                   Bytes().put<std::uint8_t>(5)),
            Bytes()
                .put<std::uint8_t>(5)
                .text("")
                .count(0)
                .put(0U)
                .put(std::uint64_t{0})
                .text("")
                .put(std::uint16_t{0})
                .put(0U)
                .str());
}

TEST_F(PlanFields, DroppedFieldsAreSkipped) {
  EXPECT_EQ(result("string a\nstring[] b\nuint8 c\nstd_msgs/Header[] d\nuint16 e", "uint8 c\nuint16 e",
                   Bytes()
                       .text("xyz")
                       .count(2)
                       .text("1")
                       .text("22")
                       .put<std::uint8_t>(9)
                       .count(1)
                       .put(1U)
                       .put(2U)
                       .put(3U)
                       .text("f")
                       .put<std::uint16_t>(7)),
            Bytes().put<std::uint8_t>(9).put<std::uint16_t>(7).str());
}

TEST_F(PlanFields, ReorderedFieldsMove) {
  EXPECT_EQ(
      result("string a\nuint8 b\nuint16[] c", "uint16[] c\nuint8 b\nstring a",
             Bytes().text("hey").put<std::uint8_t>(4).count(2).put<std::uint16_t>(1).put<std::uint16_t>(2)),
      Bytes().count(2).put<std::uint16_t>(1).put<std::uint16_t>(2).put<std::uint8_t>(4).text("hey").str());
}

TEST_F(PlanFields, EmbeddedMessagesPairByTheirFieldsRegardlessOfTheirName) {
  definitions.define("old/Part", "uint8 a\nuint8 b");
  definitions.define("renamed/Part", "uint8 b\nuint8 a\nuint8 c");
  EXPECT_EQ(
      result(
          "old/Part[] parts", "renamed/Part[] parts",
          Bytes().count(2).put<std::uint8_t>(1).put<std::uint8_t>(2).put<std::uint8_t>(3).put<std::uint8_t>(
              4)),
      Bytes()
          .count(2)
          .put<std::uint8_t>(2)
          .put<std::uint8_t>(1)
          .put<std::uint8_t>(0)
          .put<std::uint8_t>(4)
          .put<std::uint8_t>(3)
          .put<std::uint8_t>(0)
          .str());
}

TEST_F(PlanFields, IntegersAreCheckedAgainstTheirRange) {
  const auto narrow = plan("int32 speed", "uint8 speed");
  EXPECT_EQ(converted(*narrow, Bytes().put(255).str()), Bytes().put<std::uint8_t>(255).str());
  expect_says(converted(*narrow, Bytes().put(256).str()), "field speed: 256 does not fit uint8");
  expect_says(converted(*narrow, Bytes().put(-1).str()), "field speed: -1 does not fit uint8");
  const auto to_signed = plan("uint64 n", "int64 n");
  expect_says(converted(*to_signed, Bytes().put(std::uint64_t{1} << 63U).str()),
              "9223372036854775808 does not fit int64");
}

TEST_F(PlanFields, FloatingPointRoundsToTheNearestInteger) {
  const auto rounded = plan("float64 v", "int32 v");
  EXPECT_EQ(converted(*rounded, Bytes().put(2.6).str()), Bytes().put(3).str());
  EXPECT_EQ(converted(*rounded, Bytes().put(-2.6).str()), Bytes().put(-3).str());
  EXPECT_EQ(converted(*rounded, Bytes().put(2147483647.4).str()), Bytes().put(2147483647).str());
  expect_says(converted(*rounded, Bytes().put(2147483647.6).str()), "does not fit int32");
  expect_says(converted(*rounded, Bytes().put(std::nan("")).str()), "nan does not fit int32");
  expect_says(converted(*rounded, Bytes().put(-HUGE_VAL).str()), "-inf does not fit int32");
}

TEST_F(PlanFields, Float64BecomesFloat32WithinItsRange) {
  const auto shorter = plan("float64[] v", "float32[] v");
  EXPECT_EQ(converted(*shorter, Bytes().count(2).put(0.1).put(HUGE_VAL).str()),
            Bytes().count(2).put(0.1F).put(HUGE_VALF).str());
  expect_says(converted(*shorter, Bytes().count(2).put(1.0).put(1e39).str()),
              "field v[1]: 1e+39 does not fit float32");
}

TEST_F(PlanFields, ErrorsNameTheIndicesOfEmbeddedArrays) {
  definitions.define("p/In", "int32[2] n");
  definitions.define("p/Out", "int8[2] n");
  const auto nested = plan("p/In[] rows", "p/Out[] rows");
  expect_says(converted(*nested, Bytes().count(2).put(1).put(2).put(3).put(400).str()),
              "field rows[1].n[1]: 400");
}

TEST_F(PlanFields, FixedAndVariableArraysConvert) {
  EXPECT_EQ(result("uint16[2] v", "uint16[] v", Bytes().put<std::uint16_t>(1).put<std::uint16_t>(2)),
            Bytes().count(2).put<std::uint16_t>(1).put<std::uint16_t>(2).str());
  const auto fixed = plan("string[] v", "string[2] v");
  EXPECT_EQ(converted(*fixed, Bytes().count(2).text("a").text("b").str()), Bytes().text("a").text("b").str());
  expect_says(converted(*fixed, Bytes().count(1).text("a").str()),
              "field v has 1 element, the target takes 2");
  expect_says(converted(*fixed, Bytes().count(3).text("a").text("b").text("c").str()), "has 3 elements");
  expect_says(refusal("uint8[2] v", "uint8[3] v"), "uint8[2] does not become uint8[3]");
}

TEST_F(PlanFields, StringsAndBytesConvert) {
  const auto message = Bytes().text("ab\xFF").str();
  const auto to_bytes = plan("string s", "uint8[] s");
  EXPECT_EQ(to_bytes->kind(), Plan::Kind::kConvert);
  EXPECT_EQ(converted(*to_bytes, message), message);
  EXPECT_EQ(converted(*plan("char[] s", "string s"), message), message);
  EXPECT_EQ(result("string s", "uint8[3] s", Bytes().text("abc")), "abc");
  EXPECT_EQ(result("uint8[3] s", "string s", Bytes().put('a').put('b').put('c')), Bytes().text("abc").str());
}

TEST_F(PlanFields, WhatNeedsARuleIsRefusedWithTheRemedy) {
  expect_says(refusal("string s", "int32 s"),
              "field s: string does not become int32 by itself; write a rule");
  expect_says(refusal("int32 s", "int32[] s"), "a `list`");
  expect_says(refusal("int32[] s", "int32 s"), "from: s[0]");
  expect_says(refusal("time s", "duration s"), "field s: time does not become duration");
  expect_says(refusal("Header s", "float64 s"), "field s: Header does not become float64");
}

TEST_F(PlanFields, StampsShiftAtAnyDepth) {
  PlanOptions options;
  options.shift_times = true;
  const auto shifted = plan("Header header\ntime[] t\nduration d\ntime[2] u",
                            "Header header\ntime[] t\nduration d\ntime[2] u", options);
  ASSERT_EQ(shifted->kind(), Plan::Kind::kConvert);
  const auto message = [](std::uint32_t s, std::uint32_t ns, std::uint32_t zero) {
    return Bytes()
        .put(1U)
        .put(s)
        .put(ns)
        .text("f")
        .count(2)
        .put(s)
        .put(ns)
        .put(zero)
        .put(zero)
        .put(5)
        .put(6)
        .put(s)
        .put(ns)
        .put(zero)
        .put(zero)
        .str();
  };
  EXPECT_EQ(converted(*shifted, message(100, 999'999'999, 0), 2'000'000'001), message(103, 0, 0));
  EXPECT_EQ(converted(*shifted, message(100, 5, 0), -1'000'000'006), message(98, 999'999'999, 0));
  EXPECT_EQ(converted(*shifted, message(100, 5, 0), 0), message(100, 5, 0));
  EXPECT_EQ(converted(*shifted, message(1, 0, 0), -2'000'000'000), message(0, 0, 0)) << "no time before zero";
  EXPECT_EQ(converted(*shifted, message(0xFFFFFFFF, 0, 0), std::numeric_limits<std::int64_t>::max()),
            message(0xFFFFFFFF, 999'999'999, 0));
}

TEST_F(PlanFields, MessagesWithoutStampsPassWhenStampsShift) {
  PlanOptions options;
  options.shift_times = true;
  options.frame_slash = PlanOptions::Slash::kStrip;
  EXPECT_EQ(plan("duration d\nstring name", "duration d\nstring name", options)->kind(), Plan::Kind::kPass);
}

TEST_F(PlanFields, FrameNamesLoseOrGainTheirSlash) {
  PlanOptions options;
  options.frame_slash = PlanOptions::Slash::kStrip;
  const std::string text = "string frame_id\nstring child_frame_id\nstring name";
  const auto strip = plan(text, text, options);
  EXPECT_EQ(converted(*strip, Bytes().text("/base").text("arm").text("/n").str()),
            Bytes().text("base").text("arm").text("/n").str());
  EXPECT_EQ(converted(*strip, Bytes().text("").text("//x").text("").str()),
            Bytes().text("").text("x").text("").str());
  options.frame_slash = PlanOptions::Slash::kAdd;
  const auto add = plan(text, text, options);
  EXPECT_EQ(converted(*add, Bytes().text("base").text("").text("n").str()),
            Bytes().text("/base").text("").text("n").str());
  EXPECT_EQ(converted(*add, Bytes().text("/b").text("c").text("n").str()),
            Bytes().text("/b").text("/c").text("n").str());
}

TEST_F(PlanFields, OutputIsAppendedAndUntouchedAfterAnError) {
  const auto narrow = plan("string s\nint32 v", "string s\nint8 v");
  ByteBuffer out;
  out.append("head", 4);
  ASSERT_TRUE(narrow->convert(view_of(Bytes().text("ab").put(3).str()), out));
  EXPECT_EQ(string_of(out), "head" + Bytes().text("ab").put<std::int8_t>(3).str());
  const auto before = string_of(out);
  EXPECT_FALSE(narrow->convert(view_of(Bytes().text("ab").put(300).str()), out));
  EXPECT_EQ(string_of(out), before);
}

TEST_F(PlanFields, NotesNameEveryFieldAndDroppedOnesLast) {
  const auto all = plan("uint8 gone\nuint8 kept\nint32 width\nuint8 b\nuint8 a",
                        "uint8 kept\nint64 width\nstring fresh\nuint8 a\nuint8 b");
  using Kind = Plan::Note::Kind;
  const std::vector<std::pair<Kind, std::string>> expected{
      {Kind::kKept, "kept"}, {Kind::kConverted, "width"}, {Kind::kDefaulted, "fresh"},
      {Kind::kKept, "a"},    {Kind::kMoved, "b"},         {Kind::kDropped, "gone"}};
  ASSERT_EQ(all->notes().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(all->notes()[i].kind, expected[i].first) << i;
    EXPECT_EQ(all->notes()[i].path, expected[i].second);
    EXPECT_FALSE(all->notes()[i].text.empty());
  }
  EXPECT_EQ(all->notes()[1].text, "from int32 to int64");
}

TEST_F(PlanFields, ThePlanAsText) {
  const auto added = plan("Header header\nfloat64 set_point\nfloat64 error",
                          "Header header\nfloat64 set_point\nfloat64 error\nbool windup");
  EXPECT_EQ(added->describe(),
            (std::vector<std::string>{"copy one block of varying size: header.seq ... error",
                                      "write 1 byte of zeros: windup"}));
  const auto fixed = plan("float64 a\nfloat64 b\nuint8 gone\nint16 c", "float64 a\nfloat64 b\nint8 c");
  EXPECT_EQ(fixed->describe(), (std::vector<std::string>{"copy 16 bytes: a ... b", "leave out 1 byte: gone",
                                                         "convert int16 to int8: c"}));
  EXPECT_EQ(plan("int8 a", "int8 a")->describe(),
            std::vector<std::string>{"pass: forward every message as it is"});
  EXPECT_STREQ(to_string(Plan::Kind::kPass), "pass");
  EXPECT_STREQ(to_string(Plan::Kind::kConvert), "convert");
}
