#include <gtest/gtest.h>

#include "bridge_fixture.hpp"
#include "translate/bridge/param_route.hpp"

namespace extperfc::translate::test {
namespace {

class ParamRouteTest : public BridgeFixture {
 protected:
  ParamRoute::Written written_;
};

TEST_F(ParamRouteTest, ANamespaceIsWrittenLeafByLeaf) {
  const ParamRoute route(context_, written_, "/robot/", End::kOld);
  new_.param_values["/robot/own"] = 5;
  old_.on_param("/robot", XmlStruct{{"a", 1}, {"deep", XmlStruct{{"b", "text"}}}});
  EXPECT_EQ(new_.param_values.at("/robot/a"), XmlValue(1));
  EXPECT_EQ(new_.param_values.at("/robot/deep/b"), XmlValue("text"));
  EXPECT_EQ(new_.param_values.at("/robot/own"), XmlValue(5)) << "what only the other side has, stays";
  EXPECT_EQ(route.count(), 2U);
}

TEST_F(ParamRouteTest, ADeletionCrosses) {
  const ParamRoute route(context_, written_, "/robot", End::kOld);
  old_.on_param("/robot/a", 1);
  old_.on_param("/robot/a", XmlStruct{});
  EXPECT_EQ(new_.param_values.count("/robot/a"), 0U);
}

TEST_F(ParamRouteTest, ANamespaceThatIsNotThereDeletesNothing) {
  const ParamRoute route(context_, written_, "/robot", End::kOld);
  old_.on_param("/robot", XmlStruct{});
  EXPECT_EQ(new_.writes, 0);
}

TEST_F(ParamRouteTest, BothDirectionsSettleThoughMastersEcho) {
  const ParamRoute there(context_, written_, "/x", End::kOld);
  const ParamRoute back(context_, written_, "/x", End::kNew);
  const auto change = [](FakePeer& peer, int value) {
    peer.param_values["/x/a"] = value;
    peer.on_param("/x/a", value);
  };
  int steps = 0;
  for (const auto& [peer, value] :
       {std::pair{&old_, 1}, {&new_, 2}, {&old_, 1}, {&old_, 3}, {&new_, 1}, {&old_, 2}}) {
    change(*peer, value);
    ++steps;
    EXPECT_EQ(old_.param_values.at("/x/a"), XmlValue(value)) << "step " << steps;
    EXPECT_EQ(new_.param_values.at("/x/a"), XmlValue(value)) << "step " << steps;
    EXPECT_EQ(old_.writes + new_.writes, steps) << "one write for one change";
  }
}

TEST_F(ParamRouteTest, AMasterThatLostItsParametersGetsThemAgain) {
  ParamRoute route(context_, written_, "/x", End::kOld);
  old_.param_values["/x"] = XmlStruct{{"a", 1}};
  old_.on_param("/x/a", 1);
  new_.param_values.clear();
  route.write_again();
  EXPECT_EQ(new_.param_values.at("/x/a"), XmlValue(1));
}

}  // namespace
}  // namespace extperfc::translate::test
