// Rules inside plans: sources, chains, rules of embedded messages.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/translate/rules.hpp"

#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/definitions.hpp"
#include "test/unit/translate/plan/literal_of.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

Source from(Path path) {
  Source source;
  source.path = std::move(path);
  return source;
}

Source from(const std::string& name) {
  return from(Path{{name, std::nullopt}});
}

Source value(Literal literal) {
  Source source;
  source.kind = Source::Kind::kValue;
  source.value = std::move(literal);
  return source;
}

Source list(std::vector<Source> items) {
  Source source;
  source.kind = Source::Kind::kList;
  source.list = std::move(items);
  return source;
}

Source built(std::vector<std::pair<std::string, Source>> fields) {
  Source source;
  source.kind = Source::Kind::kMessage;
  source.fields = std::move(fields);
  return source;
}

class PlanRules : public testing::Test {
 protected:
  PlanRules() { definitions.define_common(); }

  void rule(const SchemaPtr& old_one, const SchemaPtr& new_one,
            std::vector<std::pair<std::string, Source>> targets) {
    MigrationRule made;
    made.from_type = old_one->type();
    made.from_md5 = old_one->md5();
    made.to_type = new_one->type();
    made.to_md5 = new_one->md5();
    made.targets = std::move(targets);
    made.origin = "test:1";
    rules.add(std::move(made));
  }
  /// A plan from `old_text` to `new_text` with one rule.
  PlanPtr with(const std::string& old_text, const std::string& new_text,
               std::vector<std::pair<std::string, Source>> targets, const PlanOptions& options = {}) {
    const auto old_one = definitions.define("p/Old", old_text);
    const auto new_one = definitions.define("p/New", new_text);
    rules = RuleSet();
    rule(old_one, new_one, std::move(targets));
    auto compiled = Plan::compile(old_one, new_one, rules, options);
    problem = compiled ? "" : compiled.error().message;
    return compiled ? *compiled : nullptr;
  }

  Definitions definitions;
  RuleSet rules;
  std::string problem;
};

void expect_says(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

Bytes pose(double x, double y, double z, double qx, double qy, double qz, double qw) {
  return Bytes().put(x).put(y).put(z).put(qx).put(qy).put(qz).put(qw);
}

double number_at(const std::string& bytes, std::size_t index) {
  double number = 0;
  std::memcpy(&number, bytes.data() + index * sizeof number, sizeof number);
  return number;
}

}  // namespace

