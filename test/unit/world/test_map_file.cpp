#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/map_file.hpp"
#include "extperfc/world/png_file.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] =
    "image: m.pgm\nresolution: 0.1\norigin: [1.5, -2, 0.25]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: "
    "0.196\n";

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// The map of a description and an image; fails the test when it cannot be read.
OccupancyGrid load(const TemporaryFolder& folder, const std::string& yaml, const std::string& pgm) {
  folder.write("m.pgm", pgm);
  const auto map = load_map(folder.write("m.yaml", yaml));
  EXPECT_TRUE(map) << map.error().message;
  return map.value_or(OccupancyGrid());
}

std::string complaint(const TemporaryFolder& folder, const std::string& yaml, const std::string& pgm) {
  folder.write("m.pgm", pgm);
  const auto map = load_map(folder.write("m.yaml", yaml));
  EXPECT_FALSE(map);
  return map ? "" : map.error().message;
}

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
}

TEST(MapFile, RandomMapsComeBack) {
  const TemporaryFolder folder;
  Rng rng(5);
  for (int trial = 0; trial < 30; ++trial) {
    OccupancyGrid map;
    map.width = static_cast<std::size_t>(rng.integer(1, 70));
    map.height = static_cast<std::size_t>(rng.integer(1, 70));
    map.resolution_m = rng.uniform(0.01, 1);
    map.origin = {rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-M_PI, M_PI)};
    for (std::size_t i = 0; i < map.width * map.height; ++i)
      map.cells.push_back(
          std::array<std::int8_t, 3>{-1, 0, 100}[static_cast<std::size_t>(rng.integer(0, 2))]);
    ASSERT_TRUE(save_map(map, folder.path() / "a map"));
    const auto read = load_map(folder.path() / "a map.yaml");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->width, map.width);
    EXPECT_EQ(read->height, map.height);
    EXPECT_NEAR(read->resolution_m, map.resolution_m, 1e-9);
    EXPECT_NEAR(read->origin.x, map.origin.x, 1e-6);
    EXPECT_NEAR(read->origin.y, map.origin.y, 1e-6);
    EXPECT_NEAR(read->origin.yaw, map.origin.yaw, 1e-9);
    EXPECT_EQ(read->cells, map.cells) << "trial " << trial;
  }
}

