#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/translate/definition_store.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::translate {
namespace {

namespace fs = std::filesystem;
const fs::path kShipped = fs::path(EXTPERFC_SOURCE_DIR) / "config" / "translate" / "definitions";
const std::string kHeaderMd5 = "2176decaecbce78abc3b96ef049fabed";
const std::string kPointMd5 = "4a842b65f413084dc2b10fb484ea7f17";

std::vector<std::vector<std::string>> rows_of(const std::string& name) {
  std::ifstream in(fs::path(EXTPERFC_TEST_DATA) / "translate" / name);
  EXPECT_TRUE(in) << name;
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream tokens(line);
    rows.emplace_back();
    for (std::string token; tokens >> token;) rows.back().push_back(token);
  }
  return rows;
}

const DefinitionStore& shipped() {
  static const DefinitionStore store = [] {
    DefinitionStore made;
    const auto count = made.add_store(kShipped);
    EXPECT_TRUE(count) << count.error().message;
    return made;
  }();
  return store;
}

/// The MD5 that a set has for a type; "" when it has none.
std::string md5_in(const DefinitionStore& store, const std::string& set, const std::string& type,
                   const std::string& kind) {
  if (kind == "msg") {
    const auto schema = store.message_of_set(set, type);
    return schema ? schema->md5() : "";
  }
  if (kind == "srv") {
    const auto schema = store.service_of_set(set, type);
    return schema ? schema->md5 : "";
  }
  const auto schema = store.action_of_set(set, type);
  return schema ? schema->action->md5() : "";
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ostringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    files[fs::relative(entry.path(), folder).string()] = text.str();
  }
  return files;
}

TEST(ShippedStore, EveryPublishedMd5OfIndigoAndNoetic) {
  // Three definitions of fkie_multimaster_msgs are not published in a form whose MD5 fits, so they are not
  // here.
  const std::vector<std::string> unknown{"fkie_multimaster_msgs/LinkState",
                                         "fkie_multimaster_msgs/LinkStatesStamped",
                                         "fkie_multimaster_msgs/LoadLaunch"};
  std::size_t checked = 0;
  for (const auto& row : rows_of("known_md5.txt")) {
    ASSERT_EQ(4U, row.size());
    for (const auto& [set, expected] : {std::pair("indigo", row[2]), std::pair("noetic", row[3])}) {
      const auto found = md5_in(shipped(), set, row[0], row[1]);
      if (expected == "-") continue;
      if (std::find(unknown.begin(), unknown.end(), row[0]) != unknown.end()) {
        EXPECT_EQ("", found) << row[0];
        continue;
      }
      EXPECT_EQ(expected, found) << set << " " << row[0] << " " << row[1];
      ++checked;
    }
  }
  EXPECT_EQ(1001U, checked);
}

TEST(ShippedStore, DifferencesOfIndigoAndNoeticAndWhichOfThemAreOnlyConstants) {
  const auto same = [](const std::string& type, const std::string& kind) {
    if (kind == "msg")
      return same_layout(*shipped().message_of_set("indigo", type),
                         *shipped().message_of_set("noetic", type));
    if (kind == "srv") {
      const auto before = shipped().service_of_set("indigo", type);
      const auto after = shipped().service_of_set("noetic", type);
      return same_layout(*before->request, *after->request) &&
             same_layout(*before->response, *after->response);
    }
    return same_layout(*shipped().action_of_set("indigo", type)->action,
                       *shipped().action_of_set("noetic", type)->action);
  };
  const auto rows = rows_of("indigo_noetic_differences.txt");
  EXPECT_EQ(69U, rows.size());
  for (const auto& row : rows) {
    ASSERT_EQ(row[2], md5_in(shipped(), "indigo", row[0], row[1])) << row[0];
    ASSERT_EQ(row[3], md5_in(shipped(), "noetic", row[0], row[1])) << row[0];
    EXPECT_EQ(row[4] == "pass", same(row[0], row[1])) << row[0];
  }
}

TEST(ShippedStore, DifferencesOfTheBaxterReleases) {
  const auto rows = rows_of("baxter_sdk_differences.txt");
  EXPECT_EQ(23U, rows.size());
  for (const auto& row : rows)
    for (const auto& [release, expected] : {std::pair(row[1], row[3]), std::pair(row[2], row[4])}) {
      auto found = md5_in(shipped(), "baxter_sdk_" + release, row[0], "msg");
      if (found.empty()) found = md5_in(shipped(), "baxter_sdk_" + release, row[0], "srv");
      EXPECT_EQ(expected == "-" ? "" : expected, found) << row[0] << " of " << release;
    }
}

