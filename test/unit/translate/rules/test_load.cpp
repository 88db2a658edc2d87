// The grammar of rules, and what is said of rules that are wrong.
#include <fstream>

#include <gtest/gtest.h>

#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

#include "test/unit/translate/rules/small_store.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kPose = "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n";

void expect_has(const std::string& message, const std::string& expected) {
  EXPECT_NE(message.find(expected), std::string::npos)
      << "message:  " << message << "\nexpected: " << expected;
}

class LoadTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new SmallStore();
    for (const std::string set : {"old", "new"}) {
      shared->write(set, "geometry_msgs/Point.msg", "float64 x\nfloat64 y\nfloat64 z\n");
      shared->write(set, "geometry_msgs/Quaternion.msg", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
      shared->write(set, "geometry_msgs/Pose.msg", kPose);
    }
    shared->write("old", "p/Head.msg",
                  "uint8 SLOW=1\nuint8 FAST=2\nfloat32 target\nint32 speed\nstring[] "
                  "names\ngeometry_msgs/Pose[] poses\n"
                  "geometry_msgs/Pose base\nbool[3] flags\nuint8 mode\n");
    shared->write("new", "p/Head.msg",
                  "uint8 WALK=10\nuint8 RUN=20\nfloat32 target\nfloat32 ratio\nstring "
                  "name\ngeometry_msgs/Pose[] poses\n"
                  "bool[] flags\ngeometry_msgs/Pose stand\nuint8 mode\nint8 small\n");
    shared->write("old", "p/Ask.srv", "int32 a\n---\nbool ok\n");
    shared->write("new", "p/Ask.srv", "int32 a\nint32 b\n---\nbool ok\n");
    shared->write("new", "q/Top.msg", "float32 target\n");
    shared->read("old");
    shared->read("new");
  }
  static void TearDownTestSuite() {
    delete shared;
    shared = nullptr;
  }

  /// A file with one entry of p/Head: line 1 `- type`, 2 `from`, 3 `to`, and the rest from line 4.
  [[nodiscard]] std::string entry(const std::string& rest) const {
    return "- type: p/Head\n  from: " + store.md5("old", "p/Head") + "\n  to: " + store.md5("new", "p/Head") +
           "\n" + rest;
  }
  [[nodiscard]] std::string problem(const std::string& text) const {
    const auto rules = parse_rules(text, "r.yaml", store.definitions);
    return rules ? "" : rules.error().message;
  }
  void expect_problem(const std::string& text, const std::string& expected) const {
    expect_has(problem(text), expected);
  }
  [[nodiscard]] RuleSet good(const std::string& text) const {
    auto rules = parse_rules(text, "r.yaml", store.definitions);
    EXPECT_TRUE(rules) << rules.error().message;
    return rules ? *rules : RuleSet();
  }
  [[nodiscard]] SchemaPtr head(const std::string& set) const {
    return store.definitions.message_of_set(set, "p/Head");
  }
  [[nodiscard]] const Source& forward(const RuleSet& rules, const std::string& target) const {
    static const Source kNone;
    const auto* rule = rules.find(*head("old"), *head("new"));
    EXPECT_NE(rule, nullptr);
    if (rule != nullptr)
      for (const auto& [name, source] : rule->targets)
        if (name == target) return source;
    ADD_FAILURE() << "no target " << target;
    return kNone;
  }

  static inline SmallStore* shared = nullptr;
  SmallStore& store = *shared;
};

TEST_F(LoadTest, NothingIsNoRule) {
  EXPECT_EQ(good("").size(), 0U);
  EXPECT_EQ(good("# only a comment\n").size(), 0U);
  EXPECT_EQ(good("rules: []\n").size(), 0U);
}

