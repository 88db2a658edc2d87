// Features of aligned faces: local binary patterns and networks.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/face/embedder.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::face {
namespace {

namespace fs = std::filesystem;

const fs::path kNetwork = fs::path(EXTPERFC_TEST_DATA) / "models/tiny_vector.onnx";

/// Stripes, grey, in squares of 16 pixels with a random direction each: a texture that another seed does not
/// have. `gain` and `offset` are the light.
AlignedFace texture(std::uint64_t seed, double gain = 1.0, double offset = 0.0, double noise = 0.0) {
  constexpr int kSquares = 7;
  Rng rng(seed);
  std::vector<double> angles;
  for (int i = 0; i < kSquares * kSquares; ++i) angles.push_back(rng.uniform(-M_PI, M_PI));
  AlignedFace face;
  for (int y = 0; y < kAlignedSize; ++y)
    for (int x = 0; x < kAlignedSize; ++x) {
      const double angle = angles[static_cast<std::size_t>(y / 16 * kSquares + x / 16)];
      const double stripes = std::sin(0.8 * (x * std::cos(angle) + y * std::sin(angle)));
      const double value = gain * (110 + 50 * stripes) + offset + noise * rng.uniform(-1, 1);
      face.bgr.insert(face.bgr.end(), 3, static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)));
    }
  return face;
}

float length(const Feature& feature) {
  return std::sqrt(similarity(feature, feature));
}

detect::InferenceOptions one_thread(const std::string& backend = "opencv") {
  detect::InferenceOptions options;
  options.backend = backend;
  options.threads = 1;
  return options;
}

TEST(LbpEmbedder, SameTextureUnderOtherLightIsMoreSimilarThanAnother) {
  const auto embedder = make_lbp_embedder();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto feature = embedder->embed(texture(seed));
    ASSERT_TRUE(feature);
    ASSERT_EQ(feature->size(), embedder->size());
    EXPECT_NEAR(length(*feature), 1.0F, 1e-4F);
    const float other = similarity(*feature, *embedder->embed(texture(seed + 50)));
    for (const auto& [gain, offset] : {std::pair{0.5, 0.0}, {0.5, 80.0}, {1.3, -20.0}}) {
      const float same = similarity(*feature, *embedder->embed(texture(seed, gain, offset, 1.0)));
      EXPECT_GT(same, embedder->default_threshold()) << seed << ", gain " << gain;
      EXPECT_GT(same, other + 0.05F) << seed << ", gain " << gain;
    }
    EXPECT_GE(other, 0.0F);
    EXPECT_LT(other, embedder->default_threshold()) << seed;
  }
}

TEST(NetworkEmbedder, FeaturesHaveTheLengthOne) {
  const auto embedder = make_network_embedder(kNetwork, one_thread());
  ASSERT_TRUE(embedder) << embedder.error().message;
  EXPECT_EQ((*embedder)->size(), 16U);
  EXPECT_FLOAT_EQ((*embedder)->default_threshold(), 0.363F);
  const auto feature = (*embedder)->embed(texture(1));
  ASSERT_TRUE(feature) << feature.error().message;
  EXPECT_NEAR(length(*feature), 1.0F, 1e-5F);
  EXPECT_NEAR(similarity(*feature, *(*embedder)->embed(texture(1))), 1.0F, 1e-5F);
  AlignedFace half = texture(1);
  std::fill_n(half.bgr.begin(), half.bgr.size() / 2, std::uint8_t{0});
  EXPECT_LT(similarity(*feature, *(*embedder)->embed(half)), 0.99F);
  EXPECT_NE((*embedder)->identity(), make_lbp_embedder()->identity());
}

TEST(NetworkEmbedder, BackEndsAgree) {
  const auto backends = detect::available_backends();
  if (std::find(backends.begin(), backends.end(), "openvino") == backends.end())
    GTEST_SKIP() << "this build has no OpenVINO";
  const auto opencv = make_network_embedder(kNetwork, one_thread());
  const auto openvino = make_network_embedder(kNetwork, one_thread("openvino"));
  ASSERT_TRUE(opencv && openvino);
  EXPECT_EQ((*opencv)->identity(), (*openvino)->identity()) << "one gallery serves both";
  EXPECT_GT(similarity(*(*opencv)->embed(texture(3)), *(*openvino)->embed(texture(3))), 0.9999F);
}

TEST(NetworkEmbedder, AFileIsFedInRgb) {
  const TemporaryFolder folder;
  folder.copy(kNetwork, "net.onnx");
  const auto described = [&](const std::string& color) {
    folder.write("model.yaml", "name: tiny\nfile: net.onnx\ninput: {width: 112, height: 112, color: " +
                                   color + "}\noutput: {layout: vector}\n");
    return make_network_embedder(folder.path(), one_thread());
  };
  AlignedFace blue = texture(4);
  for (std::size_t i = 1; i < blue.bgr.size(); i += 3) blue.bgr[i] = blue.bgr[i + 1] = 0;
  const auto file = *(*make_network_embedder(kNetwork, one_thread()))->embed(blue);
  EXPECT_GT(similarity(file, *(*described("rgb"))->embed(blue)), 0.9999F);
  EXPECT_LT(similarity(file, *(*described("bgr"))->embed(blue)), 0.999F);
}

TEST(NetworkEmbedder, WhatIsNoEmbedderIsAnError) {
  const auto expect_error = [](const fs::path& path, const std::string& part) {
    const auto embedder = make_network_embedder(path, one_thread());
    ASSERT_FALSE(embedder);
    EXPECT_NE(embedder.error().message.find(part), std::string::npos) << embedder.error().message;
  };
  expect_error("/no/such/network.onnx", "neither an ONNX file nor a model folder: /no/such/network.onnx");
  expect_error(fs::path(EXTPERFC_TEST_DATA) / "models/square", "needs the layout vector");
  expect_error(fs::path(EXTPERFC_TEST_DATA) / "models/tiny_ssd.onnx", "tiny_ssd");
  const TemporaryFolder folder;
  expect_error(folder.write("broken.onnx", "no network"), "broken");
}

TEST(Similarity, OfFeaturesOfDifferentSizesIsZero) {
  EXPECT_EQ(similarity({1, 0}, {1, 0, 0}), 0.0F);
  EXPECT_FLOAT_EQ(similarity({0.6F, 0.8F}, {0.8F, 0.6F}), 0.96F);
}

}  // namespace
}  // namespace extperfc::face