TEST(ShippedStore, LoadsQuickly) {
  const auto begin = std::chrono::steady_clock::now();
  DefinitionStore store;
  ASSERT_TRUE(store.add_store(kShipped));
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
  RecordProperty("load_ms", std::to_string(taken.count()));
  std::cout << "the shipped store: " << taken.count() << " ms\n";
}

TEST(ShippedStore, FindsBySetTypeAndMd5) {
  EXPECT_EQ((std::vector<std::string>{"baxter_sdk_0.7.0", "baxter_sdk_1.0.0", "baxter_sdk_1.0.1",
                                      "baxter_sdk_1.1.0", "baxter_sdk_1.1.1", "baxter_sdk_1.2.0", "indigo",
                                      "noetic"}),
            shipped().sets());
  const std::string old_marker = "18326976df9d29249efc939e00342cde";
  EXPECT_EQ(2U, shipped().messages("visualization_msgs/Marker").size());
  EXPECT_EQ((std::vector<std::string>{"indigo"}),
            shipped().sets_with("visualization_msgs/Marker", old_marker));
  EXPECT_EQ((std::vector<std::string>{"indigo", "noetic"}),
            shipped().sets_with("std_msgs/Header", kHeaderMd5));
  EXPECT_EQ(old_marker, shipped().find_message("visualization_msgs/Marker", old_marker)->md5());
  EXPECT_FALSE(shipped().find_message("visualization_msgs/Marker", kHeaderMd5));
  EXPECT_FALSE(shipped().find_message("no_msgs/Such", kHeaderMd5));
  // Derived from an action, and halves of services.
  EXPECT_TRUE(shipped().find_message("moveit_msgs/PickupActionGoal", "9e12196da542c9a26bbc43e9655a1906"));
  const auto half = shipped().message_of_set("indigo", "gazebo_msgs/GetModelStateResponse");
  ASSERT_TRUE(half);
  EXPECT_EQ(half, shipped().find_message("gazebo_msgs/GetModelStateResponse", half->md5()));
  EXPECT_EQ(2U, shipped().services("gazebo_msgs/GetModelState").size());
  const auto content = shipped().content("indigo");
  EXPECT_TRUE(
      std::binary_search(content.messages.begin(), content.messages.end(), "moveit_msgs/PickupResult"));
  EXPECT_FALSE(std::binary_search(content.messages.begin(), content.messages.end(),
                                  "gazebo_msgs/GetModelStateResponse"));
  EXPECT_TRUE(std::binary_search(content.actions.begin(), content.actions.end(), "moveit_msgs/Pickup"));
  EXPECT_TRUE(shipped().content("none").messages.empty());
}

TEST(ShippedStore, HoldsFieldListsOnly) {
  for (const auto& [name, text] : files_of(kShipped)) {
    if (name.substr(0, 5) == "sets/") continue;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      EXPECT_TRUE(line.find('#') == std::string::npos || line.substr(0, 9) == "# embeds ")
          << name << ": " << line;
  }
}

TEST(ShippedStore, EveryFullTextIsReadAsTheSame) {
  for (const auto& set : shipped().sets())
    for (const auto& type : shipped().content(set).messages) {
      const auto schema = shipped().message_of_set(set, type);
      const auto again = parse_full_text(type, schema->full_text());
      ASSERT_TRUE(again) << again.error().message;
      EXPECT_EQ(schema->md5(), (*again)->md5()) << type;
      EXPECT_TRUE(same_layout(*schema, **again)) << type;
    }
}

TEST(Store, WrittenAndReadAgainIsTheSame) {
  TemporaryFolder folder;
  ASSERT_TRUE(shipped().write_store(folder.path() / "copy"));
  EXPECT_EQ(files_of(kShipped), files_of(folder.path() / "copy"));
}

/// A small store of our own in a temporary folder.
class SmallStore : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("tree/std_msgs/msg/Header.msg", "uint32 seq\ntime stamp\nstring frame_id\n");
    folder_.write("tree/geometry_msgs/msg/Point.msg", "# A point\nfloat64 x\nfloat64 y\nfloat64 z\n");
    folder_.write("tree/geometry_msgs/msg/PointStamped.msg", "Header header\nPoint point\n");
    folder_.write("tree/geometry_msgs/srv/Move.srv", "Point point\n---\nbool done\n");
  }
  void write() {
    DefinitionStore store;
    const auto report = store.add_tree(folder_.path() / "tree", "old");
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(store.write_store(store_));
  }
  std::string problem_of_reading() {
    DefinitionStore store;
    const auto read = store.add_store(store_);
    EXPECT_FALSE(read);
    EXPECT_TRUE(store.sets().empty()) << "nothing is kept of a damaged store";
    return read ? "" : read.error().message;
  }
  fs::path point_file() const { return store_ / "geometry_msgs" / ("Point." + kPointMd5 + ".msg"); }

  TemporaryFolder folder_;
  fs::path store_{folder_.path() / "store"};
};

