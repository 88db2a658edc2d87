#include <set>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/mapping/param_names.hpp"

namespace extperfc::mapping {
namespace {

TEST(ParamNames, GmappingsNames) {
  MapperParams params;
  ASSERT_TRUE(set_param(params, "particles", "80"));
  ASSERT_TRUE(set_param(params, "delta", "0.1"));
  ASSERT_TRUE(set_param(params, "maxUrange", "16.5"));
  ASSERT_TRUE(set_param(params, "linearUpdate", "1e0"));
  ASSERT_TRUE(set_param(params, "temporalUpdate", "-1.0"));
  ASSERT_TRUE(set_param(params, "str", "0.2"));
  ASSERT_TRUE(set_param(params, "seed", "18446744073709551615"));
  EXPECT_EQ(params.particles, 80);
  EXPECT_EQ(params.resolution_m, 0.1);
  EXPECT_EQ(params.max_usable_range_m, 16.5);
  EXPECT_EQ(params.linear_update_m, 1);
  EXPECT_EQ(params.temporal_update_s, -1);
  EXPECT_EQ(params.str, 0.2);
  EXPECT_EQ(params.srt, MapperParams().srt);
  EXPECT_EQ(params.seed, 18446744073709551615U);
}

TEST(ParamNames, EachNameSetsAFieldOfItsOwn) {
  // Every number of MapperParams has its name: when a field is added, so must its name be.
  struct Doubles {
    int particles;
    double rest[13];
    int kept_passes;
    std::uint64_t seed;
  };
  static_assert(sizeof(MapperParams) == sizeof(Doubles), "a parameter without a name?");
  EXPECT_EQ(param_names().size(), 16U);
  std::set<std::string_view> names;
  for (const auto& name : param_names()) {
    EXPECT_TRUE(names.insert(name.name).second) << name.name;
    EXPECT_FALSE(name.help.empty()) << name.name;
    MapperParams params;
    const std::string before = param_text(params, name);
    ASSERT_TRUE(set_param(params, name.name, "77")) << name.name;
    EXPECT_EQ(param_text(params, name), "77");
    std::size_t changed = 0;
    for (const auto& other : param_names())
      changed += param_text(params, other) != param_text({}, other) ? 1 : 0;
    EXPECT_EQ(changed, 1U) << name.name;
    EXPECT_NE(before, "77");
  }
}

TEST(ParamNames, ErrorsHelp) {
  MapperParams params;
  EXPECT_EQ(set_param(params, "particels", "3").error().message,
            "unknown mapper parameter 'particels', did you mean \"particles\"?");
  EXPECT_EQ(set_param(params, "particles", "3.5").error().message,
            "particles must be a whole number, not '3.5'");
  EXPECT_EQ(set_param(params, "delta", "0.1m").error().message, "delta must be a number, not '0.1m'");
  for (const char* bad : {"", "x", "-1", "1e3", "18446744073709551616"})
    EXPECT_FALSE(set_param(params, "seed", bad)) << bad;
  EXPECT_FALSE(set_param(params, "particles", "99999999999"));
  EXPECT_EQ(params.particles, MapperParams().particles) << "errors change nothing";
}

}  // namespace
}  // namespace extperfc::mapping
