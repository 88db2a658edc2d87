#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/atomic_file.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(AtomicFile, TheOldContentStaysUntilTheNewIsWhole) {
  const TemporaryFolder folder;
  const auto file = folder.write("a", "old");
  const auto written = write_file_atomically(file, [&](std::ostream& out) {
    out << "new " << 1234567.5 << std::flush;
    EXPECT_EQ(content(file), "old");
  });
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(content(file), "new 1.23457e+06");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, AFailureLeavesEverythingAsItWas) {
  const TemporaryFolder folder;
  const auto file = folder.write("a", "old");
  const auto written = write_file_atomically(file, [](std::ostream& out) { out.setstate(std::ios::badbit); });
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("cannot write " + file.string()), std::string::npos);
  EXPECT_EQ(content(file), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, NoFolderAndAFolderInItsPlace) {
  const TemporaryFolder folder;
  const auto nothing = [](std::ostream&) {};
  const auto missing = write_file_atomically(folder.path() / "none" / "a", nothing);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("No such file or directory"), std::string::npos);
  fs::create_directories(folder.path() / "b" / "c");
  EXPECT_FALSE(write_file_atomically(folder.path() / "b", nothing));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, ATextMakesItsFolder) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "b" / "c" / "a";
  const auto written = write_text_atomically(file, std::string("one\ntwo\0three", 13));
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(content(file), std::string("one\ntwo\0three", 13));
  const auto below_a_file = write_text_atomically(file / "d", "x");
  ASSERT_FALSE(below_a_file);
  EXPECT_NE(below_a_file.error().message.find("cannot write " + (file / "d").string()), std::string::npos);
  EXPECT_NE(below_a_file.error().message.find("Not a directory"), std::string::npos)
      << below_a_file.error().message;
}

}  // namespace
}  // namespace extperfc