TEST_F(SmallStore, NamesFilesByTypeAndMd5) {
  write();
  const auto files = files_of(store_);
  EXPECT_EQ(5U, files.size());
  EXPECT_EQ("float64 x\nfloat64 y\nfloat64 z\n", files.at("geometry_msgs/Point." + kPointMd5 + ".msg"));
  EXPECT_EQ("# embeds geometry_msgs/Point " + kPointMd5 + "\n# embeds std_msgs/Header " + kHeaderMd5 +
                "\nHeader header\nPoint point\n",
            files.at("geometry_msgs/PointStamped.c63aecb41bfdfd6b7e1fac37c7cbe7bf.msg"));
  EXPECT_NE(std::string::npos, files.at("sets/old.txt").find("geometry_msgs/Point msg " + kPointMd5 + "\n"));
}

TEST_F(SmallStore, DamagedFilesAreNamed) {
  write();
  std::ofstream(point_file()) << "float64 x\nfloat64 y\n";
  EXPECT_NE(std::string::npos, problem_of_reading().find(point_file().string()));
  std::ofstream(point_file()) << "float64 x\nfloat";
  EXPECT_NE(std::string::npos, problem_of_reading().find("line 2"));
  std::ofstream(point_file()) << std::string(2U << 20U, 'x');
  EXPECT_NE(std::string::npos, problem_of_reading().find("longer than"));
  std::ofstream(point_file())
      << "# embeds geometry_msgs/PointStamped c63aecb41bfdfd6b7e1fac37c7cbe7bf\nfloat64 x\n";
  EXPECT_NE(std::string::npos, problem_of_reading().find("embeds itself"));
  fs::remove(point_file());
  EXPECT_NE(std::string::npos, problem_of_reading().find("not in the store"));
}

TEST_F(SmallStore, DamagedSetsAndNamesAreNamed) {
  write();
  std::ofstream(store_ / "sets" / "old.txt")
      << "std_msgs/Header msg " << kHeaderMd5 << "\n# fine\nwhat is this\n";
  EXPECT_NE(std::string::npos, problem_of_reading().find("old.txt:3"));
  std::ofstream(store_ / "sets" / "old.txt") << "std_msgs/Header msg " << kPointMd5 << "\n";
  EXPECT_NE(std::string::npos, problem_of_reading().find("old.txt:1"));
  fs::remove(store_ / "sets" / "old.txt");
  folder_.write("store/geometry_msgs/Pose.msg", "float64 x\n");
  EXPECT_NE(std::string::npos, problem_of_reading().find("Pose.msg"));
  EXPECT_NE(std::string::npos,
            [] {
              DefinitionStore store;
              return store.add_store("/no/such/folder").error().message;
            }()
                .find("/no/such/folder"));
}

TEST_F(SmallStore, LayoutsWithOneMd5AreKeptApart) {
  folder_.write("tree2/pkg/msg/Path.msg", "geometry_msgs/Point p\n");
  folder_.write("tree3/pkg/msg/Path.msg", "geometry_msgs/Point[] p\n");
  DefinitionStore store;
  ASSERT_TRUE(store.add_tree(folder_.path() / "tree", "old"));
  ASSERT_TRUE(store.add_tree(folder_.path() / "tree2", "one", "old"));
  ASSERT_TRUE(store.add_tree(folder_.path() / "tree3", "many", "old"));
  EXPECT_EQ(2U, store.messages("pkg/Path").size());
  ASSERT_TRUE(store.write_store(store_));
  DefinitionStore again;
  ASSERT_TRUE(again.add_store(store_));
  const auto one = again.message_of_set("one", "pkg/Path");
  const auto many = again.message_of_set("many", "pkg/Path");
  ASSERT_TRUE(one && many);
  EXPECT_EQ(one->md5(), many->md5());
  EXPECT_EQ(Arity::kSingle, one->fields()[0].arity);
  EXPECT_EQ(Arity::kVariable, many->fields()[0].arity);
}

