#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/sha256.hpp"

namespace extperfc {
namespace {

std::filesystem::path write_temporary(const std::string& name, const std::string& content) {
  const auto file = std::filesystem::temp_directory_path() / name;
  std::ofstream(file, std::ios::binary) << content;
  return file;
}

// Test vectors of FIPS 180-4.
TEST(Sha256, PublishedVectors) {
  const auto empty = write_temporary("extperfc_sha_empty", "");
  EXPECT_EQ(sha256_of_file(empty).value(),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const auto abc = write_temporary("extperfc_sha_abc", "abc");
  EXPECT_EQ(sha256_of_file(abc).value(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const auto million = write_temporary("extperfc_sha_million", std::string(1000000, 'a'));
  EXPECT_EQ(sha256_of_file(million).value(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, MissingFileAndFolderAreErrorsThatNameIt) {
  const auto missing = sha256_of_file("/no/such/file");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("/no/such/file"), std::string::npos);
  EXPECT_FALSE(sha256_of_file(std::filesystem::temp_directory_path()));
}

}  // namespace
}  // namespace extperfc
