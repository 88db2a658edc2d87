// Who a face is: thresholds, margins, bounds, and the file.
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/face/gallery.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::face {
namespace {

constexpr IdentifyParams kParams{0.8F, 0.05F};

GallerySpec spec(std::size_t max_features = 3) {
  return {"test", 3, max_features, 4};
}

/// A direction in the plane of the first two numbers: similarities are cosines of differences.
Feature at(double angle) {
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0F};
}

Gallery with(const std::vector<std::pair<std::string, double>>& people) {
  Gallery gallery(spec());
  for (const auto& [name, angle] : people) EXPECT_TRUE(gallery.add(name, at(angle)));
  return gallery;
}

TEST(Gallery, TheMostSimilarNameAboveTheThreshold) {
  const Gallery gallery = with({{"Ada", 0.0}, {"Ada", 0.3}, {"Grace", 1.5}});
  const auto ada = gallery.identify(at(0.35), kParams);
  EXPECT_EQ(ada.name, "Ada");
  EXPECT_NEAR(ada.similarity, std::cos(0.05), 1e-5) << "of her nearest feature";
  EXPECT_EQ(gallery.identify(at(1.4), kParams).name, "Grace");
  const auto stranger = gallery.identify(at(0.3 - 0.95), kParams);  // cos(0.65) = 0.796
  EXPECT_EQ(stranger.name, "");
  EXPECT_NEAR(stranger.similarity, std::cos(0.65), 1e-5) << "still reported";
  EXPECT_EQ(gallery.identify(at(-0.64), kParams).name, "Ada") << "cos(0.64) = 0.802";
}

TEST(Gallery, AnEmptyOneKnowsNoFace) {
  const auto identity = Gallery(spec()).identify(at(0), {-1.0F, 0.0F});
  EXPECT_EQ(identity.name, "");
  EXPECT_EQ(identity.similarity, 0.0F);
}

TEST(Gallery, TwoNamesWithinTheMarginAreUnknown) {
  const Gallery gallery = with({{"Ada", 0.0}, {"Grace", 0.6}});
  EXPECT_EQ(gallery.identify(at(0.3), kParams).name, "") << "half-way";
  EXPECT_EQ(gallery.identify(at(0.29), {0.8F, 0.0F}).name, "Ada") << "no margin";
  EXPECT_EQ(gallery.identify(at(0.1), kParams).name, "Ada") << "0.995 against 0.878";
  EXPECT_EQ(with({{"Ada", 0.0}, {"Ada", 0.6}}).identify(at(0.3), kParams).name, "Ada")
      << "two features of one name are no rivals";
}

TEST(Gallery, ForgetsTheOldestFeatureAndWholeNames) {
  Gallery gallery(spec(2));
  for (const double angle : {0.0, 1.0, 2.0}) ASSERT_TRUE(gallery.add("Ada", at(angle)));
  EXPECT_EQ(gallery.people().at("Ada"), (std::vector<Feature>{at(1.0), at(2.0)}));
  EXPECT_EQ(gallery.forget("Grace"), 0U);
  EXPECT_EQ(gallery.forget("Ada"), 2U);
  EXPECT_TRUE(gallery.names().empty());
}

TEST(Gallery, RefusesWhatItCannotHold) {
  Gallery gallery(spec());
  const auto refusal = [&](const std::string& name, const Feature& feature) {
    const auto added = gallery.add(name, feature);
    return added ? "" : added.error().message;
  };
  for (const std::string& name :
       {std::string(), std::string(65, 'a'), std::string("a\nb"), std::string("\x7f")})
    EXPECT_NE(refusal(name, at(0)).find("cannot be used"), std::string::npos) << name;
  EXPECT_EQ(refusal(std::string(64, 'a'), at(0)), "");
  EXPECT_NE(refusal("Ada", {1.0F}).find("a feature has 1 numbers"), std::string::npos);
  EXPECT_NE(refusal("Ada", {0.5F, 0.5F, 0.5F}).find("length 1"), std::string::npos);
  EXPECT_NE(refusal("Ada", {NAN, 0.0F, 0.0F}).find("length 1"), std::string::npos);
  for (const char* name : {"b", "c", "d"}) EXPECT_EQ(refusal(name, at(0)), "");
  EXPECT_NE(refusal("e", at(0)).find("the gallery is full"), std::string::npos);
  EXPECT_EQ(refusal("d", at(1)), "") << "a known name gets further features";
}

TEST(GalleryFile, ComesBackAsItWas) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "new/gallery.yaml";
  const Gallery gallery = with({{"Ada", 0.1}, {"Ada", 0.2}, {"Grace \"Amazing\" Höpper: #1", 1.5}});
  const auto saved = save_gallery(gallery, file);
  ASSERT_TRUE(saved) << saved.error().message;
  const auto loaded = load_gallery(file, spec());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->names(), gallery.names());
  for (const auto& [name, features] : gallery.people()) {
    const auto& back = loaded->people().at(name);
    ASSERT_EQ(back.size(), features.size()) << name;
    for (std::size_t i = 0; i < back.size(); ++i) EXPECT_NEAR(similarity(back[i], features[i]), 1.0F, 1e-5F);
  }
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path() / "new"))
    ++files;
  EXPECT_EQ(files, 1U) << "no part of a file stays behind";
}