TEST_F(SmallStore, LearnsFromConnections) {
  write();
  DefinitionStore store;
  ASSERT_TRUE(store.add_store(store_));
  const auto stamped = store.message_of_set("old", "geometry_msgs/PointStamped");
  const auto known = store.learn(stamped->type(), stamped->md5(), stamped->full_text());
  ASSERT_TRUE(known);
  EXPECT_EQ(stamped, *known) << "equal definitions are one";
  const auto twist =
      store.learn("my_msgs/Twist", "9f195f881246fdfa2798d1d3eebca84a",
                  "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n" + std::string(80, '=') +
                      "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z");
  ASSERT_TRUE(twist) << twist.error().message;
  EXPECT_EQ(*twist, store.find_message("my_msgs/Twist", "9f195f881246fdfa2798d1d3eebca84a"));
  const auto lie = store.learn("my_msgs/Lie", kHeaderMd5, "int32 a\n");
  ASSERT_FALSE(lie);
  EXPECT_NE(std::string::npos, lie.error().message.find("announced as " + kHeaderMd5));
  // rosjava sends no embedded definitions: a set completes them when the MD5 says so.
  const auto bare = store.learn("geometry_msgs/PointStamped", stamped->md5(), "Header header\nPoint point\n");
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_EQ(stamped, *bare);
  EXPECT_FALSE(store.learn("geometry_msgs/PointStamped", kPointMd5, "Header header\nPoint point\n"));
  ASSERT_TRUE(store.write_store(folder_.path() / "again"));
  EXPECT_EQ(files_of(store_), files_of(folder_.path() / "again")) << "what was learned is not written";
}

TEST_F(SmallStore, AnArrayWithTheMd5OfASingleIsLearnedAsWhatItIs) {
  DefinitionStore store;
  const std::string point =
      std::string(80, '=') + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
  const auto one = parse_full_text("pkg/Path", "geometry_msgs/Point p\n" + point);
  const auto first = store.learn("pkg/Path", (*one)->md5(), "geometry_msgs/Point p\n" + point);
  const auto second = store.learn("pkg/Path", (*one)->md5(), "geometry_msgs/Point[] p\n" + point);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(Arity::kSingle, (*first)->fields()[0].arity);
  EXPECT_EQ(Arity::kVariable, (*second)->fields()[0].arity);
}

TEST(Store, LearnsABoundedNumber) {
  DefinitionStore::Limits limits;
  limits.learned = 10;
  DefinitionStore store(limits);
  const auto name = [](int i) { return "pkg/Type" + std::to_string(i); };
  const auto one = parse_message("pkg/Type", "int32 a", nullptr);
  ASSERT_TRUE(one);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(store.learn(name(i), (*one)->md5(), "int32 a")) << i;
  EXPECT_TRUE(store.find_message(name(9), (*one)->md5()));
  EXPECT_FALSE(store.find_message(name(10), (*one)->md5()));
  limits.learned = 1000;
  limits.learned_bytes = 20;
  DefinitionStore narrow(limits);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(narrow.learn(name(i), (*one)->md5(), "int32 a")) << i;
  EXPECT_TRUE(narrow.find_message(name(1), (*one)->md5()));
  EXPECT_FALSE(narrow.find_message(name(2), (*one)->md5()));
}

TEST_F(SmallStore, TreesOfManyShapes) {
  folder_.write("ws/src/repo/nav_pkg/package.xml", "<package>\n  <name> my_nav </name>\n</package>\n");
  folder_.write("ws/src/repo/nav_pkg/msg/Goal.msg", "geometry_msgs/Point p\nWay[] w\n");
  folder_.write("ws/src/repo/nav_pkg/msg/Way.msg", "NaviFeedback last\n");
  folder_.write("ws/src/repo/nav_pkg/action/Navi.action",
                "geometry_msgs/Point[] goals\n---\n---\nint8 percent\n");
  folder_.write("ws/src/ignored/CATKIN_IGNORE", "");
  folder_.write("ws/src/ignored/msg/A.msg", "int8 a\n");
  folder_.write("ws/.hidden/pkg/msg/B.msg", "int8 a\n");
  fs::create_directory_symlink(folder_.path() / "tree", folder_.path() / "ws" / "src" / "linked");
  fs::create_directory_symlink(folder_.path() / "ws", folder_.path() / "ws" / "src" / "loop");
  folder_.write("tree/actionlib_msgs/msg/GoalID.msg", "time stamp\nstring id\n");
  folder_.write("tree/actionlib_msgs/msg/GoalStatus.msg", "GoalID goal_id\nuint8 status\nstring text\n");
  DefinitionStore store;
  const auto report = store.add_tree(folder_.path() / "ws", "mine");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(std::vector<std::string>(), report->problems);
  EXPECT_EQ(9U, report->read);
  const auto goal = store.message_of_set("mine", "my_nav/Goal");
  ASSERT_TRUE(goal);
  EXPECT_EQ("my_nav/NaviFeedback", goal->fields()[1].message->fields()[0].message->type());
  EXPECT_TRUE(store.action_of_set("mine", "my_nav/Navi"));
  EXPECT_FALSE(store.message_of_set("mine", "ignored/A"));
  EXPECT_FALSE(store.message_of_set("mine", "pkg/B"));
  EXPECT_TRUE(store.service_of_set("mine", "geometry_msgs/Move"));
  EXPECT_FALSE(store.add_tree(folder_.path() / "none", "mine"));
}

