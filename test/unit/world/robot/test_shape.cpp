#include <gtest/gtest.h>

#include "extperfc/world/shape.hpp"

namespace extperfc {
namespace {

TEST(TextureName, GoesThereAndBack) {
  for (int i = 0; i <= static_cast<int>(Texture::kBooks); ++i) {
    const auto texture = static_cast<Texture>(i);
    EXPECT_EQ(texture_from(to_string(texture)), texture) << i;
  }
}

TEST(TextureName, IsWhatWorldsWrite) {
  EXPECT_STREQ(to_string(Texture::kNone), "none");
  EXPECT_EQ(texture_from("marble"), Texture::kMarble);
  EXPECT_EQ(texture_from("books"), Texture::kBooks);
}

TEST(TextureName, UnknownNamesAreNothing) {
  EXPECT_FALSE(texture_from("Wood"));
  EXPECT_FALSE(texture_from(""));
  EXPECT_STREQ(to_string(static_cast<Texture>(99)), "unknown");
}

}  // namespace
}  // namespace extperfc
