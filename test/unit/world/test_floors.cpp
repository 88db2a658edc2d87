// Floors of a building by name.
#include <gtest/gtest.h>

#include "extperfc/world/floors.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc {
namespace {

TEST(Floors, MapsAreLoadedByName) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_map({2, 1, 0.05, {}, {0, 100}}, folder.path() / "ground"));
  ASSERT_TRUE(
      save_map({1, 1, 0.1, {}, {-1}}, folder.path() / "first", {}, {MapImage::kPng, MapMode::kTrinary}));
  const auto floors = Floors::read(
      folder.write("floors.yaml", "floors:\n- {name: ground, map: ground.yaml}\n- {name: '1', map: " +
                                      (folder.path() / "first.yaml").string() + "}\n"));
  ASSERT_TRUE(floors) << floors.error().message;
  EXPECT_EQ(floors->names(), (std::vector<std::string>{"ground", "1"}));
  EXPECT_TRUE(floors->has("1"));
  EXPECT_EQ(floors->load("ground")->cells, (std::vector<std::int8_t>{0, 100}));
  EXPECT_EQ(floors->load("1")->cells, (std::vector<std::int8_t>{-1}));
  const auto absent = floors->load("grund");
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, ErrorCode::kNotFound);
  EXPECT_NE(absent.error().message.find("\"ground\""), std::string::npos) << absent.error().message;
}

TEST(Floors, EveryProblemIsNamedWithItsLine) {
  const TemporaryFolder folder;
  folder.write("a.yaml", "");
  const auto floors = Floors::read(folder.write("floors.yaml",
                                                "floors:\n"
                                                "- {name: a, map: a.yaml}\n"
                                                "- {name: a, map: a.yaml}\n"
                                                "- {name: b, map: b.yaml}\n"
                                                "- {map: a.yaml, hight: 3}\n"));
  ASSERT_FALSE(floors);
  for (const char* part : {"floors.yaml:3: floors[1].name: is the name of two floors",
                           "floors.yaml:4: floors[2].map: no such file",
                           "floors.yaml:5: floors[3].name: is missing", "unknown key \"hight\""})
    EXPECT_NE(floors.error().message.find(part), std::string::npos) << part << '\n' << floors.error().message;
  EXPECT_FALSE(Floors::read(folder.write("empty.yaml", "floors: []")));
  EXPECT_EQ(Floors::read(folder.path() / "none.yaml").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace extperfc
