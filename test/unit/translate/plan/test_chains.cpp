// Chains of rules through definitions between, and one plan in several threads.
#include <thread>

#include <gtest/gtest.h>

#include "extperfc/translate/rules.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/definitions.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

/// Three generations of a speed: percent, per mille (renamed), and a ratio.
class PlanChains : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [set, text] : {std::pair{"one", "Header header\nstring s\nint32 percent\n"},
                                    std::pair{"two", "Header header\nint32 per_mille\nstring s\n"},
                                    std::pair{"three", "float64 ratio\nHeader header\nstring s\n"}}) {
      const auto root = folder_.path() / set;
      write(root / "std_msgs/msg/Header.msg", "uint32 seq\ntime stamp\nstring frame_id\n");
      write(root / "p/msg/Speed.msg", text);
      write(root / "p/msg/Fleet.msg", "uint8 before\np/Speed[] speeds\nuint8 after\n");
      ASSERT_TRUE(store_.add_tree(root, set));
    }
    const auto md5 = [&](const char* set) { return store_.message_of_set(set, "p/Speed")->md5(); };
    const auto entry = [&](const char* from, const char* to, const std::string& targets) {
      return "- type: p/Speed\n  from: " + md5(from) + "\n  to: " + md5(to) + "\n  forward: {" + targets +
             "}\n";
    };
    auto rules = parse_rules("rules:\n" + entry("one", "two", "per_mille: {from: percent, scale: 10}") +
                                 entry("two", "three", "ratio: {from: per_mille, scale: 0.001}"),
                             "chain.yaml", store_);
    ASSERT_TRUE(rules) << rules.error().message;
    rules_ = std::move(*rules);
  }

  PlanPtr plan(const std::string& type, const PlanOptions& options = {}) {
    auto compiled = Plan::compile(store_.message_of_set("one", type), store_.message_of_set("three", type),
                                  rules_, options);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return compiled ? *compiled : nullptr;
  }

  static std::string before(std::uint32_t stamp_s, int percent) {
    return Bytes().put(1U).put(stamp_s).put(0U).text("/base").text("x").put(percent).str();
  }
  static std::string after(std::uint32_t stamp_s, double ratio, const std::string& frame = "/base") {
    return Bytes().put(ratio).put(1U).put(stamp_s).put(0U).text(frame).text("x").str();
  }

 private:
  static void write(const std::filesystem::path& file, const std::string& text) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }

  TemporaryFolder folder_;
  DefinitionStore store_;
  RuleSet rules_;
};

}  // namespace

TEST_F(PlanChains, AMessageThroughTheDefinitionBetween) {
  const auto chained = plan("p/Speed");
  EXPECT_EQ(converted(*chained, before(5, 25)), after(5, 0.25));
  EXPECT_EQ(chained->describe().front(), "rule 1 of 2:");
}

TEST_F(PlanChains, EmbeddedMessagesThroughTheDefinitionBetween) {
  const auto chained = plan("p/Fleet");
  EXPECT_EQ(converted(*chained, "<" + Bytes().count(2).str() + before(5, 25) + before(6, 50) + ">"),
            "<" + Bytes().count(2).str() + after(5, 0.25) + after(6, 0.5) + ">");
  const auto cut =
      converted(*chained, "<" + Bytes().count(2).str() + before(5, 25) + before(6, 2'000'000'000) + ">");
  EXPECT_NE(cut.find("field speeds[1].per_mille"), std::string::npos) << cut;
}

TEST_F(PlanChains, StampsShiftOnceAndFramesKeepTheirSlashUntilTheEnd) {
  PlanOptions options;
  options.shift_times = true;
  options.frame_slash = PlanOptions::Slash::kStrip;
  EXPECT_EQ(converted(*plan("p/Speed", options), before(5, 25), 1'000'000'000), after(6, 0.25, "base"));
}

TEST_F(PlanChains, OnePlanRunsInSeveralThreads) {
  const auto chained = plan("p/Fleet");
  const auto work = [&](int percent, int& wrong) {
    const auto message = "<" + Bytes().count(1).str() + before(5, percent) + ">";
    const auto expected = converted(*chained, message);
    for (int i = 0; i < 20'000; ++i) wrong += converted(*chained, message) != expected ? 1 : 0;
    wrong += expected.rfind("error", 0) == 0 ? 1 : 0;
  };
  int first_wrong = 0;
  int second_wrong = 0;
  std::thread other([&] { work(10, first_wrong); });
  work(90, second_wrong);
  other.join();
  EXPECT_EQ(first_wrong, 0);
  EXPECT_EQ(second_wrong, 0);
}