TEST(GalleryFile, AnEmptyGalleryComesBack) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_gallery(Gallery(spec()), folder.path() / "gallery.yaml"));
  const auto loaded = load_gallery(folder.path() / "gallery.yaml", spec());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_TRUE(loaded->names().empty());
}

TEST(GalleryFile, KeepsTheLatestFeaturesOfAName) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_gallery(with({{"Ada", 0.1}, {"Ada", 0.2}, {"Ada", 0.3}}), folder.path() / "gallery.yaml"));
  const auto loaded = load_gallery(folder.path() / "gallery.yaml", spec(1));
  ASSERT_TRUE(loaded) << loaded.error().message;
  ASSERT_EQ(loaded->people().at("Ada").size(), 1U);
  EXPECT_NEAR(loaded->people().at("Ada")[0][1], std::sin(0.3), 1e-5);
}

class BadGalleryFile : public testing::Test {
 protected:
  void expect_error(const std::string& text, ErrorCode code, const std::string& part) {
    const auto file = folder_.write("gallery.yaml", text);
    const auto loaded = load_gallery(file, spec());
    ASSERT_FALSE(loaded) << text;
    EXPECT_EQ(loaded.error().code, code) << loaded.error().message;
    EXPECT_NE(loaded.error().message.find(part), std::string::npos) << loaded.error().message;
    EXPECT_NE(loaded.error().message.find(file.string()), std::string::npos) << "the file is named";
  }

  TemporaryFolder folder_;
};

constexpr const char* kHead = "format: 1\nembedder: test\nsize: 3\n";

TEST_F(BadGalleryFile, OfAnotherEmbedderSaysWhatToDo) {
  expect_error("format: 1\nembedder: other\nsize: 3\npeople: []\n", ErrorCode::kInvalidArgument,
               "enroll again");
  expect_error("format: 1\nembedder: test\nsize: 4\npeople: []\n", ErrorCode::kInvalidArgument,
               "enroll again");
}

TEST_F(BadGalleryFile, DamagedContentIsNamed) {
  expect_error("format: [1\n", ErrorCode::kCorrupt, "not YAML");
  expect_error("", ErrorCode::kInvalidArgument, "must be a map");
  expect_error("format: 2\nembedder: test\nsize: 3\n", ErrorCode::kInvalidArgument, "format");
  const std::string people = std::string(kHead) + "people:\n- name: Ada\n  features: ";
  expect_error(people + "[\"1 0 zero\"]\n", ErrorCode::kInvalidArgument, "texts of numbers");
  expect_error(people + "[\"1 0\"]\n", ErrorCode::kInvalidArgument, "a feature has 2 numbers");
  expect_error(people + "[\"1 1 1\"]\n", ErrorCode::kInvalidArgument, "length 1");
  expect_error(people + "[]\n", ErrorCode::kInvalidArgument, "features: is empty");
  expect_error(std::string(kHead) + "people:\n- features: [\"1 0 0\"]\n", ErrorCode::kInvalidArgument,
               "name: is missing");
  expect_error(std::string(kHead) + "friends: []\n", ErrorCode::kInvalidArgument, "friends");
}

TEST_F(BadGalleryFile, AMissingFileIsNotFound) {
  EXPECT_EQ(load_gallery(folder_.path() / "none.yaml", spec()).error().code, ErrorCode::kNotFound);
}

TEST_F(BadGalleryFile, WhatCannotBeWrittenIsAnError) {
  const auto file = folder_.write("file", "");
  EXPECT_FALSE(save_gallery(Gallery(spec()), file / "gallery.yaml"));
}

}  // namespace
}  // namespace extperfc::face