TEST_F(LoadTest, AnEntryIsARuleInEachDirection) {
  const auto rules =
      good(entry("  forward: {ratio: {from: speed, scale: 0.01, offset: 1, overflow: saturate}}\n"));
  EXPECT_EQ(rules.size(), 2U);
  const auto& source = forward(rules, "ratio");
  EXPECT_EQ(source.kind, Source::Kind::kField);
  ASSERT_EQ(source.path.size(), 1U);
  EXPECT_EQ(source.path[0].field, "speed");
  EXPECT_DOUBLE_EQ(source.scale, 0.01);
  EXPECT_DOUBLE_EQ(source.offset, 1.0);
  EXPECT_EQ(source.overflow, Overflow::kSaturate);
  const auto* back = rules.find(*head("new"), *head("old"));
  ASSERT_NE(back, nullptr);
  EXPECT_TRUE(back->targets.empty());
  EXPECT_EQ(back->origin, "r.yaml:1");
  EXPECT_EQ(rules.find(*head("old"), *head("new"))->origin, "r.yaml:4");
}

TEST_F(LoadTest, ReadsEverySource) {
  const auto rules =
      good(entry("  forward:\n"
                 "    ratio: speed\n"
                 "    name: {from: \"names[2]\", otherwise: none}\n"
                 "    poses: {from: poses, relative_to: base}\n"
                 "    flags: {list: [{from: \"flags[1]\"}, {value: true}]}\n"
                 "    stand: {fields: {position: {fields: {x: {from: base.position.y}}}}}\n"
                 "    mode: {from: mode, map: {SLOW: WALK, 2: RUN}, otherwise: 0}\n"
                 "    small: {value: -5}\n"
                 "  drop_forward: [target]\n"));
  EXPECT_EQ(forward(rules, "ratio").path[0].field, "speed");
  const auto& name = forward(rules, "name");
  EXPECT_EQ(name.path[0].index, 2U);
  ASSERT_TRUE(name.otherwise);
  EXPECT_EQ(name.otherwise->scalar, "none");
  EXPECT_EQ(forward(rules, "poses").relative_to[0].field, "base");
  EXPECT_EQ(forward(rules, "flags").kind, Source::Kind::kList);
  ASSERT_EQ(forward(rules, "flags").list.size(), 2U);
  EXPECT_EQ(forward(rules, "flags").list[1].value.scalar, "true");
  const auto& stand = forward(rules, "stand");
  ASSERT_EQ(stand.kind, Source::Kind::kMessage);
  EXPECT_EQ(stand.fields[0].second.fields[0].second.path.size(), 3U);
  const auto& mode = forward(rules, "mode");
  ASSERT_EQ(mode.map.size(), 2U);
  EXPECT_EQ(mode.map[0].first.scalar, "1");  // constants of either side by name
  EXPECT_EQ(mode.map[0].second.scalar, "10");
  EXPECT_EQ(mode.map[1].second.scalar, "20");
  EXPECT_EQ(rules.find(*head("old"), *head("new"))->dropped, std::vector<std::string>{"target"});
}

TEST_F(LoadTest, ServicesByTheirOwnMd5) {
  const auto rules =
      good("- service: p/Ask\n  from: " + store.md5("old", "p/Ask") + "\n  to: " + store.md5("new", "p/Ask") +
           "\n  request: {forward: {b: {value: 3}}}\n");
  const auto older = store.definitions.service_of_set("old", "p/Ask");
  const auto newer = store.definitions.service_of_set("new", "p/Ask");
  EXPECT_EQ(rules.size(), 2U);
  ASSERT_NE(rules.find(*older->request, *newer->request), nullptr);
  EXPECT_EQ(rules.find(*older->request, *newer->request)->targets.size(), 1U);
  EXPECT_NE(rules.find(*newer->request, *older->request), nullptr);
}

TEST_F(LoadTest, AHalfThatDoesNotDifferHasNoRule) {
  expect_problem("- service: p/Ask\n  from: " + store.md5("old", "p/Ask") + "\n  to: " +
                     store.md5("new", "p/Ask") + "\n  response: {forward: {ok: {value: true}}}\n",
                 "r.yaml:4: p/Ask.response: is the same on both sides");
}