TEST(MapFile, WritesAsMapSaverDoes) {
  const TemporaryFolder folder;
  OccupancyGrid map{3, 2, 0.05, {-1, 2.5, 0}, {0, 19, 20, 64, 65, -1}};
  ASSERT_TRUE(save_map(map, folder.path() / "office"));
  const std::string pgm = content(folder.path() / "office.pgm");
  EXPECT_EQ(pgm.substr(0, 3), "P5\n");
  const auto end = pgm.find("3 2\n255\n");
  ASSERT_NE(end, std::string::npos);
  // The upper row first: occupied is black, free nearly white, unknown grey.
  EXPECT_EQ(pgm.substr(end + 8), std::string("\xCD\x00\xCD\xFE\xFE\xCD", 6));
  EXPECT_EQ(content(folder.path() / "office.yaml"),
            "image: office.pgm\nresolution: 0.05\norigin: [-1, 2.5, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
            "free_thresh: 0.196\n\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2) << "temporary files are left";
}

TEST(MapFile, TextAndBinaryImages) {
  const TemporaryFolder folder;
  const std::vector<std::int8_t> expected = {-1, 100, 0, 0, 100, -1};  // the lower row first
  const auto check = [&](const std::string& pgm) {
    const auto map = load(folder, kDescription, pgm);
    EXPECT_EQ(map.width, 3U);
    EXPECT_EQ(map.height, 2U);
    EXPECT_EQ(map.cells, expected);
    EXPECT_DOUBLE_EQ(map.resolution_m, 0.1);
    EXPECT_DOUBLE_EQ(map.origin.x, 1.5);
    EXPECT_DOUBLE_EQ(map.origin.yaw, 0.25);
  };
  check(std::string("P5 3 2 255\n\xFE\x00\xCD\xCD\x00\xFE", 17));
  check(std::string("P5\n# one\n3 # two\n2\n# three\n255\n\xFE\x00\xCD\xCD\x00\xFE and more", 46));
  check("P2\n3 2\n255\n254 0 205\n205 0 254\n");
  check("P2 3 2 # a comment\n100\n100 0 80 80\t0\n100");
  check(std::string("P5 3 2 65535\n\xFE\xFE\x00\x00\xCD\x00\xCD\x00\x00\x00\xFE\xFE", 25));  // 16 bit
}

TEST(MapFile, NegatedMapsAreTheOtherWayRound) {
  const TemporaryFolder folder;
  const std::string pgm = "P2 3 1 255 254 0 205";
  for (const char* yes : {"1", "true"}) {
    const auto map = load(folder, replaced(kDescription, "negate: 0", std::string("negate: ") + yes), pgm);
    EXPECT_EQ(map.cells, (std::vector<std::int8_t>{100, 0, 100}));
  }
  EXPECT_EQ(load(folder, replaced(kDescription, "negate: 0", "negate: false"), pgm).cells,
            (std::vector<std::int8_t>{0, 100, -1}));
}

TEST(MapFile, ModesDifferBetweenTheThresholds) {
  const TemporaryFolder folder;
  // Grey 140: occupied with (255 - 140) / 255 = 0.451, between both thresholds.
  const std::string pgm = "P2 5 1 255 255 140 100 50 0";
  EXPECT_EQ(load(folder, kDescription, pgm).cells, (std::vector<std::int8_t>{0, -1, -1, 100, 100}));
  EXPECT_EQ(load(folder, std::string(kDescription) + "mode: trinary\n", pgm).cells,
            (std::vector<std::int8_t>{0, -1, -1, 100, 100}));
  // 1 + 98 (0.451 - 0.196) / (0.65 - 0.196) = 56.0; (255 - 100) / 255 = 0.608 gives 89.9.
  const auto scaled = load(folder, std::string(kDescription) + "mode: scale\n", pgm).cells;
  EXPECT_EQ(scaled, (std::vector<std::int8_t>{0, 56, 89, 100, 100}));
  EXPECT_EQ(load(folder, std::string(kDescription) + "mode: raw\n", pgm).cells,
            (std::vector<std::int8_t>{-1, -1, 100, 50, 0}));
}

TEST(MapFile, TheImageLiesBesideTheDescription) {
  const TemporaryFolder folder;
  folder.write("images/m.pgm", "P2 1 1 255 0");
  const auto relative = folder.write("maps/a.yaml", replaced(kDescription, "m.pgm", "../images/m.pgm"));
  EXPECT_TRUE(load_map(relative));
  const auto absolute = folder.write(
      "maps/b.yaml", replaced(kDescription, "m.pgm", (folder.path() / "images" / "m.pgm").string()));
  EXPECT_TRUE(load_map(absolute));
}

TEST(MapFile, OwnThresholdsAreWritten) {
  const TemporaryFolder folder;
  const OccupancyGrid map{2, 1, 1, {}, {40, 60}};
  ASSERT_TRUE(save_map(map, folder.path() / "m", {0.5, 0.45}));
  EXPECT_EQ(load_map(folder.path() / "m.yaml")->cells, (std::vector<std::int8_t>{0, 100}));
  EXPECT_FALSE(save_map(map, folder.path() / "m", {0.4, 0.5}));
  EXPECT_FALSE(save_map(map, folder.path() / "m", {1.5, 0.5}));
  EXPECT_FALSE(save_map(map, folder.path() / "m", {0.5, std::nan("")}));
}

TEST(MapFile, DescriptionsAreChecked) {
  const TemporaryFolder folder;
  const std::string pgm = "P2 1 1 255 0";
  for (const std::string key :
       {"image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"}) {
    const auto message = complaint(folder, replaced(kDescription, key, "not_" + key), pgm);
    expect_contains(message, "m.yaml");
    expect_contains(message, key + ": is missing");
  }
  expect_contains(complaint(folder, replaced(kDescription, "0.1", "fine"), pgm),
                  "m.yaml:2: resolution: must be a number");
  expect_contains(complaint(folder, replaced(kDescription, "0.1", "-0.1"), pgm),
                  "resolution: must be a number");
  expect_contains(complaint(folder, replaced(kDescription, "0.1", ".inf"), pgm), "resolution: ");
  expect_contains(complaint(folder, replaced(kDescription, "-2,", ""), pgm),
                  "origin: must have 3 or more numbers");
  expect_contains(complaint(folder, replaced(kDescription, "-2", "[]"), pgm), "origin[1]: ");
  expect_contains(complaint(folder, replaced(kDescription, "negate: 0", "negate: 2"), pgm),
                  "negate: must be true or false");
  expect_contains(complaint(folder, replaced(kDescription, "0.196", "0.7"), pgm), "free_thresh");
  expect_contains(complaint(folder, std::string(kDescription) + "mode: grey\n", pgm),
                  "mode: must be trinary, scale or raw");
  expect_contains(complaint(folder, "image: [m.pgm\n", pgm), "m.yaml:2: not YAML");
  expect_contains(complaint(folder, "just text", pgm), "must be a map of keys");
  expect_contains(complaint(folder, "", pgm), "must be a map of keys");
  expect_contains(complaint(folder, std::string(2000000, '#'), pgm), "too large");
}

TEST(MapFile, ImagesAreChecked) {
  const TemporaryFolder folder;
  for (const std::string header : {"P5", "P5 3", "P5 3 2", "P5 0 2 255\n", "P5 3 -2 255\n", "P5 3 2 0\n",
                                   "P5 3 2 70000\n", "P5 x", "P5 99999999999999999999 1 255\n"})
    expect_contains(complaint(folder, kDescription, header), "m.pgm: its header is damaged");
  expect_contains(complaint(folder, kDescription, "P5 3 2 255\nabcde"), "breaks off");
  expect_contains(complaint(folder, kDescription, "P5 3 2 65535\nabcdefgh"), "breaks off");
  expect_contains(complaint(folder, kDescription, "P2 3 2 255\n1 2 3 4 5"), "breaks off");
  expect_contains(complaint(folder, kDescription, "P2 3 2 255\n1 2 3 4 5 256"), "pixel 5");
  expect_contains(complaint(folder, kDescription, "P2 3 2 255\n1 2 x 4 5 6 7"), "pixel 2");
  expect_contains(complaint(folder, kDescription, "\x89PNG\r\n"),
                  "is neither a PGM nor a PNG image; convert it");
  expect_contains(complaint(folder, kDescription, ""), "is neither a PGM nor a PNG image");
}

TEST(MapFile, HugeImagesTakeNoMemory) {
  const TemporaryFolder folder;
  expect_contains(complaint(folder, kDescription, "P5 200000 200000 255\nabc"), "more than 2^28");
  expect_contains(complaint(folder, kDescription, "P5 16384 16384 255\nabc"), "breaks off");
  expect_contains(complaint(folder, kDescription, "P2 16384 16384 255\n1 2"), "breaks off");
}

TEST(MapFile, MissingFilesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_EQ(load_map(folder.path() / "none.yaml").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(load_map(folder.path()).error().code, ErrorCode::kNotFound);
  const auto map = load_map(folder.write("m.yaml", kDescription));
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, ErrorCode::kNotFound);
  expect_contains(map.error().message, "m.pgm");
}

TEST(MapFile, ImpossibleMapsAreNotWritten) {
  const TemporaryFolder folder;
  const auto refused = [&](const OccupancyGrid& map) {
    return !save_map(map, folder.path() / "m").has_value();
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused({2, 2, 0.05, {}, {0, 0, 0}}));
  EXPECT_TRUE(refused({1, 1, 0, {}, {0}}));
  EXPECT_TRUE(refused({1, 1, 0.05, {std::nan(""), 0, 0}, {0}}));
  EXPECT_TRUE(refused({std::size_t{1} << 40, std::size_t{1} << 40, 0.05, {}, {}}));
  EXPECT_TRUE(fs::is_empty(folder.path()));
  EXPECT_FALSE(save_map({1, 1, 0.05, {}, {0}}, folder.path() / "no" / "folder"));
  EXPECT_FALSE(save_map({1, 1, 0.05, {}, {0}}, folder.path().string() + "/"));
}

TEST(MapFile, BrokenPrefixesNeverCrash) {
  const TemporaryFolder folder;
  OccupancyGrid map{5, 4, 0.05, {}, std::vector<std::int8_t>(20, 100)};
  ASSERT_TRUE(save_map(map, folder.path() / "m"));
  const std::string yaml = content(folder.path() / "m.yaml");
  const std::string pgm = content(folder.path() / "m.pgm");
  for (std::size_t n = 0; n < pgm.size(); ++n) {
    folder.write("m.pgm", pgm.substr(0, n));
    EXPECT_FALSE(load_map(folder.path() / "m.yaml")) << n;
  }
  folder.write("m.pgm", pgm);
  for (std::size_t n = 0; n < yaml.find("free_thresh"); ++n) {
    folder.write("m.yaml", yaml.substr(0, n));
    EXPECT_FALSE(load_map(folder.path() / "m.yaml")) << n;
  }
}

OccupancyGrid random_percentages(Rng& rng) {
  OccupancyGrid map;
  map.width = static_cast<std::size_t>(rng.integer(1, 70));
  map.height = static_cast<std::size_t>(rng.integer(1, 70));
  for (std::size_t i = 0; i < map.width * map.height; ++i) {
    const int percent = rng.integer(-1, 100);
    map.cells.push_back(static_cast<std::int8_t>(percent == 99 ? 98 : percent));  // 99 has no grey value
  }
  return map;
}

TEST(MapFile, EveryModeAndImageComesBack) {
  const TemporaryFolder folder;
  Rng rng(6);
  for (const MapFormat format :
       {MapFormat{MapImage::kPng, MapMode::kScale}, MapFormat{MapImage::kPng, MapMode::kRaw},
        MapFormat{MapImage::kPgm, MapMode::kRaw}}) {
    for (int trial = 0; trial < 20; ++trial) {
      const OccupancyGrid map = random_percentages(rng);
      ASSERT_TRUE(save_map(map, folder.path() / "m", {}, format));
      const auto read = load_map(folder.path() / "m.yaml");
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->cells, map.cells);
    }
  }
  OccupancyGrid map{4, 1, 0.05, {}, {0, 30, 100, -1}};
  ASSERT_TRUE(save_map(map, folder.path() / "m", {}, {MapImage::kPng, MapMode::kTrinary}));
  EXPECT_EQ(load_map(folder.path() / "m.yaml")->cells, (std::vector<std::int8_t>{0, -1, 100, -1}));
  const MapFormat scaled{MapImage::kPgm, MapMode::kScale};
  const auto refused = save_map(map, folder.path() / "m", {}, scaled);
  ASSERT_FALSE(refused);
  expect_contains(refused.error().message, "needs PNG");
  map.cells[3] = 7;
  ASSERT_TRUE(save_map(map, folder.path() / "m", {}, scaled));
  EXPECT_EQ(load_map(folder.path() / "m.yaml")->cells, map.cells);
}

