// Every type whose definition differs between two of the shipped sets, there and back, with random messages.
#include <algorithm>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/rules.hpp"

#include "test/support/random_message.hpp"
#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/reference.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

constexpr int kMessages = 200;  // of each type and direction
constexpr std::uint64_t kSeed = 20'140'722;

const std::filesystem::path kConfig = std::filesystem::path(EXTPERFC_SOURCE_DIR) / "config" / "translate";

struct Totals {
  int types{0}, pass{0}, messages{0}, identical{0}, refused{0};
};

/// Fields that rules between two definitions write: what they do is not "the same value again".
std::set<std::string> written_by_rules(const RuleSet& rules, const SchemaPtr& from, const SchemaPtr& to) {
  std::set<std::string> names;
  const auto add = [&](const MigrationRule& rule) {
    for (const auto& [name, source] : rule.targets) names.insert(name);
  };
  if (const auto* rule = rules.find(*from, *to)) {
    add(*rule);
  } else {
    for (const auto& link : rules.chain(from, to)) add(*link.rule);
  }
  return names;
}

/// Compares the fields that both definitions have, at every depth.
class CommonFields {
 public:
  explicit CommonFields(const RuleSet& rules) : rules_(rules) {}

  void expect_equal(const SchemaPtr& schema, const SchemaPtr& other, const reference::Value& before,
                    const reference::Value& after, const std::string& path) {
    const auto there = written_by_rules(rules_, schema, other);
    const auto back = written_by_rules(rules_, other, schema);
    for (std::size_t i = 0; i < schema->fields().size(); ++i) {
      const auto& field = schema->fields()[i];
      const auto* twin = other->find(field.name);
      if (twin == nullptr || there.count(field.name) != 0 || back.count(field.name) != 0) continue;
      expect_equal(field, *twin, before.parts[i], after.parts[i], path + "." + field.name);
    }
  }

 private:
  void expect_equal(const Field& field, const Field& twin, const reference::Value& before,
                    const reference::Value& after, const std::string& path) {
    if (field.arity != Arity::kSingle) {
      ASSERT_EQ(before.parts.size(), after.parts.size()) << path;
      Field element = field;
      element.arity = Arity::kSingle;
      for (std::size_t i = 0; i < before.parts.size(); ++i)
        expect_equal(element, twin, before.parts[i], after.parts[i], path + "[" + std::to_string(i) + "]");
    } else if (field.message && twin.message) {
      expect_equal(field.message, twin.message, before, after, path);
    } else {
      ASSERT_EQ(before.bytes, after.bytes) << path;
    }
  }

  const RuleSet& rules_;
};

class AllDifferences : public testing::Test {
 protected:
  void SetUp() override {
    const auto read = store_.add_store(kConfig / "definitions");
    ASSERT_TRUE(read) << read.error().message;
    auto rules = load_rules({kConfig / "indigo_noetic.yaml", kConfig / "baxter_sdk.yaml"}, store_);
    ASSERT_TRUE(rules) << rules.error().message;
    rules_ = std::move(*rules);
  }

  Totals between(const std::string& older, const std::string& newer) {
    Totals totals;
    for (const auto& type : store_.content(older).messages)
      there_and_back(store_.message_of_set(older, type), store_.message_of_set(newer, type), totals);
    for (const auto& type : store_.content(older).services) {
      const auto from = store_.service_of_set(older, type);
      const auto to = store_.service_of_set(newer, type);
      if (!to || (from->md5 == to->md5)) continue;
      there_and_back(from->request, to->request, totals);
      there_and_back(from->response, to->response, totals);
    }
    std::printf(
        "%s and %s: %d definitions differ (%d pass), %d messages there and back, %d identical, %d refused\n",
        older.c_str(), newer.c_str(), totals.types, totals.pass, totals.messages, totals.identical,
        totals.refused);
    return totals;
  }

 private:
  void there_and_back(const SchemaPtr& older, const SchemaPtr& newer, Totals& totals) {
    if (!newer || older->md5() == newer->md5()) return;
    SCOPED_TRACE(older->type());
    const auto forward = Plan::compile(older, newer, rules_);
    const auto backward = Plan::compile(newer, older, rules_);
    ASSERT_TRUE(forward) << forward.error().message;
    ASSERT_TRUE(backward) << backward.error().message;
    ASSERT_EQ((*forward)->kind() == Plan::Kind::kPass, same_layout(*older, *newer));
    ++totals.types;
    totals.pass += (*forward)->kind() == Plan::Kind::kPass ? 1 : 0;
    round_trips(**forward, **backward, totals);
    round_trips(**backward, **forward, totals);
  }

  void round_trips(const Plan& there, const Plan& back, Totals& totals) {
    Rng rng(kSeed);
    for (int i = 0; i < kMessages; ++i) {
      const bool wild = i % 2 == 0;
      RandomMessage messages(rng, {3, 9, wild ? 0.3 : 0.0});
      round_trip(there, back, string_of(messages.make(*there.from())), wild, totals);
      if (HasFatalFailure()) FAIL() << "seed " << kSeed << ", message " << i;
    }
  }

  void round_trip(const Plan& there, const Plan& back, const std::string& message, bool wild,
                  Totals& totals) {
    ++totals.messages;
    const auto away = converted(there, message);
    const auto returned = away.rfind("error: ", 0) == 0 ? away : converted(back, away);
    if (wild && returned.find("does not fit") != std::string::npos) {  // a rule scaled a number of any bits
      ++totals.refused;
      return;
    }
    ASSERT_NE(returned.rfind("error: ", 0), 0U) << returned;
    totals.identical += returned == message ? 1 : 0;
    auto rest = message;
    const auto before = reference::decode(*there.from(), rest);
    rest = returned;
    const auto after = reference::decode(*there.from(), rest);
    ASSERT_TRUE(before && after && rest.empty());
    CommonFields(rules_).expect_equal(there.from(), there.to(), *before, *after, there.from()->type());
  }

  DefinitionStore store_;
  RuleSet rules_;
};

}  // namespace

TEST_F(AllDifferences, IndigoAndNoetic) {
  const auto totals = between("indigo", "noetic");
  EXPECT_GE(totals.types, 69);
  EXPECT_LT(totals.refused, totals.messages / 100);
}

TEST_F(AllDifferences, BaxterSdkReleases) {
  const std::vector<std::string> releases{"0.7.0", "1.0.0", "1.0.1", "1.1.0", "1.1.1", "1.2.0"};
  int types = 0;
  for (std::size_t i = 0; i + 1 < releases.size(); ++i)
    types += between("baxter_sdk_" + releases[i], "baxter_sdk_" + releases[i + 1]).types;
  EXPECT_GE(types, 18);
}

TEST_F(AllDifferences, BaxterSdkOldestAndNewestThroughChains) {
  const auto totals = between("baxter_sdk_0.7.0", "baxter_sdk_1.2.0");
  EXPECT_GE(totals.types, 12);
}