TEST_F(LoadTest, RenamesAreRead) {
  const auto rules =
      good("renames:\n  - {from: a_msgs, to: b_msgs}\n  - {from: tf/tfMessage, to: tf2_msgs/TFMessage}\n");
  EXPECT_EQ(rules.other_names("a_msgs/X"), std::vector<std::string>{"b_msgs/X"});
  EXPECT_EQ(rules.other_names("tf2_msgs/TFMessage"), std::vector<std::string>{"tf/tfMessage"});
  expect_problem("renames: []\n]\n", "not YAML");
  expect_problem("renames:\n  - {from: a_msgs, to: b/T}\n", "r.yaml:2: renames: needs from and to");
}

TEST_F(LoadTest, RulesBetweenTypesOfOtherNames) {
  const auto rules = good("- from: {type: p/Head, md5: " + store.md5("old", "p/Head") +
                          "}\n  to: {type: q/Top, md5: " + store.md5("new", "q/Top") + "}\n");
  EXPECT_EQ(rules.other_names("p/Head"), std::vector<std::string>{"q/Top"});
}

struct BadCase {
  const char* rest;
  const char* expected;
};
void PrintTo(const BadCase& bad, std::ostream* out) {
  *out << bad.rest;
}

class BadEntryTest : public LoadTest, public testing::WithParamInterface<BadCase> {};

