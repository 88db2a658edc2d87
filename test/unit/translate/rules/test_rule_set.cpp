// Rules as plain data: pairs, chains and other names.
#include <gtest/gtest.h>

#include "extperfc/translate/rules.hpp"

namespace extperfc::translate {
namespace {

SchemaPtr message(const std::string& type, const std::string& text) {
  auto schema = parse_message(type, text, [](const std::string&) { return nullptr; });
  EXPECT_TRUE(schema) << schema.error().message;
  return *schema;
}

MigrationRule rule(const SchemaPtr& from, const SchemaPtr& to) {
  MigrationRule made;
  made.from_type = from->type();
  made.from_md5 = from->md5();
  made.to_type = to->type();
  made.to_md5 = to->md5();
  return made;
}

class RuleSetTest : public testing::Test {
 protected:
  void join(const SchemaPtr& from, const SchemaPtr& to) {
    rules.add(rule(from, to));
    rules.add_schema(from);
    rules.add_schema(to);
  }

  RuleSet rules;
  SchemaPtr v1 = message("p/T", "int8 a\n"), v2 = message("p/T", "int16 a\n"),
            v3 = message("p/T", "int32 a\n"), v4 = message("p/T", "int64 a\n");
};

TEST_F(RuleSetTest, FindsARuleByThePairInOneDirection) {
  join(v1, v2);
  ASSERT_NE(rules.find(*v1, *v2), nullptr);
  EXPECT_EQ(rules.find(*v1, *v2)->to_md5, v2->md5());
  EXPECT_EQ(rules.find(*v2, *v1), nullptr);
  EXPECT_EQ(rules.find(*v1, *v3), nullptr);
  EXPECT_EQ(rules.size(), 1U);
}

TEST_F(RuleSetTest, TheTypeCountsBesideTheMd5) {
  const auto other = message("q/T", "int16 a\n");
  ASSERT_EQ(other->md5(), v2->md5());
  join(v1, v2);
  EXPECT_EQ(rules.find(*v1, *other), nullptr);
}

TEST_F(RuleSetTest, ChainsThroughVersionsBetween) {
  join(v1, v2);
  join(v2, v3);
  join(v3, v4);
  const auto links = rules.chain(v1, v4);
  ASSERT_EQ(links.size(), 3U);
  EXPECT_EQ(links[0].from, v1);
  EXPECT_EQ(links[0].to, v2);
  EXPECT_EQ(links[1].from, v2);
  EXPECT_EQ(links[1].to, v3);
  EXPECT_EQ(links[2].to, v4);
  EXPECT_EQ(links[1].rule, rules.find(*v2, *v3));
  EXPECT_TRUE(rules.chain(v4, v1).empty());
}

TEST_F(RuleSetTest, TakesTheShortestChainAndEndsInCircles) {
  join(v1, v2);
  join(v2, v1);
  join(v2, v3);
  join(v3, v2);
  join(v3, v4);
  join(v2, v4);
  EXPECT_EQ(rules.chain(v1, v4).size(), 2U);
  EXPECT_TRUE(rules.chain(v4, v1).empty());
  EXPECT_TRUE(rules.chain(v1, v1).empty());
}

TEST_F(RuleSetTest, ASingleRuleIsNoChain) {
  join(v1, v2);
  EXPECT_TRUE(rules.chain(v1, v2).empty());
}

TEST_F(RuleSetTest, AChainLeadsOnlyThroughKnownDefinitions) {
  rules.add(rule(v1, v2));
  rules.add(rule(v2, v3));
  EXPECT_TRUE(rules.chain(v1, v3).empty());
  rules.add_schema(v2);
  EXPECT_EQ(rules.chain(v1, v3).size(), 2U);
}

TEST_F(RuleSetTest, TheEndsOfAChainAreThoseThatWereAskedFor) {
  join(v1, v2);
  join(v2, v3);
  const auto same_again = message("p/T", "int8 a\n");
  EXPECT_EQ(rules.chain(same_again, v3).front().from, same_again);
}

TEST_F(RuleSetTest, PackagesAndTypesHaveOtherNames) {
  rules.add_rename("old_msgs", "new_msgs");
  rules.add_rename("new_msgs/T", "newest_msgs/U");
  EXPECT_EQ(rules.other_names("old_msgs/T"), (std::vector<std::string>{"new_msgs/T", "newest_msgs/U"}));
  EXPECT_EQ(rules.other_names("newest_msgs/U"), (std::vector<std::string>{"new_msgs/T", "old_msgs/T"}));
  EXPECT_EQ(rules.other_names("new_msgs/V"), (std::vector<std::string>{"old_msgs/V"}));
  EXPECT_TRUE(rules.other_names("old_msgs_too/T").empty());
  EXPECT_TRUE(rules.other_names("").empty());
}

TEST_F(RuleSetTest, ARuleBetweenNamesRenamesItsTypes) {
  join(v1, message("q/S", "int8 b\n"));
  EXPECT_EQ(rules.other_names("q/S"), (std::vector<std::string>{"p/T"}));
}

TEST_F(RuleSetTest, APackageIsNoNameOfAType) {
  rules.add_rename("a", "a/b");
  rules.add_rename("c", "c");
  EXPECT_TRUE(rules.other_names("a/T").empty());
  EXPECT_TRUE(rules.other_names("c/T").empty());
}

TEST_F(RuleSetTest, RenamesInACircleEnd) {
  rules.add_rename("a", "b");
  rules.add_rename("b", "c");
  rules.add_rename("c", "a");
  EXPECT_EQ(rules.other_names("a/T").size(), 2U);
}

}  // namespace
}  // namespace extperfc::translate
