// What the translator knows at the start: definitions and rules, from the package, the workspace and the
// user.
#include <gtest/gtest.h>

#include "ros/translate/knowledge.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_translate {
namespace {

namespace fs = std::filesystem;
using ros_params::TranslatorParams;

const fs::path& source_folder() {
  static const fs::path folder = EXTPERFC_SOURCE_DIR;
  return folder;
}

/// Nothing but what a test adds.
TranslatorParams nothing() {
  TranslatorParams params;
  params.definitions.shipped = false;
  params.definitions.installed = false;
  params.rules.shipped = false;
  return params;
}

TEST(Knowledge, SearchPathsAreSplit) {
  EXPECT_EQ(split_search_path("/a:/b::/c/"), (std::vector<fs::path>{"/a", "/b", "/c/"}));
  EXPECT_TRUE(split_search_path("").empty());
}

TEST(Knowledge, EverythingThatIsShippedLoads) {
  TranslatorParams params;
  params.definitions.installed = false;
  const auto knowledge = load_knowledge(params, source_folder(), {});
  ASSERT_TRUE(knowledge) << knowledge.error().message;
  EXPECT_TRUE(knowledge->problems.empty()) << knowledge->problems.front();
  for (const char* set : {"indigo", "noetic", "baxter_sdk_1.2.0"})
    EXPECT_NE(knowledge->definitions.message_of_set(
                  set, set[0] == 'b' ? "baxter_core_msgs/JointCommand" : "sensor_msgs/JointState"),
              nullptr)
        << set;
  EXPECT_GT(knowledge->rules.size(), 20U);
  EXPECT_NE(knowledge->summary.find("indigo ("), std::string::npos) << knowledge->summary;
}

TEST(Knowledge, AnOverlaysVersionOfATypeCounts) {
  const TemporaryFolder folder;
  (void)folder.write("below/mine_msgs/msg/Thing.msg", "int32 a\n");
  (void)folder.write("below/mine_msgs/msg/Other.msg", "Thing thing\n");
  (void)folder.write("above/mine_msgs/msg/Thing.msg", "int32 a\nint32 b\n");
  auto params = nothing();
  params.definitions.installed = true;
  const auto knowledge = load_knowledge(
      params, source_folder(), {folder.path() / "above", folder.path() / "none", folder.path() / "below"});
  ASSERT_TRUE(knowledge) << knowledge.error().message;
  const auto message = knowledge->definitions.message_of_set(kInstalledSet, "mine_msgs/Thing");
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->fields().size(), 2U);
  EXPECT_NE(knowledge->definitions.message_of_set(kInstalledSet, "mine_msgs/Other"), nullptr);
}

TEST(Knowledge, FilesThatDoNotParseAreReported) {
  const TemporaryFolder folder;
  (void)folder.write("mine_msgs/msg/Good.msg", "int32 a\n");
  (void)folder.write("mine_msgs/msg/Bad.msg", "int32\n");
  auto params = nothing();
  params.definitions.folders = {{folder.path(), "mine", ""}};
  const auto knowledge = load_knowledge(params, source_folder(), {});
  ASSERT_TRUE(knowledge) << knowledge.error().message;
  ASSERT_EQ(knowledge->problems.size(), 1U);
  EXPECT_NE(knowledge->problems.front().find("Bad"), std::string::npos) << knowledge->problems.front();
  EXPECT_NE(knowledge->definitions.message_of_set("mine", "mine_msgs/Good"), nullptr);
}

TEST(Knowledge, AFolderThatIsMissingIsRefused) {
  auto params = nothing();
  params.definitions.folders = {{"/no/such/folder", "mine", ""}};
  const auto knowledge = load_knowledge(params, source_folder(), {});
  ASSERT_FALSE(knowledge);
  EXPECT_NE(knowledge.error().message.find("/no/such/folder"), std::string::npos)
      << knowledge.error().message;
}

TEST(Knowledge, RuleFilesComeInOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"rules/b.yaml", "rules/a.yaml", "rules/readme.txt", "one.yaml"})
    (void)folder.write(name, "");
  ros_params::TranslatorRules params;
  params.shipped = false;
  params.files = {folder.path() / "one.yaml", folder.path() / "rules"};
  const auto files = rule_files(params, source_folder());
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_EQ(*files, (std::vector<fs::path>{folder.path() / "one.yaml", folder.path() / "rules" / "a.yaml",
                                           folder.path() / "rules" / "b.yaml"}));
  params.files = {"/no/such/rules.yaml"};
  ASSERT_FALSE(rule_files(params, source_folder()));
}

TEST(Knowledge, ARuleThatDoesNotFitIsRefusedWithItsFile) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("wrong.yaml", "rules:\n  - type: no_such/Type\n    from: {md5: a}\n    to: {md5: b}\n");
  auto params = nothing();
  params.rules.files = {file};
  const auto knowledge = load_knowledge(params, source_folder(), {});
  ASSERT_FALSE(knowledge);
  EXPECT_NE(knowledge.error().message.find(file.string() + ":"), std::string::npos)
      << knowledge.error().message;
}

}  // namespace
}  // namespace extperfc::ros_translate