TEST_P(BadEntryTest, IsRefusedWithItsLineAndReason) {
  expect_problem(entry(GetParam().rest), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    Grammar, BadEntryTest,
    testing::Values(
        BadCase{"  forwards: {}\n", "r.yaml:4: p/Head: unknown key \"forwards\", did you mean \"forward\"?"},
        BadCase{"  forward: 3\n", "r.yaml:4: p/Head.forward: must be a map"},
        BadCase{"  forward: {}\n  forward: {}\n", "r.yaml:5: p/Head.forward: is given twice"},
        BadCase{"  forward:\n    ratio: {from: speed, scal: 2}\n",
                "r.yaml:5: p/Head.forward.ratio: unknown key \"scal\", did you mean \"scale\"?"},
        BadCase{"  forward:\n    ratio: {scale: 2}\n", "r.yaml:5: p/Head.forward.ratio: has no source"},
        BadCase{"  forward:\n    ratio: {form: speed}\n", "unknown key \"form\", did you mean \"from\"?"},
        BadCase{"  forward:\n    ratio: {from: speed, value: 2}\n", "unknown key \"value\""},
        BadCase{"  forward:\n    ratio: 3\n",
                "r.yaml:5: p/Head.forward.ratio: \"3\" does not name a field: write {value"},
        BadCase{"  forward:\n    ratio: [speed]\n", "r.yaml:5: p/Head.forward.ratio: must be a map"},
        BadCase{"  forward:\n    ratio: {from: speed..x}\n", "is not a field path"},
        BadCase{"  forward:\n    ratio: {from: \"speed[-1]\"}\n", "is not a field path"},
        BadCase{"  forward:\n    ratio: {from: speed, scale: .nan}\n", "scale: must be a finite number"},
        BadCase{"  forward:\n    ratio: {from: speed, scale: 0}\n", "must not be 0"},
        BadCase{"  forward:\n    ratio: {from: speed, overflow: wrap}\n",
                "must be refuse or saturate, not \"wrap\""},
        BadCase{"  forward:\n    ratio: {from: speed, otherwise: 1}\n", "there is neither"},
        BadCase{"  forward:\n    mode: {from: mode, map: {}}\n", "map: is empty"},
        BadCase{"  forward:\n    ratio: {value: }\n", "value: has no value"},
        BadCase{"  forward:\n    flags: {list: 3}\n", "list: must be a list"},
        BadCase{"  drop_forward: speed\n", "r.yaml:4: p/Head.drop_forward: must be a list of fields"}));

INSTANTIATE_TEST_SUITE_P(
    Definitions, BadEntryTest,
    testing::Values(
        BadCase{"  forward:\n    ratios: speed\n",
                "r.yaml:5: p/Head.forward: p/Head has no field \"ratios\", did you mean \"ratio\"?"},
        BadCase{"  forward:\n    ratio: {from: sped}\n",
                "r.yaml:5: p/Head.forward.ratio.from: p/Head has no field \"sped\", did you mean \"speed\"?"},
        BadCase{"  forward:\n    ratio: {from: base.positions.x}\n",
                "geometry_msgs/Pose has no field \"positions\", did you mean \"position\"?"},
        BadCase{"  forward:\n    ratio: {from: poses.position.x}\n",
                "\"poses\" is an array: say which element"},
        BadCase{"  forward:\n    ratio: {from: \"speed[0]\"}\n", "\"speed\" is not an array"},
        BadCase{"  forward:\n    ratio: {from: speed.x}\n", "\"speed\" has no fields"},
        BadCase{"  forward:\n    flags: {list: [{from: \"flags[3]\"}]}\n", "\"flags\" has 3 elements"},
        BadCase{"  forward:\n    name: {from: \"names[0]\", scale: 2}\n", "scale: is for numbers"},
        BadCase{"  forward:\n    small: {value: 200}\n", "r.yaml:5: p/Head.forward.small.value: "},
        BadCase{"  forward:\n    small: {value: WALKED}\n",
                "p/Head has no constant \"WALKED\", did you mean \"WALK\"?"},
        BadCase{"  forward:\n    mode: {from: mode, map: {QUICK: 1}}\n", "p/Head has no constant \"QUICK\""},
        BadCase{"  forward:\n    mode: {from: mode, map: {300: 1}}\n",
                "r.yaml:5: p/Head.forward.mode.map.\"300\": "},
        BadCase{"  forward:\n    stand: {fields: {positon: {value: 1}}}\n",
                "geometry_msgs/Pose has no field \"positon\", did you mean \"position\"?"},
        BadCase{"  forward:\n    stand: {value: {position: {q: 1}}}\n",
                "geometry_msgs/Point has no field \"q\""},
        BadCase{"  forward:\n    small: {list: [{value: 1}]}\n", "list: is for arrays"},
        BadCase{"  forward:\n    small: {fields: {x: {value: 1}}}\n", "fields: is for one embedded message"},
        BadCase{"  forward:\n    poses: {from: poses, relative_to: target}\n",
                "relative_to: must be a geometry_msgs/Pose"},
        BadCase{"  forward:\n    ratio: {from: speed, relative_to: base}\n", "relative_to: is for fields of"},
        BadCase{"  drop_forward: [spee]\n",
                "r.yaml:4: p/Head.drop_forward: p/Head has no field \"spee\", did you mean \"speed\"?"},
        // Types that do not convert are found by making the plan.
        BadCase{"  forward:\n    ratio: {from: names}\n", "r.yaml:4: "},
        BadCase{"  forward:\n    name: {from: names}\n", "r.yaml:4: "}));

TEST_F(LoadTest, EveryProblemIsReportedAtOnceInTheFilesOrder) {
  const auto message =
      problem(entry("  forward:\n    small: {value: 200}\n    ratio: {from: sped}\n  frm: 1\n"));
  const auto first = message.find("r.yaml:5:"), second = message.find("r.yaml:6:"),
             third = message.find("r.yaml:7:");
  ASSERT_NE(first, std::string::npos) << message;
  ASSERT_NE(second, std::string::npos) << message;
  ASSERT_NE(third, std::string::npos) << message;
  EXPECT_LT(first, second);
  EXPECT_LT(second, third);
}

TEST_F(LoadTest, UnknownDefinitionsAreReported) {
  const std::string zeros(32, '0');
  expect_problem("- type: p/Head\n  from: " + zeros + "\n  to: " + store.md5("new", "p/Head") + "\n",
                 "r.yaml:2: p/Head: no definition with MD5 " + zeros + "; known are ");
  expect_problem("- type: p/Had\n  from: " + zeros + "\n  to: {md5: " + zeros + "}\n",
                 "r.yaml:2: p/Had: no definition of this message is known, did you mean \"p/Head\"?");
  expect_problem("- service: p/Task\n  from: " + zeros + "\n  to: " + zeros + "\n",
                 "no definition of this service is known, did you mean \"p/Ask\"?");
  expect_problem("- type: p/Head\n  from: 12\n  to: {md5: " + zeros + "}\n",
                 "needs an MD5 of 32 hexadecimal digits");
  expect_problem("- type: p/Head\n  from: {md5: " + zeros + "}\n", "p/Head: has no to");
  expect_problem("- from: {md5: " + zeros + "}\n  to: {md5: " + zeros + "}\n",
                 "needs a type like package/Name");
}

TEST_F(LoadTest, ASecondRuleForAPairIsRefused) {
  expect_problem(entry("") + entry(""),
                 "r.yaml:4: p/Head: a second rule for this pair of definitions; the first is at r.yaml:1");
  const std::string md5 = store.md5("old", "p/Head");
  expect_problem("- type: p/Head\n  from: " + md5 + "\n  to: " + md5 + "\n",
                 "is the same definition as from");
}

TEST_F(LoadTest, InvalidYamlIsReportedWithItsLine) {
  expect_problem("rules:\n  - {type: [\n", "r.yaml:");
  expect_problem("rules:\n  - {type: [\n", "not YAML");
  expect_problem("just a text\n", "r.yaml:1: must be a map");
  expect_problem("rule: []\n", "unknown key \"rule\", did you mean \"rules\"?");
  expect_problem("rules: []\n---\nrules: []\n", "a second document");
}

TEST_F(LoadTest, TreesThatAnAliasMakesEndlessOrHugeAreRefused) {
  EXPECT_NE(problem(entry("  forward: {stand: &a {fields: {position: *a}}}\n")), "");
  EXPECT_NE(problem(entry("  forward: {poses: {value: &a [*a]}}\n")), "");
  std::string bomb = "  forward:\n    poses: {value: &a0 [1,1,1,1,1,1,1,1,1,1]}\n";
  for (int i = 1; i < 9; ++i) {
    bomb += "    k" + std::to_string(i) + ": {value: &a" + std::to_string(i) + " [";
    for (int j = 0; j < 10; ++j) bomb += (j == 0 ? "*a" : ",*a") + std::to_string(i - 1);
    bomb += "]}\n";
  }
  expect_problem(entry(bomb), "more than 100000 values");
}

TEST_F(LoadTest, FilesAreReadInOrderAndMissingOnesReported) {
  const auto first = store.folder() / "a.yaml", second = store.folder() / "b.yaml";
  std::ofstream(first) << entry("");
  std::ofstream(second) << "rules:\n"
                        << "  - {type: p/Head, from: " << store.md5("old", "p/Head")
                        << ", to: " << store.md5("new", "p/Head") << "}\n";
  EXPECT_TRUE(load_rules({first}, store.definitions));
  EXPECT_TRUE(load_rules({}, store.definitions));
  const auto twice = load_rules({first, second}, store.definitions);
  ASSERT_FALSE(twice);
  expect_has(twice.error().message, second.string() + ":2: ");
  expect_has(twice.error().message, "the first is at " + first.string() + ":1");
  const auto missing = load_rules({store.folder() / "c.yaml", store.folder()}, store.definitions);
  ASSERT_FALSE(missing);
  expect_has(missing.error().message, "c.yaml: cannot be read");
}

}  // namespace
}  // namespace extperfc::translate