TEST(MapFile, ColoursCountByTheirMean) {
  const TemporaryFolder folder;
  const std::array<std::uint8_t, 12> rgb{254, 254, 254, 0, 0, 0, 205, 205, 205, 255, 0, 51};  // the last: 102
  ASSERT_TRUE(write_png({4, 1, PngLayout::kRgb, rgb.data()}, folder.path() / "m.png"));
  const std::string yaml = replaced(kDescription, "m.pgm", "m.png");
  EXPECT_EQ(load_map(folder.write("m.yaml", yaml))->cells, (std::vector<std::int8_t>{0, 100, -1, -1}));
  EXPECT_EQ(load_map(folder.write("m.yaml", yaml + "mode: scale\n"))->cells[3],
            static_cast<std::int8_t>(1 + 98 * (0.6 - 0.196) / (0.65 - 0.196)));
}

TEST(MapFile, TransparentPixelsAreUnknown) {
  const TemporaryFolder folder;
  const std::array<std::uint8_t, 8> pixels{0, 255, 0, 0, 254, 1, 254, 0};
  ASSERT_TRUE(write_png({2, 2, PngLayout::kGreyAlpha, pixels.data()}, folder.path() / "m.png"));
  for (const char* mode : {"trinary", "scale"}) {
    const auto yaml =
        folder.write("m.yaml", replaced(kDescription, "m.pgm", "m.png") + "mode: " + mode + "\n");
    EXPECT_EQ(load_map(yaml)->cells, (std::vector<std::int8_t>{0, -1, 100, -1})) << mode;
  }
}

