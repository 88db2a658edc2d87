#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/sha256.hpp"
#include "extperfc/detect/model_spec.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::detect {
namespace {

namespace fs = std::filesystem;

const fs::path kTestModels = fs::path(EXTPERFC_TEST_DATA) / "models";
const fs::path kKnownModels = fs::path(EXTPERFC_SOURCE_DIR) / "config/models";

constexpr const char* kInput = "input: {name: images, width: 32, height: 24}\n";
constexpr const char* kOutput = "output: {layout: yolo_v8, names: [output]}\n";
constexpr const char* kHead = "name: tiny\nfile: net.onnx\n";
constexpr const char* kClasses = "classes: [cone, cube, sphere]\n";

/// A folder with a network and this model.yaml.
class ModelFolder : public TemporaryFolder {
 public:
  explicit ModelFolder(const std::string& description) {
    copy(kTestModels / "tiny_yolo_v8.onnx", "net.onnx");
    write("model.yaml", description);
  }
  [[nodiscard]] Result<ModelSpec> load() const { return load_model_spec(path(), kKnownModels); }
};

void expect_error(const std::string& description, ErrorCode code, const std::vector<std::string>& parts) {
  const auto spec = ModelFolder(description).load();
  ASSERT_FALSE(spec) << description;
  EXPECT_EQ(spec.error().code, code) << spec.error().message;
  for (const auto& part : parts)
    EXPECT_NE(spec.error().message.find(part), std::string::npos)
        << part << " is not in: " << spec.error().message;
}

const std::string kWhole = std::string(kHead) + kInput + kOutput + kClasses;

TEST(ModelSpec, ReadsEveryKey) {
  const ModelFolder folder(R"(
name: tiny
file: net.onnx
input: {name: images, width: 32, height: 24, color: bgr, resize: letterbox, interpolation: area,
        mean: [1, 2, 3], scale: 0.5}
output: {layout: yolo_v8, names: [output]}
classes: [cone, cube, sphere]
thresholds: {score: 0.25, nms_iou: 0.6, max_detections: 7}
source: https://example.org
license: BSD-3-Clause
)");
  const auto spec = folder.load();
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(spec->name, "tiny");
  EXPECT_EQ(spec->file.filename(), "net.onnx");
  EXPECT_TRUE(spec->file.is_absolute());
  EXPECT_EQ(spec->sha256, sha256_of_file(spec->file).value());
  EXPECT_EQ(spec->input.name, "images");
  EXPECT_EQ(spec->input.width, 32);
  EXPECT_EQ(spec->input.height, 24);
  EXPECT_TRUE(spec->input.bgr);
  EXPECT_EQ(spec->input.resize, Resize::kLetterbox);
  EXPECT_EQ(spec->input.interpolation, Interpolation::kArea);
  EXPECT_EQ(spec->input.mean, (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(spec->input.scale, (std::array<float, 3>{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(spec->output.layout, OutputLayout::kYoloV8);
  EXPECT_EQ(spec->output.names, std::vector<std::string>{"output"});
  EXPECT_EQ(spec->classes, (std::vector<std::string>{"cone", "cube", "sphere"}));
  EXPECT_FLOAT_EQ(spec->thresholds.score, 0.25F);
  EXPECT_FLOAT_EQ(spec->thresholds.nms_iou, 0.6F);
  EXPECT_EQ(spec->thresholds.max_detections, 7);
  EXPECT_EQ(spec->source, "https://example.org");
  EXPECT_EQ(spec->license, "BSD-3-Clause");
}

TEST(ModelSpec, DefaultsAreThoseOfTheStructs) {
  const auto spec = ModelFolder(kWhole).load();
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_FALSE(spec->input.bgr);
  EXPECT_EQ(spec->input.resize, Resize::kStretch);
  EXPECT_EQ(spec->input.interpolation, Interpolation::kLinear);
  EXPECT_EQ(spec->input.scale, (std::array<float, 3>{1, 1, 1}));
  EXPECT_FLOAT_EQ(spec->thresholds.score, Thresholds{}.score);
}

TEST(ModelSpec, OutputNamesMayBeLeftOutWhereThereIsOneOutput) {
  const auto spec =
      ModelFolder(std::string(kHead) + kInput + kClasses + "output: {layout: yolo_v8}\n").load();
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_TRUE(spec->output.names.empty());
  expect_error(std::string(kHead) + kInput + kClasses + "output: {layout: ssd}\n",
               ErrorCode::kInvalidArgument, {"output.names: is missing"});
  expect_error(std::string(kHead) + kInput + kClasses + "output: {layout: yolo_v8, name: output}\n",
               ErrorCode::kInvalidArgument, {"did you mean \"names\"?"});
}

TEST(ModelSpec, ClassesFromAFile) {
  const ModelFolder folder(std::string(kHead) + kInput + kOutput + "classes_file: names.txt\n");
  folder.write("names.txt", "cone\r\ntraffic light\r\n\n");
  const auto spec = folder.load();
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(spec->classes, (std::vector<std::string>{"cone", "traffic light"}));
}

TEST(ModelSpec, PriorsListedOrGenerated) {
  const std::string begin = std::string(kHead) + kInput + kClasses;
  const auto listed =
      ModelFolder(begin +
                  "output: {layout: ssd_priors, names: [b, s], background_class: 0, apply_softmax: "
                  "true, variances: [0.2, 0.3], priors: [[0.5, 0.5, 0.1, 0.2]]}\n")
          .load();
  ASSERT_TRUE(listed) << listed.error().message;
  ASSERT_EQ(listed->output.priors.size(), 1U);
  EXPECT_FLOAT_EQ(listed->output.priors[0].h, 0.2F);
  EXPECT_FLOAT_EQ(listed->output.variances[1], 0.3F);
  EXPECT_TRUE(listed->output.apply_softmax);

  const auto made = ModelFolder(begin + R"(
output:
  layout: ssd_priors
  names: [b, s]
  priors:
    clip: true
    levels:
      - {stride: 8, min_size: 8, max_size: 18, aspect_ratios: [4]}
      - {stride: 16, columns: 1, rows: 1, min_size: 16}
)")
                        .load();
  ASSERT_TRUE(made) << made.error().message;
  const auto& priors = made->output.priors;
  ASSERT_EQ(priors.size(), 4U * 3U * 4U + 1U);
  const auto expect_prior = [](const Prior& p, float cx, float cy, float w, float h) {
    EXPECT_FLOAT_EQ(p.cx, cx);
    EXPECT_FLOAT_EQ(p.cy, cy);
    EXPECT_FLOAT_EQ(p.w, w);
    EXPECT_FLOAT_EQ(p.h, h);
  };
  expect_prior(priors[0], 4.0F / 32, 4.0F / 24, 8.0F / 32, 8.0F / 24);
  expect_prior(priors[1], 4.0F / 32, 4.0F / 24, 12.0F / 32, 12.0F / 24);
  expect_prior(priors[2], 4.0F / 32, 4.0F / 24, 16.0F / 32, 4.0F / 24);
  expect_prior(priors[3], 4.0F / 32, 4.0F / 24, 4.0F / 32, 16.0F / 24);
  EXPECT_FLOAT_EQ(priors[4].cx, 12.0F / 32);
  EXPECT_FLOAT_EQ(priors[16].cy, 12.0F / 24);
}

TEST(ModelSpec, Anchors) {
  const auto spec =
      ModelFolder(std::string(kHead) + kInput + kClasses +
                  "output: {layout: yolo_anchors, names: [fine, coarse], anchors: [{stride: 8, sizes: "
                  "[[10, 13], [16, 30]]}, {stride: 16, sizes: [[30, 61]]}]}\n")
          .load();
  ASSERT_TRUE(spec) << spec.error().message;
  ASSERT_EQ(spec->output.anchors.size(), 2U);
  EXPECT_EQ(spec->output.anchors[1].stride, 16);
  EXPECT_FLOAT_EQ(spec->output.anchors[0].sizes_px[1][1], 30);
}

TEST(ModelSpec, AllProblemsAtOnceWithKeys) {
  expect_error(
      R"(
name: tiny
file: missing.onnx
input: {width: 3, height: many, color: grey, mean: [1, 2], scale: [1, .nan, 1], hight: 5}
output: {layout: yolo_v8, names: [a, b], anchors: []}
classes: [cone, cone]
thresholds: {score: 1.5, nms_iou: [0.5]}
licence: BSD
)",
      ErrorCode::kInvalidArgument,
      {"input.width", "[8, 4096]", "input.height", "\"many\"", "input.color", "rgb or bgr",
       "input.mean: must have 3 numbers, not 2", "input.scale[1]",
       "input: unknown key \"hight\", did you mean \"height\"?", "output.names: layout yolo_v8 has 1",
       "output.anchors: is not used by layout yolo_v8", "\"cone\" is there twice", "thresholds.score",
       "thresholds.nms_iou", "unknown key \"licence\", did you mean \"license\"?", "missing.onnx"});
}

TEST(ModelSpec, MissingKeysAndWrongKindsOfNodes) {
  expect_error("name: tiny\n", ErrorCode::kInvalidArgument,
               {"file: is missing", "input: is missing", "output.layout: is missing", "classes: is missing"});
  expect_error(std::string(kHead) + "input: 5\noutput: [a]\nclasses: {a: 1}\n", ErrorCode::kInvalidArgument,
               {"input: must be a map", "output: must be a map", "classes: must be a list"});
  expect_error("", ErrorCode::kInvalidArgument, {"must be a map of keys"});
  expect_error("just text\n", ErrorCode::kInvalidArgument, {"must be a map of keys"});
  expect_error(kWhole + "name: again\n", ErrorCode::kInvalidArgument, {"name: is given twice"});
  expect_error(kWhole + "classes_file: a\n", ErrorCode::kNotFound, {"classes_file: cannot open", "not both"});
}

TEST(ModelSpec, UnknownLayoutListsTheKnownOnes) {
  expect_error(std::string(kHead) + kInput + kClasses + "output: {layout: yolo_v9, names: [output]}\n",
               ErrorCode::kUnsupported, {"yolo_v9", "ssd_priors", "yolo_grid"});
  EXPECT_STREQ(to_string(layout_from_name("ssd_priors").value()), "ssd_priors");
}

TEST(ModelSpec, NotYamlNamesTheLine) {
  expect_error("name: [1, 2\nfile: }\n", ErrorCode::kCorrupt, {"model.yaml:2: not YAML"});
}

TEST(ModelSpec, WrongSumNamesBoth) {
  const std::string wrong(64, 'a');
  expect_error(kWhole + "sha256: " + wrong + "\n", ErrorCode::kCorrupt,
               {wrong, sha256_of_file(kTestModels / "tiny_yolo_v8.onnx").value()});
  expect_error(kWhole + "sha256: 1234\n", ErrorCode::kInvalidArgument, {"64 hexadecimal digits"});
}

TEST(ModelSpec, MissingFolderAndFile) {
  EXPECT_EQ(load_model_spec("/no/such/folder").error().code, ErrorCode::kNotFound);
  const auto file = load_model_spec(kTestModels / "tiny_ssd.onnx").error();
  EXPECT_NE(file.message.find("name its folder"), std::string::npos) << file.message;
  expect_error("name: tiny\nfile: other.onnx\n" + std::string(kInput) + kOutput + kClasses,
               ErrorCode::kNotFound, {"other.onnx"});
}

/// Descriptions of two of the test networks, as config/models has them for public ones.
class KnownNetworks : public testing::Test {
 protected:
  KnownNetworks() {
    describe("one", "tiny_yolo_v8.onnx");
    describe("two", "tiny_ssd.onnx");
  }

  void describe(const std::string& name, const std::string& file) {
    known_.write(name + ".yaml", "name: " + name + "\nfile: " + file +
                                     "\nsha256: " + sha256_of_file(kTestModels / file).value() + "\n" +
                                     kInput + kOutput + kClasses);
  }

  TemporaryFolder known_;
  TemporaryFolder folder_;
};

TEST_F(KnownNetworks, AreRecognisedUnderAnyFileName) {
  folder_.copy(kTestModels / "tiny_yolo_v8.onnx", "renamed.onnx");
  folder_.copy(kTestModels / "tiny_yolo_anchors.onnx", "unknown.onnx");
  const auto spec = load_model_spec(folder_.path(), known_.path());
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(spec->name, "one");
  EXPECT_EQ(spec->file.filename(), "renamed.onnx");
}

TEST_F(KnownNetworks, SeveralInOneFolderAreAnErrorThatSaysWhich) {
  folder_.copy(kTestModels / "tiny_yolo_v8.onnx", "a.onnx");
  folder_.copy(kTestModels / "tiny_ssd.onnx", "b.onnx");
  const auto error = load_model_spec(folder_.path(), known_.path()).error();
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_NE(error.message.find("a.onnx (one), b.onnx (two)"), std::string::npos) << error.message;
}

TEST_F(KnownNetworks, NoneIsAnErrorThatSaysWhatToDo) {
  EXPECT_EQ(load_model_spec(folder_.path(), known_.path()).error().code, ErrorCode::kNotFound);
  folder_.copy(kTestModels / "tiny_yolo_anchors.onnx", "unknown.onnx");
  const auto error = load_model_spec(folder_.path(), known_.path()).error();
  EXPECT_EQ(error.code, ErrorCode::kNotFound);
  EXPECT_NE(error.message.find("write a model.yaml"), std::string::npos) << error.message;
}

TEST(KnownModels, EveryDescriptionOfThePackageIsSound) {
  for (const auto& entry : fs::directory_iterator(kKnownModels)) {
    TemporaryFolder folder;
    folder.copy(entry.path(), "model.yaml");
    const auto error = load_model_spec(folder.path()).error();
    EXPECT_EQ(error.code, ErrorCode::kNotFound) << "more than the network is missing: " << error.message;
  }
}

}  // namespace
}  // namespace extperfc::detect
