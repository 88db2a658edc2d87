#include <gtest/gtest.h>

#include "extperfc/world/yaml_map.hpp"

namespace extperfc {
namespace {

class YamlMapTest : public testing::Test {
 protected:
  [[nodiscard]] YamlMap map(const std::string& text) {
    const auto root = parse_yaml(text, problems);
    return {root.value_or(YAML::Node(YAML::NodeType::Map)), "", problems};
  }
  [[nodiscard]] std::string message() const { return problems.to_error().message; }

  Problems problems{"f.yaml"};
};

TEST_F(YamlMapTest, ReadsEveryKind) {
  YamlMap read =
      map("number: 1e-3\nwhole: 7\nyes: true\none: 1\ntext: a\ncolour: red\nlist: [1, 2]\n"
          "rows: [[1, 2], [3, 4]]\nnames: [a, b]\npart: {x: 1}\nparts: [{x: 2}, {x: 3}]\n");
  EXPECT_DOUBLE_EQ(read.number("number", kFraction), 1e-3);
  EXPECT_EQ(read.integer("whole", 0, 7), 7);
  EXPECT_TRUE(read.flag("yes"));
  EXPECT_TRUE(read.flag("one"));
  EXPECT_EQ(read.text("text"), "a");
  EXPECT_EQ(read.choice("colour", {"blue", "red"}), 1U);
  EXPECT_EQ(read.numbers("list", {1, 3}, kFinite), (std::vector<double>{1, 2}));
  EXPECT_EQ(read.vector2("list", kFinite), Eigen::Vector2d(1, 2));
  EXPECT_EQ(read.rows("rows", 2, kFinite)[1], (std::vector<double>{3, 4}));
  EXPECT_EQ(read.texts("names"), (std::vector<std::string>{"a", "b"}));
  EXPECT_DOUBLE_EQ(read.section("part").number("x", kFinite), 1);
  EXPECT_DOUBLE_EQ(read.maps("parts")[1].number("x", kFinite), 3);
  read.refuse_unknown();
  EXPECT_EQ(message(), "");
}

TEST_F(YamlMapTest, FallbacksStandForAbsentKeys) {
  YamlMap read = map("{}");
  EXPECT_DOUBLE_EQ(read.number("n", kFraction, 0.5), 0.5);
  EXPECT_EQ(read.integer("i", 0, 9, 3), 3);
  EXPECT_TRUE(read.flag("f", true));
  EXPECT_EQ(read.text("t", ""), "");
  EXPECT_EQ(read.choice("c", {"a", "b"}, 1), 1U);
  EXPECT_EQ(read.vector3("v", kFinite, Eigen::Vector3d(1, 2, 3)), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(read.section("s").items().empty());
  EXPECT_TRUE(read.maps("m").empty());
  EXPECT_EQ(message(), "");
}

TEST_F(YamlMapTest, AllProblemsAreReportedWithLineAndKey) {
  YamlMap read =
      map("number: 2\nwhole: 1.5\nyes: maybe\ntext: []\nlist: [1, x, 3]\npart: 3\nnumbr: 1\nwhole: 2\n");
  EXPECT_DOUBLE_EQ(read.number("number", kFraction, 0.25), 0.25);
  EXPECT_EQ(read.integer("whole", 1, 9), 1);
  EXPECT_FALSE(read.flag("yes", false));
  EXPECT_EQ(read.text("text"), "");
  (void)read.vector3("list", kFinite);
  (void)read.section("part");
  (void)read.text("absent");
  read.refuse_unknown();
  EXPECT_EQ(message(),
            "f.yaml:1: number: must be a number in [0, 1], not \"2\"\n"
            "f.yaml:1: absent: is missing: add it\n"
            "f.yaml:2: whole: must be a whole number in [1, 9], not \"1.5\"\n"
            "f.yaml:3: yes: must be true or false, not \"maybe\"\n"
            "f.yaml:4: text: must be a text, not a list of 0\n"
            "f.yaml:5: list[1]: must be a finite number, not \"x\"\n"
            "f.yaml:6: part: must be a map of keys and values, not \"3\"\n"
            "f.yaml:7: unknown key \"numbr\", did you mean \"number\"?\n"
            "f.yaml:8: whole: is given twice: remove one");
}

TEST_F(YamlMapTest, CountsAreChecked) {
  YamlMap read = map("a: [1]\nb: [1, 2, 3, 4]\nc: [[1]]\nd: []\ne: []\n");
  EXPECT_EQ(read.numbers("a", 2, kFinite, std::vector<double>{5, 6}), (std::vector<double>{5, 6}));
  EXPECT_EQ(read.numbers("b", {2, 3}, kFraction).size(), 2U);
  EXPECT_TRUE(read.rows("c", 2, kFinite).empty());
  EXPECT_TRUE(read.texts("d", false).empty());
  EXPECT_TRUE(read.maps("e", 1).empty());
  EXPECT_EQ(message(),
            "f.yaml:1: a: must have 2 numbers, not 1\nf.yaml:2: b: must have 2 to 3 numbers, not 4\n"
            "f.yaml:3: c[0]: must be a list of 2 numbers, not a list of 1\nf.yaml:4: d: is empty: list at "
            "least one\n"
            "f.yaml:5: e: is empty: list at least one");
}

TEST_F(YamlMapTest, WhatIsNotYamlIsCorruptAndWhatIsNotThereNotFound) {
  EXPECT_FALSE(parse_yaml("a: 1\nb: [1\n", problems));
  EXPECT_EQ(problems.to_error().code, ErrorCode::kCorrupt);
  Problems absent("none.yaml");
  EXPECT_FALSE(load_yaml("/no/such/none.yaml", absent));
  EXPECT_EQ(absent.to_error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace extperfc