TEST(MapFile, BrokenPngsNeverCrash) {
  const TemporaryFolder folder;
  Rng rng(7);
  ASSERT_TRUE(save_map(random_percentages(rng), folder.path() / "m", {}, {MapImage::kPng, MapMode::kRaw}));
  const std::string png = content(folder.path() / "m.png");
  for (std::size_t n = 0; n + 12 < png.size(); ++n) {  // without the last chunk it is whole all the same
    folder.write("m.png", png.substr(0, n));
    EXPECT_FALSE(load_map(folder.path() / "m.yaml")) << n;
  }
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = png;
    const int at = rng.integer(0, static_cast<int>(png.size()) - 1);
    damaged[static_cast<std::size_t>(at)] = static_cast<char>(rng.integer(0, 255));
    folder.write("m.png", damaged);
    (void)load_map(folder.path() / "m.yaml");
  }
  // 16384 x 16384 pixels are announced.
  std::string huge = png;
  huge.replace(16, 8, std::string("\x00\x00\x40\x00\x00\x00\x40\x00", 8));
  folder.write("m.png", huge);
  EXPECT_FALSE(load_map(folder.path() / "m.yaml"));
  EXPECT_FALSE(write_png({0, 1, PngLayout::kGrey, nullptr}, folder.path() / "none.png"));
}

}  // namespace
}  // namespace extperfc