TEST_F(PlanRules, ARenameOfTheSameBytesPasses) {
  const auto plan = with("uint8 before\nstring s", "uint8 after\nstring s", {{"after", from("before")}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(plan->kind(), Plan::Kind::kPass);
  EXPECT_EQ(plan->notes().front().kind, Plan::Note::Kind::kRule);
  EXPECT_EQ(plan->notes().front().text, "from before");
}

TEST_F(PlanRules, ScaleAndOffsetOfNumbersAndArrays) {
  auto scaled = from("speed");
  scaled.scale = 0.01;
  scaled.offset = 1;
  const auto single = with("int32 speed", "float32 ratio", {{"ratio", scaled}});
  ASSERT_TRUE(single) << problem;
  EXPECT_EQ(converted(*single, Bytes().put(50).str()), Bytes().put(1.5F).str());
  scaled.scale = 100;
  const auto several = with("float32[] speed", "uint8[] ratio", {{"ratio", scaled}});
  EXPECT_EQ(converted(*several, Bytes().count(2).put(0.5F).put(1.0F).str()),
            Bytes().count(2).put<std::uint8_t>(51).put<std::uint8_t>(101).str());
  expect_says(converted(*several, Bytes().count(2).put(0.5F).put(3.0F).str()),
              "field ratio[1]: 3 does not fit uint8");
}

TEST_F(PlanRules, SaturationTakesTheNearestValue) {
  auto saturated = from("v");
  saturated.overflow = Overflow::kSaturate;
  const auto plan = with("float64[] v", "int8[] w", {{"w", saturated}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(converted(*plan, Bytes().count(3).put(1e9).put(-HUGE_VAL).put(3.2).str()),
            Bytes().count(3).put<std::int8_t>(127).put<std::int8_t>(-128).put<std::int8_t>(3).str());
  expect_says(converted(*plan, Bytes().count(1).put(std::nan("")).str()), "nan does not fit int8");
}

TEST_F(PlanRules, MapsOfConstants) {
  auto mapped = from("mode");
  mapped.map = {{scalar("1"), scalar("10")}, {scalar("2"), scalar("20")}};
  const auto unchanged = with("uint8 mode\nstring s", "int32 mode\nstring s", {{"mode", mapped}});
  ASSERT_TRUE(unchanged) << problem;
  EXPECT_EQ(converted(*unchanged, Bytes().put<std::uint8_t>(2).text("a").str()),
            Bytes().put(20).text("a").str());
  EXPECT_EQ(converted(*unchanged, Bytes().put<std::uint8_t>(3).text("a").str()),
            Bytes().put(3).text("a").str());
  mapped.otherwise = scalar("-1");
  const auto otherwise = with("uint8[] mode\nstring s", "int32[] mode\nstring s", {{"mode", mapped}});
  EXPECT_EQ(converted(*otherwise, Bytes().count(2).put<std::uint8_t>(1).put<std::uint8_t>(3).text("a").str()),
            Bytes().count(2).put(10).put(-1).text("a").str());
}

TEST_F(PlanRules, MapsOfStringsAndBools) {
  auto mapped = from("mode");
  mapped.map = {{scalar("fast"), scalar("2")}};
  ASSERT_FALSE(with("string mode", "uint8 mode", {{"mode", mapped}})) << "other strings are no numbers";
  expect_says(problem, "otherwise");
  mapped.otherwise = scalar("0");
  const auto text = with("string mode", "uint8 mode", {{"mode", mapped}});
  ASSERT_TRUE(text) << problem;
  EXPECT_EQ(converted(*text, Bytes().text("fast").str()), "\x02");
  EXPECT_EQ(converted(*text, Bytes().text("fas").str()), std::string(1, '\0'));
  mapped.map = {{scalar("true"), scalar("yes")}};
  mapped.otherwise = scalar("no");
  const auto flag = with("bool mode", "string mode", {{"mode", mapped}});
  EXPECT_EQ(converted(*flag, "\x07"), Bytes().text("yes").str()) << "any bits but zero are true";
  EXPECT_EQ(converted(*flag, std::string(1, '\0')), Bytes().text("no").str());
}

TEST_F(PlanRules, PathsThroughMessagesAndArrays) {
  definitions.define("p/Resource", "string interface\nstring[] names\nuint8[2] pair");
  auto interface = from(Path{{"resources", 1}, {"interface", std::nullopt}});
  interface.otherwise = scalar("none");
  const auto plan =
      with("uint8 a\np/Resource[] resources\nuint8 z", "string interface\nuint8 a\nuint8 second\nuint8 z",
           {{"interface", interface}, {"second", [] {
                                         auto source = from(Path{{"resources", 0}, {"pair", 1}});
                                         source.otherwise = scalar("9");
                                         return source;
                                       }()}});
  ASSERT_TRUE(plan) << problem;
  const auto resource = [](Bytes& bytes, const std::string& name) {
    bytes.text(name).count(1).text("n").put<std::uint8_t>(7).put<std::uint8_t>(8);
  };
  Bytes two;
  two.put<std::uint8_t>(1).count(2);
  resource(two, "effort");
  resource(two, "position");
  two.put<std::uint8_t>(2);
  EXPECT_EQ(converted(*plan, two.str()),
            Bytes().text("position").put<std::uint8_t>(1).put<std::uint8_t>(8).put<std::uint8_t>(2).str());
  EXPECT_EQ(converted(*plan, Bytes().put<std::uint8_t>(1).count(0).put<std::uint8_t>(2).str()),
            Bytes().text("none").put<std::uint8_t>(1).put<std::uint8_t>(9).put<std::uint8_t>(2).str());
}

TEST_F(PlanRules, AnIndexBeyondTheEndWithoutOtherwiseIsAnError) {
  const auto plan = with("uint8[] a", "uint8 b", {{"b", from(Path{{"a", 2}})}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(converted(*plan, Bytes().count(3).put('x').put('y').put('z').str()), "z");
  expect_says(converted(*plan, Bytes().count(2).put('x').put('y').str()),
              "a rule takes the one with index 2");
}

TEST_F(PlanRules, ListsJoinAndMessagesAreBuilt) {
  definitions.define("p/Resource", "string interface\nstring[] names\nuint8 rank");
  const auto plan = with(
      "string hardware\nstring[] resources\nbool ok\nbool cancel", "p/Resource[] claimed\nbool[2] buttons",
      {{"claimed", list({built({{"names", from("resources")}, {"interface", from("hardware")}})})},
       {"buttons", list({from("ok"), from("cancel")})}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(
      converted(*plan,
                Bytes().text("hw").count(1).text("arm").put<std::uint8_t>(1).put<std::uint8_t>(0).str()),
      Bytes()
          .count(1)
          .text("hw")
          .count(1)
          .text("arm")
          .put<std::uint8_t>(0)
          .put<std::uint8_t>(1)
          .put<std::uint8_t>(0)
          .str());
}

TEST_F(PlanRules, ValuesOfMessages) {
  Literal orientation;
  orientation.kind = Literal::Kind::kFields;
  orientation.fields = {{"w", scalar("1")}};
  Literal literal;
  literal.kind = Literal::Kind::kFields;
  literal.fields = {{"orientation", orientation}};
  const auto plan = with("uint8 a", "uint8 a\ngeometry_msgs/Pose pose", {{"pose", value(literal)}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(converted(*plan, "a"), "a" + pose(0, 0, 0, 0, 0, 0, 1).str());
}

TEST_F(PlanRules, PosesAreExpressedInTheParentFrame) {
  auto relative = from("poses");
  relative.relative_to = {{"pose", std::nullopt}};
  const auto plan = with("geometry_msgs/Pose pose\ngeometry_msgs/Pose[] poses", "geometry_msgs/Pose[] poses",
                         {{"poses", relative}});
  ASSERT_TRUE(plan) << problem;
  const double half = std::sqrt(0.5);                  // a quarter turn about z: x becomes y
  const auto child = pose(1, 0, 0, 0, 0, 0, 0).str();  // an orientation of zeros is the identity
  const auto turned =
      converted(*plan, pose(10, 20, 30, 0, 0, half, half).str() + Bytes().count(1).str() + child);
  ASSERT_EQ(turned.size(), 4 + child.size());
  const auto numbers = turned.substr(4);
  const std::vector<double> expected{10, 21, 30, 0, 0, half, half};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(number_at(numbers, i), expected[i], 1e-12) << i;
  for (const double w : {0.0, 1.0})
    EXPECT_EQ(converted(*plan, pose(0, 0, 0, 0, 0, 0, w).str() + Bytes().count(1).str() + child),
              Bytes().count(1).str() + child)
        << "the identity changes no bit";
}

TEST_F(PlanRules, RelativeToNeedsPoses) {
  auto relative = from("a");
  relative.relative_to = {{"pose", std::nullopt}};
  EXPECT_FALSE(
      with("geometry_msgs/Pose pose\ngeometry_msgs/Point a", "geometry_msgs/Point a", {{"a", relative}}));
  expect_says(problem, "geometry_msgs/Pose");
  relative.relative_to = {{"b", std::nullopt}};
  EXPECT_FALSE(with("float64 b\ngeometry_msgs/Pose a", "geometry_msgs/Pose a", {{"a", relative}}));
  expect_says(problem, "b, which is not a geometry_msgs/Pose");
}

TEST_F(PlanRules, RulesApplyAtAnyDepth) {
  const auto old_part = definitions.define("p/PartOld", "uint8 v\nstring s");
  const auto new_part = definitions.define("p/PartNew", "string s\nuint8 w");
  rule(old_part, new_part, {{"w", from("v")}});
  const auto plan = Plan::compile(definitions.define("p/A", "p/PartOld[] parts\nuint8 end"),
                                  definitions.define("p/B", "p/PartNew[] parts\nuint8 end"), rules);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(converted(**plan, Bytes().count(2).put('a').text("x").put('b').text("yy").put('e').str()),
            Bytes().count(2).text("x").put('a').text("yy").put('b').put('e').str());
}

TEST_F(PlanRules, ARuleMakesADurationOfATime) {
  const auto plan = with("time t", "duration d", {{"d", from("t")}});
  ASSERT_TRUE(plan) << problem;
  EXPECT_EQ(converted(*plan, Bytes().put(5U).put(6U).str()), Bytes().put(5).put(6).str());
  expect_says(converted(*plan, Bytes().put(0x80000000U).put(6U).str()), "2147483648 s does not fit duration");
}

TEST_F(PlanRules, ARuleThatDoesNotFitNamesTheField) {
  EXPECT_FALSE(with("uint8 a", "uint8 b", {{"b", from(Path{{"a", 0}})}}));
  expect_says(problem, "a has no element 0");
  EXPECT_FALSE(with("uint8 a", "uint8 b", {{"b", value(scalar("300"))}}));
  expect_says(problem, "field b: '300' is not a value of uint8 b");
  auto scaled = from("a");
  scaled.scale = 2;
  EXPECT_FALSE(with("string a", "string b", {{"b", scaled}}));
  expect_says(problem, "need numbers");
}
