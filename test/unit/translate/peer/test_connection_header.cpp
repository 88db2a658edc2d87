#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/tcpros.hpp"

#include "test/unit/translate/peer/raw_socket.hpp"

namespace extperfc::translate {
namespace {

using testing::little_endian;

Result<ConnectionHeader> decode(const std::string& bytes) {
  return decode_header({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

std::string field(const std::string& text) {
  return little_endian(static_cast<std::uint32_t>(text.size())) + text;
}

std::string encoded(const ConnectionHeader& header) {
  const auto bytes = encode_header(header);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(ConnectionHeader, ComesBackWithBinaryValuesAndEqualsSigns) {
  const ConnectionHeader header{{"message_definition", "byte A=1\nstring s = \"=\"\n"},
                                {"binary", std::string("\0\xff=\0", 4)},
                                {"empty", ""},
                                {"topic", "/a"}};
  const auto bytes = encoded(header);
  EXPECT_EQ(bytes.substr(0, 4), little_endian(static_cast<std::uint32_t>(bytes.size() - 4)));
  const auto decoded = decode(bytes.substr(4));
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(*decoded, header);
}

TEST(ConnectionHeader, WithoutFieldsIsFine) {
  const auto decoded = decode("");
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(decoded->empty());
  EXPECT_EQ(value_of(*decoded, "topic"), "");
}

TEST(ConnectionHeader, CutAnywhereIsAnErrorOrShorter) {
  const auto whole = field("topic=/a") + field("md5sum=*") + field("type=std_msgs/String");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto decoded = decode(whole.substr(0, size));
    const bool at_field_end = size == 0 || size == 12 || size == 24;
    EXPECT_EQ(decoded.has_value(), at_field_end) << size;
  }
}

TEST(ConnectionHeader, AbsurdLengthsAreRefused) {
  for (const auto length : {0xffffffffU, 0x80000000U, 9U}) {
    const auto decoded = decode(little_endian(length) + "topic=/a");
    ASSERT_FALSE(decoded) << length;
    EXPECT_NE(decoded.error().message.find(std::to_string(length)), std::string::npos)
        << decoded.error().message;
  }
}

TEST(ConnectionHeader, FieldsWithoutEqualsOrNameAreRefused) {
  EXPECT_FALSE(decode(field("topic")));
  EXPECT_FALSE(decode(field("")));
  EXPECT_FALSE(decode(field("=value")));
}

TEST(ConnectionHeader, AHundredThousandFieldsAreRefused) {
  std::string bytes;
  for (int i = 0; i < 100'000; ++i) bytes += field("k" + std::to_string(i) + "=v");
  const auto decoded = decode(bytes);
  ASSERT_FALSE(decoded);
  EXPECT_NE(decoded.error().message.find("fields"), std::string::npos);
}

TEST(ConnectionHeader, AnyBytesAreDecodedOrRefused) {
  Rng random(20'261);
  int decoded_ones = 0;
  for (int round = 0; round < 20'000; ++round) {
    auto bytes = field("topic=/a") + field("x=") + field("md5sum=0123");
    const auto changes = random.integer(1, 3);
    for (int i = 0; i < changes; ++i) {
      const auto at = random.integer(0, static_cast<int>(bytes.size()) - 1);
      bytes[static_cast<std::size_t>(at)] = static_cast<char>(random.integer(0, 255));
    }
    decoded_ones += decode(bytes).has_value() ? 1 : 0;
  }
  EXPECT_GT(decoded_ones, 0);
  EXPECT_LT(decoded_ones, 20'000);
}

}  // namespace
}  // namespace extperfc::translate
