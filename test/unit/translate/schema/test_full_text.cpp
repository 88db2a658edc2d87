#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {
namespace {

const std::string kDivider = std::string(80, '=') + "\n";

std::string embedded(const std::string& type, const std::string& text) {
  return kDivider + "MSG: " + type + "\n" + text;
}

std::string problem(const std::string& full_text, const SchemaLimits& limits = {}) {
  const auto schema = parse_full_text("pkg/Top", full_text, limits);
  EXPECT_FALSE(schema) << full_text;
  return schema ? "" : schema.error().message;
}

const std::string kPointStamped =
    "# A point with a frame and a stamp\nHeader header\nPoint point\n\n" +
    embedded("std_msgs/Header",
             "# what: see REP 103\nuint32 seq\ntime stamp\n#0: none\nstring frame_id\n\n") +
    embedded("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z");

TEST(FullText, AsAConnectionHeaderCarriesIt) {
  const auto schema = parse_full_text("geometry_msgs/PointStamped", kPointStamped);
  ASSERT_TRUE(schema) << schema.error().message;
  EXPECT_EQ("c63aecb41bfdfd6b7e1fac37c7cbe7bf", (*schema)->md5());
  EXPECT_EQ("geometry_msgs/Point", (*schema)->fields()[1].message->type());
  EXPECT_EQ("Header header\nPoint point\n" +
                embedded("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n") +
                embedded("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
            (*schema)->full_text());
}

TEST(FullText, LineEndsAndUnusedDefinitionsDoNotMatter) {
  std::string text;
  for (const char c : kPointStamped) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  text += "\r\n" + embedded("other_msgs/Unused", "int32 a\n");
  const auto schema = parse_full_text("geometry_msgs/PointStamped", text);
  ASSERT_TRUE(schema) << schema.error().message;
  EXPECT_EQ("c63aecb41bfdfd6b7e1fac37c7cbe7bf", (*schema)->md5());
}

TEST(FullText, EachTypeOnceInOrderOfFirstUse) {
  const auto schema =
      parse_full_text("pkg/Top", "C c\nB b\nC again\n" + embedded("pkg/B", "D d\n") +
                                     embedded("pkg/C", "D d\nB[] b\n") + embedded("pkg/D", "int8 x\n"));
  ASSERT_TRUE(schema) << schema.error().message;
  EXPECT_EQ("C c\nB b\nC again\n" + embedded("pkg/C", "D d\nB[] b\n") + embedded("pkg/D", "int8 x\n") +
                embedded("pkg/B", "D d\n"),
            (*schema)->full_text());
}

TEST(FullText, MissingTwiceAndCircular) {
  EXPECT_NE(std::string::npos, problem("B b\n").find("pkg/B is embedded, but the text does not hold"));
  EXPECT_NE(
      std::string::npos,
      problem("B b\n" + embedded("pkg/B", "int8 x") + "\n" + embedded("pkg/B", "int16 x")).find("twice"));
  EXPECT_TRUE(
      parse_full_text("pkg/Top", "B b\n" + embedded("pkg/B", "int8 x\n") + embedded("pkg/B", "int8 x\n\n")));
  EXPECT_NE(std::string::npos, problem("Top t\n").find("embeds itself"));
  EXPECT_NE(std::string::npos,
            problem("B b\n" + embedded("pkg/B", "C c\n") + embedded("pkg/C", "B b\n")).find("embeds itself"));
  EXPECT_NE(std::string::npos, problem("int8 a\n" + kDivider + "int8 b\n").find("line 3"));
  EXPECT_NE("", problem("int8 a\n" + kDivider + "MSG: ../../etc/passwd\nint8 b\n"));
  EXPECT_NE("", problem("int8 a\n" + kDivider));
  EXPECT_NE(std::string::npos, problem("B b\n" + embedded("pkg/B", "int8 x\nint8 x\n")).find("pkg/B line 5"))
      << "lines of the whole text";
}

TEST(FullText, Limits) {
  std::string chain = "L1 a\n";
  for (int level = 1; level < 40; ++level)
    chain += embedded("pkg/L" + std::to_string(level), "L" + std::to_string(level + 1) + " a\n");
  chain += embedded("pkg/L40", "int8 a\n");
  EXPECT_NE(std::string::npos, problem(chain).find("more than 32"));

  SchemaLimits limits;
  limits.definitions = 3;
  const auto three = "A a\n" + embedded("pkg/A", "B b\n") + embedded("pkg/B", "int8 x\n");
  EXPECT_TRUE(parse_full_text("pkg/Top", three, limits));
  EXPECT_NE("", problem(three + embedded("pkg/C", "int8 x\n"), limits));
  limits = {};
  limits.text_bytes = three.size() - 1;
  EXPECT_NE("", problem(three, limits));
}

TEST(FullText, DoublingIsFoundBeforeItCostsAnything) {
  std::string text = "L1 a\nL1 b\n";
  for (int level = 1; level < 30; ++level) {
    const auto below = "L" + std::to_string(level + 1);
    text += embedded("pkg/L" + std::to_string(level), below + " a\n" + below + " b\n");
  }
  text += embedded("pkg/L30", "");
  EXPECT_NE(std::string::npos, problem(text).find("fields"));
}

TEST(FullText, DamagedTextsNeverCrash) {
  Rng rng(7);
  const std::string marks = "[]=#\n\r\t /-\\0aZ9:";
  for (int round = 0; round < 20'000; ++round) {
    auto text = kPointStamped;
    for (int hits = rng.integer(1, 4); hits > 0; --hits) {
      const auto at = static_cast<std::size_t>(rng.integer(0, static_cast<int>(text.size()) - 1));
      switch (rng.integer(0, 2)) {
        case 0:
          text[at] = marks[static_cast<std::size_t>(rng.integer(0, static_cast<int>(marks.size()) - 1))];
          break;
        case 1:
          text.resize(at + 1);
          break;
        default:
          text.insert(at, text.substr(at / 2, static_cast<std::size_t>(rng.integer(0, 90))));
      }
    }
    const auto schema = parse_full_text("geometry_msgs/PointStamped", text);
    if (!schema) {
      EXPECT_FALSE(schema.error().message.empty());
      continue;
    }
    const auto again = parse_full_text("geometry_msgs/PointStamped", (*schema)->full_text());
    ASSERT_TRUE(again) << text;
    EXPECT_EQ((*schema)->md5(), (*again)->md5()) << text;
  }
}

/// Random definitions that embed those made before.
class RandomSchemas {
 public:
  explicit RandomSchemas(std::uint64_t seed) : rng_(seed) {}

  SchemaPtr make() {
    const auto type = "pkg" + std::to_string(rng_.integer(0, 2)) + "/Type" + std::to_string(made_.size());
    std::vector<Constant> constants;
    for (int i = rng_.integer(0, 3); i > 0; --i) constants.push_back(constant(i));
    std::vector<Field> fields;
    for (int i = rng_.integer(0, 6); i > 0; --i) fields.push_back(field(type, i));
    made_.push_back(std::make_shared<const MessageSchema>(type, std::move(fields), std::move(constants)));
    return made_.back();
  }

 private:
  Constant constant(int index) {
    const auto name = "NAME_" + std::to_string(index);
    static const std::vector<Constant> kinds{{"string", "", "a # b = 'c'"},
                                             {"string", "", ""},
                                             {"bool", "", "True"},
                                             {"float32", "", "-1.50e3"},
                                             {"byte", "", "-128"},
                                             {"char", "", "255"},
                                             {"uint64", "", "18446744073709551615"}};
    auto made = kinds[static_cast<std::size_t>(rng_.integer(0, static_cast<int>(kinds.size()) - 1))];
    made.name = name;
    return made;
  }

  Field field(const std::string& owner, int index) {
    static const std::vector<std::pair<const char*, Primitive>> kinds{
        {"bool", Primitive::kBool},       {"int8", Primitive::kInt8},         {"uint8", Primitive::kUint8},
        {"int16", Primitive::kInt16},     {"uint16", Primitive::kUint16},     {"int32", Primitive::kInt32},
        {"uint32", Primitive::kUint32},   {"int64", Primitive::kInt64},       {"uint64", Primitive::kUint64},
        {"float32", Primitive::kFloat32}, {"float64", Primitive::kFloat64},   {"string", Primitive::kString},
        {"time", Primitive::kTime},       {"duration", Primitive::kDuration}, {"byte", Primitive::kInt8},
        {"char", Primitive::kUint8}};
    Field made;
    made.name = "field_" + std::to_string(index);
    made.arity = static_cast<Arity>(rng_.integer(0, 2));
    if (made.arity == Arity::kFixed) made.fixed_count = static_cast<std::uint32_t>(rng_.integer(0, 9));
    if (!made_.empty() && rng_.chance(0.4)) {
      const int back = std::min<int>(6, static_cast<int>(made_.size()));
      made.message = made_[made_.size() - static_cast<std::size_t>(rng_.integer(1, back))];
      if (made.message->depth() < 5) {
        made.primitive = Primitive::kMessage;
        made.written_type = short_name(owner, made.message->type());
        return made;
      }
      made.message = nullptr;
    }
    const auto& kind = kinds[static_cast<std::size_t>(rng_.integer(0, static_cast<int>(kinds.size()) - 1))];
    made.written_type = kind.first;
    made.primitive = kind.second;
    return made;
  }

  std::string short_name(const std::string& owner, const std::string& type) {
    const auto slash = type.find('/');
    return owner.substr(0, slash) == type.substr(0, slash) && rng_.chance(0.5) ? type.substr(slash + 1)
                                                                               : type;
  }

  Rng rng_;
  std::vector<SchemaPtr> made_;
};

TEST(FullText, OfARandomSchemaIsReadAsTheSame) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomSchemas schemas(seed);
    for (int i = 0; i < 60; ++i) {
      const auto schema = schemas.make();
      const auto read = parse_full_text(schema->type(), schema->full_text());
      ASSERT_TRUE(read) << "seed " << seed << ": " << read.error().message << "\n" << schema->full_text();
      EXPECT_EQ(schema->md5(), (*read)->md5()) << "seed " << seed;
      EXPECT_TRUE(same_layout(*schema, **read)) << "seed " << seed;
      EXPECT_EQ(schema->full_text(), (*read)->full_text()) << "seed " << seed;
      EXPECT_EQ(schema->min_size(), (*read)->min_size()) << "seed " << seed;
      EXPECT_EQ(schema->fixed_size(), (*read)->fixed_size()) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace extperfc::translate
