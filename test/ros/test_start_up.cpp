// A nodelet that cannot work refuses to load, and says everything that is wrong in one message.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nodelet/NodeletLoad.h>
#include <ros/param.h>
#include <ros/service.h>

#include "extperfc/detect/inference.hpp"

#include "test/ros/support/manager.hpp"
#include "test/ros/support/recording.hpp"
#include "test/ros/support/watch.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

namespace fs = std::filesystem;

class StartUpTest : public testing::Test {
 protected:
  /// The nodelet refuses, and one message has all of these texts.
  void expect_refusal(const std::string& type, const Params& params, const std::vector<std::string>& texts) {
    EXPECT_FALSE(manager_.load("/victim", type, params));
    ASSERT_TRUE(log_.wait(texts.front())) << "no message with '" << texts.front() << "', but:\n"
                                          << log_.text();
    for (const auto& text : texts)
      EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
    EXPECT_EQ(log_.count(texts.front()), 1U) << "once is enough:\n" << log_.text();
  }

  /// A copy of the model `square` that a test may spoil.
  fs::path copy_of_model() {
    fs::copy(model_folder("square"), folder_.path() / "model");
    return folder_.path() / "model";
  }

  static void replace(const fs::path& file, const std::string& old_text, const std::string& new_text) {
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto at = text.find(old_text);
    ASSERT_NE(at, std::string::npos) << file << " has no " << old_text;
    std::ofstream(file) << text.replace(at, old_text.size(), new_text);
  }

  TemporaryFolder folder_;
  LogWatch log_;
  Manager manager_;
};

Params with(Params params, const Params& more) {
  for (const auto& [key, value] : more) params[key] = value;
  return params;
}

TEST_F(StartUpTest, ModelFolderIsMissing) {
  expect_refusal("detector", {{"model", "/no/such/model"}}, {"there is no model folder /no/such/model"});
}

TEST_F(StartUpTest, ModelFolderIsEmpty) {
  expect_refusal("detector", {{"model", folder_.path().string()}},
                 {"has neither model.yaml nor an ONNX file"});
}

TEST_F(StartUpTest, ChecksumIsWrong) {
  const auto model = copy_of_model();
  std::ofstream(model / "square.onnx", std::ios::app) << "x";
  expect_refusal("detector", {{"model", model.string()}},
                 {"sha256: square.onnx has", "fetch the file again"});
}

TEST_F(StartUpTest, NetworkIsCorrupt) {
  for (const std::string& backend : detect::available_backends()) {
    log_.forget();
    const auto model = copy_of_model();
    fs::resize_file(model / "square.onnx", fs::file_size(model / "square.onnx") / 2);
    replace(model / "model.yaml", "sha256:", "source: ");
    expect_refusal("detector", {{"model", model.string()}, {"backend", backend}},
                   {"model square (" + (model / "square.onnx").string() + ") with " + backend});
    fs::remove_all(model);
  }
}

TEST_F(StartUpTest, LayoutIsUnknown) {
  const auto model = copy_of_model();
  replace(model / "model.yaml", "yolo_v8", "yolo_v99");
  expect_refusal("detector", {{"model", model.string()}}, {"unknown layout \"yolo_v99\"", "use one of ssd"});
}

TEST_F(StartUpTest, DeviceIsMissing) {
  for (const std::string& backend : detect::available_backends()) {
    log_.forget();
    expect_refusal("detector", with(detector_params(), {{"backend", backend}, {"device", "NPU"}}),
                   {"with " + backend + " on NPU"});
  }
}

TEST_F(StartUpTest, BackendIsUnknown) {
  expect_refusal("detector", with(detector_params(), {{"backend", "abacus"}}),
                 {"unknown back end \"abacus\": use one of auto, "});
}

TEST_F(StartUpTest, EveryWrongParameterOfTheDetectorIsNamedAtOnce) {
  expect_refusal("detector",
                 with(detector_params(), {{"thread", 2},
                                          {"threads", 1000},
                                          {"score_threshold", 2.5},
                                          {"timeout_s", "soon"},
                                          {"precision", "f8"},
                                          {"mode", "turbo"}}),
                 {"/victim/thread is not a parameter of this nodelet; it knows:",
                  "/victim/threads = 1000 is out of its range [0, 256]",
                  "/victim/score_threshold = 2.5 is out of its range [-1, 1]",
                  "/victim/timeout_s must be a number, but is 'soon'", "f8", "turbo"});
}

TEST_F(StartUpTest, EveryWrongParameterOfBoxDepthIsNamedAtOnce) {
  expect_refusal("box_depth",
                 {{"estimator", "guess"},
                  {"window", 3},
                  {"central_fraction", 0.0},
                  {"depth_queue", 1.5},
                  {"target_frame", 7}},
                 {"/victim/window is not a parameter", "guess",
                  "/victim/central_fraction = 0 is out of its range [0.01, 1]",
                  "/victim/depth_queue must be a whole number, but is '1.5'",
                  "/victim/target_frame must be a text, but is '7'"});
}

TEST_F(StartUpTest, DepthLimitsMustFitTogether) {
  expect_refusal("box_depth", {{"min_depth_m", 5.0}, {"max_depth_m", 1.0}}, {"max_depth_m"});
}

TEST_F(StartUpTest, SourceNeedsItsPath) {
  for (const char* type : {"image_pair_source", "rawlog_source"}) {
    log_.forget();
    expect_refusal(type, {{"loop", "yes"}, {"rate", 5}},
                   {"/victim/path is not set", "/victim/loop must be true or false, but is 'yes'",
                    "/victim/rate is not a parameter"});
  }
}

TEST_F(StartUpTest, SourceNamesAMissingFolderOrFile) {
  expect_refusal("image_pair_source", {{"path", "/no/such/folder"}}, {"no such folder: /no/such/folder"});
}

TEST_F(StartUpTest, SourceNamesAMissingCameraFile) {
  write_recording(folder_.path(), 1);
  expect_refusal("image_pair_source", {{"path", folder_.path().string()}, {"camera_info", "/no/camera.yaml"}},
                 {"/no/camera.yaml"});
}

TEST_F(StartUpTest, AfterARefusalTheSameNameLoads) {
  EXPECT_FALSE(manager_.load("/victim", "detector", {{"model", "/no/such/model"}}));
  EXPECT_TRUE(manager_.load("/victim", "detector", detector_params())) << log_.text();
}

/// As `rosrun nodelet nodelet load` does it.
bool load_into_manager(const std::string& name, const std::string& type, const Params& params) {
  for (const auto& [key, value] : params) ros::param::set(name + "/" + key, value);
  nodelet::NodeletLoad call;
  call.request.name = name;
  call.request.type = "extperfc/" + type;
  return ros::service::call("/manager/load_nodelet", call) && call.response.success != 0U;
}

TEST_F(StartUpTest, ARealManagerOutlivesARefusal) {
  ASSERT_TRUE(ros::service::waitForService("/manager/load_nodelet", ros::Duration(kPatienceS)));
  // Asked again until it is heard: the first refusals may come before the manager's log is connected here.
  EXPECT_TRUE(wait_for([&] {
    EXPECT_FALSE(load_into_manager("/first", "detector", {{"model", "/no/such/model"}}));
    return log_.count("there is no model folder /no/such/model") > 0;
  })) << log_.text();
  EXPECT_TRUE(load_into_manager("/second", "detector", detector_params())) << log_.text();
}

}  // namespace
}  // namespace extperfc::ros_test