TEST_F(SmallStore, DamagedFilesOfATreeAreReportedAndTheRestIsRead) {
  folder_.write("tree/pkg/msg/Binary.msg", std::string("\0\xff\xfe junk \x80", 10));
  folder_.write("tree/pkg/msg/Loop.msg", "Loop2 l\n");
  folder_.write("tree/pkg/msg/Loop2.msg", "Loop l\n");
  folder_.write("tree/pkg/msg/Orphan.msg", "no_such_msgs/Thing t\n");
  folder_.write("tree/pkg/msg/not a name.msg", "int8 a\n");
  folder_.write("tree/pkg/msg/Long.msg", std::string(2U << 20U, '#'));
  folder_.write("tree/pkg/srv/Half.srv", "int8 a\n");
  folder_.write("tree/pkg/action/None.action", "---\n---\n");
  folder_.write("tree/pkg/msg/README.txt", "int8 a\n");
  fs::create_directories(folder_.path() / "tree/pkg/msg/Folder.msg");
  folder_.write("tree/pkg/msg/Fine.msg", "geometry_msgs/Point p\n");
  DefinitionStore store;
  const auto report = store.add_tree(folder_.path() / "tree", "mine");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(5U, report->read);
  EXPECT_EQ(8U, report->problems.size()) << ::testing::PrintToString(report->problems);
  for (const auto& problem : report->problems)
    EXPECT_NE(std::string::npos, problem.find((folder_.path() / "tree/pkg").string())) << problem;
  EXPECT_TRUE(store.message_of_set("mine", "pkg/Fine"));
}

TEST_F(SmallStore, TheFallbackCompletesATreeAndALaterTreeReplaces) {
  DefinitionStore store;
  ASSERT_TRUE(store.add_tree(folder_.path() / "tree", "base"));
  folder_.write("over/pkg/msg/Way.msg", "geometry_msgs/Point[] points\n");
  EXPECT_EQ(1U, store.add_tree(folder_.path() / "over", "alone")->problems.size());
  EXPECT_TRUE(store.add_tree(folder_.path() / "over", "mine", "base")->problems.empty());
  EXPECT_TRUE(store.message_of_set("mine", "pkg/Way"));
  EXPECT_FALSE(store.message_of_set("mine", "geometry_msgs/Point")) << "the fallback's types do not join";
  folder_.write("newer/pkg/msg/Way.msg", "geometry_msgs/Point[] points\nint8 kind\n");
  ASSERT_TRUE(store.add_tree(folder_.path() / "newer", "mine", "base"));
  EXPECT_EQ(2U, store.message_of_set("mine", "pkg/Way")->fields().size());
}

TEST(Store, ReadsTheSystemsPackages) {
  if (!fs::is_directory("/usr/share/std_msgs/msg")) GTEST_SKIP() << "no ROS packages under /usr/share";
  DefinitionStore store;
  const auto report = store.add_tree("/usr/share", "system");
  ASSERT_TRUE(report) << report.error().message;
  const auto header = store.message_of_set("system", "std_msgs/Header");
  ASSERT_TRUE(header);
  EXPECT_EQ(kHeaderMd5, header->md5());
}

TEST(Store, ReadsTheInterfacesOfThisPackage) {
  DefinitionStore store;
  ASSERT_TRUE(store.add_store(kShipped));
  const auto report = store.add_tree(fs::path(EXTPERFC_SOURCE_DIR) / "interfaces", "ours", "noetic");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(std::vector<std::string>(), report->problems);
  EXPECT_EQ(md5_in(store, "noetic", "baxter_core_msgs/SolvePositionIK", "srv"),
            md5_in(store, "ours", "baxter_core_msgs/SolvePositionIK", "srv"));
}

}  // namespace
}  // namespace extperfc::translate
