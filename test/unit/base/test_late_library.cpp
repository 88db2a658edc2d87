#include <gtest/gtest.h>

#include "extperfc/base/late_library.hpp"

namespace extperfc {
namespace {

const char kHere = 0;

TEST(LateLibrary, FindsWhatTheSystemHas) {
  // libextperfc_base lies beside itself.
  const auto found = late_symbol("extperfc_base", "_ZN8extperfc9to_stringENS_9ErrorCodeE",
                                 reinterpret_cast<const void*>(&late_symbol));
  ASSERT_TRUE(found) << found.error().message;
  const auto to_text = reinterpret_cast<const char* (*)(ErrorCode)>(*found);
  EXPECT_STREQ(to_text(ErrorCode::kNotFound), "not_found");
}

TEST(LateLibrary, AMissingLibraryIsNamed) {
  const auto found = late_symbol("extperfc_there_is_none", "entry", &kHere);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(found.error().message.find("libextperfc_there_is_none.so"), std::string::npos);
}

TEST(LateLibrary, AMissingSymbolIsNamed) {
  const auto found =
      late_symbol("extperfc_base", "no_such_entry", reinterpret_cast<const void*>(&late_symbol));
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("no_such_entry"), std::string::npos);
  EXPECT_EQ(found.error().message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace extperfc
