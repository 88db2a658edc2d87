#include <string>

#include <gtest/gtest.h>

#include "extperfc/offline/recording.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::offline {
namespace {

std::string complaint(const std::filesystem::path& file) {
  const auto opened = open_recording(file);
  EXPECT_FALSE(opened) << file;
  return opened ? "" : opened.error().message;
}

TEST(Recording, TheContentDeterminesTheFormat) {
  const std::filesystem::path data = std::filesystem::path(EXTPERFC_TEST_DATA) / "carmen";
  const TemporaryFolder folder;
  for (const char* name : {"small.clf", "small.clf.gz", "small.clf.bz2"}) {
    const auto log = open_recording(folder.copy(data / name, std::string(name) + ".dat"));
    ASSERT_TRUE(log) << log.error().message;
    std::size_t scans = 0;
    while (true) {
      const auto record = (*log)->next();
      ASSERT_TRUE(record) << record.error().message;
      if (!*record) break;
      ++scans;
    }
    EXPECT_EQ(scans, 6U) << name;
  }
}

TEST(Recording, WhatIsNoneIsRefusedInOneLine) {
  const TemporaryFolder folder;
  EXPECT_NE(complaint(folder.path() / "none.bag").find("cannot read"), std::string::npos);
  EXPECT_NE(complaint(folder.path()).find("is a folder"), std::string::npos);
  EXPECT_NE(complaint(folder.write("empty", "")).find("is empty"), std::string::npos);
  EXPECT_NE(complaint(folder.write("binary", std::string("\x00\x01\x02", 3))).find("neither a CARMEN log"),
            std::string::npos);
  for (const auto& [name, content] :
       {std::pair<const char*, std::string>{"a.bag", "#ROSBAG V2.0\nand no more"},
        {"b.rawlog", "no rawlog"},
        {"c",
         "\x98"
         "CObservation and no more"}}) {
    const auto message = complaint(folder.write(name, content));
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace extperfc::offline
